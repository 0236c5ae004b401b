"""Verdicts on a scene and the layers of its golden."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Final, Literal

from pipeline.errors import CannotJudge, GoldenMissing, ProductionError, PronkError

Layer = Literal["motion", "frames", "film"]
LAYERS: Final[tuple[Layer, ...]] = ("motion", "frames", "film")


class Outcome(Enum):
    """Result of comparing a layer with its golden."""

    IDENTICAL = "identical"
    WITHIN = "within its limits"
    UNJUDGED = "cannot judge here"
    MISSING = "golden missing"
    DAMAGED = "golden damaged"
    FAILED = "could not be made"
    CHANGED = "changed"


PASSING_OUTCOMES: Final = (Outcome.IDENTICAL, Outcome.WITHIN)

_CODES: Final = {
    Outcome.CHANGED: PronkError.exit_code,
    Outcome.FAILED: ProductionError.exit_code,
    Outcome.DAMAGED: ProductionError.exit_code,
    Outcome.MISSING: GoldenMissing.exit_code,
    Outcome.UNJUDGED: CannotJudge.exit_code,
}
"""Exit codes, the most severe first."""


@dataclass(frozen=True, slots=True)
class Box:
    """A tile that differs: left, top, width, height [pixels], and its error."""

    left: int
    top: int
    width: int
    height: int
    value: float


@dataclass(frozen=True, slots=True)
class FrameVerdict:
    """Verdict on one frame.

    Attributes:
        frame: its number.
        outcome: of the comparison.
        rule: that decided: "digest", "FLIP" or "z-test".
        text: the numbers as text.
        mean: FLIP over the picture.
        tile: FLIP over its worst tile.
        psnr: [dB], infinite if no pixel differs.
        z: of the worst tile or region, None where it is not needed.
        exposure: change of the mean luminance [stops].
        boxes: the worst tiles, in descending order.
    """

    frame: int
    outcome: Outcome
    rule: str
    text: str
    mean: float = 0.0
    tile: float = 0.0
    psnr: float = float("inf")
    z: float | None = None
    exposure: float = 0.0
    boxes: tuple[Box, ...] = ()


@dataclass(frozen=True, slots=True)
class LayerVerdict:
    """Verdict on one layer of a scene.

    Attributes:
        layer: its name.
        outcome: of the comparison.
        text: reason in one line.
        details: more lines.
        frames: verdicts of the layer of frames.
        seconds: time of the check [s].
    """

    layer: Layer
    outcome: Outcome
    text: str
    details: tuple[str, ...] = ()
    frames: tuple[FrameVerdict, ...] = ()
    seconds: float = 0.0

    @property
    def passed(self) -> bool:
        """Whether the golden still holds."""
        return self.outcome in PASSING_OUTCOMES


@dataclass(frozen=True, slots=True)
class SceneVerdict:
    """Verdict on all layers of a scene."""

    scene: str
    layers: tuple[LayerVerdict, ...]

    @property
    def passed(self) -> bool:
        """Whether every layer passed."""
        return all(layer.passed for layer in self.layers)

    @property
    def outcome(self) -> Outcome:
        """The most severe outcome of its layers."""
        return gravest_outcome(layer.outcome for layer in self.layers)

    def __str__(self) -> str:
        lines = [f"{self.scene}: {self.outcome.value}"]
        for layer in self.layers:
            lines.append(f"  {layer.layer:<6} {layer.outcome.value}: {layer.text}")
            lines.extend(f"         {detail}" for detail in layer.details)
        return "\n".join(lines)


def gravest_outcome(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the most severe of several outcomes; identical if there are none."""
    order = [*_CODES, Outcome.WITHIN, Outcome.IDENTICAL]
    return min(outcomes, key=order.index, default=Outcome.IDENTICAL)


def exit_code(verdicts: Iterable[SceneVerdict]) -> int:
    """Return the exit code of a check with these verdicts."""
    return _CODES.get(gravest_outcome(verdict.outcome for verdict in verdicts), 0)
