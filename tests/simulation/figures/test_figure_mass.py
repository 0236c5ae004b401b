"""Mass properties of figures, against trimesh and against all solids as one mesh."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from pipeline.errors import SceneError
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.kinematics import JointTree
from pipeline.simulation.figures.skeleton import BODY
from pipeline.simulation.figures.solids import Solid
from pipeline.simulation.locomotion.inventory import leg_masses
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array

Build = Callable[..., Figure]

WORM = "{nodes: {a: [0, 0], b: [0, 1], c: [0, 2]}, chains: [[a, b, c]], radius: 0.1%s}"


def trimesh_of(solid: Solid, density: float) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh(solid.vertices, solid.faces.astype(int), process=False)
    mesh.density = density
    return mesh


def assert_same(one: MassProperties, other: MassProperties, tolerance: float = 1e-9) -> None:
    size = float(np.sqrt(np.trace(other.inertia) / other.mass))
    assert one.mass == pytest.approx(other.mass, rel=tolerance)
    assert np.abs(one.centre - other.centre).max() <= tolerance * size
    assert np.abs(one.inertia - other.inertia).max() <= tolerance * other.mass * size**2


def mesh_in_pose(figure: Figure, q: Array) -> tuple[Array, Array]:
    """Return one mesh of all solids of a figure at joint values `q`, in the body's frame."""
    skeleton = figure.skeleton
    X_BJ = JointTree.of(skeleton).pose(q)
    vertices, faces, count = [], [], 0
    for piece in figure.pieces:
        here, joint = piece.solid.vertices, skeleton.links[piece.link].joint
        if joint != BODY:
            X = X_BJ[joint]
            here = (here - skeleton.places[joint]) @ X[:3, :3].T + X[:3, 3]
        vertices.append(here)
        faces.append(piece.solid.faces.astype(int) + count)
        count += len(here)
    return np.concatenate(vertices), np.concatenate(faces)


def test_masses_of_all_shipped_solids_match_trimesh(shipped: Figure) -> None:
    for piece in shipped.pieces:
        theirs = trimesh_of(piece.solid, 850.0)
        assert theirs.is_watertight, piece.name
        mass = mass_of_solid(piece.solid.vertices, piece.solid.faces, 850.0)
        expected = MassProperties(theirs.mass, theirs.center_mass, theirs.moment_inertia)
        assert_same(mass, expected)


def test_mass_of_a_figure_matches_its_mesh_in_any_pose(shipped: Figure) -> None:
    inertia = FigureMass(shipped)
    rng = np.random.default_rng(1)
    skeleton = shipped.skeleton
    poses = [skeleton.preferred, rng.uniform(skeleton.lower, skeleton.upper)]
    for q, mass in zip(poses, [inertia.at_rest, inertia.at(poses[1])], strict=True):
        if shipped.masses:
            assert mass.mass == pytest.approx(sum(shipped.masses.values()))
        else:
            assert_same(mass, mass_of_solid(*mesh_in_pose(shipped, q), shipped.density))
    assert inertia.at_rest.mass == pytest.approx(sum(link.mass for link in inertia.links))


def test_mass_of_a_head_includes_its_eyes(beetle: Figure) -> None:
    head = next(limb for limb in beetle.skeleton.limbs if limb.name == "head")
    pieces = [piece for piece in beetle.pieces if piece.link == head.links[-1]]
    assert [piece.name for piece in pieces] == ["head.2", "head.eye_l", "head.eye_r"]
    whole = sum(trimesh_of(piece.solid, 1000.0).mass for piece in pieces)
    assert FigureMass(beetle).of_link(head.links[-1]).mass == pytest.approx(whole, rel=1e-9)


def test_mass_properties_scale_with_size(figure: Build) -> None:
    one, two = (FigureMass(figure(WORM % "", scale)).links[1] for scale in (1.0, 2.0))
    assert two.mass == pytest.approx(8 * one.mass)
    assert np.allclose(two.centre, 2 * one.centre)
    assert np.allclose(two.inertia, 32 * one.inertia)


def test_density_is_that_of_water_by_default(figure: Build) -> None:
    assert figure(WORM % "").density == 1000.0
    water, lead = FigureMass(figure(WORM % "")), FigureMass(figure(WORM % ", density: 11340"))
    for one, other in zip(water.links, lead.links, strict=True):
        assert other.mass == pytest.approx(11.34 * one.mass)
        assert np.allclose(other.inertia, 11.34 * one.inertia)
        assert np.allclose(other.centre, one.centre)


def test_a_mass_that_is_given_is_that_of_its_limb_at_any_scale(figure: Build) -> None:
    plain, heavy = (
        FigureMass(figure(WORM % words, scale=2.0)) for words in ("", ", masses: {body: 7}")
    )
    assert heavy.of_link(0).mass == pytest.approx(8 * 7)
    assert heavy.of_link(0).centre == pytest.approx(plain.of_link(0).centre)
    for one, other in zip(heavy.links[1:], plain.links[1:], strict=True):
        assert one.mass == other.mass
    everything = range(len(heavy.links))
    assert heavy.mass_of(everything) == pytest.approx(sum(mass.mass for mass in heavy.links))


def test_a_mass_of_no_limb_is_refused(figure: Build) -> None:
    with pytest.raises(SceneError, match=r"masses\.bod.*no such part.*did you mean 'body'"):
        figure(WORM % ", masses: {bod: 3}")


def test_mass_properties_of_legs_are_symmetric(beetle: Figure) -> None:
    inertia, legs = FigureMass(beetle), beetle.skeleton.legs
    for left, right in zip(legs[:3], legs[3:], strict=True):
        for a, b in zip(left.links, right.links, strict=True):
            one, other = inertia.links[a], inertia.links[b]
            assert one.mass == pytest.approx(other.mass)
            assert np.allclose(one.centre * [1, 1, -1], other.centre)
            mirror = np.diag([1, 1, -1])
            assert np.allclose(mirror @ one.inertia @ mirror, other.inertia, rtol=1e-9)


def test_leg_masses_are_sums_of_link_masses(scene_of: Callable[..., object]) -> None:
    scene = scene_of("{figure: beetle, scale: 0.5}", duration=1)
    herd = Simulation(scene).troupes[0].herd
    legs = herd.figures[0].skeleton.legs
    links = FigureMass(herd.figures[0]).links
    assert leg_masses(herd) == pytest.approx(
        [sum(links[i].mass for i in leg.links) for leg in legs]
    )


def test_mass_of_all_links_matches_the_mass_properties(shipped: Figure) -> None:
    inertia = FigureMass(shipped)
    numbers = range(len(shipped.skeleton.links))
    whole = sum(mass.mass for mass in inertia.links)
    assert inertia.mass_of(numbers) == pytest.approx(whole, rel=1e-9)
