"""The hard upper plates of a beetle: two ridged wing cases, pronotum and scutellum, as it stands.

They are lofted, since a mesh of lumps is too coarse for an edge: wing cases end sharply at the seam
and in a raised rim, and the pronotum has hind corners and a groove along its middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.simulation.figures.hide.sheets import Paint, lay, outward, painted
from pipeline.simulation.figures.hide.stance import smoothstep
from pipeline.simulation.figures.solids import Solid, loft
from pipeline.simulation.spatial import Array

RIDGES = 7
"""Ridges along a wing case."""

GROOVE = 0.030
"""Depth of the grooves between them, in the half width of the body."""

CASE_RINGS = 30

SQUARENESS = 0.86
"""Exponent of a cross-section's sine and cosine: 1 is an ellipse, less is flatter on top."""

RIM_COLOR, GROOVE_COLOR = "#6f5426", "#070605"


@dataclass(frozen=True)
class ShellPlan:
    """Where the upper plates of a beetle are [m], X ahead and Y up.

    Attributes:
        front: of the pronotum, along X.
        waist: where pronotum and wing cases meet, along X.
        rear: end of the wing cases, along X.
        rim: height of the lower edge of the plates.
        half_width: of the wing cases.
        height: of their top above the rim.
    """

    front: float
    waist: float
    rear: float
    rim: float
    half_width: float
    height: float

    def case_width(self, t: Array) -> Array:
        """Return the half width (n,) of both wing cases at shares (n,) of their length."""
        shoulder = 0.76 + 0.24 * np.sin(0.5 * np.pi * np.clip(t / 0.42, 0.0, 1.0)) ** 0.7
        tip = np.sqrt(1.0 - np.clip((t - 0.42) / 0.58, 0.0, 1.0) ** 2.5)
        return np.asarray(self.half_width * shoulder * tip)

    def case_height(self, t: Array) -> Array:
        """Return the height (n,) of the wing cases above their rim."""
        front = 0.80 + 0.20 * np.sin(0.5 * np.pi * np.clip(t / 0.40, 0.0, 1.0))
        back = 1.0 - np.clip((t - 0.40) / 0.62, 0.0, 1.0) ** 2.2
        return np.asarray(self.height * front * back)


def wing_case(plan: ShellPlan, side: float) -> tuple[Solid, Paint]:
    """Return the wing case of one side, 1 on the right, and its paint."""
    t = 1.0 - (1.0 - np.linspace(0.0, 1.0, CASE_RINGS)) ** 1.35
    t = 0.997 * t
    # Three vertices a ridge: one in the groove and two on the ridge.
    u = np.linspace(0.0, 1.0, 3 * RIDGES + 1)
    in_groove = (np.arange(len(u)) % 3 == 0).astype(float)
    in_groove[[0, -1]] = 0.0
    wide, high = plan.case_width(t)[:, None], plan.case_height(t)[:, None]
    # Ridges run out before the tip.
    deep = GROOVE * plan.half_width * in_groove * smoothstep((1.0 - t) / 0.12)[:, None]
    angle = 0.5 * np.pi * u
    across = np.sin(angle) ** SQUARENESS * (wide - 0.6 * deep)
    up = np.cos(angle) ** SQUARENESS * high - deep * np.cos(0.7 * angle)
    edge = 0.020 * plan.half_width
    # The seam: a bevel, then a wall between the two cases.
    seam = np.full_like(wide, 0.12 * edge)
    walls_z = [seam, seam]
    walls_y = [up[:, :1] - 3.2 * edge, up[:, :1] - 0.7 * edge]
    across[:, :1] = 0.9 * edge * np.minimum(wide / plan.half_width * 4.0, 1.0) + seam
    # The rim stands out and turns up; the lower side goes back to the seam.
    rim_z = [wide + 0.4 * edge, wide + 2.4 * edge, wide + 2.4 * edge, wide - 3.0 * edge]
    rim_y = [0.3 * edge + 0 * wide, 1.3 * edge + 0 * wide, -0.8 * edge + 0 * wide, -edge + 0 * wide]
    z = np.concatenate([*walls_z, across, *rim_z], axis=1)
    y = np.concatenate([*walls_y, up, *rim_y], axis=1)
    x = plan.waist + (plan.rear - plan.waist) * t[:, None]
    # The front edge is slanted: a wing case begins behind the shoulders' middle.
    x = x + 0.05 * plan.half_width * (1.0 - t[:, None]) * (1.0 - 2.0 * z / plan.half_width)
    rings = np.stack([np.broadcast_to(x, z.shape), plan.rim + y, side * z], axis=-1)
    solid = outward(loft(rings, rings.mean(axis=1)[[0, -1]]))
    paint = painted(len(solid.vertices), GROOVE_COLOR, 0.0)
    dark = np.concatenate([[0.9, 0.7], 0.75 * in_groove, [0.0, 0.0, 0.0, 0.8]])
    bright = np.concatenate([np.zeros(len(u)), [0.25], np.ones(5)])
    bright[len(u)] = 0.35
    for color, share in ((GROOVE_COLOR, dark), (RIM_COLOR, 0.7 * bright)):
        lay(paint, color, np.concatenate([np.tile(share, len(t)), [0.0, 0.0]]))
    return solid, paint


def pronotum(plan: ShellPlan) -> tuple[Solid, Paint]:
    """Return the shield behind the head, and its paint."""
    t = np.array([0.0, 0.02, 0.06, 0.14, 0.26, 0.40, 0.54, 0.68, 0.80, 0.89, 0.95, 0.985, 1.0])
    wide = np.interp(t, [0.0, 0.14, 0.40, 0.80, 1.0], [0.58, 0.70, 0.80, 0.70, 0.72])
    wide = plan.half_width * wide
    high = np.interp(t, [0.0, 0.06, 0.4, 0.8, 0.95, 1.0], [0.44, 0.56, 0.74, 0.74, 0.66, 0.58])
    high = plan.height * high
    v = np.array([0.0, 0.035, 0.09, 0.2, 0.34, 0.48, 0.62, 0.74, 0.84, 0.90, 0.96, 1.0])
    angle = 0.5 * np.pi * v
    z = np.sin(angle) ** SQUARENESS * wide[:, None]
    y = np.cos(angle) ** 0.75 * high[:, None]
    inside = np.sin(np.pi * t)[:, None]
    groove = np.exp(-((v / 0.03) ** 2))
    y = y - 0.035 * plan.half_width * inside**0.5 * groove
    # A gutter along the side, and a dent before each hind corner.
    gutter = np.exp(-(((v - 0.90) / 0.05) ** 2))
    y = y - 0.03 * plan.half_width * gutter
    dent = np.exp(-(((v - 0.5) / 0.12) ** 2)) * np.exp(-(((t[:, None] - 0.84) / 0.09) ** 2))
    y = y - 0.07 * plan.half_width * dent
    edge = 0.022 * plan.half_width
    z = np.concatenate([z, z[:, -1:] + edge, z[:, -1:] + edge, z[:, -1:] - 4 * edge], axis=1)
    low = np.array([0.8, -1.2, -2.0]) * edge
    y = np.concatenate([y, np.broadcast_to(low, (len(t), 3))], axis=1)
    z = np.concatenate([-z[:, :0:-1], z], axis=1)
    y = np.concatenate([y[:, :0:-1], y], axis=1)
    off = (z / plan.half_width) ** 2
    # Hollow towards the head, hind corners drawn back.
    ahead = 0.16 * (1.0 - t[:, None]) * off - 0.12 * t[:, None] * off
    x = plan.front + (plan.waist - plan.front) * t[:, None] + plan.half_width * ahead
    rings = np.stack([x, plan.rim + y, z], axis=-1)
    solid = outward(loft(rings, rings.mean(axis=1)[[0, -1]]))
    paint = painted(len(solid.vertices), GROOVE_COLOR, 0.0)
    half = np.concatenate([smoothstep((v - 0.78) / 0.16), [1.0, 1.0, 0.6]])
    rim = np.concatenate([half[:0:-1], half])
    dark = np.concatenate([groove, [0.0, 0.0, 0.0]])
    dark = 0.6 * np.concatenate([dark[:0:-1], dark])
    lay(paint, GROOVE_COLOR, np.concatenate([np.tile(dark, len(t)), [0.0, 0.0]]))
    lay(paint, RIM_COLOR, 0.6 * np.concatenate([np.tile(rim, len(t)), [0.0, 0.0]]))
    return solid, paint


def scutellum(plan: ShellPlan) -> tuple[Solid, Paint]:
    """Return the small triangular plate between the roots of the wing cases, and its paint."""
    t = np.array([0.0, 0.1, 0.4, 0.7, 0.9, 1.0])
    wide = 0.17 * plan.half_width * np.array([0.9, 1.0, 0.78, 0.46, 0.20, 0.03])
    angle = np.arange(10) * (2.0 * np.pi / 10)
    length = 0.30 * plan.half_width
    top = plan.rim + plan.case_height(t * length / (plan.waist - plan.rear))
    thick = 0.03 * plan.half_width
    x = np.broadcast_to((plan.waist - t * length)[:, None], (len(t), 10))
    y = top[:, None] + thick * (np.sin(angle) - 0.5)
    z = wide[:, None] * np.cos(angle)
    rings = np.stack([x, y, z], axis=-1)
    solid = outward(loft(rings, rings.mean(axis=1)[[0, -1]]))
    return solid, painted(len(solid.vertices), GROOVE_COLOR, 0.5)
