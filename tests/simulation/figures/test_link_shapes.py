"""Link shapes: closed, facing outward, of their configured sizes, and placed by the drawing."""

from __future__ import annotations

from collections.abc import Callable
from typing import get_args

import numpy as np
import pytest
import trimesh

from pipeline.errors import SceneError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.link_shapes import SHAPE_MAKERS, link_solid
from pipeline.simulation.figures.skeleton import Link
from pipeline.simulation.spatial import UP, Array, normalized
from pipeline.spec.figure import LinkShape

Build = Callable[..., Figure]
NAMES = get_args(LinkShape)

FIN = (
    "{style: %s, nodes: {a: [0, -1], b: [0, 1], k_l: {at: [-1, -1], shape: box},"
    " f_l: {at: [-2, -1.2], shape: plate}, t: {at: [0, 2], shape: ball}},"
    " chains: [[a, b], [a, k_l, f_l], [b, t]], then: [{mirror: x, nodes: [k_l, f_l]},"
    " {copy: [k_l, f_l], translate: [0, 1]}], radius: 0.1}"
)


def build_link(
    shape: LinkShape, span: Array, radii: tuple[float, float], normal: Array = UP
) -> Link:
    start = np.array([0.3, -0.2, 0.1])
    ends = np.stack([start, start + span])
    return Link("l1.1", "leg", 0, ends, radii, "", True, shape, normal)


def link_coordinates(link: Link) -> Array:
    """Return the vertices of a link in its frame: along, up, across."""
    x = normalized(link.ends[1] - link.ends[0])
    axes = np.stack([x, link.normal, np.cross(x, link.normal)], axis=-1)
    return (link_solid(link, 0.2).vertices - link.ends[0]) @ axes


def test_every_link_shape_has_a_maker() -> None:
    assert set(SHAPE_MAKERS) == set(NAMES)


@pytest.mark.parametrize("shape", NAMES)
def test_shapes_are_closed_and_face_outward(shape: LinkShape) -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        span = rng.normal(size=3) * 10 ** rng.uniform(-2, 1)
        radii = 10 ** rng.uniform(-2, 0.5, 2)
        normal = normalized(np.cross(span, rng.normal(size=3)))
        one = build_link(shape, span, (float(radii[0]), float(radii[1])), normal)
        solid = link_solid(one, 0.2)
        mesh = trimesh.Trimesh(solid.vertices, solid.faces.astype(int), process=False)
        assert mesh.is_watertight
        assert mesh.is_winding_consistent
        assert mesh.volume > 0
        assert (mesh.area_faces > 0).all()
        # Both ends of the link are inside, so that no gap opens in a joint.
        low, high = link_coordinates(one)[:, 0].min(), link_coordinates(one)[:, 0].max()
        length = np.linalg.norm(span)
        assert high > length
        assert low < 0 or (shape == "ball" and length - radii[1] < low + 1e-9)


def test_a_plate_is_flat_in_the_plane_of_the_drawing() -> None:
    one = build_link("plate", np.array([1.0, 0, 0]), (0.1, 0.1))
    extent = np.ptp(link_coordinates(one), axis=0)
    assert extent[1] < 0.3 * extent[2]
    round_link = build_link("round", one.ends[1] - one.ends[0], one.radii)
    assert extent[2] == pytest.approx(np.ptp(link_coordinates(round_link), axis=0)[2])


def test_a_box_link_is_flat_sided_and_no_wider_than_a_round_link() -> None:
    one = build_link("box", np.array([1.0, 0, 0]), (0.1, 0.1))
    solid = link_solid(one, 0.2)
    normals = trimesh.Trimesh(solid.vertices, solid.faces.astype(int), process=False)
    flat = np.abs(normals.face_normals).max(axis=-1) > 0.99
    assert normals.area_faces[flat].sum() > 0.8 * normals.area
    beyond = np.linalg.norm(link_coordinates(one)[:, 1:], axis=-1)
    assert beyond.max() == pytest.approx(0.1, rel=0.03)


def test_a_ball_link_is_a_sphere_around_its_node_with_a_stem() -> None:
    for length in (0.02, 0.3, 2.0):
        one = build_link("ball", np.array([length, 0, 0]), (0.05, 0.2))
        away = np.linalg.norm(link_coordinates(one) - [length, 0, 0], axis=-1)
        stem = link_coordinates(one)[:, 0] < length - 0.2
        assert away[~stem].max() < 0.2 * 1.01
        assert away[~stem].min() > 0.2 * 0.95
        across = np.linalg.norm(link_coordinates(one)[stem][:, 1:], axis=-1)
        assert across.max(initial=0.0) <= 0.0500001
        assert (length > 0.2) == stem.any()


def test_round_links_swell_and_straight_ones_do_not() -> None:
    straight = build_link("straight", np.array([0.4, 0.1, 0.2]), (0.1, 0.05))
    round_ = build_link("round", np.array([0.4, 0.1, 0.2]), (0.1, 0.05))
    assert (link_solid(straight, 0.3).vertices == link_solid(straight, 0.0).vertices).all()
    x = link_coordinates(build_link("straight", np.array([1.0, 0, 0]), (0.1, 0.05)))
    between = x[(x[:, 0] > 0) & (x[:, 0] < 1)]
    radii = np.linalg.norm(between[:, 1:], axis=-1)
    assert np.allclose(radii, 0.1 - 0.05 * between[:, 0])
    volumes = [
        trimesh.Trimesh(s.vertices, s.faces.astype(int), process=False).volume
        for s in (link_solid(straight, 0.0), link_solid(round_, 0.0), link_solid(round_, 0.3))
    ]
    assert volumes[0] == pytest.approx(volumes[1])
    assert volumes[2] > 1.2 * volumes[1]


def test_mirrored_and_copied_nodes_keep_their_shapes(figure: Build) -> None:
    fin = figure(FIN % "insect")
    shape = dict(zip(fin.drawing.names, fin.drawing.shapes, strict=True))
    box, plate = ({name for name in shape if shape[name] == kind} for kind in ("box", "plate"))
    assert box == {"k_l", "k_r", "k_2_l"}
    assert plate == {"f_l", "f_r", "f_2_l"}
    legs = fin.skeleton.legs
    assert len(legs) == 3
    for leg in legs:
        assert [fin.skeleton.links[i].shape for i in leg.links] == ["box", "plate"]


@pytest.mark.parametrize("style", ["insect", "mammal"])
def test_plates_lie_in_the_plane_of_the_drawing(figure: Build, style: str) -> None:
    """An insect's fins lie flat; a mammal's are folded down with their legs."""
    fin = figure(FIN % style)
    flat = 1 if style == "insect" else 2
    for piece in fin.pieces:
        if fin.skeleton.links[piece.link].shape == "plate":
            centred = piece.solid.vertices - piece.solid.vertices.mean(axis=0)
            thin = np.linalg.eigh(centred.T @ centred)[1][:, 0]
            assert abs(thin[flat]) == pytest.approx(1.0)


def test_plates_of_a_pitched_mammal_are_pitched(figure: Build) -> None:
    fish = figure(
        "{style: mammal, pitch_deg: 30, nodes: {a: [0, 0], b: [0, 1], c: [0.2, 0.5],"
        " t: {at: [0, 2], shape: plate}}, chains: [[a, b, c, a], [b, t]], radius: 0.1}"
    )
    (tail,) = [one for one in fish.skeleton.links if one.shape == "plate"]
    assert np.allclose(tail.normal, [-np.sin(np.pi / 6), np.cos(np.pi / 6), 0])
    assert tail.normal @ (tail.ends[1] - tail.ends[0]) == pytest.approx(0, abs=1e-12)


def test_a_shape_without_a_link_is_a_warning(figure: Build) -> None:
    built = figure(FIN.replace("a: [0, -1]", "a: {at: [0, -1], shape: box}") % "insect")
    warnings = [str(remark) for remark in built.anatomy.warnings]
    assert warnings == ["no link ends at 'a', so its shape is not used"]


def test_invalid_shapes_and_densities_are_refused(figure: Build) -> None:
    with pytest.raises(SceneError) as caught:
        figure(FIN.replace("shape: ball", "shape: boll") % "insect")
    (problem,) = caught.value.problems
    assert problem.path == "figures.thing.nodes.t.shape"
    assert "ball" in problem.message
    for density in ("0", "-5", "1e9", "heavy"):
        with pytest.raises(SceneError) as caught:
            figure(f"{(FIN % 'insect')[:-1]}, density: {density}}}")
        assert [one.path for one in caught.value.problems] == ["figures.thing.density"]


@pytest.mark.parametrize("shape", NAMES)
def test_thinnest_links_have_mass_and_thinner_ones_are_refused(
    figure: Build, shape: LinkShape
) -> None:
    config = (
        "{nodes: {a: [0, 0], b: [0, 1], c: [0.2, 0.5], d: {at: [1, 0.3], radius: %g},"
        f" f: {{at: [4, 0.7], radius: %g, shape: {shape}}}}}, chains: [[a, b, c, a], [c, d, f]],"
        " radius: 0.2}"
    )
    built = figure(config % (3.2e-6, 3.2e-6))
    number = next(i for i, one in enumerate(built.skeleton.links) if one.is_tip)
    solid = next(piece.solid for piece in built.pieces if piece.link == number)
    mass = FigureMass(built).of_link(number)
    assert 0 < mass.mass < 1e-6
    assert np.ptp(solid.vertices, axis=0).max() < 3.1
    with pytest.raises(SceneError) as caught:
        figure(config % (1e-4, 2e-6) if shape == "ball" else config % (2e-6, 2e-6))
    (problem,) = caught.value.problems
    assert problem.path == "figures.thing.nodes.f"
    assert "from 'd' to 'f' is thinner than a millionth" in problem.message


def test_too_thin_a_body_is_refused(figure: Build) -> None:
    thin = figure(
        "{nodes: {a: [0, 0], b: [0, 1], c: [0.2, 0.57]}, chains: [[a, b, c, a]], radius: 0.002}"
    )
    with pytest.raises(SceneError, match="the body is too thin for its length; give 'a'"):
        assert thin.pieces


def test_eyes_lie_on_the_surface_of_heads_of_all_shapes(figure: Build) -> None:
    """The surface of the head intersects each eye."""
    for shape in NAMES:
        for at in (-0.2, -0.5):
            built = figure(
                f"{{nodes: {{a: [0, 0], b: [0, 1], c: [0.2, 0.5], h: {{at: [0, {at}], radius: 0.12,"
                f" shape: {shape}}}}}, chains: [[a, b, c, a], [a, h]], radius: 0.12}}"
            )
            head = next(p for p in built.pieces if p.name == "head.1").solid
            mesh = trimesh.Trimesh(head.vertices, head.faces.astype(int), process=False)
            eyes = [p.solid.vertices for p in built.pieces if ".eye_" in p.name]
            assert len(eyes) == 2
            for eye in eyes:
                middle, radius = eye.mean(axis=0), float(np.ptp(eye[:, 0])) / 2
                points = np.broadcast_to(middle, (len(mesh.faces), 3))
                nearest = trimesh.triangles.closest_point(mesh.triangles, points)
                away = np.linalg.norm(nearest - middle, axis=-1).min()
                assert away < 0.8 * radius, (shape, at)
