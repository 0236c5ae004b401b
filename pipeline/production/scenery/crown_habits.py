"""Crown habits: what broad-leaved trees and shrubs are like, by species and variant."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pipeline.production.scenery.prototype import Color


@dataclass(frozen=True)
class Crown:
    """A broad-leaved tree or shrub.

    Attributes:
        height: of the whole [m].
        trunk: height of the lowest branches relative to the whole.
        low: height of the foot of the crown relative to the whole.
        width: of the crown relative to the height.
        top: where the crown is widest: 0.5 in its middle, 0.8 near its top.
        stems: their number.
        foot: radius of the stem at the ground [m].
        attractors: points of free space.
        step: of growth [m].
        leaf: length of a leaf [m].
        leaf_wide: width of a leaf relative to its length.
        leaves: their number, nearby.
        color: of leaves, linear.
        young: colour of leaves at the outside of the crown.
        bark: its colour.
        sag: by which twigs hang.
        hollow: share of each lobe, from its middle, that stays without twigs.
        lobes: of the crown.
        tiers: storeys of the crown with air between them.
        lean: sidewards shift of the top relative to the height.
        escaped: share of shoots that stand out of the crown.
    """

    height: float
    trunk: float
    low: float
    width: float
    top: float
    stems: int
    foot: float
    attractors: int
    step: float
    leaf: float
    leaf_wide: float
    leaves: int
    color: Color
    young: Color
    bark: Color
    sag: float = 0.0
    hollow: float = 0.2
    lobes: int = 10
    tiers: int = 1
    lean: float = 0.0
    escaped: float = 0.0

    @property
    def is_shrub(self) -> bool:
        """Whether it branches from the ground."""
        return self.trunk < SHRUB


SHRUB = 0.1
"""Relative height of the lowest branches below which a plant is a shrub."""

CROWNS: dict[str, Crown] = {
    "oak": Crown(
        8.5, 0.20, 0.22, 1.05, 0.52, 1, 0.27, 900, 0.34, 0.135, 0.62, 36000,
        (0.108, 0.152, 0.036), (0.218, 0.268, 0.072), (0.115, 0.092, 0.068),
        escaped=0.05,
    ),
    "birch": Crown(
        9.5, 0.16, 0.20, 0.50, 0.42, 1, 0.10, 620, 0.32, 0.095, 0.72, 27000,
        (0.125, 0.170, 0.042), (0.258, 0.300, 0.088), (0.55, 0.53, 0.49),
        sag=0.22, hollow=0.1, lobes=12,
    ),
    "acacia": Crown(
        6.0, 0.27, 0.68, 1.55, 0.62, 1, 0.17, 800, 0.30, 0.108, 0.45, 27500,
        (0.108, 0.134, 0.046), (0.205, 0.224, 0.086), (0.135, 0.104, 0.076), hollow=0.1,
    ),
    "bush": Crown(
        1.5, 0.01, 0.0, 1.4, 0.40, 8, 0.020, 460, 0.11, 0.064, 0.58, 9600,
        (0.100, 0.142, 0.038), (0.205, 0.250, 0.074), (0.110, 0.086, 0.062), hollow=0.2, lobes=6,
        escaped=0.10,
    ),
    "scrub": Crown(
        0.7, 0.02, 0.06, 1.5, 0.6, 7, 0.0085, 300, 0.065, 0.031, 0.42, 4200,
        (0.115, 0.118, 0.064), (0.245, 0.232, 0.140), (0.130, 0.105, 0.078), hollow=0.1,
        escaped=0.06,
    ),
    "willow scrub": Crown(
        0.55, 0.02, 0.05, 1.8, 0.6, 7, 0.0075, 260, 0.06, 0.036, 0.38, 3700,
        (0.072, 0.095, 0.034), (0.215, 0.215, 0.095), (0.090, 0.068, 0.050), hollow=0.05,
    ),
}  # fmt: skip
"""Broad-leaved trees and shrubs."""

HABITS: dict[str, tuple[dict[str, float], ...]] = {
    "oak": (
        {},
        {"width": 1.2, "trunk": 0.16, "low": 0.16, "lobes": 12, "lean": 0.04},
        {"height": 9.4, "width": 0.82, "trunk": 0.24, "top": 0.58, "lobes": 11},
        {"width": 1.1, "top": 0.45, "lean": 0.10, "lobes": 9, "low": 0.26},
    ),
    "birch": (
        {},
        {"stems": 2, "width": 0.62, "lobes": 13},
        {"height": 10.4, "width": 0.40, "trunk": 0.22, "low": 0.28},
        {"height": 8.4, "lean": 0.12, "width": 0.55},
    ),
    "acacia": (
        {"width": 1.70, "low": 0.74, "lean": 0.05},
        {"tiers": 2, "low": 0.50, "width": 1.35, "height": 6.6, "lobes": 10},
        {"stems": 2, "width": 1.45, "low": 0.66, "lobes": 6, "hollow": 0.35},
        {"height": 5.0, "width": 1.05, "low": 0.50, "top": 0.72, "trunk": 0.2, "lean": 0.16},
    ),
    "bush": (
        {},
        {"width": 1.75, "height": 1.2, "lobes": 9},
        {"height": 1.8, "width": 1.0, "lean": 0.2, "lobes": 5},
        {"width": 1.5, "lobes": 4, "top": 0.55},
        {"height": 1.25, "width": 2.0, "lobes": 7, "lean": 0.15},
        {"height": 1.65, "lobes": 8, "hollow": 0.4},
    ),
}
"""What sets the variants of a species apart."""


def habit(kind: str, seed: int) -> Crown:
    """Return what the plant of a kind and seed is like."""
    varied = HABITS.get(kind, ({},))
    # Seeds of variants lie 101 apart.
    return replace(CROWNS[kind], **varied[(seed // 101) % len(varied)])  # type: ignore[arg-type]
