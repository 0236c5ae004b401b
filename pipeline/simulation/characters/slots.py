"""Slots: places on things, such as the seats of a bench, each of which one person takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Claim:
    """A slot that a person has taken.

    Attributes:
        person: its name.
        facing: heading of a person in the slot [rad].
    """

    person: str
    facing: float


@dataclass(eq=False)
class Slots:
    """The slots that are taken, of all things of a scene.

    Attributes:
        claims: by the name of the thing and the number of the slot.
    """

    claims: dict[str, dict[int, Claim]] = field(default_factory=dict)

    def free(self, thing: str, count: int) -> list[int]:
        """Return which of the slots of a thing nobody has taken."""
        taken = self.claims.get(thing, {})
        return [number for number in range(count) if number not in taken]

    def take(self, thing: str, number: int, person: str, facing: float) -> None:
        """Let a person take a free slot; it leaves every other one."""
        self.leave(person)
        self.claims.setdefault(thing, {})[number] = Claim(person, facing)

    def leave(self, person: str) -> None:
        """Let a person leave its slot, if it has one."""
        for taken in self.claims.values():
            for number in [n for n, claim in taken.items() if claim.person == person]:
                del taken[number]

    def facing(self, thing: str) -> float | None:
        """Return the heading of those who have slots of a thing [rad], None without any."""
        return next((claim.facing for claim in self.claims.get(thing, {}).values()), None)

    def persons(self, thing: str) -> Sequence[str]:
        """Return the names of those who have slots of a thing, in the order of the slots."""
        return [claim.person for _, claim in sorted(self.claims.get(thing, {}).items())]
