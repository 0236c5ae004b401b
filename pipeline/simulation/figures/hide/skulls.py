"""Skulls: the lumps of heads by name.

A place on a skull is given by its distance from the back of the head, in the length of the last
link of the head's chain; by its height and its offset to the side, in the radius there, which goes
from that drawn at the back to that at the tip. Radii are in the same radius. A row with an offset
to the side is meant twice, left and right.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

Row = tuple[
    tuple[float, float, float], tuple[float, float, float], tuple[float, float], tuple[float, float]
]
"""Both ends, and the radii upward and to the side at both."""

Hole = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Place and radii of what is carved out: along, up, to the side."""


@dataclass(frozen=True, slots=True)
class Skull:
    """The shape of a head.

    Attributes:
        rows: lumps.
        eye: place of the right eye.
        eye_size: its radius.
        look: direction in which the right eye looks: along, up, to the side.
        slant: how far its outer corner is turned up [degrees].
        pupil: `round`, `slit` (upright) or `bar` (level).
        iris: sRGB colour of the iris.
        holes: nostrils and the like.
        ear: place of the root of the right ear.
        ear_way: direction of the right ear: along, up, to the side.
        ear_opening: direction to which it is open.
        ear_length, ear_width: length of the ear in that drawn; width in its length.
        ear_fold: depth of the cup of an ear, in half of its width.
        ear_point: 0 for ears like leaves, 1 for triangles.
        ear_wave: height of the waves of an ear's rim, in half of its width.
        horn: place of the root of the right horn.
        nose: place below the skin, radii and sRGB colour of a bare nose; None without.
        mouth: heights of the mouth line at its corner and its front; None without.
        lids: softness of the lids' union, in half of the eye's radius; 0 without lids.
        lid_color: sRGB colour of the lids.
        droop: how far the upper lid hangs over the eye [degrees].
        lid_opening: angle at which the lids end, from where the eye looks [degrees].
        sunk: depth of the middle of the eye below the skull, in its radius.
        whiskers: their length, in that of the head; 0 without.
        muzzle_from: place along the head from which the muzzle begins.
    """

    rows: tuple[Row, ...]
    eye: tuple[float, float, float]
    eye_size: float = 0.2
    look: tuple[float, float, float] = (0.25, 0.15, 1.0)
    slant: float = 0.0
    pupil: str = "bar"
    iris: str = "#4d2c14"
    holes: tuple[Hole, ...] = ()
    ear: tuple[float, float, float] = (0.02, 0.75, 0.5)
    ear_way: tuple[float, float, float] = (-0.25, 1.0, 0.35)
    ear_opening: tuple[float, float, float] = (0.75, 0.0, 0.65)
    ear_length: float = 1.0
    ear_width: float = 0.38
    ear_fold: float = 0.55
    ear_point: float = 0.0
    ear_wave: float = 0.0
    horn: tuple[float, float, float] = (0.12, 0.75, 0.35)
    nose: tuple[tuple[float, float, float], tuple[float, float, float], str] | None = None
    mouth: tuple[float, float, float, float] | None = None
    muzzle_from: float = 0.72
    lids: float = 0.25
    lid_color: str = "#17100c"
    lid_opening: float = 47.0
    droop: float = 9.0
    sunk: float = 0.34
    whiskers: float = 0.0


_DEER = Skull(
    rows=(
        ((0.02, 0.10, 0), (0.32, 0.22, 0), (0.84, 0.74), (0.76, 0.82)),
        ((0.28, 0.16, 0), (0.88, 0.10, 0), (0.62, 0.60), (0.62, 0.52)),
        ((0.10, -0.46, 0.32), (0.40, -0.44, 0.24), (0.56, 0.36), (0.44, 0.30)),
        ((0.36, -0.46, 0), (0.92, -0.62, 0), (0.38, 0.34), (0.34, 0.40)),
        ((0.26, 0.58, 0.50), (0.40, 0.54, 0.46), (0.24, 0.22), (0.20, 0.20)),
        ((0.84, 0.06, 0.12), (1.00, -0.04, 0.14), (0.76, 0.62), (0.74, 0.66)),
    ),
    eye=(0.34, 0.34, 0.74),
    eye_size=0.33,
    slant=10.0,
    ear=(0.02, 0.55, 0.62),
    ear_way=(-0.45, 0.75, 0.85),
    ear_length=1.25,
    ear_width=0.36,
    horn=(0.17, 0.80, 0.34),
    nose=((0.90, 0.08, 0.0), (0.34, 0.40, 0.56), "#1d1614"),
    mouth=(0.58, -0.42, 1.2, -0.50),
)

SKULLS: Mapping[str, Skull] = {
    "horse": Skull(
        rows=(
            ((0.02, 0.10, 0), (0.30, 0.20, 0), (0.82, 0.64), (0.72, 0.76)),
            ((0.26, 0.18, 0), (0.90, 0.18, 0), (0.62, 0.66), (0.64, 0.54)),
            ((0.10, -0.58, 0.44), (0.30, -0.62, 0.42), (0.78, 0.36), (0.70, 0.32)),
            ((0.30, -0.70, 0.10), (0.88, -0.76, 0), (0.44, 0.30), (0.36, 0.40)),
            ((0.36, 0.08, 0.50), (0.66, -0.02, 0.40), (0.24, 0.20), (0.18, 0.16)),
            ((0.84, 0.12, 0.16), (1.00, 0.00, 0.34), (0.72, 0.50), (0.82, 0.62)),
            ((0.94, -0.34, 0), (1.05, -0.46, 0), (0.62, 0.74), (0.54, 0.70)),
            ((0.90, -1.04, 0), (1.00, -1.06, 0), (0.40, 0.54), (0.38, 0.50)),
            ((0.28, 0.62, 0.54), (0.40, 0.58, 0.52), (0.24, 0.20), (0.20, 0.18)),
        ),
        eye=(0.35, 0.34, 0.72),
        eye_size=0.34,
        slant=6.0,
        holes=(((1.12, 0.12, 0.88), (0.24, 0.40, 0.24)),),
        ear=(0.03, 0.72, 0.38),
        ear_way=(-0.05, 1.0, 0.16),
        ear_length=1.0,
        ear_width=0.42,
        ear_point=0.3,
        mouth=(0.74, -0.76, 1.3, -0.72),
    ),
    "deer": _DEER,
    # No bare nose: nostrils that close to slits, and a long upper lip.
    "giraffe": replace(
        _DEER,
        rows=(*_DEER.rows, ((1.00, -0.20, 0.0), (1.10, -0.40, 0.0), (0.60, 0.60), (0.46, 0.50))),
        nose=None,
        holes=(((1.14, 0.30, 0.56), (0.30, 0.12, 0.24)),),
        lid_opening=45.0,
        mouth=(0.58, -0.42, 1.2, -0.62),
    ),
    "camel": Skull(
        rows=(
            ((0.02, 0.05, 0), (0.32, 0.16, 0), (0.84, 0.72), (0.78, 0.80)),
            ((0.28, 0.10, 0), (0.86, 0.10, 0), (0.66, 0.56), (0.62, 0.54)),
            ((0.08, -0.48, 0.34), (0.40, -0.44, 0.22), (0.60, 0.38), (0.46, 0.32)),
            ((0.36, -0.46, 0), (0.90, -0.72, 0), (0.40, 0.36), (0.38, 0.48)),
            ((0.82, 0.14, 0.10), (1.02, 0.00, 0.12), (0.80, 0.68), (0.86, 0.80)),
            ((0.98, -0.26, 0.26), (1.18, -0.56, 0.26), (0.66, 0.52), (0.50, 0.42)),
            ((0.96, -1.06, 0), (1.12, -1.28, 0), (0.40, 0.56), (0.34, 0.46)),
            ((0.26, 0.62, 0.56), (0.42, 0.58, 0.54), (0.26, 0.26), (0.22, 0.22)),
        ),
        eye=(0.36, 0.34, 0.74),
        eye_size=0.31,
        slant=4.0,
        lid_opening=44.0,
        holes=(((1.20, 0.42, 0.60), (0.30, 0.10, 0.36)),),
        ear=(0.02, 0.62, 0.62),
        ear_way=(-0.55, 0.9, 0.5),
        ear_length=0.72,
        ear_width=0.55,
        mouth=(0.60, -0.66, 1.3, -0.92),
        lids=0.45,
    ),
    "kangaroo": Skull(
        rows=(
            ((0.04, 0.05, 0), (0.32, 0.16, 0), (0.88, 0.80), (0.80, 0.82)),
            ((0.30, 0.12, 0), (0.88, 0.04, 0), (0.66, 0.64), (0.70, 0.62)),
            ((0.10, -0.34, 0.40), (0.44, -0.30, 0.32), (0.52, 0.40), (0.42, 0.34)),
            ((0.34, 0.50, 0.44), (0.46, 0.44, 0.40), (0.24, 0.24), (0.20, 0.22)),
            ((0.70, -0.14, 0.22), (1.00, -0.20, 0.24), (0.62, 0.46), (0.66, 0.56)),
            ((0.30, -0.56, 0), (0.92, -0.84, 0), (0.36, 0.42), (0.34, 0.46)),
        ),
        eye=(0.42, 0.30, 0.72),
        eye_size=0.32,
        look=(0.45, 0.15, 1.0),
        slant=8.0,
        pupil="round",
        iris="#55311a",
        ear=(0.06, 0.70, 0.46),
        ear_way=(-0.18, 1.0, 0.34),
        ear_length=1.05,
        ear_width=0.42,
        nose=((0.90, 0.12, 0.0), (0.36, 0.36, 0.46), "#191312"),
        mouth=(0.58, -0.50, 1.4, -0.58),
    ),
    "dog": Skull(
        rows=(
            ((0.02, 0.16, 0), (0.30, 0.22, 0), (0.88, 0.92), (0.76, 0.86)),
            ((0.06, -0.22, 0.50), (0.42, -0.16, 0.48), (0.52, 0.44), (0.36, 0.34)),
            ((0.40, 0.46, 0.30), (0.50, 0.40, 0.26), (0.30, 0.30), (0.24, 0.26)),
            ((0.44, 0.06, 0), (1.00, 0.16, 0), (0.50, 0.50), (0.60, 0.58)),
            ((0.52, -0.30, 0.24), (0.94, -0.36, 0.28), (0.40, 0.34), (0.56, 0.44)),
            ((0.24, -0.56, 0), (0.86, -0.92, 0), (0.34, 0.50), (0.34, 0.46)),
        ),
        eye=(0.45, 0.26, 0.50),
        eye_size=0.25,
        look=(1.0, 0.12, 0.80),
        slant=8.0,
        pupil="round",
        iris="#5c3516",
        lid_opening=42.0,
        sunk=0.48,
        ear=(0.06, 0.62, 0.56),
        ear_way=(0.02, 1.0, 0.34),
        ear_opening=(0.85, 0.0, 0.5),
        ear_length=1.2,
        ear_width=0.68,
        ear_point=0.65,
        nose=((0.90, 0.22, 0.0), (0.36, 0.33, 0.41), "#141011"),
        mouth=(0.36, -0.52, 1.2, -0.74),
        muzzle_from=0.5,
    ),
    "cat": Skull(
        rows=(
            ((0.08, 0.10, 0), (0.28, 0.16, 0), (0.95, 0.98), (0.86, 0.96)),
            ((0.20, -0.28, 0.54), (0.42, -0.34, 0.44), (0.54, 0.52), (0.44, 0.46)),
            ((0.42, 0.46, 0.26), (0.48, 0.42, 0.22), (0.26, 0.34), (0.22, 0.30)),
            ((0.40, 0.02, 0.0), (0.92, -0.02, 0), (0.62, 0.50), (0.52, 0.42)),
            ((0.80, -0.36, 0.32), (0.90, -0.42, 0.30), (0.48, 0.48), (0.42, 0.44)),
            ((0.50, -0.72, 0), (0.80, -0.90, 0), (0.36, 0.42), (0.30, 0.34)),
        ),
        eye=(0.52, 0.24, 0.46),
        eye_size=0.28,
        lid_opening=52.0,
        sunk=0.50,
        look=(1.0, 0.10, 0.52),
        slant=10.0,
        droop=3.0,
        pupil="slit",
        iris="#a3b53a",
        ear=(0.14, 0.72, 0.62),
        ear_way=(0.05, 1.0, 0.40),
        ear_length=1.1,
        ear_width=0.98,
        ear_point=0.85,
        nose=((0.84, 0.06, 0.0), (0.24, 0.19, 0.26), "#5e3a36"),
        whiskers=0.8,
        mouth=(0.74, -0.78, 1.2, -0.66),
        muzzle_from=0.72,
    ),
    "mouse": Skull(
        rows=(
            ((0.05, 0.0, 0), (0.40, 0.06, 0), (0.95, 0.92), (0.88, 0.88)),
            ((0.38, 0.04, 0.0), (1.0, -0.04, 0), (0.78, 0.74), (0.76, 0.66)),
            ((0.20, -0.34, 0.50), (0.50, -0.36, 0.42), (0.50, 0.44), (0.46, 0.42)),
            ((0.78, -0.30, 0.36), (0.92, -0.30, 0.34), (0.60, 0.54), (0.56, 0.54)),
            ((0.50, -0.60, 0), (0.86, -1.00, 0), (0.40, 0.46), (0.32, 0.40)),
        ),
        eye=(0.52, 0.38, 0.70),
        eye_size=0.36,
        look=(0.55, 0.3, 1.0),
        pupil="round",
        iris="#1c100c",
        slant=-12.0,
        lid_opening=58.0,
        droop=-6.0,
        sunk=0.22,
        ear=(0.16, 0.62, 0.66),
        ear_way=(-0.15, 0.9, 0.62),
        ear_length=1.3,
        ear_fold=0.28,
        ear_width=1.0,
        nose=((0.90, 0.10, 0.0), (0.30, 0.28, 0.32), "#a8625c"),
        whiskers=0.7,
        mouth=(0.80, -0.78, 1.2, -0.66),
    ),
    "elephant": Skull(
        rows=(
            ((0.00, 0.15, 0), (0.42, 0.10, 0), (1.0, 0.85), (1.0, 0.82)),
            ((0.20, 0.75, 0.28), (0.30, 0.72, 0.26), (0.42, 0.42), (0.40, 0.40)),
            ((0.20, -0.45, 0), (0.62, -0.72, 0), (0.52, 0.50), (0.36, 0.40)),
            ((0.42, 0.02, 0), (1.0, 0.0, 0), (0.86, 0.74), (1.0, 1.0)),
            ((0.40, 0.48, 0.62), (0.58, 0.38, 0.60), (0.20, 0.18), (0.16, 0.16)),
            ((0.34, -0.18, 0.64), (0.66, -0.30, 0.54), (0.28, 0.20), (0.20, 0.18)),
        ),
        eye=(0.50, 0.24, 0.80),
        eye_size=0.18,
        pupil="round",
        lid_color="#3f3a35",
        iris="#8a5f2a",
        horn=(0.62, -0.78, 0.42),
        ear=(0.08, 0.26, 0.66),
        ear_way=(0.14, -0.66, 0.92),
        ear_opening=(0.30, 0.70, 0.40),
        ear_length=1.0,
        ear_width=1.15,
        ear_fold=0.14,
        ear_wave=0.10,
        lids=0.35,
        sunk=0.3,
    ),
    "frog": Skull(
        rows=(
            ((0.0, 0.0, 0), (0.40, -0.05, 0), (0.78, 1.05), (0.66, 1.05)),
            ((0.30, -0.10, 0), (0.95, -0.22, 0), (0.60, 1.05), (0.62, 1.12)),
            ((0.36, 0.62, 0.56), (0.42, 0.66, 0.56), (0.44, 0.42), (0.42, 0.40)),
        ),
        eye=(0.42, 0.78, 0.62),
        eye_size=0.40,
        look=(0.45, 0.45, 1.0),
        pupil="bar",
        lid_color="#33461a",
        iris="#b08a1e",
        holes=(((1.28, 0.30, 0.30), (0.06, 0.08, 0.08)),),
        mouth=(0.15, -0.25, 1.6, -0.30),
        muzzle_from=2.0,
    ),
    "lizard": Skull(
        rows=(
            ((0.0, 0.0, 0), (0.42, 0.08, 0), (0.72, 0.92), (0.74, 0.96)),
            ((0.36, 0.0, 0), (1.0, -0.10, 0), (0.70, 0.90), (0.80, 0.95)),
            ((0.36, 0.45, 0.56), (0.50, 0.42, 0.52), (0.26, 0.24), (0.22, 0.22)),
            ((0.10, -0.30, 0.35), (0.45, -0.35, 0.25), (0.42, 0.46), (0.36, 0.42)),
        ),
        eye=(0.44, 0.30, 0.80),
        eye_size=0.20,
        look=(0.25, 0.1, 1.0),
        pupil="round",
        lid_color="#2a3419",
        iris="#a5751c",
        holes=(((1.20, 0.35, 0.50), (0.08, 0.10, 0.10)),),
        mouth=(0.25, -0.26, 1.5, -0.30),
        muzzle_from=2.0,
    ),
    "bird": Skull(
        rows=(
            ((-0.10, 0.0, 0), (0.25, 0.02, 0), (0.92, 0.86), (0.80, 0.78)),
            ((0.20, -0.05, 0), (0.42, -0.05, 0), (0.72, 0.72), (0.60, 0.62)),
        ),
        eye=(0.24, 0.26, 0.66),
        eye_size=0.36,
        look=(0.25, 0.08, 1.0),
        pupil="round",
        iris="#2c1a0c",
        muzzle_from=2.0,
        lids=0.2,
    ),
}
"""Skulls by name."""

DEFAULT_SKULLS: Mapping[str, str] = {
    "hooves": "deer",
    "paws": "dog",
    "toes": "bird",
    "claws": "lizard",
    "plain": "dog",
}
"""Skull of a figure that names none, by its feet."""
