"""Consent: whether a person with a mind accepts what another asks of it.

It declines by its mood, by its attachment to the other, and by what it is doing.

Source: Bowlby 1969, for whom a frightened child comes to: its attachment figure.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipeline.simulation.characters.body_arrays import NOBODY

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind

DECLINED_FEAR = 0.25  # of the other, from which it is declined
DECLINED_ANGER = 0.4
DECLINED_ANXIETY = 0.6  # from which only attachment figures and their children are accepted

PREOCCUPATIONS: Mapping[str, str] = {"flee": "is fleeing", "fight": "is fighting"}
"""What is not left off for another, by the name of the behaviour."""


@dataclass(frozen=True, eq=False)
class Consent:
    """The consent of one mind."""

    mind: Mind

    def refusal(self, asker: int) -> str:
        """Return why it does not let a character hug it, "" if it does."""
        mind, name = self.mind, self.mind.surroundings.view.names[asker]
        if float(mind.attention.fears[asker]) > DECLINED_FEAR:
            return f"is afraid of {name}"
        if mind.anger > DECLINED_ANGER:
            return "is angry"
        if reason := PREOCCUPATIONS.get(mind.doing.partition(" ")[0], ""):
            return reason
        if mind.anxiety > DECLINED_ANXIETY and not self.is_bound_to(asker):
            return f"is anxious, and {name} is no caregiver"
        return ""

    def refusal_to_give(self, asker: int, thing: int) -> str:
        """Return why it does not hand a thing to a character, "" if it does."""
        carried = (getattr(one, "thing", NOBODY) for one in self.mind.behaviours.values())
        if thing != NOBODY and thing in carried:
            return "wants to keep it"
        return self.refusal(asker)

    def is_bound_to(self, other: int) -> bool:
        """Tell whether the other is its caregiver, or a child that it comforts."""
        behaviours = self.mind.behaviours.items()
        bonds = [one for name, one in behaviours if name.startswith(("attachment", "comfort"))]
        return any(getattr(bond, "target", NOBODY) == other for bond in bonds)
