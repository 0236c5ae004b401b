"""Cast: the members of a scene, told apart by the block that each alone has.

A new kind of performer is a class in a module of its own, its place in `AnyMember` and its
block in `MEMBER_BLOCKS`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

from pipeline.spec import body, character, creature, dancer, group, prop
from pipeline.spec.model_base import keyed_union
from pipeline.spec.partial_scene import MEMBER_BLOCKS

AnyMember = (
    creature.Creature
    | prop.Prop
    | body.Body
    | group.Group
    | body.Many
    | dancer.Dancer
    | character.Character
)

if TYPE_CHECKING:
    Member = AnyMember
else:
    MEMBERS = dict(zip(MEMBER_BLOCKS, get_args(AnyMember), strict=True))
    Member = keyed_union(MEMBERS, default="Creature")
