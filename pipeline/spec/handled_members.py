"""Handled members: what people may take into their hands or kick in a scene."""

from __future__ import annotations

from pipeline.spec.body import Body, Many
from pipeline.spec.character import Character
from pipeline.spec.prop import Prop
from pipeline.spec.scene import Scene
from pipeline.spec.script import Carry, Do, Grab, Kick, Throw


def handled_members(scene: Scene, directed: bool) -> frozenset[str]:
    """Return the names of all members that an order may grab, carry, throw or kick.

    Args:
        scene: the scene; of `many` bodies single ones have names.
        directed: whether further orders may arrive. They are for bodies, and for props that go
            with nothing and that nothing goes with.
    """
    orders = (instruction.do for _, instruction in scene.instructions)
    names = {name for do in orders if (name := handled_by(do)) is not None}
    if directed and any(isinstance(m, Character) and m.acts for m in scene.cast):
        tied = _tied_props(scene)
        for member in scene.cast:
            if isinstance(member, Many):
                names.update(_bodies_of(member))
            elif isinstance(member, Body) or (isinstance(member, Prop) and member.name not in tied):
                names.add(member.name)
    return frozenset(names)


def refusal_of_handling(order: Do, scene: Scene, directed: bool) -> str | None:
    """Return why hands and feet cannot move what an order names, None if they can."""
    name = handled_by(order)
    if name is None or name in handled_members(scene, directed):
        return None
    things = {m.name for m in scene.cast if isinstance(m, Prop | Body)}
    if name not in things:
        return None
    return (
        f"'{name}' goes with others, or changes its size; name something else, or write the order "
        f"into the script of the scene"
    )


def handled_by(order: object) -> str | None:
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


def _bodies_of(member: Many) -> list[str]:
    return [f"{member.name}_{k + 1}" for k in range(member.many.total)]


def _tied_props(scene: Scene) -> set[str]:
    """Return the names of props that go with others or carry them, or change their size."""
    carriers = {m.parent for m in scene.cast if m.parent is not None}
    for member in scene.cast:
        if isinstance(member, Prop | Body):
            carriers.update(hold.by for hold in member.held)
    tied = {name.partition(".")[0] for name in carriers}
    props = [member for member in scene.cast if isinstance(member, Prop)]
    return tied | {m.name for m in props if m.parent is not None or m.held or m.is_scaled}
