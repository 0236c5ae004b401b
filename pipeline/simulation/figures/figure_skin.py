"""The rendered surface of a figure, which may be smoother than its collision geometry.

Masses and contacts use the separate solids of the links. The rendered surface grows together where
links of one material meet, and has feet, claws, jaws and faces besides. These extremities are made
in the rest pose, where soles are level, and hang on the last link of their limb. None extends far
beyond the ball that touches the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.hide.animal import AnimalHide
from pipeline.simulation.figures.hide.arthropod import ArthropodHide
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.link_shapes import EYE_MATERIAL, SWELLING, SolidPiece
from pipeline.simulation.figures.network import FEELER, HEAD
from pipeline.simulation.figures.skeleton import Limb, Link
from pipeline.simulation.figures.skins import (
    Skin,
    body_skin,
    find_stumps,
    leaf_skin,
    limb_skin,
    merge_skins,
    skin_runs,
)
from pipeline.simulation.figures.solids import BODY_FLATNESS, Solid, ball_solid, loft
from pipeline.simulation.spatial import UP, Array, cross, normalized

FACE_RISE = 0.8
"""Sine of a head's elevation from which it has a face."""

FORWARD = np.array([1.0, 0.0, 0.0])

ExtremityMaker = Callable[[Array, Array, float], list[Solid]]
"""Solids from the place of the tip and the direction of the link, (3,) each, and its radius [m]."""


FACE_EYE_SCALE = 0.55
"""Size of the eyes in a face, in those of an animal."""


def extremity_skins(figure: Figure) -> Iterator[tuple[int, list[Skin]]]:
    """Yield the last link of each limb with the skins on its tip."""
    skeleton = figure.skeleton
    X_BJ = JointTree.of(skeleton).pose(skeleton.preferred)
    for limb in skeleton.limbs:
        made = _maker_of(figure, limb)
        link = skeleton.links[limb.links[-1]]
        if made is None or link.shape not in ("round", "straight"):
            continue
        X = X_BJ[link.joint]
        R, shift = X[:3, :3], X[:3, 3] - (X[:3, :3] * skeleton.places[link.joint]).sum(axis=1)
        tip = (R * link.ends[1]).sum(axis=1) + shift
        along = normalized((R * (link.ends[1] - link.ends[0])).sum(axis=1))
        solids = made(tip, along, link.radii[1])
        back = [Solid(((s.vertices - shift)[:, :, None] * R).sum(axis=1), s.faces) for s in solids]
        yield limb.links[-1], [Skin.rigid(solid, limb.links[-1]) for solid in back]


def _maker_of(figure: Figure, limb: Limb) -> ExtremityMaker | None:
    if limb.kind == HEAD:
        if has_face(figure.skeleton.links[limb.links[-1]]):
            return _face
        return _jaws if figure.jaws else None
    return FOOT_MAKERS.get(figure.feet) if limb.kind == "leg" else None


def _hoof(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return a hoof, wider below than above, with a sloping wall and a flat sole."""
    del along
    heights = np.array([0.55, 0.25, -0.35, -0.86, -0.97])
    wide = np.array([0.78, 0.95, 1.04, 1.12, 1.04])
    ahead = np.array([-0.22, -0.12, 0.06, 0.20, 0.20])
    angle = np.arange(16) * (2.0 * np.pi / 16)
    # Longer at the front than at the back.
    shape = 1.0 + 0.14 * np.cos(angle)
    rings = np.stack(
        [
            wide[:, None] * shape * np.cos(angle) + ahead[:, None],
            np.repeat(heights[:, None], 16, axis=1),
            wide[:, None] * 0.94 * np.sin(angle),
        ],
        axis=-1,
    )
    ends = np.array([[ahead[0], 0.62, 0.0], [ahead[-1], -0.97, 0.0]])
    solid = loft(rings[:, ::-1], ends)
    return [Solid(tip + radius * solid.vertices, solid.faces)]


def _paw(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return a paw: a pad and four toes."""
    del along
    solids = [
        _ellipsoid(
            tip + radius * np.array([0.05, -0.22, 0.0]), radius * np.array([1.15, 0.72, 1.12])
        )
    ]
    for z, x in ((-0.78, 0.62), (-0.28, 0.95), (0.28, 0.95), (0.78, 0.62)):
        middle = tip + radius * np.array([x, -0.50, z])
        solids.append(_ellipsoid(middle, radius * np.array([0.52, 0.42, 0.34])))
    return solids


def _toes(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return the toes of a bird: three ahead, one behind."""
    del along
    solids = []
    for degrees, length in ((0.0, 4.2), (32.0, 3.3), (-32.0, 3.3), (180.0, 1.8)):
        turn = np.radians(degrees)
        way = np.array([np.cos(turn), 0.0, np.sin(turn)])
        low = tip - 0.28 * radius * UP
        points = np.array(
            [
                low,
                low + 0.55 * length * radius * way,
                low + length * radius * way - 0.3 * radius * UP,
            ]
        )
        solids.append(_horn(points, radius * np.array([0.72, 0.52, 0.12])))
    return solids


def _claws(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return two small hooks that spread from the tip."""
    out = along * [1.0, 0.0, 1.0]
    way = normalized(out) if float((out * out).sum()) > 1e-6 else FORWARD
    side = cross(way, UP)
    solids = []
    for sign in (-1.0, 1.0):
        apart = normalized(way + sign * 0.55 * side)
        points = np.array(
            [
                tip,
                tip + 1.6 * radius * apart + 0.25 * radius * UP,
                tip + 3.4 * radius * apart - 0.7 * radius * UP,
            ]
        )
        solids.append(_horn(points, radius * np.array([0.75, 0.50, 0.10])))
    return solids


def _jaws(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return two jaws that curve towards each other."""
    side = normalized(cross(along, UP))
    down = cross(along, side)
    solids = []
    for sign in (-1.0, 1.0):
        line = ((0.55, 0.50, 0.25), (1.20, 0.62, 0.28), (1.62, 0.40, 0.30), (1.80, 0.08, 0.32))
        points = np.array(
            [tip + radius * (a * along + sign * s * side + d * down) for a, s, d in line]
        )
        solids.append(_horn(points, radius * np.array([0.24, 0.20, 0.13, 0.03])))
    return solids


def has_face(link: Link) -> bool:
    """Return whether a link stands upright, like a person's head, whose eyes look ahead."""
    span = link.ends[1] - link.ends[0]
    return bool(span[1] > FACE_RISE * np.sqrt((span * span).sum()))


def _face(tip: Array, along: Array, radius: float) -> list[Solid]:
    """Return a nose and two ears."""
    del along
    places = [((0.97, -0.14, 0.0), (0.17, 0.21, 0.13))]
    places += [((-0.06, -0.06, side), (0.15, 0.25, 0.09)) for side in (-0.97, 0.97)]
    return [_ellipsoid(tip + radius * np.array(at), radius * np.array(size)) for at, size in places]


def _ellipsoid(centre: Array, radii: Array) -> Solid:
    ball = ball_solid(np.zeros(3), 1.0)
    return Solid(centre + radii * ball.vertices, ball.faces)


def _horn(points: Array, radii: Array) -> Solid:
    """Return a curved cone along points (n, 3), round at its start and pointed at its end."""
    n, around = 9, 8
    s = np.linspace(0.0, 1.0, len(points))
    t = np.linspace(0.0, 1.0, n)
    # Smoothed twice, a polyline looks round.
    middle = np.stack([np.interp(t, s, points[:, k]) for k in range(3)], axis=-1)
    for _ in range(2):
        middle[1:-1] = 0.25 * middle[:-2] + 0.5 * middle[1:-1] + 0.25 * middle[2:]
    sizes = np.interp(t, s, radii)
    ways = normalized(np.gradient(middle, axis=0))
    across = np.eye(3)[int(np.abs(ways).max(axis=0).argmin())]
    y = normalized(across - (ways * across).sum(axis=-1, keepdims=True) * ways)
    z = cross(ways, y)
    angle = np.arange(around) * (2.0 * np.pi / around)
    ring = np.cos(angle)[:, None] * y[:, None] + np.sin(angle)[:, None] * z[:, None]
    rings = middle[:, None] + sizes[:, None, None] * ring
    ends = np.stack([middle[0] - 0.5 * sizes[0] * ways[0], middle[-1] + sizes[-1] * ways[-1]])
    return loft(rings, ends)


FOOT_MAKERS: Mapping[str, ExtremityMaker] = {
    "hooves": _hoof,
    "paws": _paw,
    "toes": _toes,
    "claws": _claws,
}
"""Feet other than plain ones."""


@dataclass(frozen=True, eq=False)
class FigureSkin:
    """The rendered surface of a figure.

    Attributes:
        skins: by number of the piece that each replaces.
        covered: numbers of the pieces hidden inside another's skin.
    """

    skins: Mapping[int, Skin]
    covered: frozenset[int]


_SKINS: WeakKeyDictionary[Figure, FigureSkin] = WeakKeyDictionary()
"""Skins of figures in use: many creatures share one figure."""


def figure_skin(figure: Figure) -> FigureSkin:
    """Return the rendered surface of a figure, built once."""
    if figure not in _SKINS:
        _SKINS[figure] = build_figure_skin(figure)
    return _SKINS[figure]


def build_figure_skin(figure: Figure) -> FigureSkin:
    """Return the rendered surface of a figure."""
    form = skin_form(figure)
    if form == "person":
        # A dressed person is made instead (`people/dressed_figure.py`).
        return FigureSkin({}, frozenset(range(len(figure.pieces))))
    if form == "animal":
        return _hide_skin(figure, AnimalHide(figure))
    if form == "arthropod":
        return _hide_skin(figure, ArthropodHide(figure))
    return _plain_skin(figure)


def skin_form(figure: Figure) -> str:
    """Return the form of a figure's skin: what it says, or what suits it."""
    if figure.skin.form is not None:
        return figure.skin.form
    if figure.skin.shell != "plain":
        return "arthropod"
    heads = [limb for limb in figure.skeleton.limbs if limb.kind == HEAD]
    if figure.style != "mammal" or not figure.skeleton.legs:
        return "plain"
    # Faces of upright heads are made here.
    faces = [limb for limb in heads if has_face(figure.skeleton.links[limb.links[-1]])]
    return "plain" if faces or not heads else "animal"


def _hide_skin(figure: Figure, hide: AnimalHide | ArthropodHide) -> FigureSkin:
    number = _piece_numbers(figure.pieces)
    found, covered = hide.skins()
    skins = {number[link]: skin for link, skin in found.items()}
    inside = {number[link] for link in covered}
    # What is no part of the hide grows together by itself.
    for limb in figure.skeleton.limbs:
        if not hide.untouched.isdisjoint(limb.links):
            for run in skin_runs(limb, figure.skeleton):
                skins[number[run[0]]] = limb_skin(run, figure.skeleton.links, 0.0)
                inside.update(number[link] for link in run[1:])
    skins |= dict(hide.eyes())
    return FigureSkin(skins, frozenset(inside))


def _plain_skin(figure: Figure) -> FigureSkin:
    number = _piece_numbers(figure.pieces)
    skeleton = figure.skeleton
    skins, covered = dict[int, Skin](), set[int]()
    for limb in skeleton.limbs:
        if figure.style == "mammal" and limb.kind == FEELER and len(limb.links) == 1:
            link = limb.links[0]
            skins[number[link]] = leaf_skin(link, skeleton.links[link])
            continue
        for run in skin_runs(limb, skeleton):
            swelling = SWELLING.get(limb.kind, 0.08)
            skins[number[run[0]]] = limb_skin(run, skeleton.links, swelling)
            covered.update(number[link] for link in run[1:])
    body = _body_skin(figure)
    if body is not None:
        skins[0] = body
    bearer = {
        link: number[run[0]]
        for limb in skeleton.limbs
        for run in skin_runs(limb, skeleton)
        for link in run
    }
    for link, more in extremity_skins(figure):
        place = bearer.get(link, number[link])
        own = skins.get(place) or Skin.rigid(figure.pieces[place].solid, link)
        skins[place] = merge_skins([own, *more])
    skins |= _face_eyes(figure)
    return FigureSkin(skins, frozenset(covered))


def _piece_numbers(pieces: Sequence[SolidPiece]) -> dict[int, int]:
    """Return the number of the first piece of each link."""
    found: dict[int, int] = {}
    for i, piece in enumerate(pieces):
        found.setdefault(piece.link, i)
    return found


def _face_eyes(figure: Figure) -> dict[int, Skin]:
    """Return the eyes of faces, which are smaller than those of animals."""
    found = {}
    for i, piece in enumerate(figure.pieces):
        if piece.material == EYE_MATERIAL and has_face(figure.skeleton.links[piece.link]):
            middle = piece.solid.vertices.mean(axis=0)
            small = middle + FACE_EYE_SCALE * (piece.solid.vertices - middle)
            found[i] = Skin.rigid(Solid(small, piece.solid.faces), piece.link)
    return found


def _body_skin(figure: Figure) -> Skin | None:
    """Return the skin of the body with its stumps; None without stumps."""
    nodes = list(figure.anatomy.body)
    radii = figure.drawing.radii[nodes] * figure.scale
    girth, material = float(radii.max()), figure.pieces[0].material
    skeleton = figure.skeleton
    stumps = find_stumps(skeleton.limbs, skeleton.links, girth, material, figure.material)
    if not stumps:
        return None
    place = {node: i for i, node in enumerate(nodes)}
    bones = [(place[a], place[b]) for a, b in figure.anatomy.bones]
    flatness = BODY_FLATNESS if figure.style == "insect" else 1.0
    return body_skin(figure.points[nodes], radii, bones or [(0, 0)], flatness, stumps)
