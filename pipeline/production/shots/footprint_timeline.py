"""Footprints of a take on soft ground, from the moment of each contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact, Take
from render.footprints import BLOCK, MAX_FOOTPRINTS, FootprintRaster, pack_texels

SOFT_GROUNDS: Mapping[str, tuple[float, float]] = {
    "snow": (0.035, 0.16),
    "sand": (0.022, 0.30),
    "mud": (0.020, 0.40),
    "soil": (0.012, 0.40),
    "grass": (0.008, 0.35),
    "moss": (0.008, 0.35),
}
"""Depth of a footprint [m] and its darkening, by the texture of the ground."""


@dataclass(frozen=True, slots=True)
class _FootprintShape:
    """Shape of a footprint in soft ground.

    Attributes:
        width: relative to the foot.
        min_radius: least radius [m].
        length: relative to the width.
        rim_height: of the raised rim, relative to the depth.
        rim_radius: outer radius of the rim, in radii of the footprint.
    """

    width: float = 1.5
    min_radius: float = 0.02
    length: float = 1.45
    rim_height: float = 0.35
    rim_radius: float = 1.6


@dataclass(frozen=True, slots=True)
class _TexelSpacing:
    """Resolution of the raster.

    Attributes:
        per_radius: texels across the radius of the smallest footprint.
        least: spacing [m].
        greatest: spacing [m].
    """

    per_radius: float = 7.0
    least: float = 0.002
    greatest: float = 0.01


SHAPE = _FootprintShape()
SPACING = _TexelSpacing()


@dataclass(frozen=True, eq=False)
class FootprintTimeline:
    """The footprints of a take.

    Attributes:
        raster: all footprints.
        rows: (n,) row of the take, with fraction, at which each is made, ascending.
    """

    raster: FootprintRaster
    rows: Array

    def count(self, row: float) -> int:
        """Return the number of footprints made until a row of the take."""
        return int(np.searchsorted(self.rows, row, side="right"))


@dataclass(frozen=True)
class _Foot:
    x: float
    z: float
    radius: float
    heading: float


def footprint_timeline(take: Take, texture: str) -> FootprintTimeline | None:
    """Return the footprints of a take, None on hard ground or without contacts.

    Args:
        take: with contacts.
        texture: of the ground.
    """
    contacts = [c for c in take.contacts if c.kind == "touch" and c.other == "terrain"]
    contacts = contacts[:MAX_FOOTPRINTS]
    if not contacts or texture not in SOFT_GROUNDS:
        return None
    radii = foot_radii(take)
    feet = [_foot(take, contact, radii) for contact in contacts]
    rows = [contact_row(take, contact) for contact in contacts]
    return FootprintTimeline(_raster(feet, *SOFT_GROUNDS[texture]), np.array(rows))


def contact_row(take: Take, contact: Contact) -> float:
    """Return the row of a take, with fraction, at which a contact starts."""
    header = take.header
    return (contact.step + contact.fraction) / header.steps * header.samples


def foot_radii(take: Take) -> dict[str, float]:
    """Return the radius of the last link of each limb, by the limb's name [m]."""
    radii: dict[str, float] = {}
    # The links of a limb are in order, so the last one wins.
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
    row = int(contact_row(take, contact))
    span = take.header.samples * 4
    path = take.positions[max(row - span, 0) : row + span + 1, body]
    way = path[-1] - path[0]
    heading = float(np.arctan2(way[2], way[0])) if np.hypot(way[0], way[2]) > 1e-3 else 0.0
    x, _, z = contact.place
    return _Foot(x, z, max(SHAPE.width * radius, SHAPE.min_radius), heading)


def _raster(feet: list[_Foot], depth: float, dark: float) -> FootprintRaster:
    spacing = min(foot.radius for foot in feet) / SPACING.per_radius
    spacing = float(np.clip(spacing, SPACING.least, SPACING.greatest))
    reach = SHAPE.rim_radius * SHAPE.length * max(foot.radius for foot in feet)
    places = np.array([[foot.x, foot.z] for foot in feet])
    corner = places.min(axis=0) - reach
    side = BLOCK * spacing
    columns, rows = np.ceil((places.max(axis=0) + reach - corner) / side).astype(int)
    blocks = np.zeros((rows, columns), np.uint32)
    texels = [np.zeros((BLOCK + 1, BLOCK + 1), np.uint32)]
    for number, foot in enumerate(feet, start=1):
        wide = SHAPE.rim_radius * SHAPE.length * foot.radius
        low = np.floor((np.array([foot.x, foot.z]) - wide - corner) / side).astype(int)
        high = np.floor((np.array([foot.x, foot.z]) + wide - corner) / side).astype(int)
        for j in range(max(low[1], 0), min(high[1], rows - 1) + 1):
            for i in range(max(low[0], 0), min(high[0], columns - 1) + 1):
                at = corner + np.array([i, j]) * side
                made = _stamp(foot, number, at, spacing, (depth, dark))
                if not made.any():
                    continue
                if blocks[j, i] == 0:
                    blocks[j, i] = len(texels)
                    texels.append(np.zeros_like(texels[0]))
                block = texels[blocks[j, i]]
                # The first footprint keeps its texels: the ground there is pressed already.
                np.copyto(block, made, where=block == 0)
    return FootprintRaster((float(corner[0]), float(corner[1])), spacing, blocks, np.array(texels))


def _stamp(
    foot: _Foot, number: int, corner: Array, spacing: float, soft: tuple[float, float]
) -> NDArray[np.uint32]:
    """Return the texels of a block under one foot, 0 beyond its rim."""
    at = np.arange(-1, BLOCK + 2) * spacing
    x, z = (corner[0] + at - foot.x)[None, :], (corner[1] + at - foot.z)[:, None]
    c, s = np.cos(foot.heading), np.sin(foot.heading)
    along, across = (c * x + s * z) / SHAPE.length, c * z - s * x
    # The outline varies by a few hundredths between footprints.
    angle = np.arctan2(across, along)
    waver = 1.0 + 0.05 * np.sin(3 * angle + 2.4 * number) + 0.04 * np.sin(5 * angle + 1.1 * number)
    rho = np.hypot(along, across) / (foot.radius * waver)
    t = ((1.05 - rho) / 0.4).clip(0, 1)
    hollow = t * t * (3 - 2 * t)
    depth = min(soft[0], 0.6 * foot.radius)
    rim = SHAPE.rim_height * np.exp(-(((rho - 1.2) / 0.17) ** 2))
    height = depth * (rim - hollow)
    slopes = np.stack([np.gradient(height, spacing, axis=axis) for axis in (1, 0)])
    inner = (slice(1, -1), slice(1, -1))
    reached = (rho < SHAPE.rim_radius)[inner]
    shade = soft[1] * hollow[inner]
    made = pack_texels(np.full(shade.shape, number, np.uint32), shade, slopes[:, 1:-1, 1:-1])
    return np.where(reached, made, np.uint32(0)).astype(np.uint32)
