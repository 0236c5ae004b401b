"""Footprints: what the feet of a take leave on soft ground, from the moment they touch it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Take
from render.footprints import BLOCK, MAX_FOOTPRINTS, FootprintRaster, pack_texels

DEPTHS: Mapping[str, tuple[float, float]] = {
    "snow": (0.035, 0.16),
    "sand": (0.022, 0.30),
    "mud": (0.020, 0.40),
    "soil": (0.012, 0.40),
    "grass": (0.008, 0.35),
}
"""How deep a foot goes into ground of a texture [m], and how much darker that makes it."""

LONGER = 1.45
"""Length of a print as a part of its width."""

RIM, REACH = 0.35, 1.6
"""Height of the rim as a part of the depth, and where it ends, in radii."""

FINENESS, FINEST, COARSEST = 7.0, 0.002, 0.01
"""Texels across the radius of the smallest foot, and bounds of their spacing [m]."""

WIDER, SMALLEST = 1.5, 0.02
"""How much wider a print is than the foot, and its radius at least [m]."""


@dataclass(frozen=True, eq=False)
class Footprints:
    """The prints of a take.

    Attributes:
        prints: their raster.
        rows: (n,) row of the take, with its fraction, at which each is made, ascending.
    """

    prints: FootprintRaster
    rows: Array

    def made(self, row: float) -> int:
        """Return how many have been made at a row of the take."""
        return int(np.searchsorted(self.rows, row, side="right"))


@dataclass(frozen=True)
class _Foot:
    x: float
    z: float
    radius: float
    heading: float


def footprints(take: Take, texture: str) -> Footprints | None:
    """Return the prints of a take's feet, None where the ground is hard or nobody treads on it.

    Args:
        take: what happened.
        texture: of the ground.
    """
    treads = [c for c in take.contacts if c.kind == "touch" and c.other == "terrain"]
    treads = treads[:MAX_FOOTPRINTS]
    if not treads or texture not in DEPTHS:
        return None
    radii = _radii(take)
    feet = [_foot(take, contact, radii) for contact in treads]
    rows = [_row(take, contact) for contact in treads]
    return Footprints(_raster(feet, *DEPTHS[texture]), np.array(rows))


def _row(take: Take, contact: Contact) -> float:
    header = take.header
    return (contact.step + contact.fraction) / header.steps * header.samples


def _radii(take: Take) -> dict[str, float]:
    """Return the radius of the last link of each limb, by the limb's name [m]."""
    radii: dict[str, float] = {}
    # Links of a limb stand in order, so that the last one stays.
    for part in take.parts:
        limb, _, number = part.name.rpartition(".")
        if number.isdecimal():
            spread = np.linalg.eigvalsh(np.cov(take.meshes[part.mesh].vertices.T.astype(float)))
            # On a circle the mean square of a coordinate is half that of the radius.
            radii[limb] = float(np.sqrt(2.0 * max(spread[1], 0.0)))
    return radii


def _foot(take: Take, contact: Contact, radii: Mapping[str, float]) -> _Foot:
    radius = radii.get(contact.part, radii.get(f"{contact.performer}.{contact.part}"))
    if radius is None:
        radius = 0.1 * contact.size
    body = next(i for i, node in enumerate(take.nodes) if node.performer == contact.performer)
    row = int(_row(take, contact))
    span = take.header.samples * 4
    path = take.positions[max(row - span, 0) : row + span + 1, body]
    way = path[-1] - path[0]
    heading = float(np.arctan2(way[2], way[0])) if np.hypot(way[0], way[2]) > 1e-3 else 0.0
    return _Foot(contact.place[0], contact.place[2], max(WIDER * radius, SMALLEST), heading)


def _raster(feet: list[_Foot], depth: float, dark: float) -> FootprintRaster:
    spacing = min(foot.radius for foot in feet) / FINENESS
    spacing = float(np.clip(spacing, FINEST, COARSEST))
    reach = REACH * LONGER * max(foot.radius for foot in feet)
    places = np.array([[foot.x, foot.z] for foot in feet])
    corner = places.min(axis=0) - reach
    side = BLOCK * spacing
    columns, rows = np.ceil((places.max(axis=0) + reach - corner) / side).astype(int)
    blocks = np.zeros((rows, columns), np.uint32)
    texels = [np.zeros((BLOCK + 1, BLOCK + 1), np.uint32)]
    for number, foot in enumerate(feet, start=1):
        wide = REACH * LONGER * foot.radius
        low = np.floor((np.array([foot.x, foot.z]) - wide - corner) / side).astype(int)
        high = np.floor((np.array([foot.x, foot.z]) + wide - corner) / side).astype(int)
        for j in range(max(low[1], 0), min(high[1], rows - 1) + 1):
            for i in range(max(low[0], 0), min(high[0], columns - 1) + 1):
                at = corner + np.array([i, j]) * side
                made = _pressed(foot, number, at, spacing, (depth, dark))
                if not made.any():
                    continue
                if blocks[j, i] == 0:
                    blocks[j, i] = len(texels)
                    texels.append(np.zeros_like(texels[0]))
                block = texels[blocks[j, i]]
                # Who came first keeps its place: the ground there is pressed already.
                np.copyto(block, made, where=block == 0)
    return FootprintRaster((float(corner[0]), float(corner[1])), spacing, blocks, np.array(texels))


def _pressed(
    foot: _Foot, number: int, corner: Array, spacing: float, soft: tuple[float, float]
) -> NDArray[np.uint32]:
    """Return the texels of a block under one foot, 0 where it does not reach."""
    at = np.arange(-1, BLOCK + 2) * spacing
    x, z = (corner[0] + at - foot.x)[None, :], (corner[1] + at - foot.z)[:, None]
    c, s = np.cos(foot.heading), np.sin(foot.heading)
    along, across = (c * x + s * z) / LONGER, c * z - s * x
    # No two prints are equal: the outline wavers by a few hundredths.
    angle = np.arctan2(across, along)
    waver = 1.0 + 0.05 * np.sin(3 * angle + 2.4 * number) + 0.04 * np.sin(5 * angle + 1.1 * number)
    rho = np.hypot(along, across) / (foot.radius * waver)
    t = ((1.05 - rho) / 0.4).clip(0, 1)
    hollow = t * t * (3 - 2 * t)
    depth = min(soft[0], 0.6 * foot.radius)
    rim = RIM * np.exp(-(((rho - 1.2) / 0.17) ** 2))
    height = depth * (rim - hollow)
    slopes = np.stack([np.gradient(height, spacing, axis=axis) for axis in (1, 0)])
    inner = (slice(1, -1), slice(1, -1))
    reached = (rho < REACH)[inner]
    shade = soft[1] * hollow[inner]
    made = pack_texels(np.full(shade.shape, number, np.uint32), shade, slopes[:, 1:-1, 1:-1])
    return np.where(reached, made, np.uint32(0)).astype(np.uint32)
