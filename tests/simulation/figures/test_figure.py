"""Figures: operations of drawings, anatomy, names, solids, errors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.solids import body_solid
from pipeline.spec import Figure as Words

Build = Callable[..., Figure]

SPIDER = (
    "{nodes: {a: [0, -1], b: [0, 1], k1: [1, -1], f1: [2, -1], k2: [1, 1], f2: [2, 1]},"
    " chains: [[a, b], [a, k1, f1], [b, k2, f2]], then: [{mirror: x}]}"
)


def test_mirror_copies_nodes_beside_the_axis() -> None:
    words = Words.model_validate(
        {
            "nodes": {"hip": [0, 0], "knee_l": [-1, 0.5], "foot": [-2, 0.5]},
            "chains": [["hip", "knee_l", "foot"]],
            "then": [{"mirror": "x"}],
        }
    )
    drawing = draw(words)
    place = dict(zip(drawing.names, drawing.places.tolist(), strict=True))
    assert place["knee_r"] == [1, 0.5]
    assert place["foot_m"] == [2, 0.5]
    named = {frozenset((drawing.names[a], drawing.names[b])) for a, b in drawing.connections}
    assert frozenset(("hip", "knee_r")) in named, "a copied leg keeps its hip"
    assert frozenset(("knee_r", "foot_m")) in named
    assert len(named) == 4


def test_mirrors_apply_in_sequence() -> None:
    words = Words.model_validate(
        {
            "nodes": {"hip": [0.2, -0.3], "foot": [1, -1]},
            "chains": [["hip", "foot"]],
            "then": [{"mirror": "x", "suffix": "_w"}, {"mirror": "y", "suffix": "_s"}],
        }
    )
    drawing = draw(words)
    place = dict(zip(drawing.names, drawing.places.tolist(), strict=True))
    assert place["foot_w_s"] == [-1, 1]
    assert len(drawing.names) == 8
    assert len(drawing.connections) == 4
    assert all(a < b for a, b in drawing.connections)
    for node, others in enumerate(drawing.neighbours):
        assert all(node in drawing.neighbours[other] for other in others)


def test_creation_frame_is_right_handed_with_x_forward(beetle: Figure) -> None:
    points = dict(zip(beetle.drawing.names, beetle.drawing.creation(), strict=True))
    ahead = points["head"] - points["rump"]
    right = points["foot2_r"] - points["foot2_l"]
    assert ahead[0] > 0
    assert right[2] > 0
    assert np.cross(right, ahead)[1] > 0


def test_beetle_anatomy(beetle: Figure) -> None:
    kinds = [limb.kind for limb in beetle.skeleton.limbs]
    assert kinds == ["leg"] * 6 + ["head", "tail", "feeler", "feeler"]
    assert [leg.name for leg in beetle.skeleton.legs] == ["l1", "l2", "l3", "r1", "r2", "r3"]
    body = {beetle.drawing.names[n] for n in beetle.anatomy.body}
    assert {f"hip{i}_{side}" for i in (1, 2, 3) for side in "lr"} <= body, "loops are body"
    assert not beetle.anatomy.ignored
    for leg in beetle.skeleton.legs:
        assert (leg.tip[2] < 0) == (leg.side == "l")
    for side in ("l", "r"):
        x = [leg.tip[0] for leg in beetle.skeleton.legs if leg.side == side]
        assert x == sorted(x, reverse=True), "front to back"
    left, right = beetle.skeleton.legs[:3], beetle.skeleton.legs[3:]
    for one, other in zip(left, right, strict=True):
        assert np.allclose(one.tip * [1, 1, -1], other.tip)


def test_links_match_joints_and_drawing(beetle: Figure) -> None:
    skeleton = beetle.skeleton
    assert skeleton.links[0].joint == BODY
    assert (skeleton.parents < np.arange(len(skeleton.parents))).all()
    spans = sum(len(appendage.nodes) - 1 for appendage in beetle.anatomy.appendages)
    assert len(skeleton.links) == 1 + spans
    assert np.allclose(np.linalg.norm(skeleton.axes, axis=-1), 1.0)
    assert (skeleton.lower <= skeleton.preferred).all()
    assert (skeleton.preferred <= skeleton.upper).all()
    for link in skeleton.links[1:]:
        assert np.allclose(skeleton.places[link.joint], link.ends[0])
    for leg in skeleton.legs:
        assert np.allclose(skeleton.links[leg.links[-1]].ends[1], leg.tip)
        spans = [np.ptp(skeleton.links[i].ends, axis=0) for i in leg.links]
        assert leg.length == pytest.approx(sum(np.linalg.norm(s) for s in spans))


def test_feelers_hang_on_the_head(beetle: Figure) -> None:
    skeleton = beetle.skeleton
    head = next(limb for limb in skeleton.limbs if limb.kind == "head")
    for feeler in (limb for limb in skeleton.limbs if limb.kind == "feeler"):
        assert skeleton.parents[feeler.joints[0]] in head.joints


def test_scale_multiplies_every_length(figure: Build) -> None:
    one, two = figure(SPIDER), figure(SPIDER, 2.5)
    assert np.allclose(one.skeleton.places * 2.5, two.skeleton.places)
    assert np.allclose(one.skeleton.axes, two.skeleton.axes)
    assert [limb.length * 2.5 for limb in one.skeleton.limbs] == pytest.approx(
        [limb.length for limb in two.skeleton.limbs]
    )
    assert two.belly == pytest.approx(2.5 * one.belly)


def test_disconnected_nodes_are_ignored(figure: Build) -> None:
    words = SPIDER.replace("nodes: {", "nodes: {x1: [9, 9], x2: [9, 8], ").replace(
        "chains: [", "chains: [[x1, x2], "
    )
    built = figure(words)
    ignored = {built.drawing.names[n] for n in built.anatomy.ignored}
    assert ignored == {"x1", "x2", "x1_m", "x2_m"}
    assert len(built.skeleton.legs) == 4
    assert np.allclose(built.skeleton.places, figure(SPIDER).skeleton.places)


def test_body_of_a_chain_is_its_middle(figure: Build) -> None:
    worm = figure("{nodes: {a: [0, 0], b: [0, 1], c: [0, 2]}, chains: [[a, b, c]]}")
    assert [worm.drawing.names[n] for n in worm.anatomy.body] == ["b"]
    assert [limb.name for limb in worm.skeleton.limbs] == ["head", "tail"]
    assert len(worm.skeleton.links) == 3
    assert np.isfinite(worm.body.vertices).all()


def test_a_loop_is_body(figure: Build) -> None:
    ring = figure("{nodes: {a: [0, 0], b: [0, 1], c: [1, 0]}, chains: [[a, b, c, a]]}")
    assert len(ring.anatomy.body) == 3
    assert len(ring.anatomy.bones) == 3


def test_parts_override_kinds(figure: Build) -> None:
    by_guess = figure(SPIDER)
    assert {limb.kind for limb in by_guess.skeleton.limbs} == {"leg"}
    told = figure(SPIDER[:-1] + ", parts: {f1: head, f1_m: feeler}}")
    kinds = sorted(limb.kind for limb in told.skeleton.limbs)
    assert kinds == ["feeler", "head", "leg", "leg"]


def test_part_override_of_an_inner_node_is_refused(figure: Build) -> None:
    with pytest.raises(SceneError) as caught:
        figure(SPIDER[:-1] + ", parts: {k1: leg}}")
    (problem,) = caught.value.problems
    assert problem.path == "figures.thing.parts.k1"
    assert "is no tip" in problem.message
    assert "f1, f1_m, f2, f2_m" in problem.message


def test_a_figure_without_connections_is_refused(figure: Build) -> None:
    with pytest.raises(SceneError) as caught:
        figure("{nodes: {a: [0, 0], b: [1, 1]}}")
    assert caught.value.problems[0].path == "figures.thing.chains"


def test_solids_are_closed_with_outward_faces(beetle: Figure) -> None:
    for piece in beetle.pieces:
        vertices, faces = piece.solid.vertices, piece.solid.faces.astype(int)
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        both = {(a, b) for a, b in edges.tolist()}
        assert len(both) == len(edges), piece.name
        assert {(b, a) for a, b in both} == both, piece.name
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 > 0, piece.name


def test_body_surface_encloses_its_nodes(beetle: Figure) -> None:
    nodes = list(beetle.anatomy.body)
    v = beetle.body.vertices
    for point in beetle.drawing.creation()[nodes] - beetle.drawing.creation()[nodes].mean(axis=0):
        moved = point + beetle.skeleton.links[0].ends[0]
        assert (v.min(axis=0) < moved).all()
        assert (v.max(axis=0) > moved).all()
    assert beetle.belly > 0.7 * beetle.drawing.radii[nodes].max()


@pytest.mark.parametrize("radius", [30.0, 10_000.0])
def test_a_body_far_thicker_at_one_node_than_at_the_others_has_a_surface(radius: float) -> None:
    points = np.array([[0.0, 0.0, z] for z in (-0.2, 0.0, 0.2, 0.4)])
    solid = body_solid(points, np.array([0.02, radius, 0.02, 0.02]), [(0, 1), (1, 2), (2, 3)])
    extent = np.ptp(solid.vertices, axis=0)
    assert extent == pytest.approx([2.0 * radius] * 3, rel=0.03)
