"""Laid pieces: slabs and boards that differ: each shows another piece of the tile, in its own tone.

Boards and slabs lie in courses: their ends are at other places in each, and slabs are of mixed
lengths. A tile holds a few pieces; a floor of them in the same order would show the repetition.
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

LENGTH, UNEVEN = 1.3, 0.62
"""Mean length of a slab relative to the height of its course, and by how much of that it varies."""

RIM = 0.2
"""Part of a slab along its ends that is not stretched, relative to the height of its course."""

BOND = 0.5
"""By which every second course of tiles is displaced [tiles laid]."""

TONES: Mapping[str, float] = {"slabs": 0.085, "tiles": 0.075, "planks": 0.17}
"""Deviation of the tones of whole pieces, by pattern."""

HUES: Mapping[str, float] = {"slabs": 0.34, "tiles": 0.3, "planks": 0.2}
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
        j = dr.floor(v * across)
        course = mi.UInt32(mi.Int32(j))
        i, along = _mixed(u * across, course) if pattern == "slabs" else _bonded(u * across, j)
        word = _hash(mi.UInt32(mi.Int32(i)), course)
        source_u, source_v = word % across, (word >> 9) % across
        found = (
            (mi.Float(source_u) + along) / across,
            (mi.Float(source_v) + v * across - j) / across,
        )
    seen = dr.clip((SEEN[1] - mi.Float(level)) / (SEEN[1] - SEEN[0]), 0.0, 1.0)
    first, second = _part(_hash(word, mi.UInt32(11))), _part(_hash(word, mi.UInt32(13)))
    # The sum of two is nearer to normal: few pieces stand out.
    tone = (first + second - 1.0) * (2.45 * TONES[pattern])
    hue = (_part(_hash(word, mi.UInt32(17))) * 2.0 - 1.0) * HUES[pattern]
    return Piece(*found, 1.0 + seen * tone, seen * hue)


def _bonded(x: Any, course: Any) -> tuple[Any, Any]:
    """Return number of and place along a tile, 0 to 1, of courses each displaced by half of one."""
    at = x + BOND * (course - 2.0 * dr.floor(0.5 * course))
    number = dr.floor(at)
    return number, at - number


def _mixed(x: Any, course: Any) -> tuple[Any, Any]:
    """Return number of and place along a slab, 0 to 1, of courses of slabs of mixed lengths."""
    at = x / LENGTH + _part(_hash(course, mi.UInt32(3)))
    number = dr.floor(at)
    number = dr.select(at < number + _shift(number, course), number - 1.0, number)
    low, high = (number + k + _shift(number + k, course) for k in (0.0, 1.0))
    before, after = (at - low) * LENGTH, (high - at) * LENGTH
    # The middle is stretched, so that all joints are of one width.
    middle = RIM + (1.0 - 2.0 * RIM) * (before - RIM) / (before + after - 2.0 * RIM)
    along = dr.select(before < RIM, before, dr.select(after < RIM, 1.0 - after, middle))
    return number, dr.clip(along, 0.0, 0.9999)


def _shift(number: Any, course: Any) -> Any:
    """Return by how much the joint before a slab is displaced [mean lengths]."""
    return (0.5 * UNEVEN) * _part(_hash(mi.UInt32(mi.Int32(number)) + mi.UInt32(101), course))


def _hash(a: Any, b: Any) -> Any:
    word = (a * 0x9E3779B1) ^ (b * 0x85EBCA77)
    word ^= word >> 15
    word *= 0x2C1B3C6D
    word ^= word >> 12
    word *= 0x297A2D39
    return word ^ (word >> 15)


def _part(word: Any) -> Any:
    return mi.Float(word >> 8) * 2.0**-24
