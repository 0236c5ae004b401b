"""Verdict: what came of comparing a scene with its golden, layer by layer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Final, Literal

from pipeline.errors import CannotJudge, GoldenMissing, ProductionError, PronkError

Layer = Literal["motion", "frames", "film"]
LAYERS: Final[tuple[Layer, ...]] = ("motion", "frames", "film")


class Outcome(Enum):
    """Whether a layer still is what its golden says."""

    IDENTICAL = "identical"
    WITHIN = "within its limits"
    UNJUDGED = "cannot judge here"
    MISSING = "golden missing"
    DAMAGED = "golden damaged"
    FAILED = "could not be made"
    CHANGED = "changed"


PASSING: Final = (Outcome.IDENTICAL, Outcome.WITHIN)

_CODES: Final = {
    Outcome.CHANGED: PronkError.exit_code,
    Outcome.FAILED: ProductionError.exit_code,
    Outcome.DAMAGED: ProductionError.exit_code,
    Outcome.MISSING: GoldenMissing.exit_code,
    Outcome.UNJUDGED: CannotJudge.exit_code,
}
"""Exit codes, the gravest first."""


@dataclass(frozen=True, slots=True)
class Box:
    """A tile that differs: left, top, width, height [pixels], and by how much."""

    left: int
    top: int
    width: int
    height: int
    value: float


@dataclass(frozen=True, slots=True)
class FrameVerdict:
    """What came of comparing one frame.

    Attributes:
        frame: its number.
        outcome: of it.
        rule: what decided: "digest", "FLIP" or "z-test".
        text: the numbers in words.
        mean: FLIP over the picture.
        tile: FLIP over its worst tile.
        psnr: [dB], infinite if no pixel differs.
        z: of the worst tile, None where it was not asked for.
        boxes: the worst tiles, the worst first.
    """

    frame: int
    outcome: Outcome
    rule: str
    text: str
    mean: float = 0.0
    tile: float = 0.0
    psnr: float = float("inf")
    z: float | None = None
    boxes: tuple[Box, ...] = ()


@dataclass(frozen=True, slots=True)
class LayerVerdict:
    """What came of one layer of a scene.

    Attributes:
        layer: which.
        outcome: of it.
        text: in one line, what decided.
        details: more lines.
        frames: of the layer of frames.
        seconds: that it took.
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
        return self.outcome in PASSING


@dataclass(frozen=True, slots=True)
class SceneVerdict:
    """What came of all layers of a scene."""

    scene: str
    layers: tuple[LayerVerdict, ...]

    @property
    def passed(self) -> bool:
        """Whether every layer passed."""
        return all(layer.passed for layer in self.layers)

    @property
    def outcome(self) -> Outcome:
        """The gravest outcome of its layers."""
        return gravest(layer.outcome for layer in self.layers)

    def __str__(self) -> str:
        lines = [f"{self.scene}: {self.outcome.value}"]
        for layer in self.layers:
            lines.append(f"  {layer.layer:<6} {layer.outcome.value}: {layer.text}")
            lines.extend(f"         {detail}" for detail in layer.details)
        return "\n".join(lines)


def gravest(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the outcome that decides over several; identical if there is none."""
    order = [*_CODES, Outcome.WITHIN, Outcome.IDENTICAL]
    return min(outcomes, key=order.index, default=Outcome.IDENTICAL)


def exit_code(verdicts: Iterable[SceneVerdict]) -> int:
    """Return the code that a check with these verdicts ends in."""
    return _CODES.get(gravest(verdict.outcome for verdict in verdicts), 0)
