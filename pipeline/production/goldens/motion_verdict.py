"""Verdict: what came of comparing a take with its golden."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Outcome(Enum):
    """Whether a take moves like its golden."""

    IDENTICAL = "identical"
    WITHIN = "equal within tolerance"
    CHANGED = "changed"


WHOLE = -1
"""Step of a difference that concerns the whole take."""


@dataclass(frozen=True, slots=True)
class Difference:
    """Something beyond tolerance.

    Attributes:
        step: the first at which it is, -1 for the whole take.
        kind: "position", "rotation", "alive", "scale", "channel", "contact", "event",
            "note", "ground", or "take" for what keeps all the rest from being compared.
        who: node, channel or part, such as "bug.l1.2".
        text: what differs at that step, such as "lies 3.1 mm off".
        excess: how often the largest difference of this kind and part holds its tolerance.
        worst: what that largest difference is, and where; empty for a single one.
    """

    step: int
    kind: str
    who: str
    text: str
    excess: float = 1.0
    worst: str = ""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of comparing a take with its golden.

    Attributes:
        scene: its name.
        outcome: whether it moves alike.
        elsewhere: how this machine and its libraries differ from those that the golden was
            made with; empty if the exact rule applies.
        differences: all beyond tolerance, the first first.
        moment: of the first difference, in words.
        totals: kind -> how many things of the kind could differ.
        bits: where the first bits differ, in words; empty if none do, or it is no wonder.
    """

    scene: str
    outcome: Outcome
    elsewhere: str
    differences: tuple[Difference, ...] = ()
    moment: str = ""
    totals: tuple[tuple[str, int], ...] = ()
    bits: str = ""

    @property
    def passed(self) -> bool:
        """Whether the golden still holds."""
        return self.outcome is not Outcome.CHANGED

    @property
    def first(self) -> Difference | None:
        """The first difference, None if there is none."""
        return self.differences[0] if self.differences else None

    @property
    def rule(self) -> str:
        """Which rule decided, in words."""
        if self.outcome is Outcome.IDENTICAL:
            return "exact: the digests of the motion agree"
        if self.elsewhere:
            return f"tolerant: {self.elsewhere}"
        return "tolerant: same class of processor and libraries, but other bits"

    def __str__(self) -> str:
        lines = [f"{self.scene}: {self.outcome.value} ({self.rule})"]
        if self.first is not None:
            lines.append(f"  first {self.moment}: {self.first.who} {self.first.text}")
        for kind, total in self.totals:
            found = [d for d in self.differences if d.kind == kind]
            if found:
                most = max(found, key=lambda d: d.excess)
                count = f"{len(found)} of {total}" if total else f"{len(found)}"
                end = f", most {most.who}: {most.worst}" if most.worst else ""
                lines.append(f"  {kind}: {count} differ{end}")
        if self.bits:
            lines.append(f"  {self.bits}")
        return "\n".join(lines)
