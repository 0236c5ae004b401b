"""Handled members: what people may take into their hands or kick in a scene."""

from __future__ import annotations

from pipeline.spec.body import Body, Many
from pipeline.spec.character import Character
from pipeline.spec.prop import Prop
from pipeline.spec.scene import Scene
from pipeline.spec.script import Carry, Grab, Kick, Throw


def handled_members(scene: Scene, directed: bool) -> frozenset[str]:
    """Return the names of all members that an order may grab, carry, throw or kick.

    Args:
        scene: the scene; of `many` bodies single ones have names.
        directed: whether further orders may arrive, to any person and for any thing.
    """
    names = {name for one in scene.script if (name := _handled_by(one.do)) is not None}
    if directed and any(isinstance(m, Character) and m.acts for m in scene.cast):
        for member in scene.cast:
            if isinstance(member, Many):
                names.update(f"{member.name}_{k + 1}" for k in range(member.many.total))
            elif isinstance(member, Body) or (isinstance(member, Prop) and not member.is_scaled):
                names.add(member.name)
    return frozenset(names)


def _handled_by(order: object) -> str | None:
    """Return the member that an order takes into a hand or kicks."""
    match order:
        case Grab():
            return order.grab
        case Carry():
            return order.carry
        case Throw():
            return order.throw
        case Kick():
            return order.kick
    return None
