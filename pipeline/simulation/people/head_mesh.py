"""Head mesh: a face that moves, neck, ears, eyes, teeth, brows and hair.

Lengths are in heads, from the middle of the head: X forward, Y up, Z to the right. A child's eyes
are larger and lower, its jaw and nose smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.simulation.face_units import EYE_TURN
from pipeline.simulation.figures.solids import loft, vertex_normals
from pipeline.simulation.people.face_mesh import (
    ORIGIN,
    FaceGrid,
    cast_rays,
    face_grid,
)
from pipeline.simulation.people.face_morphs import FaceSkin, unit_offsets
from pipeline.simulation.people.face_shape import FaceShape, face_field
from pipeline.simulation.people.proportions import BodyMeasures
from pipeline.simulation.people.signed_distance import (
    Field,
    ellipsoid,
    half_space,
    openness,
    round_cone,
    smooth_difference,
    smooth_intersection,
    smooth_union,
)
from pipeline.simulation.people.skinned_surface import (
    SkinnedPatch,
    Surface,
    angle_around,
    cached_part,
    merge_patches,
    polygonise,
    ramp,
    symmetric_field,
    tube,
    with_mirror,
)
from pipeline.simulation.people.tints import (
    BEARD,
    BLUSH,
    HOLLOW,
    IRIS,
    LASH,
    LIMBUS,
    LIP,
    PALE,
    PUPIL,
    SHEEN,
    TOOTH,
)
from pipeline.simulation.spatial import Array, normalized

LEAST_MOVE = 4e-4
"""Least move of a vertex by a unit that is kept [heads]."""


ADULT_HEAD = 0.06
"""By how much larger the head of an adult is drawn: broad shoulders in clothes dwarf it."""


@dataclass(frozen=True)
class Head:
    """The head of a person.

    Attributes:
        build: measures of the person.
    """

    build: BodyMeasures

    @property
    def size(self) -> float:
        """Distance from chin to crown [m]."""
        p = self.build.proportions
        return p.head_size * p.height * (1.0 + ADULT_HEAD * (1.0 - self.build.childish))

    @property
    def centre(self) -> Array:
        """Middle (3,) [m]."""
        return np.array([0.02 * self.size, self.build.proportions.height - 0.5 * self.size, 0.0])

    def at(self, x: float, y: float, z: float) -> Array:
        """Return a place (3,) in the head [m]."""
        return self.centre + self.size * np.array([x, y, z])

    @cached_property
    def face(self) -> FaceShape:
        """Shape of the face, in heads."""
        g = self.build.girth
        base = np.array([-0.010 * g, self.build.level(0.838), 0.0])
        low = (base - self.centre) / self.size
        return FaceShape(
            self.build.childish, 0.0290 * g / self.size, (float(low[0]), float(low[1]))
        )

    def on_body(self, places: Array) -> Array:
        """Return places (n, 3) in heads in the frame of the body [m]."""
        return self.centre + self.size * places


@cached_part
def head_skin(head: Head) -> SkinnedPatch:
    """Return the skin of the head down to the neck, which the face moves."""
    grid = face_grid(head.face)
    places = head.on_body(grid.vertices)
    base, chin = head.build.level(0.826), float(head.at(0.0, -0.42, 0.0)[1])
    share = ramp(places[:, 1], base + 0.15 * (chin - base), chin)
    # The head first: what follows it alone is quick to pose.
    patch = Surface(places, grid.faces).follow("head", "chest", 1.0 - share)
    skin = FaceSkin(grid.vertices, grid.jaw, grid.closing, grid.lid, grid.upper)
    shade = _skin_shade(head.face, grid)
    bare, child = LIP_SHARES
    red = bare + (child - bare) * head.build.childish
    tint = _skin_tint(head.face, grid, max(red, head.build.curves))
    return replace(_with_units(head, patch, skin), tint=tint, shade=shade)


HOLLOW_REACH, HOLLOW_DARKNESS = 0.20, 0.70
"""Distance in which something shades skin [heads], and how dark that makes it at most."""

BELOW_EYE = 0.3
"""Share of such shade that is left out below the eyes: dark rings look tired."""

CHIN_SHADE, CHIN_SPAN = 0.30, (-0.40, -0.55)
"""How dark the neck is below the chin, and heights between which that comes about [heads]."""


def _skin_shade(face: FaceShape, grid: FaceGrid) -> Array:
    """Return the shade (V,) of the skin of a head: in sockets, beside the nose, below lip and chin.

    Soft light is traced too coarsely for the forms of a face that is small in the frame.
    """
    p, normals = grid.vertices, vertex_normals(grid.vertices, grid.faces)
    # A slit is no hollow: lids would be dark along their margins.
    solid = symmetric_field(face_field(face))
    closed = np.clip(1.0 - openness(solid, p, normals, HOLLOW_REACH), 0.0, 1.0)
    below = CHIN_SHADE * ramp(p[:, 1], *CHIN_SPAN)
    rings = np.exp(-(((p[:, 1] - face.eye[0][1] + 0.075) / 0.055) ** 2))
    closed = closed * (1.0 - BELOW_EYE * rings * ramp(np.abs(p[:, 2]), 0.05, 0.10))
    return (1.0 - HOLLOW_DARKNESS * ramp(closed, 0.03, 0.65)) * (1.0 - below)


def _with_units(head: Head, patch: SkinnedPatch, skin: FaceSkin) -> SkinnedPatch:
    """Return a patch that the units of the face move."""
    moves = unit_offsets(head.face, skin)
    units, vertices = np.nonzero(np.linalg.norm(moves, axis=-1) > LEAST_MOVE)
    return replace(
        patch,
        targets=np.stack([vertices, units], axis=-1),
        offsets=head.size * moves[units, vertices],
    )


LASH_LINE, LASH_SPAN, LASH_SHARE, LOWER_LASH_SHARE = 0.97, (0.62, 0.95), 0.85, 0.15
"""Share of a lid from which it is its margin, shares between which upper lashes begin, and how dark
lashes make the upper and the lower margin."""


def _flushed(drop: float) -> tuple[tuple[float, ...], ...]:
    """Return the flushed places of a face: share, least X, height, place aside, breadth, height."""
    return (
        (0.80, 0.10, -0.115 + drop, 0.180, 0.095, 0.075),
        (0.80, 0.37, -0.140, 0.0, 0.060, 0.055),
        (0.35, 0.20, -0.430, 0.0, 0.090, 0.060),
        (0.30, 0.20, 0.075 + drop, 0.100, 0.110, 0.035),
    )


LIP_SHARES = 0.55, 0.75
"""Shares of the colour of lips of grown people without a bust, and of children: lips are painted
otherwise."""


def _skin_tint(face: FaceShape, grid: FaceGrid, red: float) -> Array:
    """Return the number and share (V, 2) of the tint of the skin of a head.

    Args:
        face: of the head.
        grid: its skin.
        red: share of the colour of lips.
    """
    p, c = grid.vertices, face.child
    aside = np.abs(p[:, 2])
    drop = -face.drop

    def spot(x: float, y: float, z: float, wide: float, high: float) -> Array:
        return np.exp(-(((aside - z) / wide) ** 2) - ((p[:, 1] - y) / high) ** 2) * (p[:, 0] > x)

    blush = np.max([share * spot(*place) for share, *place in _flushed(drop)], axis=0)
    rings = 0.25 * spot(0.15, -0.060 + drop, 0.150, 0.085, 0.042)
    nostril = spot(0.34, -0.176, 0.030 - 0.006 * c, 0.016, 0.013)
    hollow = np.maximum(grid.hollow, 0.8 * nostril)
    tint = np.stack([np.full(len(p), float(BLUSH)), blush], axis=-1)
    # Wide enough for an eye of a few pixels, which has no outline otherwise.
    lash = LASH_SHARE * ramp(grid.lid, *LASH_SPAN) + np.where(
        grid.lid < -LASH_LINE, LOWER_LASH_SHARE, 0.0
    )
    tint[rings > blush] = np.stack([np.full(len(p), float(PALE)), rings], axis=-1)[rings > blush]
    for number, share in ((LIP, red * grid.lips), (HOLLOW, hollow), (LASH, lash)):
        tint[share > 0.04] = np.stack([np.full(len(p), number), share], axis=-1)[share > 0.04]
    return tint


BEARD_LINE = ((0.0, 0.10, 0.16, 0.25, 0.34), (-0.335, -0.305, -0.255, -0.160, -0.040))
"""Heights of the upper edge of a beard, by the distance from the middle of the face."""


def bearded(patch: SkinnedPatch, head: Head, share: float) -> SkinnedPatch:
    """Return the skin of a head with a beard, or its stubble: `share` is that of its colour."""
    if share == 0.0:
        return patch
    x, y, aside = ((patch.vertices - head.centre) / head.size).T
    aside = np.abs(aside)
    line = np.interp(aside, *BEARD_LINE)
    cheeks = ramp(y, line + 0.035, line - 0.035) * ramp(y, -0.55, -0.46) * ramp(x, -0.09, -0.02)
    lip = np.exp(-(((y + 0.218) / 0.022) ** 2)) * ramp(aside, 0.13, 0.09) * ramp(x, 0.2, 0.25)
    return _grown_over(patch, share * np.maximum(cheeks, lip))


SCALP, SCALP_SPAN, NAPE = 0.80, (0.005, -0.050), (-0.40, -0.28)
"""Share of the colour of hair on the skin below it, the distances before its line between which
that begins, and heights between which it begins in the nape, in heads."""


def haired(patch: SkinnedPatch, head: Head) -> SkinnedPatch:
    """Return the skin of a head as it shows between the thin hairs along the hair line."""
    seen = (patch.vertices - head.centre) / head.size
    grown = ramp(before_hair_line(head.face, seen), *SCALP_SPAN) * ramp(seen[:, 1], *NAPE)
    return _grown_over(patch, SCALP * grown)


def _grown_over(patch: SkinnedPatch, grown: Array) -> SkinnedPatch:
    """Return skin with a share (V,) of the colour of hair."""
    tint = patch.tint.copy()
    has_hair = tint[:, 0] == BEARD
    grown = np.maximum(grown, np.where(has_hair, tint[:, 1], 0.0))
    # Lips, lids and the inside of the mouth keep their colours.
    covered = (grown > 0.05) & (np.isin(tint[:, 0], (BLUSH, PALE)) | has_hair)
    tint[covered] = np.stack([np.full(len(grown), float(BEARD)), grown], axis=-1)[covered]
    return replace(patch, tint=tint)


@cached_part
def neck_skin(head: Head) -> SkinnedPatch:
    """Return the neck, which turns between chest and head, up into the head."""
    s, centre = head.size, head.centre
    base = head.build.level(0.826)
    top = centre[1] - 0.50 * s
    low = (centre[0] - 0.55 * s, base - 0.20 * s, -0.40 * s)
    high = (centre[0] + 0.40 * s, top + 0.10 * s, 0.40 * s)
    net = polygonise(_neck_field(head, top), low, high, 0.063 * s, symmetric=True)
    chin = float(head.at(0.0, -0.42, 0.0)[1])
    share = ramp(net.vertices[:, 1], base + 0.15 * (chin - base), chin)
    shade = np.full(len(net.vertices), 1.0 - CHIN_SHADE)
    return replace(net.follow("chest", "head", share), shade=shade)


def _neck_field(head: Head, top: float) -> Field:
    g = head.build.girth
    base = (-0.010 * g, head.build.level(0.838), 0.0)
    neck = round_cone(base, head.at(-0.115, -0.22, 0.0), 0.0340 * g, 0.0315 * g)
    return smooth_intersection(neck, half_space((0.0, top, 0.0), (0.0, 1.0, 0.0)), 0.02 * head.size)


@cached_part
def ears(head: Head) -> SkinnedPatch:
    """Return both ears: a bowl with a rim, and a lobe."""
    solids = smooth_union(
        [
            ellipsoid((-0.045, -0.012, 0.338), (0.072, 0.098, 0.042)),
            ellipsoid((-0.022, -0.105, 0.322), (0.040, 0.050, 0.030)),
        ],
        0.05,
    )
    bowl = ellipsoid((-0.026, -0.006, 0.392), (0.046, 0.066, 0.040))
    shape = smooth_difference(solids, bowl, 0.018)
    net = polygonise(shape, (-0.15, -0.20, 0.24), (0.06, 0.13, 0.42), 0.026)
    patch = Surface(head.on_body(net.vertices), net.faces).follow("head")
    red = np.stack([np.full(len(net.vertices), float(BLUSH)), np.full(len(net.vertices), 0.65)], -1)
    return with_mirror(replace(patch, tint=red))


EYE_RINGS_DEG = np.array([7.0, 13.5, 15.5, 20.0, 27.0, 28.0, 31.5, 33.0, 50.0, 68.0, 90.0, 130.0])
"""Rings of an eyeball around its axis, denser where its colour changes."""

PUPIL_DEG, IRIS_DEG, LIMBUS_DEG = 14.5, 27.5, 32.0
"""Ends of pupil, iris and its dark edge: lids cover some of an iris, above and below."""

LID_SHADE, CORNER_SHADE = 0.72, 0.50
"""How dark the upper lid makes an eye, and its corners."""

EYE_SEGMENTS = 14


@cached_part
def eyeballs(head: Head) -> SkinnedPatch:
    """Return both eyeballs, coloured, which turn with the gaze, and the teeth."""
    middle, radius = head.face.eye
    angle = np.radians(EYE_RINGS_DEG)
    turn = np.arange(EYE_SEGMENTS) * (2.0 * np.pi / EYE_SEGMENTS)
    x = np.repeat(np.cos(angle)[:, None], EYE_SEGMENTS, axis=1)
    ring = np.sin(angle)[:, None] * np.stack([np.cos(turn), np.sin(turn)])[:, None]
    # Along X from behind.
    rings = np.stack([x, ring[0], ring[1]], axis=-1)[::-1]
    solid = loft(rings, np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    own = np.degrees(np.arccos(np.clip(solid.vertices[:, 0], -1.0, 1.0)))
    kind = np.select([own < PUPIL_DEG, own < IRIS_DEG, own < LIMBUS_DEG], [PUPIL, IRIS, LIMBUS], 0)
    above = ramp(solid.vertices[:, 1], -0.15, 0.45)
    beside = ramp(np.abs(solid.vertices[:, 2]), 0.35, 0.85)
    shade = (1.0 - LID_SHADE * above) * (1.0 - CORNER_SHADE * beside)
    tint = np.stack([kind, kind > 0], axis=-1).astype(float)
    places = head.on_body(middle + radius * solid.vertices)
    patch = Surface(places, solid.faces).follow("head")
    count = len(places)
    turned = np.stack([np.arange(count), np.full(count, EYE_TURN)], axis=-1)
    spokes = head.size * radius * solid.vertices
    eye = replace(patch, targets=turned, offsets=spokes, tint=tint, shade=shade)
    return with_mirror(eye)


@cached_part
def teeth(head: Head) -> SkinnedPatch:
    """Return the upper teeth, and the lower ones, which go with the jaw."""
    mouth, wide = head.face.mouth
    rows = []
    for low, high, back, jaw in ((-0.022, 0.035, 0.020, 0.0), (-0.060, -0.024, 0.028, 1.0)):
        z = np.linspace(-0.82, 0.82, 9) * wide
        x = mouth[0] - back - 5.0 * z * z
        y = mouth[1] + np.array([low, high, high, low])
        depth = np.array([0.0, 0.0, -0.03, -0.03])
        rings = np.stack(np.broadcast_arrays(x[:, None] + depth, y, z[:, None]), axis=-1)
        solid = loft(rings, rings[[0, -1]].mean(axis=1))
        patch = Surface(head.on_body(solid.vertices), solid.faces).follow("head")
        patch = replace(patch, tint=np.tile([float(TOOTH), 1.0], (len(z) * 4 + 2, 1)))
        rows.append(_with_units(head, patch, FaceSkin.free(solid.vertices, jaw)))
    return merge_patches(rows)


BROW_LINE = ((0.050, 0.112), (0.09, 0.120), (0.145, 0.126), (0.20, 0.117), (0.245, 0.092))
"""Places of a brow, out and up."""

BROW_RADII = np.array([0.0075, 0.0105, 0.0098, 0.0075, 0.0040])

FINE_BROWS = 0.2
"""By how much brows of grown people with a bust are thinner."""

BROW_PALENESS = np.array([0.34, 0.12, 0.10, 0.22, 0.45])
"""Share of the skin that is seen between the hairs of a brow, from its inner end."""


BROW_SHADE = 0.62
"""Brows are darker than the hair of the head."""


@cached_part
def brows(head: Head) -> SkinnedPatch:
    """Return both brows, on the skin."""
    face = head.face
    field, drop = face_field(face, with_lids=False), -face.drop
    wanted = np.array([(0.33, y + drop, z) for z, y in BROW_LINE])
    aims = wanted.copy()
    for _ in range(4):
        found = cast_rays(field, normalized(aims - ORIGIN))
        aims = aims + (wanted - found) * [0.0, 1.0, 1.0]
    fine = FINE_BROWS * head.build.is_curved * (1.0 - face.child)
    radii = BROW_RADII * (1.0 - 0.15 * face.child - fine)
    net = tube(found - np.array([0.004, 0.0, 0.0]), radii, 6)
    patch = Surface(head.on_body(net.vertices), net.faces).follow("head")
    pale = np.interp(net.vertices[:, 2], [z for z, _ in BROW_LINE], BROW_PALENESS)
    tint = np.stack([np.full(len(pale), float(BLUSH)), pale], axis=-1)
    dark = np.full(len(pale), BROW_SHADE)
    skin = _with_units(head, patch, FaceSkin.free(net.vertices))
    return with_mirror(replace(skin, tint=tint, shade=dark))


Style = Callable[[Head], Field]


HAIR_LINE, CHILD_LINE = (0.310, 0.345, 0.0), (0.030, -0.070, 0.0)
"""Place of the hair line in the middle of the forehead, a third of a face above its brows, and by
how much a child's lies elsewhere, in heads."""

LINE_NORMAL = normalized(np.array([0.84, -0.54, 0.0]))
"""Direction of the plane that cuts off hair there: down to before the ears."""

TEMPLE, TEMPLE_BREADTH, TEMPLE_RISE = 0.215, 0.075, 0.062
"""Place of a temple aside, its breadth, and by how much the line runs higher there, in heads."""

LINE_WAVE = 0.010
"""By how much the line runs to and fro, in heads."""

TAPER, TAPER_SLOPE = 0.016, 0.32
"""Thickness of hair at its line, in heads, and by how much it grows per distance behind the line:
hair that began in a step would be a cap."""

HANGS = (0.12, -0.02)
"""Heights between which hair that hangs beside the face is free of that, in heads."""


def _hair_cap(head: Head, thick: float | Sequence[float]) -> Field:
    """Return hair on the skull, cut off along a line from the forehead to the nape.

    Args:
        head: of the person.
        thick: of the hair, or (3,) of it along the axes, in heads.
    """
    s, at = head.size, head.at
    radii = np.array([0.430, 0.395, 0.345]) + np.asarray(thick)
    skull = ellipsoid(at(-0.060, 0.130, 0.0), s * radii)

    def line(places: Array) -> Array:
        return np.asarray(s * before_hair_line(head.face, (places - head.centre) / s))

    return smooth_intersection(skull, line, 0.02 * s)


def _tapered(head: Head, hair: Field, hangs: bool) -> Field:
    """Return hair that grows out of the skin along its line, where it does not hang."""
    skin = face_field(head.face, with_lids=False)

    def above(places: Array) -> Array:
        seen = (places - head.centre) / head.size
        most = TAPER + TAPER_SLOPE * np.maximum(-before_hair_line(head.face, seen), 0.0)
        free = hangs * ramp(seen[:, 1], *HANGS)
        return np.asarray(head.size * (skin(seen) - most - free))

    return smooth_intersection(hair, above, 0.03 * head.size)


def before_hair_line(face: FaceShape, places: Array) -> Array:
    """Return the distances (n,) of places before the hair line, negative behind it, in heads."""
    point = np.array(HAIR_LINE) + face.child * np.array(CHILD_LINE)
    aside = np.abs(places[:, 2])
    temple = TEMPLE_RISE * np.exp(-(((aside - TEMPLE) / TEMPLE_BREADTH) ** 2))
    wave = LINE_WAVE * np.sin(22.0 * aside + 2.2)
    return np.asarray((places - point) @ LINE_NORMAL + temple + wave)


def _short(head: Head) -> Field:
    s, at = head.size, head.at
    tuft = round_cone(at(0.12, 0.45, -0.11), at(0.12, 0.45, 0.11), 0.105 * s, 0.105 * s)
    # Cut short towards the neck: a round nape would be a helmet's.
    nape = ellipsoid(at(-0.255, -0.085, 0.0), s * np.array([0.180, 0.225, 0.235]))
    cap = _hair_cap(head, (0.032, 0.058, 0.016))
    return _tapered(head, smooth_union([cap, tuft, nape], 0.07 * s), hangs=False)


def _bob(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        round_cone(at(-0.06, 0.12, 0.30 * m), at(-0.04, -0.36, 0.315 * m), 0.11 * s, 0.10 * s)
        for m in (1, -1)
    ]
    back = round_cone(
        at(-0.26, 0.10, 0.0), at(-0.24, -0.36, 0.0), 0.22 * s, 0.20 * s, (1.0, 1.0, 1.45)
    )
    hair = smooth_union([_hair_cap(head, 0.056), *sides, back, *_curtains(head)], 0.09 * s)
    return _tapered(head, hair, hangs=True)


def _curtains(head: Head) -> list[Field]:
    """Return hair that falls from a parting over both temples."""
    s, at = head.size, head.at
    return [
        round_cone(at(0.235, 0.40, 0.08 * m), at(0.150, 0.13, 0.285 * m), 0.05 * s, 0.06 * s)
        for m in (1, -1)
    ]


KNOT, KNOT_RADIUS = (-0.535, 0.09, 0.0), 0.150
"""Middle and radius of the knot of a bun."""


def _bun(head: Head) -> Field:
    s, at = head.size, head.at
    nape = ellipsoid(at(-0.24, -0.09, 0.0), s * np.array([0.185, 0.22, 0.24]))
    drawn_back = _tapered(head, smooth_union([_hair_cap(head, 0.022), nape], 0.05 * s), hangs=False)
    return smooth_union([drawn_back, ellipsoid(at(*KNOT), KNOT_RADIUS * s)], 0.018 * s)


def _long(head: Head) -> Field:
    s, at = head.size, head.at
    sides = [
        round_cone(at(-0.08, 0.14, 0.29 * m), at(-0.17, -0.52, 0.27 * m), 0.115 * s, 0.085 * s)
        for m in (1, -1)
    ]
    back = round_cone(
        at(-0.27, 0.12, 0.0), at(-0.36, -0.72, 0.0), 0.21 * s, 0.11 * s, (1.0, 1.0, 1.7)
    )
    hair = smooth_union([_hair_cap(head, 0.052), *sides, back, *_curtains(head)], 0.10 * s)
    return _tapered(head, hair, hangs=True)


HAIR_STYLES: Mapping[str, Style] = {"short": _short, "bob": _bob, "bun": _bun, "long": _long}


HAIR_CELL = 0.068
"""Distance of the samples of hair, in heads."""


@cached_part
def hair_patch(head: Head, style: str) -> SkinnedPatch:
    """Return the hair of a head; below the chin it follows the back."""
    s, c = head.size, head.centre
    low = (c[0] - 0.80 * s, c[1] - (0.95 if style == "long" else 0.62) * s, -0.54 * s)
    high = (c[0] + 0.50 * s, c[1] + 0.62 * s, 0.54 * s)
    net = polygonise(HAIR_STYLES[style](head), low, high, HAIR_CELL * s, symmetric=True)
    share = ramp(net.vertices[:, 1], float(c[1] - 0.85 * s), float(c[1] - 0.30 * s))
    patch = net.follow("head", "chest", 1.0 - share)
    seen = (net.vertices - c) / s
    normals = vertex_normals(net.vertices, net.faces)
    patch = replace(patch, vertices=c + s * _with_locks(seen, style))
    return replace(patch, tint=_hair_gloss(seen, normals), shade=_hair_shade(seen, normals))


LOCK_DEPTH: Mapping[str, float] = {"short": 0.013, "bob": 0.013, "long": 0.014, "bun": 0.006}
"""By how much locks stand out and lie deeper by style, in heads."""

HEM_LOCKS = 0.040
"""By how much the lower ends of locks hang lower or higher, in heads."""


SKULL = (-0.06, 0.06, 0.0)
"""Middle of the skull."""


def _with_locks(places: Array, style: str) -> Array:
    """Return the surface (V, 3) of hair in locks: its outline is a helmet's otherwise."""
    # Alike on both sides; the parting is not.
    locks = _locks(places)
    # Not along the hair line, where locks would show the skull.
    kept = ramp(places[:, 0], 0.26, 0.16)
    # Away from the skull: normals of the net are not alike on both sides.
    outward = normalized(places - np.array(SKULL))
    moved = places + (LOCK_DEPTH[style] * locks * kept)[:, None] * outward
    if style in ("bob", "long"):
        ends = 0.6 * np.sin(5.0 * angle_around(places) + 0.5) + 0.5 * locks
        moved[:, 1] += HEM_LOCKS * ramp(places[:, 1], -0.10, -0.40) * ends
    return np.asarray(moved)


def _locks(places: Array) -> Array:
    """Return how far locks stand out (V,), -1.7 between two and 1.7 on their ridges."""
    around = angle_around(places)
    return np.asarray(np.sin(9.0 * around + 1.3) + 0.7 * np.sin(14.0 * around + 4.0 * places[:, 1]))


PARTING, PARTING_SPAN, PARTING_BACK = 0.11, 0.045, (-0.20, 0.0)
"""How far a parting lies aside, half its breadth, and places along X between which it begins, in
heads."""

PARTING_DEPTH, SWEPT_RISE = 0.030, 0.045
"""Depth of a parting, and by how much hair stands higher on the side to which it is combed."""

PARTING_SHADE, LOCK_SHADE = 0.35, 0.34
"""How dark hair is in its parting, and between two locks."""


def parted(patch: SkinnedPatch, head: Head, style: str, parting: float) -> SkinnedPatch:
    """Return hair with a parting, and more of it on the side to which it is combed.

    Args:
        patch: hair alike on both sides.
        head: of the person.
        style: of the hair.
        parting: side of the parting, -1 on the left, 1 on the right, 0 in the middle.
    """
    if style == "bun" or (style == "short" and parting == 0.0):
        return patch
    x, y, z = seen = ((patch.vertices - head.centre) / head.size).T
    upper = ramp(y, 0.20, 0.42)
    groove = np.exp(-(((z - PARTING * parting) / PARTING_SPAN) ** 2)) * ramp(x, *PARTING_BACK)
    # Flat beside the parting, highest where hair is thrown over.
    heap = np.exp(-(((-parting * z - 0.10) / 0.16) ** 2)) * ramp(x, -0.15, 0.12) * abs(parting)
    edge = ramp(before_hair_line(head.face, seen.T), -0.02, -0.14)
    rise = upper * edge * (SWEPT_RISE * heap - PARTING_DEPTH * groove)
    outward = normalized(seen.T - np.array(SKULL))
    shade = patch.shades * (1.0 - PARTING_SHADE * upper * groove)
    moved = patch.vertices + head.size * rise[:, None] * outward
    return replace(patch, vertices=moved, shade=shade)


GLOSS, GLOSS_RISE, GLOSS_BREADTH = 0.20, 0.66, 0.17
"""Gloss of hair: its greatest share; upward part of the normal in its band, and the breadth."""

NAPE_SHADE = 0.45
"""How dark hair is where it hangs in its own shade."""


CROWN, CROWN_SHADE = (-0.12, 0.50, 0.0), 0.45
"""Whorl from which hair goes out, and how dark it is there, where one sees down to the roots."""


def _hair_gloss(places: Array, normals: Array) -> Array:
    """Return the tint (V, 2) of the gloss: a band around the crown, broken by locks."""
    around = np.arctan2(places[:, 2], places[:, 0])
    locks = 0.62 + 0.38 * np.sin(11.0 * around) * np.sin(5.0 * around + 1.0)
    band = np.exp(-(((normals[:, 1] - GLOSS_RISE) / GLOSS_BREADTH) ** 2))
    tint = np.stack([np.full(len(places), float(SHEEN)), GLOSS * band * locks], axis=-1)
    return tint


def _hair_shade(places: Array, normals: Array) -> Array:
    """Return the shade (V,) of hair: below the ears and wherever it faces down."""
    low = ramp(places[:, 1], 0.15, -0.45)
    under = ramp(normals[:, 1], 0.1, -0.6)
    top = np.exp(-((np.linalg.norm(places - np.array(CROWN), axis=-1) / 0.30) ** 2))
    between = LOCK_SHADE * ramp(_locks(places), 0.6, -1.4)
    below = 1.0 - NAPE_SHADE * np.maximum(low, under)
    return below * (1.0 - CROWN_SHADE * top) * (1.0 - between)
