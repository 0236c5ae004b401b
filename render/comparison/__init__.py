"""Comparison: how different two pictures look, and where.

FLIP says how visible a difference is to somebody who flips between both pictures; its mean
over the worst tile finds what is small, its mean over the picture what is everywhere.
"""

from render.comparison.flip import JUDGES, flip, judge
from render.comparison.psnr import psnr
from render.comparison.spread import Spread, distances, spread_of
from render.comparison.tiles import TILE, tile_box, tile_means

__all__ = [
    "JUDGES",
    "TILE",
    "Spread",
    "distances",
    "flip",
    "judge",
    "psnr",
    "spread_of",
    "tile_box",
    "tile_means",
]
