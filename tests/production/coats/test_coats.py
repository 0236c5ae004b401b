"""Coats: hair stays on the hide of its animal, and a film has the same strands in every frame."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from pipeline.errors import SceneError
from pipeline.production.coats.coats import FEATHERS, HAIR, MOST_STRANDS
from pipeline.production.run.picture_notes import shooting_notes
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.simulate import simulate
from pipeline.spec import read_scene
from render.shot import Mesh

pytestmark = pytest.mark.nightly

SCENE = """
pronk: 1
fps: 24
duration: 0.25
terrain: {{kind: flat, size: [20, 20], cells: [8, 8], material: dry soil, scatter: none}}
cast:
  - {{name: it, figure: {figure}, at: [0, 0], walk: {{}}}}
camera: {{at: [0, 1.2, {away}], look_at: [0, 0.8, 0]}}
film: {{size: [1280, 720]}}
"""

SHEEP = """figures:
  sheep: {style: mammal, feet: paws, material: fur,
      nodes: {a: {at: [0, 0.3], radius: 0.2}, b: {at: [0, -0.3], radius: 0.2},
              l: {at: [-0.2, -0.3], radius: 0.06}, k: {at: [-0.6, -0.3], radius: 0.05},
              h: {at: [-0.2, 0.3], radius: 0.06}, g: {at: [-0.6, 0.3], radius: 0.05}},
      chains: [[a, b], [b, l, k], [a, h, g]], then: [{mirror: x}],
      skin: {form: animal, coat: COAT}}"""


@lru_cache(maxsize=8)
def builder(figure: str, away: float = 4.0, drawn: str = "") -> ShotBuilder:
    text = SCENE.format(figure=figure, away=away) + drawn
    scene = read_scene(text)
    return ShotBuilder(scene, simulate(scene))


def strands(figure: str, frame: int = 1, away: float = 4.0) -> list[Mesh]:
    shot = builder(figure, away).shot(frame)
    return [mesh for mesh in shot.meshes if mesh.material in (HAIR, FEATHERS)]


def triangles(meshes: Sequence[Mesh]) -> int:
    return sum(len(mesh.faces) for mesh in meshes)


@pytest.mark.parametrize(
    ("figure", "material"),
    [
        pytest.param("kangaroo", HAIR, marks=pytest.mark.nightly),
        ("horse", HAIR),
        ("ostrich", FEATHERS),
    ],
)
@pytest.mark.sample(1)
def test_animals_have_the_coat_of_their_material(figure: str, material: str) -> None:
    found = strands(figure)
    assert {mesh.material for mesh in found} == {material}
    assert {mesh.owner for mesh in found} == {"it"}


@pytest.mark.parametrize("figure", ["beetle", "frog", "elephant"])
@pytest.mark.sample(1)
def test_shells_and_bare_skin_have_none(figure: str) -> None:
    assert strands(figure) == []


def test_strands_are_of_one_topology_in_all_frames_and_made_again_to_the_byte() -> None:
    first, last = strands("kangaroo"), strands("kangaroo", 6)
    assert [mesh.topology for mesh in first] == [mesh.topology for mesh in last]
    assert any((a.vertices != b.vertices).any() for a, b in zip(first, last, strict=True))
    again = ShotBuilder(builder("kangaroo").scene, builder("kangaroo").take).shot(6)
    made = [mesh for mesh in again.meshes if mesh.material == HAIR]
    assert [mesh.digest for mesh in made] == [mesh.digest for mesh in last]


def test_hair_grows_on_the_hide_and_stands_off_little() -> None:
    shot = builder("kangaroo").shot(6)
    hides = {mesh.name: mesh for mesh in shot.meshes if mesh.owner == "it"}
    for coat in strands("kangaroo", 6):
        hide = hides[coat.name.removesuffix(" coat")]
        surface = trimesh.Trimesh(hide.vertices, hide.faces, process=False)
        ribbons = coat.vertices.reshape(-1, 5, 3)[::400]
        skin = cKDTree(trimesh.sample.sample_surface(surface, 40_000, seed=1)[0])
        for place, most in ((0, 0.03), (4, 0.10)):
            assert skin.query(ribbons[:, place])[0].max() < most


def test_skin_below_hair_is_as_dark_as_the_coat_and_bare_skin_as_it_is() -> None:
    built = builder("kangaroo")
    shown = {mesh.name: mesh for mesh in built.shot(1).meshes if mesh.owner == "it"}
    dark = bare = 0
    for part in built.take.parts:
        mesh = built.take.meshes[part.seen]
        if not len(mesh.hair) or not len(mesh.paint) or f"{part.name} coat" not in shown:
            continue
        cover, grows = shown[part.name].cover, np.linalg.norm(mesh.hair, axis=-1) > 0.0
        assert cover is not None
        assert (cover[grows, 3] == 1.0).all()
        full = grows & (mesh.paint[:, 3] > 0.9)
        assert not full.any() or cover[full, :3].mean() < 0.9 * mesh.paint[full, :3].mean()
        np.testing.assert_array_equal(cover[~grows], mesh.paint[~grows])
        dark, bare = dark + np.count_nonzero(full), bare + np.count_nonzero(~grows)
    assert dark > 0
    assert bare > 0


def test_hair_does_not_reach_into_the_ground() -> None:
    for figure in ("kangaroo", "horse", "camel"):
        low = min(float(mesh.vertices[:, 1].min()) for mesh in strands(figure, 6))
        assert low > -0.02


@pytest.mark.nightly
def test_what_is_far_away_has_fewer_and_wider_strands_and_at_last_none() -> None:
    near, far, speck = (strands("kangaroo", 1, away) for away in (4.0, 20.0, 400.0))
    assert 3 * MOST_STRANDS >= triangles(near) > 1.5 * triangles(far) > 0
    assert speck == []
    widths = [
        np.median(np.linalg.norm(v[:, 1] - v[:, 0], axis=-1))
        for v in (np.concatenate([m.vertices.reshape(-1, 5, 3) for m in s]) for s in (near, far))
    ]
    assert widths[1] > 1.5 * widths[0]


def test_tracks_keep_the_grain() -> None:
    tracks = builder("kangaroo").tracks
    again = FilmTracks.of_arrays(tracks.arrays())
    assert again.grain.tolist() == tracks.grain.tolist()
    assert len(builder("beetle").tracks.grain) == 0


def test_a_coat_that_cannot_grow_is_told() -> None:
    for material, told in (("steel", ["bare_coat"]), ("grey fur", [])):
        drawn = SHEEP.replace("COAT", "long").replace("material: fur", f"material: {material}")
        shooting = builder("sheep", drawn=drawn)
        notes = shooting_notes(shooting.scene, shooting)
        assert [note.kind for note in notes if note.kind == "bare_coat"] == told
        assert not told or notes[-1].place.endswith(":7")


@pytest.mark.nightly
def test_a_figure_may_be_shorn() -> None:
    for coat, some in (("long", True), ("none", False)):
        shot = builder("sheep", drawn=SHEEP.replace("COAT", coat)).shot(1)
        assert any(mesh.material == HAIR for mesh in shot.meshes) == some
    with pytest.raises(SceneError, match=r"shaggi.*shaggy"):
        builder("sheep", drawn=SHEEP.replace("COAT", "shaggi"))
