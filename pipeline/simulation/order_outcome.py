"""Order outcomes: how the orders of a script end, and what hands take hold of and release."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.simulation.spatial import Array
from pipeline.spec.script import Do


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The end of an order.

    Attributes:
        who: name of the performer.
        order: the order, the same object that was given.
        reason: why it was given up; empty if it is done.
    """

    who: str
    order: Do
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class GripChange:
    """Hands that take hold of a member of another troupe, or release it.

    Attributes:
        holder: name of the performer.
        hands: names of the nodes of the hand or of both hands, such as "kid.hand_r".
        member: name of the member.
        taken: whether they take hold.
        velocity: (3,) with which it is released [m/s]; None for that of the hands.
    """

    holder: str
    hands: tuple[str, ...]
    member: str
    taken: bool
    velocity: Array | None = None
