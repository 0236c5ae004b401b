"""Deviations: where the numbers of a take leave those of its golden."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_golden import MotionGolden
from pipeline.production.goldens.motion_sampling import channel_stride, kept, kept_rows
from pipeline.production.goldens.motion_verdict import WHOLE, Difference
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take


@dataclass(frozen=True, eq=False)
class Deviations:
    """How far tracks of one kind lie from their golden.

    Attributes:
        kind: such as "position".
        who: (n,) names of the tracks.
        steps: (K,) of the rows.
        amounts: (K, n) differences.
        allowed: (n,) tolerances.
        said: says an amount of a track in words.
    """

    kind: str
    who: Sequence[str]
    steps: NDArray[np.int64]
    amounts: Array
    allowed: Array
    said: Callable[[int, float], str]

    def differences(self) -> Iterator[Difference]:
        """Yield one difference for each track that is ever beyond tolerance."""
        beyond = self.amounts > self.allowed
        for n in np.flatnonzero(beyond.any(axis=0)).tolist():
            amounts = self.amounts[:, n]
            first, most = int(np.argmax(beyond[:, n])), int(np.argmax(amounts))
            allowed = self.said(n, float(self.allowed[n]))
            yield Difference(
                int(self.steps[first]),
                self.kind,
                self.who[n],
                TOLD[self.kind].format(self.said(n, float(amounts[first])), allowed),
                float(amounts[most] / self.allowed[n]),
                f"{self.said(n, float(amounts[most]))} at step {self.steps[most]}",
            )


TOLD = {
    "position": "lies {} off (allowed: {})",
    "rotation": "is turned {} off (allowed: {})",
    "scale": "is scaled {} off (allowed: {})",
    "alive": "is there where the golden has none, or the other way round",
    "channel": "is {} off (allowed: {})",
}


def deviations(golden: MotionGolden, take: Take) -> list[Deviations]:
    """Return how far poses and channels of `take` lie from `golden`, nodes first.

    The take has the golden's nodes, channels and rows.
    """
    now = kept(take, golden.stride, golden.nodes, list(golden.channels))
    then = {name: series.values for name, series in golden.series.items()}
    a_row = take.header.steps // take.header.samples
    rows = kept_rows(len(take.positions), golden.stride)
    frames = kept_rows(len(take.values), channel_stride(golden.stride, take.header.samples))
    units = list(golden.channels.values())

    def nodes(
        kind: str, amounts: Array, allowed: float, said: Callable[[float], str]
    ) -> Deviations:
        bounds = np.full(len(golden.nodes), allowed)
        return Deviations(
            kind, golden.nodes, rows * a_row, amounts, bounds, lambda _, amount: said(amount)
        )

    return [
        nodes(
            "position", _apart(now, then, "positions", 3), motion_tolerance.POSITION, millimetres
        ),
        nodes(
            "rotation",
            _angle(now["rotations"], then["rotations"]),
            motion_tolerance.ROTATION,
            degrees,
        ),
        nodes("scale", _apart(now, then, "scales", 3), motion_tolerance.SCALE, plain),
        nodes("alive", _apart(now, then, "alive", 1), 0.5, plain),
        Deviations(
            "channel",
            list(golden.channels),
            frames * a_row,
            _channels(now["values"], then["values"], list(golden.channels), units),
            np.array([motion_tolerance.of_unit(unit) for unit in units]),
            lambda n, amount: f"{amount:.3g} {units[n] if units[n] != '1' else ''}".rstrip(),
        ),
    ]


def ground(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    """Yield how the ground of `take`, of as many vertices, differs from `golden`'s."""
    then = golden.series["terrain"].values
    now = kept(take, golden.stride, (), ())["terrain"]
    amounts = np.linalg.norm(now - then, axis=-1)
    if not len(amounts) or not amounts.max() > motion_tolerance.POSITION:
        return
    most = int(np.argmax(amounts))
    x, y, z = now[most]
    yield Difference(
        WHOLE,
        "ground",
        take.terrain.material,
        f"differs at {np.count_nonzero(amounts > motion_tolerance.POSITION)} "
        f"of {len(amounts)} places, most at ({x:.2f}, {y:.2f}, {z:.2f}): "
        f"{millimetres(float(amounts[most]))}",
    )


def millimetres(metres: float) -> str:
    """Return a length in words."""
    return f"{metres * 1000:.3g} mm"


def degrees(radians: float) -> str:
    """Return an angle in words."""
    return f"{np.degrees(radians):.3g} degrees"


def plain(amount: float) -> str:
    """Return a number in words."""
    return f"{amount:.3g}"


def _apart(now: dict[str, Array], then: dict[str, Array], name: str, width: int) -> Array:
    """Return distances (K, J) between vectors of `width`."""
    apart = _by_node(now[name] - then[name], width)
    result: Array = np.linalg.norm(apart, axis=-1)
    return _known(result)


def _angle(now: Array, then: Array) -> Array:
    """Return the angles (K, J) between rotations [rad]; both signs of one are the same.

    The chord between unit quaternions of rotations that are θ apart is 2 sin(θ/4), which
    keeps its precision where the cosine has none.
    """
    p, q = _by_node(now, 4), _by_node(then, 4)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    chord = np.minimum(np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1))
    result: Array = 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    return _known(result)


def _channels(now: Array, then: Array, names: list[str], units: list[str]) -> Array:
    """Return differences (K, C); angles and phases come round, the others do not."""
    apart = np.where(np.isnan(now) & np.isnan(then), 0.0, now - then)
    for c, (name, unit) in enumerate(zip(names, units, strict=True)):
        period = 2.0 * np.pi if unit == "rad" else 1.0 if name.endswith("phase") else 0.0
        if period:
            apart[:, c] -= period * np.rint(apart[:, c] / period)
    return _known(np.abs(apart))


def _by_node(values: Array, width: int) -> Array:
    return values.reshape(len(values), values.shape[1] // width, width)


def _known(amounts: Array) -> Array:
    """Return `amounts` with infinity for what is no number."""
    return np.where(np.isnan(amounts), np.inf, amounts)
