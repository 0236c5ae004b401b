"""Patterns of ground materials."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.textures.noise import TILE, cells, noise, pebbles

Array = NDArray[np.floating]
Drawn = tuple[Array, Array, Array, float]
"""Shade, warmth, relief [m] and natural size [m] of a tile; see `render.textures.Tile`."""


def soil(rng: np.random.Generator) -> Drawn:
    """Draw crumbs of soil of three sizes and stones on a crust with cracks, with straw on it."""
    swell, grit = noise(rng, 1.5, first=6), noise(rng, 0.3, first=150)
    first, second, _ = cells(rng, 27, warp=0.3)
    crust = np.clip(1.2 * noise(rng, 1.5, first=3) + 0.1, 0.0, 1.0)
    crack = np.exp(-(((second - first) / 0.05) ** 2)) * crust
    shade = (0.84 + 0.07 * swell) * (1.0 - 0.35 * crack)
    relief = 0.0012 * noise(rng, 1.2, first=13, last=70) - 0.004 * crack
    tint = np.zeros((TILE, TILE))
    # Loose crumbs lie where the crust is broken.
    loose = np.clip(0.75 - 0.9 * crust + 0.35 * noise(rng, 1.3, first=7), 0.0, 1.0)
    kinds = (
        (190, 0.75, 0.0025, 0.0),
        (110, 0.5, 0.005, 0.0),
        (58, 0.35, 0.010, 0.04),
        (30, 0.10, 0.020, 0.16),
    )
    for across, share, high, pale in kinds:
        dome, own = pebbles(rng, across, share)
        shown = (dome > 0) & ((loose > 0.5 + 0.35 * own) | (pale > 0.1))
        # A crumb is dark at its foot, where it shades the ground and itself.
        lit = 0.36 + 0.80 * np.sqrt(dome) + pale
        shade = np.where(shown, lit * (1 + 0.2 * own), shade)
        relief = np.where(shown, relief + high * dome, relief)
        tint = np.where(shown, own - (2.0 if pale > 0.1 else 0.0), tint)
    shade = 1.15 * shade * (1.0 + 0.10 * grit)
    relief = relief + 0.0004 * grit
    warmth = 0.2 * noise(rng, 1.4, first=5) + 0.22 * tint
    for count, longest, light in ((420, 26, 1.25), (90, 60, 0.7), (60, 70, 1.35)):
        row, column = _lines(rng, count, longest)
        shade[row, column] = light * rng.uniform(0.75, 1.25, (count, 1))
        warmth[row, column] = 0.5
        relief[row, column] += 0.0012
    return shade.clip(0.3, 1.9), warmth.clip(-1, 1), relief, 2.6


def sand(rng: np.random.Generator) -> Drawn:
    """Draw wind ripples."""
    bend, grain = noise(rng, 2.4, first=2), noise(rng, 0.3, first=90)
    y, x = np.mgrid[0:TILE, 0:TILE] / TILE
    phase = 2 * np.pi * (17 * y + 4 * x) + 1.9 * bend
    # The lee side of a ripple is steeper than the windward one.
    ripple = np.sin(phase + 0.45 * np.sin(phase))
    height = 0.6 + 0.4 * np.tanh(noise(rng, 2.0, first=2))
    relief = 0.0055 * ripple * height + 0.0028 * noise(rng, 1.6, first=5) + 0.0003 * grain
    shade = 1 + 0.05 * ripple * height + 0.05 * grain + 0.03 * noise(rng, 1.2, first=6)
    return shade.clip(0.5, 1.5), 0.2 * noise(rng, 1.3, first=5), relief, 2.2


def grass(rng: np.random.Generator) -> Drawn:
    """Draw blades from above: short, every way, over moss and thatch without waves of its own."""
    blades, points = 70_000, 24
    along = np.linspace(0, 1, points)[None, :]
    clump, fine = noise(rng, 1.3, first=11), noise(rng, 1.1, first=34)
    root = rng.uniform(0, TILE, (2, blades, 1))
    # Blades of one way in a patch would look combed.
    heading = rng.uniform(0, 2 * np.pi, (blades, 1)) + rng.normal(0, 0.5, (blades, 1)) * along
    length = rng.uniform(9, 30, (blades, 1))
    row = (root[0] + length * along * np.sin(heading)).astype(np.intp) % TILE
    column = (root[1] + length * along * np.cos(heading)).astype(np.intp) % TILE
    tall = rng.uniform(0.4, 1.0, (blades, 1)) * np.sin(np.pi * (0.15 + 0.75 * along))
    height = np.zeros((TILE, TILE))
    np.maximum.at(height, (row, column), tall)
    np.maximum.at(height, (row, (column + 1) % TILE), tall * 0.97)
    tint = np.zeros((TILE, TILE))
    top = tall >= height[row, column]
    tint[row[top], column[top]] = np.broadcast_to(rng.normal(0, 1, (blades, 1)), row.shape)[top]
    # A few metres away blades are finer than pixels: a lawn shows tufts and dark gaps between them.
    tufts, own = pebbles(rng, 30, 0.9)
    gaps = 0.72 + 0.42 * tufts + 0.10 * own * (tufts > 0)
    # Low light turns any wave of the ground into a ripple: the relief is that of blades alone.
    relief = 0.0035 * height + 0.0012 * clump + 0.0008 * fine
    shade = (0.5 + 0.65 * height) * (1 + 0.14 * tint) * (1 + 0.13 * clump) * (1 + 0.12 * fine)
    shade = shade * gaps
    warmth = 0.3 * tint + 0.22 * clump + 0.2 * noise(rng, 1.5, first=4)
    return shade.clip(0.2, 2.0), warmth.clip(-1, 1), relief, 1.9


def moss(rng: np.random.Generator) -> Drawn:
    """Draw cushions of moss of three sizes, with fallen needles and scraps of leaves on them."""
    shade, relief, tint = (np.full((TILE, TILE), level) for level in (0.62, 0.0, 0.0))
    cushions = ((70, 0.8, 0.005, 0.66), (31, 0.75, 0.013, 0.70), (14, 0.6, 0.026, 0.74))
    for across, share, high, dark in cushions:
        dome, own = pebbles(rng, across, share)
        over = dome > 0
        # A cushion is dark at its rim, where it meets the next.
        shade = np.where(over, dark + 0.55 * dome + 0.12 * own, shade)
        relief = np.where(over, np.maximum(relief, high * dome), relief)
        tint = np.where(over, own, tint)
    fuzz, stars = noise(rng, 0.25, first=130), noise(rng, 0.9, first=60)
    shade = shade * (1 + 0.17 * fuzz + 0.09 * stars) * (1 + 0.1 * noise(rng, 1.5, first=4))
    relief = relief + 0.0007 * fuzz + 0.0006 * stars
    warmth = 0.35 * tint + 0.3 * noise(rng, 1.5, first=5)
    for count, longest, light, brown in ((1500, 34, 0.78, 0.9), (260, 90, 0.6, 0.8)):
        row, column = _lines(rng, count, longest)
        shade[row, column] = light * rng.uniform(0.6, 1.4, (count, 1))
        warmth[row, column] = brown
        relief[row, column] += 0.0012
    return shade.clip(0.2, 1.9), warmth.clip(-1, 1), relief, 1.1


def _lines(
    rng: np.random.Generator, count: int, longest: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns (N, P) of straight lines up to a length [texels]."""
    along = np.linspace(0, 1, longest)[None, :]
    root = rng.uniform(0, TILE, (2, count, 1))
    heading, length = rng.uniform(0, 2 * np.pi, (count, 1)), rng.uniform(0.4, 1.0, (count, 1))
    row = root[0] + longest * length * along * np.sin(heading)
    column = root[1] + longest * length * along * np.cos(heading)
    return row.astype(np.intp) % TILE, column.astype(np.intp) % TILE


def snow(rng: np.random.Generator) -> Drawn:
    """Draw drifts under a crust."""
    drift, crust, grain = (
        noise(rng, 2.4, first=3),
        noise(rng, 1.2, first=20),
        noise(rng, 0.2, first=120),
    )
    relief = 0.012 * drift + 0.0012 * crust + 0.0003 * grain
    return 1 + 0.015 * crust + 0.02 * grain, 0.1 * drift, relief, 2.4


def rock(rng: np.random.Generator) -> Drawn:
    """Draw slabs that cracks part, chipped at their edges, with stones of two sizes on them."""
    first, second, owner = cells(rng, 7, warp=0.35)
    fine_first, fine_second, _ = cells(rng, 23, warp=0.3)
    crack = np.exp(-(((second - first) / 0.04) ** 2))
    broken = noise(rng, 1.6, first=5) > 0.3
    chip = np.exp(-(((fine_second - fine_first) / 0.06) ** 2)) * broken
    rough, grain = noise(rng, 2.0, first=7), noise(rng, 0.9, first=60)
    facet = rng.uniform(-1, 1, 49)[owner]
    stones, stone_tint = pebbles(rng, 40, 0.16)
    grit, grit_tint = pebbles(rng, 95, 0.14)
    relief = 0.005 * rough + 0.007 * facet - 0.010 * crack - 0.0015 * chip
    relief += 0.0005 * grain + 0.020 * stones + 0.004 * grit
    shade = 1 + 0.12 * rough + 0.11 * facet - 0.4 * crack - 0.12 * chip + 0.08 * grain
    shade += np.where(stones > 0, 0.18 + 0.22 * stone_tint, 0) + 0.22 * grit_tint * (grit > 0)
    warmth = 0.45 * noise(rng, 1.5, first=4) + 0.15 * stone_tint * (stones > 0)
    return shade.clip(0.25, 1.8), warmth.clip(-1, 1), relief, 2.9


def gravel(rng: np.random.Generator) -> Drawn:
    """Draw stones of three sizes, the larger on the smaller."""
    cobbles, cobble_tint = pebbles(rng, 17, 0.3)
    large, large_tint = pebbles(rng, 36, 0.65)
    small, small_tint = pebbles(rng, 84, 0.9)
    relief, shade, tint = 0.006 * small, 0.8 * np.sqrt(small), small_tint
    for lies, own, low, high in (
        (large, large_tint, 0.004, 0.012),
        (cobbles, cobble_tint, 0.006, 0.016),
    ):
        over = lies > 0
        relief = np.where(over, low + high * lies, relief)
        shade = np.where(over, np.sqrt(lies), shade)
        tint = np.where(over, own, tint)
    shade = 0.62 + 0.28 * tint + 0.45 * shade + 0.06 * noise(rng, 0.4, first=80)
    return shade.clip(0.15, 2.0), (0.6 * tint).clip(-1, 1), relief, 1.8


def mud(rng: np.random.Generator) -> Drawn:
    """Draw stirred and settled mud."""
    swirl, lumps = noise(rng, 2.0, first=5), noise(rng, 1.5, first=14)
    hollow = np.tanh(1.4 * swirl)
    relief = 0.016 * hollow + 0.003 * lumps
    shade = 1 + 0.2 * hollow + 0.08 * lumps + 0.03 * noise(rng, 0.6, first=60)
    return shade.clip(0.4, 1.7), 0.3 * noise(rng, 1.6, first=5).clip(-2, 2), relief, 2.2


def asphalt(rng: np.random.Generator) -> Drawn:
    """Draw chips of stone in tar."""
    chips, tint = pebbles(rng, 128, 0.85)
    shade = 0.75 + 0.5 * chips * (0.6 + 0.7 * tint) + 0.07 * noise(rng, 1.0, first=8)
    return shade.clip(0.2, 2.0), 0.25 * tint, 0.0022 * chips, 1.0


def ice(rng: np.random.Generator) -> Drawn:
    """Draw deep cracks, and clouds of air below the surface."""
    first, second, _ = cells(rng, 5, warp=0.3)
    fine_first, fine_second, _ = cells(rng, 17, warp=0.5)
    crack = np.exp(-(((second - first) / 0.02) ** 2))
    hair = np.exp(-(((fine_second - fine_first) / 0.02) ** 2)) * (noise(rng, 2.0, first=4) > 0.2)
    cloud = np.tanh(noise(rng, 1.9, first=4))
    shade = 0.9 + 0.18 * cloud + 0.5 * crack + 0.3 * hair
    return (
        shade.clip(0.4, 1.9),
        -0.3 * cloud,
        0.0012 * noise(rng, 2.0, first=6) - 0.001 * crack,
        2.5,
    )


def waves(rng: np.random.Generator) -> Drawn:
    """Draw wind waves on water, with their crests along the rows."""
    long, short = noise(rng, 1.9, first=6, last=40, stretch=0.45), noise(rng, 1.5, first=24)
    relief = 0.11 * long + 0.018 * short
    return 1 + 0.06 * long.clip(-2, 2), 0.1 * long.clip(-2, 2), relief, 9.0


def tiles(rng: np.random.Generator) -> Drawn:
    """Draw six by six floor tiles, each of its own tone, with grout between them."""
    return _slabs(rng, np.zeros((6, 6)))


def checker(rng: np.random.Generator) -> Drawn:
    """Draw six by six floor tiles, light and dark."""
    row, column = np.indices((6, 6))
    return _slabs(rng, 0.72 * ((row + column) % 2 * 2.0 - 1.0))


def slabs(rng: np.random.Generator) -> Drawn:
    """Draw four by four slabs of stone: worn edges, pits, stains, earthy joints, some cracks."""
    across, size = 4, 1.8
    y, x = np.mgrid[0:TILE, 0:TILE] * (across / TILE)
    row, column = y.astype(int), x.astype(int)
    edge = np.minimum(np.minimum(x - column, 1 - x + column), np.minimum(y - row, 1 - y + row))
    edge = edge * (size / across)
    ragged = noise(rng, 1.2, first=24).clip(-2, 2)
    edge = edge + 0.0016 * ragged
    joint = np.exp(-((edge.clip(0) / 0.0072) ** 2))
    # Feet and wheels have rounded the edges.
    shoulder = np.clip((edge - 0.005) / 0.026, 0, 1)
    shoulder = shoulder * (2 - shoulder)
    dirt = np.exp(-edge.clip(0) / (0.02 + 0.012 * noise(rng, 1.6, first=10).clip(-1, 3)))
    stain, hewn = noise(rng, 1.7, first=6), noise(rng, 1.5, first=18)
    sand, (pit, _, _) = noise(rng, 0.5, first=90), cells(rng, 90)
    pore = np.exp(-((pit / 0.2) ** 2)) * (noise(rng, 1.4, first=12) > 0.5)
    first, second, _ = cells(rng, 3, warp=0.4)
    crack = np.exp(-(((second - first) / 0.007) ** 2)) * (noise(rng, 1.9, first=4) > 1.0)
    tone = rng.normal(0, 0.06, (across, across))[row, column]
    warm = rng.normal(0, 0.18, (across, across))[row, column]
    shade = 1 + tone + 0.05 * stain + 0.045 * hewn + 0.05 * sand - 0.16 * dirt
    shade = shade * (1 - 0.62 * joint) * (1 - 0.4 * pore) * (1 - 0.55 * crack)
    relief = 0.0007 * hewn + 0.0002 * sand + 0.0034 * shoulder - 0.0008 * pore - 0.001 * crack
    # A joint has the hue of neither slab, so that no step lies in it.
    warmth = warm * (1 - joint) + 0.35 * dirt + 0.15 * stain
    return shade.clip(0.1, 1.8), warmth.clip(-1, 1), relief, size


def _slabs(rng: np.random.Generator, tones: Array) -> Drawn:
    """Draw square slabs in 2.4 m, whose tones (N, N) vary a little."""
    across = len(tones)
    y, x = np.mgrid[0:TILE, 0:TILE] * (across / TILE)
    row, column = y.astype(int), x.astype(int)
    edge = np.minimum(np.minimum(x - column, 1 - x + column), np.minimum(y - row, 1 - y + row))
    # The edges of a slab are rounded over a few millimetres.
    rise = np.clip((edge - 0.012) / 0.018, 0, 1)
    slab = rise * rise * (3 - 2 * rise)
    tone = (tones + rng.normal(0, 0.06, (across, across)))[row, column]
    shade = np.where(slab > 0.02, 1.0 + tone, 0.6) + 0.05 * noise(rng, 1.2, first=6)
    relief = 0.004 * slab + 0.00015 * noise(rng, 1.4, first=12)
    return shade.clip(0.12, 2.0), 0.15 * noise(rng, 1.6, first=4).clip(-2, 2), relief, 2.4
