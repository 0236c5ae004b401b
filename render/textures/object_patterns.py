"""Patterns of objects and creatures; directional ones run along the rows."""

from __future__ import annotations

import numpy as np

from render.textures.ground_patterns import Drawn
from render.textures.noise import TILE, cells, noise


def wood(rng: np.random.Generator) -> Drawn:
    """Draw year rings and fibres of a board."""
    fibre = noise(rng, 0.9, first=14, stretch=24.0)
    flow = noise(rng, 2.2, first=2, stretch=5.0)
    y = np.mgrid[0:TILE, 0:TILE][0] / TILE
    ring = np.sin(2 * np.pi * 7 * y + 2.2 * flow) ** 3
    shade = 1 + 0.2 * ring + 0.1 * fibre
    return shade.clip(0.4, 1.6), 0.3 * ring, 0.0003 * fibre + 0.0004 * ring, 0.5


def mottle(rng: np.random.Generator) -> Drawn:
    """Draw soft spots."""
    spots = np.tanh(1.6 * noise(rng, 1.8, first=5))
    fine = noise(rng, 0.8, first=40)
    return 1 + 0.22 * spots + 0.05 * fine, 0.3 * spots, 0.002 * fine, 1.0


def planks(rng: np.random.Generator) -> Drawn:
    """Draw a floor of boards laid end to end, each nailed thrice, some with cracks and knots."""
    boards, size = len(BOARD_ENDS), 1.6
    y, x = np.mgrid[0:TILE, 0:TILE] / TILE
    row = (y * boards).astype(int)
    across = y * boards - row
    x = (x + np.array(BOARD_ENDS)[row]) % 1
    beside, end = np.minimum(across, 1 - across) * (size / boards), np.minimum(x, 1 - x) * size
    gap = np.minimum(beside, end)
    groove = np.exp(-((gap / 0.0021) ** 2))
    # Edges are worn round, and dirt lies along them.
    dirt = np.exp(-gap / 0.007) * (0.6 + 0.4 * noise(rng, 1.5, first=9).clip(-1.5, 1.5))
    shade, warmth, relief, _ = wood(rng)
    # Every board shows another part of the wood.
    at = rng.integers(0, TILE, (2, boards))
    rows = (np.arange(TILE)[:, None] + at[0][row]) % TILE
    columns = (np.arange(TILE)[None, :] + at[1][row]) % TILE
    tone = rng.normal(0, 0.07, boards)[row]
    crack = _cracks(rng, boards)
    nail = np.zeros_like(x)
    for place in (0.02, 0.5, 0.98):
        for side in (0.2, 0.8):
            away = np.hypot((x - place) * size, (across - side) * size / boards)
            nail = np.maximum(nail, np.exp(-((away / 0.0034) ** 4)))
    shade = 0.6 + 0.4 * shade[rows, columns] + tone + 0.035 * noise(rng, 1.5, first=8)
    shade = shade * (1 - 0.8 * groove) * (1 - 0.22 * dirt) * (1 - 0.6 * crack) * (1 - 0.55 * nail)
    relief = relief[rows, columns] - 0.002 * groove - 0.0006 * crack - 0.0003 * nail
    return shade.clip(0.08, 1.8), warmth[rows, columns] * (1 - nail), relief, size


BOARD_ENDS = (0.0, 0.55, 0.2, 0.8, 0.4, 0.05, 0.65, 0.3, 0.9, 0.48, 0.12, 0.72)
"""Where the boards of each row of `planks` end [tiles]."""


def _cracks(rng: np.random.Generator, boards: int) -> np.ndarray:
    """Return cracks along some boards, 0 to 1."""
    line = noise(rng, 1.7, first=5, stretch=30.0)
    thin = np.exp(-((line / 0.035) ** 2))
    some = (rng.random(boards) < 0.5)[(np.arange(TILE) * boards // TILE)][:, None]
    return np.asarray(thin * some * (noise(rng, 1.9, first=3) > 0.7), np.float32)


def shell(rng: np.random.Generator) -> Drawn:
    """Draw the pits and clouds of a beetle's wing-case, in rows along it."""
    first, _, _ = cells(rng, 40)
    pit = np.exp(-((first / 0.28) ** 2))
    y = np.mgrid[0:TILE, 0:TILE][0] / TILE
    stria = np.cos(2 * np.pi * 14 * y) ** 8
    cloud = np.tanh(noise(rng, 1.9, first=4))
    shade = 1 + 0.08 * cloud - 0.16 * pit - 0.05 * stria + 0.03 * noise(rng, 0.8, first=40)
    relief = -0.0006 * pit - 0.0003 * stria + 0.0004 * cloud
    return shade.clip(0.4, 1.6), 0.35 * cloud, relief, 0.3


def carapace(rng: np.random.Generator) -> Drawn:
    """Draw the granules, pits and clouds of plates without rows, as of crabs and scorpions."""
    first, _, _ = cells(rng, 44, warp=0.2)
    tiny, _, _ = cells(rng, 90)
    granule = np.exp(-((first / 0.30) ** 2))
    pit = np.exp(-((tiny / 0.20) ** 2))
    cloud, worn = np.tanh(noise(rng, 1.9, first=4)), noise(rng, 1.4, first=9)
    shade = 1 + 0.14 * cloud + 0.05 * worn + 0.07 * granule - 0.12 * pit
    relief = 0.0005 * granule - 0.0004 * pit + 0.0005 * cloud
    return shade.clip(0.4, 1.6), (0.45 * cloud + 0.12 * worn).clip(-1, 1), relief, 0.3


def fur(rng: np.random.Generator) -> Drawn:
    """Draw hair that lies along the rows, in tufts."""
    hair, tuft = noise(rng, 0.7, first=40, stretch=14.0), noise(rng, 1.5, first=9, stretch=4.0)
    patch = noise(rng, 1.8, first=4)
    shade = 1 + 0.11 * hair + 0.1 * tuft + 0.06 * patch
    return shade.clip(0.35, 1.8), 0.25 * patch + 0.15 * tuft, 0.0005 * hair + 0.0012 * tuft, 0.32


def plumage(rng: np.random.Generator) -> Drawn:
    """Draw rows of vanes that overlap like shingles."""
    y, x = np.mgrid[0:TILE, 0:TILE] / TILE
    rows = 8
    row = np.floor(x * rows)
    along, across = x * rows - row, (y * 12 + 0.5 * (row % 2)) % 1.0 - 0.5
    # A vane ends in a round tip; beyond it the next row is visible.
    end = 0.55 + 0.45 * np.sqrt(np.clip(1 - (2 * across) ** 2, 0, 1))
    under = along > end
    barbs = noise(rng, 0.6, first=60, stretch=10.0)
    height = np.where(under, 0.15, along / end)
    shade = 0.7 + 0.45 * height - 0.25 * np.exp(-((across / 0.03) ** 2)) * ~under + 0.12 * barbs
    return (
        shade.clip(0.3, 1.7),
        0.2 * noise(rng, 1.7, first=4),
        0.006 * height + 0.0004 * barbs,
        0.5,
    )


def pores(rng: np.random.Generator) -> Drawn:
    """Draw skin: pores between fine folds, and flushed areas."""
    first, second, _ = cells(rng, 70, warp=0.2)
    fold = np.exp(-(((second - first) / 0.12) ** 2))
    pore = np.exp(-((first / 0.15) ** 2))
    flush = noise(rng, 1.9, first=4)
    # Hardly flushed: in the shadow, and in the contrast of a low sun, more looks like dirt.
    shade = 1 + 0.02 * flush - 0.06 * fold - 0.1 * pore
    return shade.clip(0.5, 1.4), 0.1 * flush.clip(-2, 2), -0.0002 * fold - 0.0002 * pore, 0.12


def wrinkles(rng: np.random.Generator) -> Drawn:
    """Draw thick hide: a net of deep wrinkles with finer ones between them, and dry dust."""
    first, second, _ = cells(rng, 14, warp=0.30)
    near, next_to, _ = cells(rng, 46, warp=0.25)
    deep = np.exp(-(((second - first) / 0.11) ** 2))
    fine = np.exp(-(((next_to - near) / 0.16) ** 2))
    dust = np.tanh(noise(rng, 1.9, first=4))
    shade = 1.06 - 0.30 * deep - 0.15 * fine + 0.06 * dust
    relief = -0.0030 * deep - 0.0010 * fine
    return shade.clip(0.4, 1.5), 0.25 * dust, relief, 0.5


def scales(rng: np.random.Generator) -> Drawn:
    """Draw keeled scales in rows offset by half a scale, and clouds of colour over them."""
    y, x = np.mgrid[0:TILE, 0:TILE] / TILE
    rows, across = 20, 16
    nearest, off = np.full(x.shape, 9.0), np.zeros_like(x)
    for half in (0, 1):
        # Twice as many rows as columns, every second one offset: each scale has six neighbours.
        v = (y * across + 0.5 * half) % 1.0 - 0.5
        u = (x * rows + 0.5 * half) % 1.0 - 0.5
        away = np.hypot(v, 0.86 * u)
        off = np.where(away < nearest, v, off)
        nearest = np.minimum(nearest, away)
    dome = np.clip(1.0 - (nearest / 0.52) ** 2, 0.0, 1.0)
    edge = np.exp(-(((nearest - 0.50) / 0.07) ** 2))
    keel = np.exp(-((off / 0.06) ** 2)) * dome
    cloud = np.tanh(noise(rng, 1.8, first=5))
    shade = 0.82 + 0.26 * dome - 0.30 * edge + 0.12 * keel + 0.10 * cloud
    shade += 0.03 * noise(rng, 0.7, first=50)
    relief = 0.0045 * np.sqrt(dome) + 0.0012 * keel
    return shade.clip(0.3, 1.6), 0.35 * cloud, relief, 0.5


def weave(rng: np.random.Generator) -> Drawn:
    """Draw threads that go over and under one another."""
    threads = 40
    y, x = np.mgrid[0:TILE, 0:TILE] * (threads / TILE)
    over = (np.floor(x) + np.floor(y)) % 2 == 0
    warp, weft = np.abs(np.sin(np.pi * x)), np.abs(np.sin(np.pi * y))
    height = np.where(over, warp * (0.6 + 0.4 * weft), weft * (0.6 + 0.4 * warp))
    # Thicker threads here and there, but no clouds: cloth with these looks felted from afar.
    slub = noise(rng, 0.9, first=10, stretch=6.0) + noise(rng, 0.9, first=10, stretch=6.0).T
    shade = 0.5 + 0.7 * height + 0.035 * slub
    return shade.clip(0.2, 1.6), 0.1 * slub.clip(-3, 3), 0.0012 * height, 0.22


def scratches(rng: np.random.Generator) -> Drawn:
    """Draw lacquer with fine scratches along the rows and some dust."""
    fine = noise(rng, 0.5, first=60, stretch=40.0)
    worn = np.clip(noise(rng, 1.1, first=6) - 1.6, 0, 1)
    shade = 1 + 0.03 * fine + 0.5 * worn + 0.04 * noise(rng, 1.6, first=4)
    return shade.clip(0.5, 1.8), -0.2 * worn, 0.00002 * fine - 0.0002 * worn, 0.4


def brushed(rng: np.random.Generator) -> Drawn:
    """Draw metal brushed along the rows."""
    line, stain = noise(rng, 0.5, first=40, stretch=60.0), noise(rng, 1.8, first=4)
    return 1 + 0.07 * line + 0.05 * stain, 0.3 * stain.clip(-2, 2), 0.00004 * line, 0.3


def plaster(rng: np.random.Generator) -> Drawn:
    """Draw plaster smoothed with a trowel."""
    trowel, grain = noise(rng, 1.8, first=4), noise(rng, 0.7, first=50)
    shade = 1 + 0.035 * trowel + 0.025 * grain
    return shade, 0.12 * trowel.clip(-2, 2), 0.0016 * trowel + 0.00015 * grain, 1.0


def clay(rng: np.random.Generator) -> Drawn:
    """Draw fired clay: grooves of the wheel, grains, pale bloom."""
    groove, grain = noise(rng, 1.0, first=12, stretch=30.0), noise(rng, 0.6, first=60)
    bloom = np.tanh(noise(rng, 1.9, first=4))
    shade = 1 + 0.05 * groove + 0.06 * grain + 0.1 * bloom
    return shade.clip(0.5, 1.6), -0.3 * bloom, 0.0005 * groove + 0.0001 * grain, 0.4


def marble(rng: np.random.Generator) -> Drawn:
    """Draw veins."""
    vein = np.exp(-np.abs(noise(rng, 2.0, first=4)) / 0.07)
    fine = np.exp(-np.abs(noise(rng, 1.7, first=9)) / 0.04)
    shade = 1.06 - 0.42 * vein - 0.15 * fine + 0.04 * noise(rng, 1.6, first=5)
    return shade.clip(0.3, 1.3), 0.2 * vein, np.zeros_like(shade), 0.6
