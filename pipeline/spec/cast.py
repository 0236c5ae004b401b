"""Cast: the members of a scene, told apart by the block that each alone has.

A new kind of performer is a class in a module of its own and its place in `AnyMember`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pipeline.spec.body import Body, Many
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.group import Group
from pipeline.spec.model_base import keyed_union
from pipeline.spec.partial_scene import MEMBER_BLOCKS
from pipeline.spec.prop import Prop

AnyMember = Creature | Prop | Body | Group | Many | Dancer | Character

if TYPE_CHECKING:
    Member = AnyMember
else:
    _MODELS = (Creature, Prop, Body, Group, Many, Dancer, Character)
    Member = keyed_union(dict(zip(MEMBER_BLOCKS, _MODELS, strict=True)), default="Creature")
