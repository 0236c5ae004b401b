"""Scenery: stands on the ground, out of the way, and in the same places every time."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import MATERIALS, meshes, triangle_counts
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import BANK, GroundSurface
from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.placement import MARGIN, Placement, Wanted
from pipeline.production.scenery.scatter_choice import ScatterChoice
from pipeline.production.scenery.scenery import (
    LEAST_COVER,
    TooManyTriangles,
    placed_scenery,
    scenery_meshes,
    thinned,
)
from pipeline.production.scenery.scenery_tally import SceneryTally
from pipeline.production.scenery.species import KINDS, prototype
from pipeline.production.scenery.treads import Treads
from pipeline.production.shots.film_tracks import FilmTracks
from pipeline.production.surroundings.choice import Choice
from pipeline.production.surroundings.land import Land
from pipeline.production.surroundings.land_mesh import land_mesh, vertices_around
from pipeline.simulation.take import TerrainRecord
from pipeline.simulation.terrain import build_ground
from pipeline.spec.scene_loader import read_scene
from pipeline.spec.terrain.kinds import HillsTerrain
from pipeline.spec.terrain.scatter import SPECIES
from render.shot import CameraPose, Mesh

DETAIL = 0.3
UNTRODDEN = Treads(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0), 96.0)
GREEN = (0.15, 0.15, 0.06)
POSES = tuple(CameraPose((6.0 + 0.1 * k, 1.5, 4.0), (0.0, 0.4, 0.0)) for k in range(5))
VIEW = FilmView.of(POSES, 1.6)


@pytest.fixture(scope="module")
def record() -> TerrainRecord:
    ground = build_ground(HillsTerrain(size=(20, 16), cells=(60, 48), height=0.6), seed=5)
    field = ground.field
    return TerrainRecord(field.vertices, field.faces, field.cells, ground.forbidden, "grass")


@pytest.fixture(scope="module")
def land(record: TerrainRecord) -> Land:
    return Land(record, "hills", "rough", 2)


@pytest.fixture(scope="module")
def horizon(land: Land, record: TerrainRecord) -> Mesh:
    return land_mesh(land, record, "grass", GREEN, DETAIL)


@pytest.fixture(scope="module")
def ground(land: Land, horizon: Mesh) -> GroundSurface:
    return GroundSurface(land, horizon, GREEN, GREEN, vertices_around(DETAIL))


def clearings() -> Clearings:
    """A performer walked along x through the middle, and a box stands at (2, 2)."""
    x, z = np.meshgrid(np.arange(-12, 12, 0.1), np.arange(-12, 12, 0.1))
    distance = np.minimum(np.abs(z), np.hypot(x - 2, z - 2)) / Clearings.UNIT
    return Clearings(
        (-12.0, -12.0), 0.1, np.minimum(distance, 255).astype(np.uint8), np.hypot(x - 2, z - 2) < 1
    )


@pytest.mark.slow
def test_every_species_has_a_shape_and_its_levels_of_detail_get_simpler() -> None:
    assert set(SPECIES) == set(KINDS)
    for name, species in KINDS.items():
        counts = [prototype(name, 1, k).triangles for k in range(len(species.levels) + 1)]
        assert counts == sorted(counts, reverse=True), name
        shape = prototype(name, 1, 0)
        assert np.isfinite(shape.vertices).all()
        assert np.isfinite(shape.colors).all()
        np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-5)
        assert shape.vertices[:, 1].max() * species.sizes[1] < 1.5 * species.height + 0.03, name


def test_places_lie_on_the_triangles_of_the_land(ground: GroundSurface, horizon: Mesh) -> None:
    # The middles of its triangles, which no vertex shares.
    faces = horizon.faces[5000:60000:211].astype(int)
    corners = horizon.vertices[faces].astype(float)
    middle = corners.mean(axis=1)
    near = np.hypot(middle[:, 0], middle[:, 2]) < 300.0
    found = ground.at(middle[near, 0], middle[near, 2]).height
    spread = np.ptp(corners[near, :, 1], axis=1)
    assert np.abs(found - middle[near, 1]).max() < 0.02 + 0.05 * spread.max()


def test_a_lower_density_leaves_things_out_and_moves_none(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    many, few = (placement.placed(Wanted("dry grass", d)).points for d in (1.0, 0.3))
    assert 0.15 * len(many) < len(few) < 0.6 * len(many)
    assert {tuple(p) for p in few.round(6)} <= {tuple(p) for p in many.round(6)}
    assert not {
        tuple(p)
        for p in Placement(ground, VIEW, None, 4, Growth(4), DETAIL)
        .placed(Wanted("dry grass", 1.0))
        .points.round(6)
    } & {tuple(p) for p in many.round(6)}


def test_patches_take_the_share_of_the_ground_that_an_author_wants(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)

    def squares(cover: float | None) -> int:
        wanted = Wanted("pebbles", 4.0, even=True, cover=cover)
        points = placement.placed(wanted).points
        return len(np.unique(np.floor(points[:, [0, 2]]), axis=0))

    own, wide, narrow = squares(None), squares(1.0), squares(0.1)
    assert wide > 1.4 * own
    assert narrow < 0.6 * own


def test_nothing_solid_stands_in_the_way_of_performers(ground: GroundSurface) -> None:
    where = clearings()
    placement = Placement(ground, VIEW, where, 3, Growth(3, where), 1.0)
    stones = placement.placed(Wanted("stone", 3.0)).points
    assert len(stones) > 50
    least = KINDS["stone"].radius + MARGIN["solid"]
    assert where.distance(stones[:, 0], stones[:, 2]).min() >= least - 1e-6
    grass = placement.placed(Wanted("short grass", 1.0)).points
    assert (where.distance(grass[:, 0], grass[:, 2]) < 0.1).any()
    assert not where.is_covered(grass[:, 0], grass[:, 2]).any()


def test_nothing_hides_the_target_of_a_camera(ground: GroundSurface) -> None:
    bushes = Placement(ground, VIEW, None, 3, Growth(3), 1.0).placed(Wanted("bush", 20.0)).points
    assert len(bushes) > 20
    for pose in POSES:
        a, b = (np.array([p[0], p[2]]) for p in (pose.p_WC, pose.p_WT))
        t = np.clip(((bushes[:, [0, 2]] - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
        apart = np.hypot(*(bushes[:, [0, 2]] - a - t[:, None] * (b - a)).T)
        assert apart.min() > 0.8


def test_no_shrub_hides_the_feet_of_the_target_and_grass_may() -> None:
    # Half way, where the line of sight to the target is 0.95 m high, to its feet 0.75 m.
    shrub = np.array([[3.2, 0.0, 2.0]]), np.array([0.6]), np.array([0.3])
    assert not VIEW.in_the_way(*shrub).any()
    assert VIEW.in_the_way(*shrub, hides=True).all()
    aside = np.array([[5.5, 0.0, 0.0]]), *shrub[1:]
    assert not VIEW.in_the_way(*aside, hides=True).any()


def test_moss_grows_before_the_target_but_not_at_the_lens() -> None:
    # On a rise whose top is as high as the line of sight.
    target, eye = np.array(POSES[0].p_WT), np.array(POSES[0].p_WC)
    rise = target + 0.1 * (eye - target)
    radii = np.array([0.1])
    assert not VIEW.in_the_way(rise[None], np.array([0.05]), radii, grows=True).any()
    assert VIEW.in_the_way(rise[None], np.array([0.07]), radii, grows=True).all()
    assert VIEW.in_the_way(rise[None], np.array([0.05]), radii).all()
    assert VIEW.in_the_way(eye[None], np.array([0.05]), radii, grows=True).all()


def test_cover_is_thinned_out_to_a_budget_and_all_else_stays(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    placed = [placement.placed(Wanted(name, 1.0)) for name in ("dry grass", "sedge", "boulder")]
    most = round(0.7 * sum(triangle_counts(every, DETAIL).sum() for every in placed))
    made = [meshes(every, DETAIL) for every in (placed, thinned(placed, most, DETAIL))]
    full, less = (sum(len(mesh.faces) for mesh in some) for some in made)
    assert full > 10_000
    assert 0.93 * most < less <= most
    assert {mesh.name for mesh in made[0]} <= set(MATERIALS)


def test_cover_that_no_frame_shows_is_left_out(ground: GroundSurface) -> None:
    points = Placement(ground, VIEW, None, 3, Growth(3), DETAIL).placed(Wanted("sedge", 1.0)).points
    way = points - np.array(POSES[2].p_WC)
    right, up, ahead = POSES[2].axes @ way.T
    # At 35 degrees, with the margin of the view, that of shadows, and the width of all poses.
    assert (np.abs(right) < np.tan(np.radians(32.0)) * ahead + 0.9).all()
    assert (np.abs(up) < np.tan(np.radians(22.0)) * ahead + 0.6).all()
    nearest = np.hypot(right, ahead).min()
    assert 1.5 < nearest < 6.0
    assert not VIEW.sees(np.array([[6.0, 0.0, 3.5]]), np.array([0.2])).any()
    assert VIEW.sees(np.array([[6.0, 0.0, 3.5]]), np.array([2.0])).all()


def test_trees_do_not_take_the_place_of_all_cover(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    grass, oaks = (placement.placed(Wanted(name, 1.0)) for name in ("dry grass", "oak"))
    most = 20_000
    assert triangle_counts(oaks, DETAIL).sum() > most
    kept, trees = thinned([grass, oaks], most, DETAIL)
    assert len(trees.points) == len(oaks.points)
    share = triangle_counts(kept, DETAIL).sum() / most
    assert 0.95 * LEAST_COVER < share <= LEAST_COVER


def test_the_nearest_cover_is_thinned_out_last(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    every = placement.placed(Wanted("dry grass", 1.0))
    (kept,) = thinned([every], round(0.5 * triangle_counts(every, DETAIL).sum()), DETAIL)
    middle = float(np.median(every.distances))
    near, far = (
        (kept.distances < middle).sum() / (every.distances < middle).sum(),
        (kept.distances >= middle).sum() / (every.distances >= middle).sum(),
    )
    assert near > 1.3 * far > 0.0


def test_stones_line_the_shore_and_weeds_stand_under_water(land: Land, horizon: Mesh) -> None:
    level = float(np.quantile(land.field.heights, 0.4))
    ground = GroundSurface(land, horizon, GREEN, GREEN, vertices_around(DETAIL), level)
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    stones = placement.placed(Wanted("stone", 8.0, where="shore")).points
    assert len(stones) > 30
    turns = np.arange(0.0, 2.0 * np.pi, 0.25 * np.pi)
    around = np.array(
        [
            ground.height(stones[:, 0] + BANK * np.cos(t), stones[:, 2] + BANK * np.sin(t)) < level
            for t in turns
        ]
    )
    assert (around.any(axis=0) & ~around.all(axis=0)).mean() > 0.9
    reeds = placement.placed(Wanted("reeds", 8.0, 0.4, where="shore")).points
    assert (reeds[:, 1] < level + 0.09).all()
    weeds = placement.placed(Wanted("water weed", 4.0, 0.1, where="wet")).points
    assert len(weeds) > 5
    assert (weeds[:, 1] < level).all()


def test_a_density_of_the_authors_own_is_kept_where_nothing_thrives(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 3, Growth(3), DETAIL)
    even, thriving = (
        len(placement.placed(Wanted("oak", 20.0, even=even)).points) for even in (True, False)
    )
    assert even > 1.2 * thriving


def test_the_same_scenery_is_made_again_byte_for_byte(ground: GroundSurface) -> None:
    choice = ScatterChoice((Wanted("meadow grass", 0.3), Wanted("stone", 1.0)), ())
    first, again = (
        scenery_meshes(
            placed_scenery(ground, VIEW, clearings(), choice, Growth(9), DETAIL),
            *(UNTRODDEN, (3.0, 0.0), DETAIL),
        )
        for _ in range(2)
    )
    assert [mesh.digest for mesh in first[0]] == [mesh.digest for mesh in again[0]]


def test_too_many_triangles_are_refused_with_their_memory(
    ground: GroundSurface, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.production.scenery.scenery.MAX_TRIANGLES", 10_000)
    choice = ScatterChoice((), (Wanted("dry grass", 1.0),))
    with pytest.raises(TooManyTriangles, match=r"GiB; at most 0.01 million .* 'dry grass'"):
        placed_scenery(ground, VIEW, None, choice, Growth(9), DETAIL)


def test_a_tally_counts_things_and_their_triangles(ground: GroundSurface) -> None:
    choice = ScatterChoice((Wanted("meadow grass", 0.3), Wanted("stone", 1.0)), ())
    every = placed_scenery(ground, VIEW, None, choice, Growth(9), DETAIL)
    tally = SceneryTally.of(every, DETAIL)
    assert tally.counts == {placed.name: len(placed.points) for placed in every}
    made, _ = scenery_meshes(every, UNTRODDEN, (3.0, 0.0), DETAIL)
    assert tally.triangles == sum(len(mesh.faces) for mesh in made)


def test_listed_species_stand_on_the_bed_where_all_is_under_water() -> None:
    for level, where in ((2.8, "wet"), (0.1, "dry")):
        scene = read_scene(
            "pronk: 1\nframes: 1\nterrain: {preset: dunes, height: 0.5, scatter: [boulder], "
            f"water: {{preset: lagoon, level: {level}}}}}\ncast: [{{figure: beetle}}]\n"
        )
        (asked,) = ScatterChoice.of(scene, Choice.of(scene)).asked
        assert (asked.name, asked.where) == ("boulder", where)


def test_a_preset_at_a_larger_size_covers_the_same_share_of_the_ground() -> None:
    def choice(scatter: str) -> ScatterChoice:
        scene = read_scene(
            f"pronk: 1\nframes: 1\nterrain: {{preset: meadow, scatter: {scatter}, water: pond}}\n"
            "cast: [{figure: beetle}]\n"
        )
        return ScatterChoice.of(scene, Choice.of(scene))

    usual = choice("{preset: heath, species: [fern]}")
    large = choice("{preset: heath, size: 5, species: [fern]}")
    assert large.asked == usual.asked
    assert len(large.fitted) == len(usual.fitted)
    for one, other in zip(usual.fitted, large.fitted, strict=True):
        assert other.size == pytest.approx(5.0 * one.size)
        assert other.density * other.size**2 == pytest.approx(one.density * one.size**2)


def test_large_plants_are_seen_as_far_as_their_size_wants(ground: GroundSurface) -> None:
    placement = Placement(ground, VIEW, None, 9, Growth(9), DETAIL)
    usual, large = (placement.placed(Wanted("dry grass", 0.2, size)) for size in (1.0, 4.0))
    assert len(large.points) > len(usual.points)
    assert large.distances.max() > usual.distances.max()


def test_tracks_keep_clearings() -> None:
    where = clearings()
    again = FilmTracks.of_arrays(FilmTracks(POSES, None, (), where).arrays()).clearings
    assert again is not None
    assert (again.corner, again.cell) == (where.corner, where.cell)
    np.testing.assert_array_equal(again.distances, where.distances)
    np.testing.assert_array_equal(again.covered, where.covered)


@pytest.mark.parametrize(
    ("terrain", "on_terrain", "on_land"),
    [
        ("{kind: flat, material: grass}", "oak", "oak"),
        ("{kind: flat, material: sand}", "beach grass", "beach grass"),
        ("{kind: flat, material: concrete}", "leaves", "oak"),
        ("{kind: flat, material: concrete, edging: room}", None, "oak"),
        ("{kind: flat, material: concrete, scatter: pavement}", "leaves", "oak"),
        ("{kind: flat, material: grass, scatter: none}", None, None),
        ("{kind: flat, material: grass, scatter: [fern]}", "fern", "fern"),
        (
            "{kind: flat, material: snow, scatter: {preset: tundra, density: 0.5}}",
            "tussock",
            "stone",
        ),
    ],
)
def test_scatter_suits_the_ground(
    terrain: str, on_terrain: str | None, on_land: str | None
) -> None:
    scene = read_scene(f"pronk: 1\nframes: 1\nterrain: {terrain}\ncast: [{{figure: beetle}}]\n")
    wanted = ScatterChoice.of(scene, Choice.of(scene)).wanted
    for names, name in (
        ({one.name for one in wanted if one.on_terrain}, on_terrain),
        ({one.name for one in wanted if one.on_land}, on_land),
    ):
        assert (name in names) if name else not names
