"""Routes over the plane, by arc length."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pipeline.simulation.locomotion.routes.route import (
    Route,
    heading_vector,
    plan_route,
    sharp_corners,
    spline_route,
    standing_route,
    straight_route,
    turn_in_place,
)
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene

WAYPOINTS = st.lists(
    st.tuples(st.integers(-8, 8), st.integers(-8, 8)), min_size=2, max_size=6, unique=True
).map(lambda points: [np.array(point, dtype=float) for point in points])


def fine(route: Route) -> Array:
    return np.linspace(0.0, route.s[-1], 1500)


@given(WAYPOINTS, st.booleans())
def test_spline_passes_every_waypoint_at_unit_speed(points: list[Array], closed: bool) -> None:
    closed = closed and len(points) > 2
    assume(not sharp_corners([points[-1], *points, points[0]] if closed else points))
    route = spline_route(points, None, closed)
    s = fine(route)
    xz, headings = route.at(s)
    gaps = np.linalg.norm(xz[:, None] - np.array(points), axis=-1).min(axis=0)
    assert gaps.max() < 0.02
    speed = np.linalg.norm(np.diff(xz, axis=0), axis=-1) / np.diff(s)
    assert np.abs(np.median(speed) - 1.0) < 0.01
    assert speed.max() < 1.2
    ahead = np.einsum("si,si->s", np.diff(xz, axis=0), heading_vector(headings)[:-1]) / np.diff(s)
    assert np.median(ahead) > 0.99
    if closed:
        np.testing.assert_allclose(xz[-1], xz[0], atol=1e-9)


def test_spline_starts_with_the_given_heading() -> None:
    route = spline_route([np.zeros(2), np.array([4.0, 1.0])], 0.7)
    xz, headings = route.at(np.array([0.0, 0.05]))
    assert headings[0] == pytest.approx(0.7, abs=0.05)
    np.testing.assert_allclose((xz[1] - xz[0]) / 0.05, heading_vector(0.7), atol=0.06)


@pytest.mark.parametrize(("heading", "turns"), [(65.0, False), (100.0, True), (-150.0, True)])
def test_a_path_that_leads_back_begins_with_a_turn_in_place(heading: float, turns: bool) -> None:
    walk = f"walk: {{path: [[2, 0], [4, 1]]}}, heading_deg: {heading}"
    scene = read_scene(f"pronk: 1\nduration: 1\ncast: [{{figure: horse, {walk}}}]\n")
    ((_, member),) = scene.creatures
    route = plan_route(member, np.array([0.6, 0.3]), 10.0)
    assert route.turns_at(0.01) == turns
    assert route.heading[0] == pytest.approx(np.radians(heading), abs=0.05)
    np.testing.assert_allclose(route.xz[-1], [4.0, 1.0], atol=1e-9)
    # No hairpin: it never turns within less than a decimetre.
    assert np.abs(route.curvature(fine(route))).max() < 10.0


def test_straight_and_standing_routes_keep_their_heading() -> None:
    s = np.array([-1.0, 0.0, 2.5, 1e6])
    xz, headings = straight_route(np.array([1.0, 2.0]), 0.3).at(s)
    np.testing.assert_allclose(xz, [1.0, 2.0] + s[:, None] * heading_vector(0.3))
    np.testing.assert_array_equal(headings, np.full(4, 0.3))
    assert straight_route(np.zeros(2), 0.0).length == np.inf
    xz, _ = standing_route(np.array([1.0, 2.0]), 0.3).at(s[1:])
    np.testing.assert_array_equal(xz, np.tile([1.0, 2.0], (3, 1)))


def test_turn_in_place_keeps_its_position() -> None:
    route = turn_in_place(np.array([1.0, -1.0]), 0.5, -2.0, 0.4)
    assert route.length == pytest.approx(0.8)
    xz, headings = route.at(fine(route))
    np.testing.assert_allclose(xz, np.tile([1.0, -1.0], (1500, 1)), atol=1e-12)
    np.testing.assert_allclose(headings, np.linspace(0.5, -1.5, 1500), atol=1e-9)
    assert not route.curvature(fine(route)).any()


def test_routes_are_cut_and_joined_continuously() -> None:
    first = spline_route([np.zeros(2), np.array([2.0, 1.0]), np.array([3.0, 4.0])], None)
    cut = first.upto(1.3)
    assert cut.length == pytest.approx(1.3)
    place, headings = first.at(np.array([1.3]))
    whole = cut.then(turn_in_place(place[0], float(headings[0]) + 4 * np.pi, 1.0, 0.5))
    assert whole.length == pytest.approx(1.8)
    s = np.linspace(0.0, 1.3, 200)
    np.testing.assert_allclose(whole.at(s)[0], first.at(s)[0], atol=1e-3)
    _, headings = whole.at(fine(whole))
    assert np.abs(np.diff(headings)).max() < 0.02


def test_curvature_of_a_circle_is_its_inverse_radius() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
    route = spline_route([3.0 * heading_vector(-a) for a in angles], None, closed=True)
    assert route.length == pytest.approx(6.0 * np.pi, rel=5e-3)
    bends = route.curvature(fine(route)[50:-50])
    assert np.abs(np.median(np.abs(bends)) - 1 / 3) < 0.02
