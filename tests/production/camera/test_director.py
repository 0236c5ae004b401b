"""Director: its cuts keep to the rules of the craft, and can be put into a scene."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
import yaml

from pipeline.production.camera.cuts import camera_poses
from pipeline.production.camera.director.action_line import crossing, line_of
from pipeline.production.camera.director.edit_decision import (
    EditDecision,
    decisions_json,
    decisions_of_json,
    decisions_yaml,
)
from pipeline.production.camera.director.editing_pace import LEAST_SHOT_S, PACES
from pipeline.production.camera.director.key_light import LEAST_ANGLE, KeyLight, light_cost
from pipeline.production.camera.director.performer_tracks import PerformerTracks
from pipeline.production.camera.director.planned_shot import PlannedShot, f_number
from pipeline.production.camera.director.shot_plan import ShotPlan
from pipeline.production.camera.director.story_event import StoryEvent
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from render.config import Camera, light
from render.config.camera import cuts
from render.shot import CameraPose
from tests.production.camera.directed_scenes import directed, directed_film, directed_scene

RATE = 24.0

Pace = Literal["calm", "natural", "quick"]


def tracks(seconds: float, still_from: float = math.inf, gap: float = 2.0) -> PerformerTracks:
    """Return two who walk along +X side by side, until they stand."""
    times = np.arange(0.0, seconds, 1 / 12)
    way = np.minimum(times, still_from)
    moving = (times < still_from).astype(float)
    centers = np.stack([np.stack([way, 0 * way, 0 * way + z], -1) for z in (0.0, gap)], axis=1)
    velocities = np.zeros_like(centers)
    velocities[..., 0] = moving[:, None]
    return PerformerTracks(
        names=("one", "other"),
        times=times,
        centers=centers,
        velocities=velocities,
        heights=np.ones((len(times), 2)),
        activities=np.repeat(moving[:, None], 2, axis=1),
        motions=np.ones(2),
        radii=np.full(2, 0.5),
        jointed=np.ones(2, dtype=bool),
        counts=np.full(2, 9),
    )


def event(time: float, kind: Literal["hug", "arrival"] = "hug") -> StoryEvent:
    return StoryEvent(kind, time, time + 0.5, ("one", "other"), "one hugs other")


def plan(
    seconds: float,
    story: Sequence[StoryEvent],
    pace: Pace = "natural",
    still_from: float = math.inf,
) -> list[PlannedShot]:
    own = tracks(seconds, still_from)
    shots = ShotPlan(own, own.names, None, PACES[pace], RATE)
    return shots.shots(0, round(seconds * RATE), story)


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("times", [(), (0.7,), (4.0,), (2.0, 5.0, 9.0), (11.5,), (5.0, 5.6, 6.2)])
def test_a_plan_opens_wide_and_has_no_short_shots(pace: Pace, times: tuple[float, ...]) -> None:
    shots = plan(12.0, [event(time) for time in times], pace)
    assert (shots[0].first, shots[0].size, shots[0].follow) == (0, "wide", None)
    assert shots[-1].end == 12 * RATE
    for shot, following in itertools.pairwise(shots):
        assert shot.end == following.first
    assert min(shot.end - shot.first for shot in shots) >= LEAST_SHOT_S * RATE
    calm, quick = plan(12.0, [], "calm"), plan(12.0, [], "quick")
    assert len(calm) < len(quick)


@pytest.mark.parametrize("pace", PACES)
def test_a_shot_begins_before_its_event_and_lasts_beyond_it(pace: Pace) -> None:
    (shot,) = [shot for shot in plan(12.0, [event(5.0)], pace) if shot.is_event]
    assert shot.size == "close"
    assert set(shot.follow or ()) == {"one", "other"}
    assert 0.4 - 1 / RATE <= 5.0 - shot.first / RATE <= 0.6 + 1 / RATE
    assert shot.end / RATE - 5.0 >= 1.0


def test_a_short_film_is_one_shot() -> None:
    (shot,) = plan(3.9, [event(2.0)])
    assert (shot.size, shot.end) == ("wide", round(3.9 * RATE))


def test_a_dead_tail_ends_in_a_wider_shot() -> None:
    *_, last = plan(12.0, [event(5.0)], still_from=6.5)
    assert last.size == "wide"
    assert 6.5 <= last.first / RATE <= 7.5
    assert "nothing more happens" in last.reason
    *_, last = plan(12.0, [event(5.0)])
    assert "nothing more happens" not in last.reason


def test_the_line_runs_between_two_and_along_the_motion_of_one() -> None:
    own = tracks(4.0)
    assert line_of(own, ("one", "other"), 1.0) == pytest.approx([0, 0, 1])
    assert line_of(own, ("one",), 1.0) == pytest.approx([1, 0, 0])
    assert line_of(tracks(4.0, still_from=0.0), ("one",), 1.0) is None
    assert line_of(own, (), 1.0) is None
    ahead, right = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    assert [crossing(ahead, ahead, v) for v in (ahead, -ahead, right)] == [0.0, 1.0, 0.5]
    # A view that is nearly along the line, on its other side.
    assert crossing(ahead, ahead, right - 0.1 * ahead) == 1.0


def test_the_key_light_is_that_of_the_scene() -> None:
    studio = KeyLight.of(light({"studio": {"heading_deg": 90, "elevation_deg": 0}}))
    assert studio is not None
    assert studio.direction == pytest.approx([0, 0, -1])
    assert studio.angle(np.array([0.0, 0.0, -2.0])) == pytest.approx(0.0, abs=1e-6)
    for name in ("night", "overcast"):
        assert KeyLight.of(light(name)) is None
    flat, side, behind = (light_cost(a) for a in (LEAST_ANGLE, math.pi / 2, math.pi))
    assert (side, flat) == (0.0, 1.0)
    assert behind > side


def test_a_closer_shot_has_a_shallower_focus() -> None:
    assert f_number("wide", 8.0, 1.0) is None
    medium, close = f_number("medium", 5.0, 0.5), f_number("close", 4.0, 0.5)
    assert medium is not None
    assert close is not None
    assert close < medium
    # A small thing needs a smaller aperture to be sharp.
    small = f_number("close", 0.3, 0.1)
    assert small is not None
    assert small > close


def test_the_cuts_are_yaml_for_a_scene() -> None:
    decisions = [
        EditDecision(Camera(view=40.0, fov_deg=36.0), "establishing shot of all"),
        EditDecision(Camera(start=2.5, follow=("bug", "on"), view=-20.0, aperture=2.0), "a: #b"),
    ]
    text = decisions_yaml(decisions)
    assert "# establishing shot of all" in text
    given = yaml.safe_load(text)["camera"]
    assert list(cuts(given)) == [decision.camera for decision in decisions]
    assert list(decisions_of_json(decisions_json(decisions))) == decisions


def _shake(still: CameraPose, held: CameraPose) -> float:
    """Return the angle between the directions of two poses [degrees]."""
    ways = [np.array(pose.p_WT) - np.array(pose.p_WC) for pose in (still, held)]
    cosine = ways[0] @ ways[1] / math.prod(float(np.linalg.norm(way)) for way in ways)
    return math.degrees(math.acos(min(1.0, cosine)))


def test_a_camera_that_shakes_is_the_same_every_time(hills: tuple[Scene, Take]) -> None:
    _, take = hills
    still = camera_poses(take, cuts({"view": "side"}), 16 / 9)
    held = camera_poses(take, cuts({"view": "side", "handheld": 0.3}), 16 / 9)
    assert held == camera_poses(take, cuts({"view": "side", "handheld": 0.3}), 16 / 9)
    # A cut does not begin the shake anew.
    later = [{"view": "side", "handheld": 0.3}, {"start": 0.5, "view": "side", "handheld": 0.3}]
    parts = camera_poses(take, cuts(later), 16 / 9)
    assert _shake(still[-1], held[-1]) == pytest.approx(
        _shake(
            camera_poses(take, cuts([{**c, "handheld": 0} for c in later]), 16 / 9)[-1], parts[-1]
        ),
        abs=1e-4,
    )
    aims = []
    for a, b in zip(still, held, strict=True):
        assert a.p_WC == b.p_WC
        aims.append(_shake(a, b))
    assert 0.02 < max(aims) < 0.35
    # Smooth: it never moves by a tenth of a degree from one frame to the next.
    assert np.abs(np.diff(aims)).max() < 0.1
    other = replace(take, header=replace(take.header, seed=take.header.seed + 1))
    assert camera_poses(other, cuts({"view": "side", "handheld": 0.3}), 16 / 9) != held


@pytest.mark.parametrize(("angle", "name"), [(90.0, "side"), (180.0, "back"), (0.0, "front")])
def test_a_view_by_angle_is_that_of_the_same_name(
    hills: tuple[Scene, Take], angle: float, name: Literal["side", "back", "front"]
) -> None:
    _, take = hills
    by_angle, by_name = (
        camera_poses(take, cuts({"view": view, "elevation_deg": 10}), 16 / 9)
        for view in (angle, name)
    )
    assert np.array([p.p_WC for p in by_angle]) == pytest.approx(
        np.array([p.p_WC for p in by_name]), abs=1e-5
    )


def test_cuts_that_nobody_has_decided_are_refused(hills: tuple[Scene, Take]) -> None:
    _, take = hills
    with pytest.raises(ValueError, match="director"):
        camera_poses(take, cuts("auto"), 16 / 9)


SMALL = 1
SEEDS = range(50)


def _keeps_the_rules(shooting: ShotBuilder) -> None:
    film = directed_film(shooting)
    assert film.lost <= 0.3
    assert film.crossed == 0
    assert film.jumps == 0
    assert film.light is None or film.light >= 38.0
    assert min(film.shots) >= LEAST_SHOT_S or len(film.shots) == 1


@pytest.mark.nightly
def test_the_cuts_of_a_small_scene_keep_the_rules() -> None:
    scene = directed_scene(SMALL)
    shooting = directed(scene)
    _keeps_the_rules(shooting)
    # The cuts that are printed, in place of `auto`, make the same film.
    written = yaml.safe_load(decisions_yaml(shooting.decisions))["camera"]
    again = ShotBuilder(scene.model_copy(update={"camera": cuts(written)}), shooting.take)
    assert again.poses == shooting.poses


@pytest.mark.nightly
@pytest.mark.parametrize("seed", SEEDS)
def test_the_cuts_of_random_scenes_keep_the_rules(seed: int) -> None:
    _keeps_the_rules(directed(directed_scene(seed)))
