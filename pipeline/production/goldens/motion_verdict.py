"""Motion verdict: result of comparing a take with its golden."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class MotionOutcome(Enum):
    """Result of the comparison."""

    IDENTICAL = "identical"
    WITHIN = "equal within tolerance"
    CHANGED = "changed"


WHOLE_TAKE = -1
"""Step of a difference of the whole take."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference beyond tolerance.

    Attributes:
        step: the first beyond tolerance, -1 for the whole take.
        kind: "position", "rotation", "alive", "scale", "channel", "contact", "event",
            "note", "ground", or "take" for what makes the rest incomparable.
        who: node, channel or part, such as "bug.l1.2".
        text: of the difference at that step, such as "lies 3.1 mm off".
        excess: ratio of the largest difference of this kind and part to its tolerance.
        worst: text of that largest difference; empty for a single one.
    """

    step: int
    kind: str
    who: str
    text: str
    excess: float = 1.0
    worst: str = ""


@dataclass(frozen=True, slots=True)
class MotionVerdict:
    """Verdict on the motion of a take.

    Attributes:
        scene: its name.
        outcome: of the comparison.
        elsewhere: differences of machine and libraries from those of the golden; empty if the
            exact rule applies.
        differences: all beyond tolerance, in order of time.
        moment: of the first difference, as text.
        totals: kind -> number of things that could differ.
        bits: place of the first bits that differ, as text; empty if none do or other machines
            explain it.
    """

    scene: str
    outcome: MotionOutcome
    elsewhere: str
    differences: tuple[Difference, ...] = ()
    moment: str = ""
    totals: tuple[tuple[str, int], ...] = ()
    bits: str = ""

    @property
    def passed(self) -> bool:
        """Whether the golden still holds."""
        return self.outcome is not MotionOutcome.CHANGED

    @property
    def first(self) -> Difference | None:
        """The first difference, None if there is none."""
        return self.differences[0] if self.differences else None

    @property
    def rule(self) -> str:
        """The rule that decided, as text."""
        if self.outcome is MotionOutcome.IDENTICAL:
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


def millimetres(metres: float) -> str:
    """Return a length as text."""
    return f"{metres * 1000:.3g} mm"
