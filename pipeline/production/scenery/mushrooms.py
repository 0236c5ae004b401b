"""Mushrooms: caps with streaks, scales or warts over gills, on stems with bulb and skirt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.production.scenery.prototype import (
    Color,
    Prototype,
    Shape,
    add_rings,
    mixed,
    turned_rings,
    unit,
)
from pipeline.production.surroundings.lattice_noise import smoothstep
from pipeline.simulation.spatial import Array


@dataclass(frozen=True)
class Kind:
    """A kind of mushroom; lengths are in radii of the cap.

    Attributes:
        cap: linear colour of the middle of the cap.
        rim: colour of its rim.
        gills: colour of the gills.
        stem: colour of the stem.
        height: of a grown one, to the middle of its cap.
        dome: height of a young cap; an old one is a third of it.
        stout: radius of the stem.
        skirt: width of the ring around the stem.
        warts: number of warts of pale skin on the cap.
        scales: how dark its scales are, 0 to 1.
    """

    cap: Color
    rim: Color
    gills: Color
    stem: Color
    height: float
    dome: float
    stout: float
    skirt: float = 0.0
    warts: int = 0
    scales: float = 0.0


KINDS: tuple[Kind, ...] = (
    Kind((0.150, 0.062, 0.022), (0.330, 0.165, 0.065), (0.42, 0.36, 0.17),
         (0.46, 0.36, 0.22), height=1.7, dome=0.85, stout=0.30),
    Kind((0.190, 0.105, 0.050), (0.500, 0.400, 0.270), (0.52, 0.46, 0.36),
         (0.47, 0.41, 0.31), height=2.7, dome=0.75, stout=0.13, skirt=0.16, scales=0.75),
    Kind((0.400, 0.026, 0.012), (0.520, 0.085, 0.025), (0.62, 0.57, 0.46),
         (0.64, 0.60, 0.50), height=2.2, dome=0.80, stout=0.17, skirt=0.20, warts=26),
)  # fmt: skip
"""A bolete, a parasol and a fly agaric, by the seed."""

RADIUS = 0.035
"""Of a middling cap [m]."""

WART: Color = (0.66, 0.62, 0.52)

STEM = np.array(
    [[1.35, 0.0, 0.35], [1.55, 0.12, 0.75], [1.1, 0.35, 0.95], [0.95, 0.8, 1.0], [0.9, 1.0, 0.8]]
)
"""Radius, height and shade of a stem, relative to those of its kind: a soiled bulb at its foot."""

GILL_SHADE = np.array([1.0, 0.8, 0.55])[:, None, None]
"""Of gills from the rim to the stem."""


def mushroom(seed: int, level: int) -> Prototype:
    """Return two to five mushrooms of one kind, young and old, that lean from one another."""
    rng, shape = np.random.default_rng([seed, 47]), Shape()
    kind = KINDS[seed % len(KINDS)]
    count = int(rng.integers(2, 6))
    turn = rng.uniform(0.0, 2.0 * np.pi)
    for k in range(count):
        age = rng.uniform(0.15, 1.0) if k else rng.uniform(0.6, 1.0)
        angle = turn + 2.4 * k
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        at = out * 0.028 * np.sqrt(k) * rng.uniform(1.0, 1.9)
        lean = unit(np.array([0.0, 1.0, 0.0]) + out * rng.uniform(0.0, 0.25) * (k > 0))
        # Each has its own generator, because levels of detail draw different numbers of values.
        one = np.random.default_rng([seed, 47, k])
        _add_one(shape, kind, age, (at, lean), (one, level))
    return shape.prototype()


def _add_one(
    shape: Shape,
    kind: Kind,
    age: float,
    stand: tuple[Array, Array],
    drawn: tuple[np.random.Generator, int],
) -> None:
    """Add a mushroom.

    Args:
        shape: to which it is added.
        kind: of the mushroom.
        age: 0 to 1; the young are small and closed.
        stand: foot [m] and direction of its stem.
        drawn: source of what is random, and level of detail.
    """
    rng, level = drawn
    rings, sides = ((11, 32), (6, 14), (4, 8), (3, 5))[level]
    size = RADIUS * (0.35 + 0.65 * age) * rng.uniform(0.75, 1.35)
    height = kind.height * rng.uniform(0.8, 1.15)
    dome = kind.dome * (1.0 - 0.67 * age**2)
    t = np.linspace(0.02, 1.0, rings)[:, None]
    around = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)[None]
    # Caps are not turned on a lathe: their rims are waved, old ones most.
    waves, phases = np.array([[2.0, 0.045], [3.0, 0.035], [5.0, 0.03]]), rng.uniform(0, 6.3, 3)
    wave = (waves[:, 1:] * np.cos(waves[:, :1] * around + phases[:, None])).sum(axis=0)[None]
    radius = np.sin(0.5 * np.pi * t) ** 0.85 * (1.0 + wave * t**2)
    top = height + dome * np.cos(0.5 * np.pi * t) ** 0.8 + 0.9 * age * wave * t**3
    color, lift = _cap_skin(kind, t, around, wave, rng)
    # Gills hang below the rim and run up to the stem.
    inward = np.array([0.97, 0.62, 1.1 * kind.stout])[:, None]
    below = top[-1:] - np.array([0.10, 0.0, -0.06])[:, None]
    plate = np.where(np.arange(sides) % 2, 1.0, 0.62)[:, None]
    fibre = 1.0 + 0.10 * rng.normal(size=(sides, 1))
    gills = np.array(kind.gills)
    sheets = [
        (turned_rings(radius, top + 0.05 * lift, around), color, True),
        (turned_rings(inward * radius[-1:], below, around), gills * plate * GILL_SHADE, True),
        (
            turned_rings(kind.stout * STEM[:, :1], (height + 0.05) * STEM[:, 1:2], around),
            np.array(kind.stem) * fibre * STEM[:, 2:, None],
            False,
        ),
    ]
    if kind.skirt and age > 0.4 and level < 2:
        hang = np.array([0.72, 0.70, 0.60])[:, None] * height - 0.4 * np.abs(wave)
        wide = kind.stout + kind.skirt * np.array([0.0, 0.55, 1.0])[:, None] * (1.0 + 3.0 * wave)
        sheets.append((turned_rings(wide, hang, around), gills * fibre, True))
    foot, lean = stand
    side = unit(np.cross(lean, [0.0, 0.0, 1.0]))
    frame = np.stack([side, lean, np.cross(side, lean)])
    for places, colors, faces_up in sheets:
        add_rings(shape, foot + size * places @ frame, colors, upward=faces_up)


def _cap_skin(
    kind: Kind, t: Array, around: Array, wave: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return the colours (R, S, 3) of a cap and how high warts lie on it (R, S), 0 to 1.

    Args:
        kind: of the mushroom.
        t: (R, 1) from the middle, 0, to the rim, 1.
        around: (1, S) angles [rad].
        wave: (1, S) of the rim.
        rng: source of what is random.
    """
    shape = len(t), around.shape[1]
    color = mixed(np.array(kind.cap), kind.rim, smoothstep(0.15, 1.0, t + 1.5 * wave * t))
    streak = rng.normal(0.0, 0.05, (1, shape[1])) + rng.normal(0.0, 0.03, shape)
    color = color * (1.0 + streak * (0.3 + t))[..., None]
    if kind.scales:
        # Skin that tears as the cap opens: whole in the middle, in rows of scales beyond.
        torn = np.cos(19.0 * t + 3.0 * np.sin(4.0 * around) + rng.normal(0.0, 0.8, shape))
        scale = smoothstep(0.1, 0.7, torn) * (1.0 - 0.7 * t) * (t > 0.2) + (t <= 0.2)
        color = mixed(color, kind.cap, kind.scales * scale)
    lift = _warts(kind.warts, t, around, rng)
    return mixed(color, WART, smoothstep(0.15, 0.55, lift)), lift


def _warts(count: int, t: Array, around: Array, rng: np.random.Generator) -> Array:
    """Return the heights, 0 to 1, of warts strewn evenly over a cap (R, S)."""
    found = np.zeros(np.broadcast_shapes(t.shape, around.shape))
    for k in range(count):
        # Leaves of a sunflower: even, and in no rows.
        far, angle = np.sqrt((k + 0.5) / count), 2.39996 * k + rng.normal(0.0, 0.15)
        x = t * np.cos(around) - far * np.cos(angle)
        z = t * np.sin(around) - far * np.sin(angle)
        found = np.maximum(found, np.exp(-(x * x + z * z) / rng.uniform(0.04, 0.085) ** 2))
    return found
