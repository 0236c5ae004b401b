"""Laid pieces: slabs and boards that differ: each shows another piece of the tile, in its own tone.

A tile holds a few pieces; a floor of them in the same order would show the repetition.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from render.textures.object_patterns import BOARD_ENDS

SLABS: Mapping[str, int] = {"slabs": 4, "tiles": 6}
"""Slabs along a tile, by its pattern."""

TONES: Mapping[str, float] = {"slabs": 0.10, "tiles": 0.055, "planks": 0.17}
"""Deviation of the tones of whole pieces, by pattern."""

HUES: Mapping[str, float] = {"slabs": 0.22, "tiles": 0.12, "planks": 0.2}
"""Greatest share of warmth that a whole piece adds."""

SEEN = 5.0, 7.5
"""Mip levels of a tile between which whole pieces become smaller than pixels."""

ENDS = "ends"
"""Name of the surface parameter that holds the ends of the boards of a tile."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Where pieces of a floor are looked up, `mi.Float` each.

    Attributes:
        u: along the rows [tiles].
        v: along the columns [tiles].
        tone: factor on its brightness.
        warmth: that it adds.
    """

    u: Any
    v: Any
    tone: Any
    warmth: Any


def has_pieces(pattern: str) -> bool:
    """Return whether a pattern is of pieces that can be exchanged for one another."""
    return pattern in TONES


def prepare(pattern: str, values: dict[str, Any]) -> None:
    """Add what pieces need to the parameters of a surface."""
    if pattern == "planks":
        values[ENDS] = mi.Float(list(BOARD_ENDS))


def laid(pattern: str, u: Any, v: Any, level: Any, values: dict[str, Any]) -> Piece:
    """Return the piece at coordinates in tiles.

    Args:
        pattern: of slabs or boards.
        u: along the rows.
        v: along the columns.
        level: mip level that is looked up.
        values: parameters of the surface.
    """
    if pattern == "planks":
        rows = len(BOARD_ENDS)
        row = dr.floor(v * rows)
        number = mi.UInt32(mi.Int32(row))
        word = _hash(number, mi.UInt32(77))
        source = word % rows
        along = u + _part(_hash(word, mi.UInt32(5)))
        board = dr.floor(along + dr.gather(mi.Float, values[ENDS], source))
        found = along, (mi.Float(source) + v * rows - row) / rows
        word = _hash(number, mi.UInt32(mi.Int32(board)))
    else:
        across = SLABS[pattern]
        i, j = dr.floor(u * across), dr.floor(v * across)
        word = _hash(mi.UInt32(mi.Int32(i)), mi.UInt32(mi.Int32(j)))
        source_u, source_v = word % across, (word >> 9) % across
        found = (
            (mi.Float(source_u) + u * across - i) / across,
            (mi.Float(source_v) + v * across - j) / across,
        )
    seen = dr.clip((SEEN[1] - mi.Float(level)) / (SEEN[1] - SEEN[0]), 0.0, 1.0)
    first, second = _part(_hash(word, mi.UInt32(11))), _part(_hash(word, mi.UInt32(13)))
    # The sum of two is nearer to normal: few pieces stand out.
    tone = (first + second - 1.0) * (2.45 * TONES[pattern])
    hue = (_part(_hash(word, mi.UInt32(17))) * 2.0 - 1.0) * HUES[pattern]
    return Piece(*found, 1.0 + seen * tone, seen * hue)


def _hash(a: Any, b: Any) -> Any:
    word = (a * 0x9E3779B1) ^ (b * 0x85EBCA77)
    word ^= word >> 15
    word *= 0x2C1B3C6D
    word ^= word >> 12
    word *= 0x297A2D39
    return word ^ (word >> 15)


def _part(word: Any) -> Any:
    return mi.Float(word >> 8) * 2.0**-24
