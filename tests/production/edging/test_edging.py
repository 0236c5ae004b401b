"""Edging: floors end like built things, out of the way of cast and cameras."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.production.edging.apron import Apron
from pipeline.production.edging.border import Border
from pipeline.production.edging.carpentry import Carpentry
from pipeline.production.edging.edging import LIT_LAMPS, Edging, Setting, edging_materials
from pipeline.production.edging.edging_choice import EdgingChoice
from pipeline.production.edging.floor_mesh import deck_mesh, paving_mesh
from pipeline.production.edging.floor_plan import FloorPlan
from pipeline.production.edging.ivy import ivy
from pipeline.production.edging.turned import fountain, lamp, pot, vase
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import MATERIALS
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.land import PLATFORM_HEIGHT, Land
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec.scene_loader import read_scene
from pipeline.spec.terrain.kinds import FlatTerrain
from render.config import Light
from render.shot import CameraPose, Mesh

EYE, TARGET = (6.5, 2.0, 0.0), (0.0, 0.8, 0.0)
VIEW = FilmView.of((CameraPose(EYE, TARGET),), 1.6)
PIECE, SEED = 1.2, 5
WORDS = (
    *("hedge", "wall", "fence", "railing", "planters", "overgrown"),
    *("room", "houses", "house", "school"),
)


def terrain(size: float = 30.0, heading: float = 0.0) -> TerrainRecord:
    kind = FlatTerrain(size=(size, size), cells=(20, 20), heading_deg=heading)
    ground = build_ground(kind, seed=1)
    field = ground.field
    return TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "concrete")


def clearings(half: float = 1.0) -> Clearings:
    """The cast is in a square around the middle."""
    x, z = np.meshgrid(np.arange(-9, 9, 0.1), np.arange(-9, 9, 0.1))
    out = np.hypot(np.maximum(np.abs(x) - half, 0), np.maximum(np.abs(z) - half, 0))
    distance = np.minimum(np.ceil(out / Clearings.UNIT), 255).astype(np.uint8)
    return Clearings((-9.0, -9.0), 0.1, distance, np.zeros(x.shape, bool))


def plan(*, is_broken: bool = True) -> FloorPlan:
    found = FloorPlan.of(terrain(), clearings(), PIECE, SEED, is_broken=is_broken)
    assert found is not None
    return found


def edging(
    word: str, floor: str = "paving", sun: tuple[float, float, float] | None = None
) -> Edging:
    record = terrain()
    land = Land(record, "hills", "platform", 2)
    choice = EdgingChoice(floor, word, PIECE)
    return Edging.of(choice, Setting(record, land, clearings(), VIEW, SEED, 0.5, sun), "concrete")


def top(mesh: Mesh) -> Array:
    """Return the vertices near the height of the floor."""
    return np.asarray(mesh.vertices[mesh.vertices[:, 1] > -0.08], float)


def test_a_floor_is_whole_around_the_cast_and_ends_before_the_terrain_does() -> None:
    made = plan()
    x, z = (a.ravel() for a in np.meshgrid(np.linspace(-1.5, 1.5, 40), np.linspace(-1.5, 1.5, 40)))
    assert made.has_piece(np.stack([x, z], axis=-1)).all()
    assert (made.low > -8.0).all()
    assert (made.high < 8.0).all()
    assert not made.kept.all()
    assert plan(is_broken=False).kept.all()


@pytest.mark.parametrize("heading", [20.0, 90.0])
def test_a_turned_floor_keeps_its_size(heading: float) -> None:
    made = FloorPlan.of(terrain(heading=heading), clearings(), PIECE, SEED, is_broken=True)
    assert made is None


def test_slabs_lie_level_where_the_cast_goes_and_are_sunk_and_tilted_at_the_border() -> None:
    made = plan()
    mesh = paving_mesh(made, "concrete", SEED)
    points = top(mesh)
    near = made.free(points[:, [0, 2]]) < 0.8
    assert near.any()
    assert np.ptp(points[near, 1]) == 0.0
    assert points[~near, 1].min() < made.height - 0.01
    up = np.cross(
        mesh.vertices[mesh.faces[:, 1]] - mesh.vertices[mesh.faces[:, 0]],
        mesh.vertices[mesh.faces[:, 2]] - mesh.vertices[mesh.faces[:, 0]],
    )[:, 1]
    # All that faces up or down faces up: no slab is seen from below.
    assert up.min() > -1e-4
    assert up.max() > 0.5


def test_a_deck_is_a_whole_rectangle() -> None:
    made = plan(is_broken=False)
    points = deck_mesh(made, "wood").vertices
    assert np.allclose(points[:, [0, 2]].min(axis=0), made.low)
    assert np.allclose(points[:, [0, 2]].max(axis=0), made.high)


def test_soil_creeps_over_the_border_but_never_under_the_cast_or_above_the_land_at_its_edge() -> (
    None
):
    made = plan()
    apron = Apron(made, True, SEED)
    mesh = apron.mesh("grass")
    places, height = mesh.vertices[:, [0, 2]].astype(float), mesh.vertices[:, 1]
    assert height[made.free(places) < 0.4].max() < made.height - 0.05
    out = made.beyond(places)
    assert height[np.abs(out) < 1.0].max() > made.height
    edge = np.abs(places).max(axis=1) > 15.0 - 1e-3
    np.testing.assert_allclose(height[edge], made.height - PLATFORM_HEIGHT, atol=1e-6)
    is_floor = apron.is_floor(places)
    assert is_floor[made.free(places) < 0.4].all()
    assert not is_floor[out > 0.1].any()


@pytest.mark.parametrize(
    ("light", "lit"),
    [
        ({"sun": {"hour": 12.0}}, False),
        ({"sun": {"hour": 12.0}, "weather": "rain"}, False),
        ({"sun": {"hour": 18.0, "day": 150, "clouds": "clear"}}, False),
        ({"sun": {"hour": 18.0, "day": 150, "clouds": "clear"}, "weather": "rain"}, True),
        ({"sun": {"hour": 18.0, "day": 150, "clouds": "overcast"}}, True),
        ({"sun": {"hour": 21.5, "day": 150, "clouds": "clear"}}, True),
        ("night", True),
        ("studio", False),
    ],
)
def test_lamps_are_lit_in_the_dark_and_in_gloom(light: object, lit: bool) -> None:
    glass = edging_materials(Light.model_validate(light))["edging lantern glass"]
    assert (glass.glow > 0.0) == lit


def test_street_lamps_give_light_from_within_their_glass_in_the_dark() -> None:
    made = edging("houses")
    assert not made.street_lamps(Light.model_validate({"sun": {"hour": 12.0}}))
    lit = made.street_lamps(Light.model_validate({"sun": {"hour": 21.5, "day": 150}}))
    assert 2 <= len(lit) <= LIT_LAMPS
    (glass,) = [mesh for mesh in made.meshes() if mesh.material == "edging lantern glass"]
    low, high = glass.vertices.min(axis=0), glass.vertices.max(axis=0)
    for light in lit:
        near = np.abs(glass.vertices - light.at).max(axis=1) < 0.13
        assert near.sum() >= 8
        assert low[1] < light.at[1] < high[1]
    assert not edging("hedge").street_lamps(Light.model_validate("night"))


@pytest.mark.sample(8)
@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("floor", ["paving", "deck"])
def test_nothing_stands_in_the_way_of_the_cast_or_of_the_camera(word: str, floor: str) -> None:
    made = edging(word, floor)
    named = {*MATERIALS, *edging_materials(Light())}
    assert made.floor is not None
    for mesh in made.meshes():
        assert mesh.material in named
        assert np.isfinite(mesh.vertices).all()
        # A rug lies under the cast.
        points = mesh.vertices[mesh.vertices[:, 1] > 0.05].astype(float)
        assert made.border.clearings is not None
        assert made.border.clearings.distance(points[:, 0], points[:, 2]).min(initial=9.0) > 0.3
    for placed in made.placed:
        tall = placed.points[placed.points[:, 1] > -0.2]
        assert np.isfinite(tall).all()
    if word in ("hedge", "wall"):
        # The camera looks along -x from beyond the floor: its side is left open, the others not.
        points = np.concatenate([mesh.vertices for mesh in made.meshes()])
        points = points[points[:, 1] > 0.3]
        assert points[:, 0].min() < -3.5
        ahead = np.abs(points[:, 2]) < 0.5
        assert points[ahead, 0].max() < 0.5


def test_the_same_scene_has_the_same_edging() -> None:
    first, second = (edging("hedge").meshes() for _ in range(2))
    assert [m.topology for m in first] == [m.topology for m in second]
    assert all((a.vertices == b.vertices).all() for a, b in zip(first, second, strict=True))


def test_no_tree_throws_its_shade_on_the_cast() -> None:
    sun = (0.0, 0.5, 0.866)
    border = Border(
        *(np.array([-4.0, -4.0]), np.array([4.0, 4.0]), lambda p: np.zeros(len(p))),
        *(VIEW, clearings(), SEED, 1.0, sun),
    )
    shades = border.shades_the_cast(np.array([[0.0, 7.0], [0.0, -7.0], [12.0, 0.0]]), 7.0, 2.0)
    assert shades.tolist() == [True, False, False]


def test_a_room_is_around_cast_and_cameras_and_has_windows_towards_the_sun() -> None:
    made = edging("room", sun=(0.0, 0.5, 0.866))
    walls = next(m for m in made.meshes() if m.material.startswith("edging wall")).vertices
    assert walls[:, 0].max() > EYE[0] + 0.5
    assert walls[:, 0].min() < -2.0
    tall = walls[walls[:, 1] > 2.0]
    for axis in (0, 2):
        assert np.ptp(tall[:, axis]) > 5.0
    # Wall above and below the windows, none between.
    sunny = walls[walls[:, 2] > walls[:, 2].max() - 0.3]
    assert {0.7, 2.4} <= {round(float(y), 2) for y in sunny[:, 1]}
    wool = {m.material: m.vertices for m in made.meshes() if "rug" in m.material}
    assert len(wool) > 2
    for rug in wool.values():
        # Performers stand on it; its bound edge and its fringes are beyond them.
        low = rug[(np.abs(rug[:, [0, 2]]) < 1.6).all(axis=1)]
        assert low[:, 1].max(initial=0.0) < 0.006
    assert max(rug[:, 1].max() for rug in wool.values()) > 0.008


def test_squares_are_paved_to_the_houses_and_furnished() -> None:
    made = edging("houses")
    names = {mesh.material for mesh in made.meshes()}
    assert {"edging water", "edging dark soil", "edging hewn stone"} <= names
    assert made.floor is not None
    hedged = edging("hedge")
    assert hedged.floor is not None
    assert np.ptp(made.floor.vertices[:, 0]) > np.ptp(hedged.floor.vertices[:, 0]) + 4.0


def test_what_grows_and_turns_is_of_sound_shapes() -> None:
    for made in (fountain(), pot(), vase(), lamp(), ivy(1, 0, 3.0), ivy(2, 1, 6.5)):
        assert np.isfinite(made.vertices).all()
        assert made.triangles > 100
        assert made.vertices[:, 1].min() > -0.2
    # A shape of revolution faces outwards.
    basin = fountain()
    a, b, c = (basin.vertices[basin.solid[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    assert ((facing * basin.normals[basin.solid[:, 0]]).sum(axis=1) > -1e-9).all()


@pytest.mark.nightly
def test_houses_are_seen_have_windows_and_stand_where_they_shade_nobody() -> None:
    made = edging("houses", sun=(-0.6, 0.4, 0.69))
    assert made.plots
    panes = next(m for m in made.meshes() if m.material == "edging pane").vertices
    # The camera looks along -x: facades stand on that side, but not between the cast and the sun.
    assert panes[:, 1].max() > 4.0
    plain = edging("houses")
    far = [plot for plot in plain.plots if plot.middle[0] < -7.0]
    assert far
    for plot in made.plots:
        border = made.border
        corners = plot.middle + [[dx, dz] for dx in (-3.0, 3.0) for dz in (-3.0, 3.0)]
        assert not border.shades_the_cast(corners, 6.3, 0.0).any()
    houses = [plot for plot in made.plots if plot.half.max() > 3.0]
    assert houses
    for placed in made.placed:
        for plot in houses:
            # Flowers grow before the facade, on its pavement and sills.
            assert not plot.holds(placed.points[:, [0, 2]], -2.6).any()


def test_the_door_of_a_house_is_at_the_head_of_stairs() -> None:
    record = terrain(12.0)
    vertices = record.vertices.copy()
    vertices[:, 1] = np.where(np.abs(vertices[:, 2] - 2.0) < 1.1, 0.6, 0.0)
    record = replace(record, vertices=vertices)
    land = Land(record, "hills", "platform", 2)
    choice = EdgingChoice("paving", "house", PIECE)
    made = Edging.of(choice, Setting(record, land, clearings(), VIEW, SEED, 0.5), "concrete")
    doors = [
        m.vertices
        for m in made.meshes()
        if m.material.startswith("edging shutter") and m.vertices[:, 1].min() < 0.75
    ]
    assert doors
    low = np.concatenate(doors)
    low = low[low[:, 1] < 0.9]
    assert low[:, 1].min() == pytest.approx(0.6, abs=0.02)
    assert abs(low[:, 2].mean() - 2.0) < 0.4


def test_a_school_has_a_path_that_ends_before_the_cast() -> None:
    made = edging("school", "ground")
    assert len(made.plots) > 5
    middles = np.array([plot.middle for plot in made.plots])
    assert made.border.clearings is not None
    assert 1.2 < made.border.clearings.distance(*middles.T).min()
    assert made.floor is None
    assert made.placed


def test_roofs_taper() -> None:
    carpentry = Carpentry()
    carpentry.add("oak", np.zeros(3), (4.0, 2.0, 3.0), top=(1.0, 0.1))
    (mesh,) = carpentry.meshes()
    ridge = mesh.vertices[mesh.vertices[:, 1] > 0.0]
    assert np.ptp(ridge[:, 2]) == pytest.approx(0.3)
    assert np.ptp(ridge[:, 0]) == pytest.approx(4.0)


def test_boards_have_their_grain_along_their_longest_side() -> None:
    carpentry = Carpentry()
    carpentry.add("oak", np.zeros(3), (0.1, 2.0, 0.05), 0.4)
    (mesh,) = carpentry.meshes()
    assert mesh.rest is not None
    assert np.ptp(mesh.rest, axis=0) == pytest.approx([2.0, 0.1, 0.05])
    centre = mesh.vertices[mesh.faces].mean(axis=1)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a) * centre).sum(axis=1).min() > 0.0


@pytest.mark.parametrize(
    ("ground", "light", "expected"),
    [
        ("{kind: flat, material: concrete, surroundings: forest}", "", ("paving", "hedge", 0.45)),
        ("{kind: flat, material: wood, surroundings: sea}", "", ("deck", "railing", 0.125)),
        ("{kind: flat, material: tiles}", "", ("paving", "wall", 0.4)),
        ("{kind: flat, material: tiles, edging: room}", "", ("paving", "room", 0.4)),
        ("{kind: flat, material: tiles, edging: none}", "", None),
        ("{kind: flat, material: tiles, show_forbidden: true}", "", None),
        ("{kind: flat, material: grass, edging: hedge}", "", None),
        ("{kind: flat, material: grass, edging: school}", "", ("ground", "school", 1.0)),
        ("{kind: flat, material: tiles, edging: houses}", "", ("paving", "houses", 0.4)),
        ("{kind: flat, material: tiles, surroundings: none, edging: house}", "", None),
        ("{kind: flat, material: concrete}", "light: studio", None),
    ],
)
def test_edging_suits_floor_and_surroundings_unless_an_author_says_otherwise(
    ground: str, light: str, expected: tuple[str, str, float] | None
) -> None:
    text = (
        f"pronk: 1\nduration: 1\nterrain: {ground}\ncast: [{{name: bay, figure: horse}}]\n{light}\n"
    )
    scene = read_scene(text)
    choice = EdgingChoice.of(scene, Choice.of(scene))
    if expected is None:
        assert choice is None
    else:
        assert choice is not None
        assert (choice.floor, choice.along) == expected[:2]
        assert choice.piece == pytest.approx(expected[2])
