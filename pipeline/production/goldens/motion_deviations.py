"""Motion deviations: differences of a take's poses, channels and ground from its golden."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.production.goldens import motion_tolerance
from pipeline.production.goldens.motion_golden import (
    MotionGolden,
    channel_stride,
    sampled,
    sampled_rows,
)
from pipeline.production.goldens.motion_verdict import WHOLE_TAKE, Difference, millimetres
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take


@dataclass(frozen=True, eq=False)
class Deviations:
    """Differences of tracks of one kind from their golden.

    Attributes:
        kind: such as "position".
        who: (n,) names of the tracks.
        steps: (K,) of the rows.
        amounts: (K, n) differences.
        allowed: (n,) tolerances.
        format: returns an amount of a track as text.
    """

    kind: str
    who: Sequence[str]
    steps: NDArray[np.int64]
    amounts: Array
    allowed: Array
    format: Callable[[int, float], str]

    def differences(self) -> Iterator[Difference]:
        """Yield one difference for each track that exceeds its tolerance."""
        beyond = self.amounts > self.allowed
        for n in np.flatnonzero(beyond.any(axis=0)).tolist():
            amounts = self.amounts[:, n]
            first, most = int(np.argmax(beyond[:, n])), int(np.argmax(amounts))
            allowed = self.format(n, float(self.allowed[n]))
            yield Difference(
                int(self.steps[first]),
                self.kind,
                self.who[n],
                TEXTS[self.kind].format(self.format(n, float(amounts[first])), allowed),
                float(amounts[most] / self.allowed[n]),
                f"{self.format(n, float(amounts[most]))} at step {self.steps[most]}",
            )


TEXTS = {
    "position": "lies {} off (allowed: {})",
    "rotation": "is turned {} off (allowed: {})",
    "scale": "is scaled {} off (allowed: {})",
    "alive": "is there where the golden has none, or the other way round",
    "channel": "is {} off (allowed: {})",
}


def deviations(golden: MotionGolden, take: Take) -> list[Deviations]:
    """Return the deviations of poses and channels, nodes first.

    The take must have the golden's nodes, channels and rows.
    """
    now = sampled(take, golden.stride, golden.nodes, list(golden.channels))
    then = {name: series.values for name, series in golden.series.items()}
    a_row = take.header.steps // take.header.samples
    rows = sampled_rows(len(take.positions), golden.stride)
    frames = sampled_rows(len(take.values), channel_stride(golden.stride, take.header.samples))
    units = list(golden.channels.values())

    def nodes(
        kind: str, amounts: Array, allowed: float, text: Callable[[float], str]
    ) -> Deviations:
        bounds = np.full(len(golden.nodes), allowed)
        return Deviations(
            kind, golden.nodes, rows * a_row, amounts, bounds, lambda _, amount: text(amount)
        )

    return [
        nodes(
            "position",
            _distances(now, then, "positions", 3),
            motion_tolerance.POSITION,
            millimetres,
        ),
        nodes(
            "rotation",
            _angles(now["rotations"], then["rotations"]),
            motion_tolerance.ROTATION,
            degrees,
        ),
        nodes("scale", _distances(now, then, "scales", 3), motion_tolerance.SCALE, plain_number),
        nodes("alive", _distances(now, then, "alive", 1), 0.5, plain_number),
        Deviations(
            "channel",
            list(golden.channels),
            frames * a_row,
            _channel_differences(now["values"], then["values"], list(golden.channels), units),
            np.array([motion_tolerance.channel_tolerance(unit) for unit in units]),
            lambda n, amount: f"{amount:.3g} {units[n] if units[n] != '1' else ''}".rstrip(),
        ),
    ]


def ground_differences(golden: MotionGolden, take: Take) -> Iterator[Difference]:
    """Yield the difference of the ground of `take`, with as many vertices, from `golden`'s."""
    then = golden.series["terrain"].values
    now = sampled(take, golden.stride, (), ())["terrain"]
    amounts = np.linalg.norm(now - then, axis=-1)
    if not len(amounts) or not amounts.max() > motion_tolerance.POSITION:
        return
    most = int(np.argmax(amounts))
    x, y, z = now[most]
    yield Difference(
        WHOLE_TAKE,
        "ground",
        take.terrain.material,
        f"differs at {np.count_nonzero(amounts > motion_tolerance.POSITION)} "
        f"of {len(amounts)} places, most at ({x:.2f}, {y:.2f}, {z:.2f}): "
        f"{millimetres(float(amounts[most]))}",
    )


def degrees(radians: float) -> str:
    """Return an angle as text."""
    return f"{np.degrees(radians):.3g} degrees"


def plain_number(amount: float) -> str:
    """Return a number as text."""
    return f"{amount:.3g}"


def _distances(now: dict[str, Array], then: dict[str, Array], name: str, width: int) -> Array:
    """Return distances (K, J) between vectors of `width`."""
    apart = _by_node(now[name] - then[name], width)
    result: Array = np.linalg.norm(apart, axis=-1)
    return _nan_as_infinity(result)


def _angles(now: Array, then: Array) -> Array:
    """Return the angles (K, J) between rotations [rad]; a quaternion and its negative are equal.

    The chord between unit quaternions of rotations that are θ apart is 2 sin(θ/4), which is
    precise at small angles, unlike the cosine.
    """
    p, q = _by_node(now, 4), _by_node(then, 4)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    chord = np.minimum(np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1))
    result: Array = 4.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    return _nan_as_infinity(result)


def _channel_differences(now: Array, then: Array, names: list[str], units: list[str]) -> Array:
    """Return differences (K, C); angles and phases are periodic."""
    apart = np.where(np.isnan(now) & np.isnan(then), 0.0, now - then)
    for c, (name, unit) in enumerate(zip(names, units, strict=True)):
        period = 2.0 * np.pi if unit == "rad" else 1.0 if name.endswith("phase") else 0.0
        if period:
            apart[:, c] -= period * np.rint(apart[:, c] / period)
    return _nan_as_infinity(np.abs(apart))


def _by_node(values: Array, width: int) -> Array:
    return values.reshape(len(values), values.shape[1] // width, width)


def _nan_as_infinity(amounts: Array) -> Array:
    return np.where(np.isnan(amounts), np.inf, amounts)
