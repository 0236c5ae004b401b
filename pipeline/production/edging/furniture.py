"""Furniture: what is built of boards and iron along a floor: railings, planters, benches, lamps."""

from __future__ import annotations

import numpy as np

from pipeline.production.edging.border import Border
from pipeline.production.scenery.prototype import UP
from pipeline.simulation.spatial import Array

LANTERN = 3.33
"""Height of the light of a lamp post [m]."""


def rim(border: Border, material: str, level: float) -> None:
    """Add a beam around a deck, a little over its boards, and a skirt below it."""
    rows = border.rows(0.06, 1.6, 0.1, 0.1)
    spans = border.spans(rows, 1.6, 0.06)
    points = np.stack([rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1)
    sizes = np.column_stack([spans - 0.004, np.full(len(spans), 0.16), np.full(len(spans), 0.12)])
    border.carpentry.add(material, points - [0.0, 0.03, 0.0], sizes, rows.heading)


def railing(border: Border, level: float, material: str) -> None:
    """Add posts with a handrail and two lower rails."""
    rows = border.rows(-0.12, 1.5, 1.0, 0.12)
    if not len(rows.places):
        return
    spans = border.spans(rows, 1.5, -0.12)
    base = np.stack([rows.places[:, 0], np.full(len(rows.places), level), rows.places[:, 1]], -1)
    along = np.stack([np.cos(rows.heading), np.zeros(len(base)), -np.sin(rows.heading)], axis=-1)
    for side in (-0.5, 0.5):
        posts = base + side * spans[:, None] * along + [0.0, 0.5, 0.0]
        border.carpentry.add(material, posts, (0.085, 1.02, 0.085), rows.heading)
        border.carpentry.add(material, posts + 0.525 * UP, (0.12, 0.03, 0.12), rows.heading)
    for up, high, deep in ((0.96, 0.045, 0.11), (0.66, 0.05, 0.03), (0.36, 0.05, 0.03)):
        sizes = np.column_stack([spans, np.full(len(spans), high), np.full(len(spans), deep)])
        border.carpentry.add(material, base + up * UP, sizes, rows.heading)


def planters(border: Border, out: float, spacing: float, material: str, level: float) -> None:
    """Add boxes of boards with bushes and flowers."""
    rows = border.rows(out, spacing, 0.9, 0.55)
    n = len(rows.places)
    if not n:
        return
    rng = np.random.default_rng([border.seed, 454])
    base = np.stack([rows.places[:, 0], np.full(n, level), rows.places[:, 1]], -1)
    long, deep, tall = 1.05, 0.46, 0.42
    _box_of_boards(border, material, base, rows.heading, (long, tall, deep))
    border.carpentry.add(
        "edging dark soil",
        base + (tall - 0.06) * UP,
        (long - 0.08, 0.06, deep - 0.08),
        rows.heading,
    )
    along = np.stack([np.cos(rows.heading), np.zeros(n), -np.sin(rows.heading)], axis=-1)
    for side in (-0.3, 0.02, 0.31):
        foot = base + side * along * rng.uniform(0.8, 1.2, (n, 1)) + [0.0, tall - 0.12, 0.0]
        border.add_plants("bush", foot, 0.38, rng)
    for kind in ("poppy", "daisy", "meadow grass", "meadow grass"):
        for side in (-0.42, -0.15, 0.15, 0.42):
            foot = base + (side + rng.normal(0, 0.06, (n, 1))) * along + [0, tall - 0.04, 0]
            foot[:, [0, 2]] += rng.normal(0, 0.09, (n, 2))
            border.add_plants(kind, foot, 1.0, rng)


def _box_of_boards(
    border: Border, material: str, base: Array, heading: Array, size: tuple[float, float, float]
) -> None:
    """Add boxes whose sides are three boards one over another."""
    long, tall, deep = size
    side = np.stack([np.sin(heading), np.zeros(len(base)), np.cos(heading)], axis=-1)
    along = np.stack([np.cos(heading), np.zeros(len(base)), -np.sin(heading)], axis=-1)
    board = tall / 3.0
    for k in range(3):
        up = [0.0, board * (k + 0.5), 0.0]
        for way in (-0.5, 0.5):
            border.carpentry.add(
                material, base + way * deep * side + up, (long, board - 0.006, 0.025), heading
            )
            border.carpentry.add(
                material, base + way * long * along + up, (0.025, board - 0.006, deep), heading
            )
    for a in (-0.5, 0.5):
        for b in (-0.5, 0.5):
            corner = base + a * long * along + b * deep * side + [0.0, 0.5 * tall + 0.015, 0.0]
            border.carpentry.add(material, corner, (0.06, tall + 0.03, 0.06), heading)


def benches(border: Border, out: float, spacing: float) -> None:
    """Add park benches that face the floor."""
    rows = border.rows(out, spacing, 0.9, 0.9)
    n = len(rows.places)
    if not n:
        return
    base = border.points(rows.places)
    heading = rows.heading
    back = np.stack([rows.outward[:, 0], np.zeros(n), rows.outward[:, 1]], axis=-1)
    along = np.stack([np.cos(heading), np.zeros(n), -np.sin(heading)], axis=-1)
    for k in range(4):
        slat = base + (-0.16 + 0.11 * k) * back + [0.0, 0.45, 0.0]
        border.carpentry.add("edging weathered", slat, (1.6, 0.03, 0.09), heading)
    for k in range(3):
        slat = base + (0.25 + 0.03 * k) * back + [0.0, 0.58 + 0.12 * k, 0.0]
        border.carpentry.add("edging weathered", slat, (1.6, 0.09, 0.028), heading)
    for side in (-0.62, 0.62):
        foot = base + side * along
        border.carpentry.add(
            "edging iron", foot - 0.14 * back + [0, 0.21, 0], (0.05, 0.46, 0.05), heading
        )
        border.carpentry.add(
            "edging iron", foot + 0.24 * back + [0, 0.42, 0], (0.05, 0.88, 0.05), heading
        )
        border.carpentry.add(
            "edging iron", foot + 0.05 * back + [0, 0.42, 0], (0.05, 0.04, 0.42), heading
        )


def lamps(border: Border, out: float, spacing: float) -> None:
    """Add lamp posts of cast iron with a lantern each."""
    rows = border.rows(out, spacing, 3.6, 0.25)
    if not len(rows.places):
        return
    base = border.points(rows.places)
    iron = "edging iron"
    for up, wide, high in (
        *((0.12, 0.34, 0.3), (0.4, 0.22, 0.3), (1.75, 0.09, 2.6), (2.6, 0.16, 0.06)),
        *((3.08, 0.14, 0.08), (3.56, 0.40, 0.05)),
    ):
        border.carpentry.add(iron, base + up * UP, (wide, high, wide), rows.heading)
    border.carpentry.add(iron, base + 3.68 * UP, (0.40, 0.22, 0.40), rows.heading, top=(0.15, 0.15))
    border.carpentry.add(
        "edging lantern glass", base + LANTERN * UP, (0.13, 0.2, 0.13), rows.heading
    )
    for k in range(4):
        # Bars at the corners: the lantern is open.
        angle = rows.heading + (k + 0.5) * 0.5 * np.pi
        aside = np.stack([np.cos(angle), np.zeros(len(base)), -np.sin(angle)], axis=-1)
        border.carpentry.add(
            iron, base + 0.19 * aside + LANTERN * UP, (0.022, 0.42, 0.022), rows.heading
        )
