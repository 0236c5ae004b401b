"""Bearing of people: weight shifts in standing, heads of walkers, feet in turns."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from pipeline.simulation.characters.motor_control import MAX_HEAD_SPEED, MAX_WALKING_GAZE_YAW
from pipeline.simulation.characters.person_record import FOOT, HIP, STANCE
from pipeline.simulation.spatial import Array
from tests.simulation.characters.scripted_people import STEPS, Play, play_scene, walk

pytestmark = pytest.mark.slow


def longest_still(places: Array, limit: float = 0.01) -> float:
    """Return the longest time in which a place (K, 3) moves by less than a limit [s]."""
    longest = start = 0
    for k in range(1, len(places)):
        if np.linalg.norm(places[k] - places[start]) > limit:
            start = k
        longest = max(longest, k - start)
    return longest / STEPS


@cache
def standing(cast: str = "ab") -> Play:
    people = {
        "a": "{name: a, character: adult}",
        "b": "{name: b, character: child, scale: 0.8, at: [0, 2]}",
        "c": "{name: c, character: adult, at: [0, -2]}",
        "t": "{name: twin, character: adult, at: [0, -4]}",
    }
    return play_scene(
        f"duration: 10\ncast: [{', '.join(people[name] for name in cast)}]\n"
        "script:\n  - {at: 0, who: a, do: stand}\n"
        + ("  - {at: 0, who: c, do: freeze}\n" if "c" in cast else "")
    )


@pytest.mark.parametrize("name", ["a", "b"])
def test_a_standing_person_shifts_weight_over_feet_that_stay(name: str) -> None:
    play = standing()
    assert longest_still(play.joint(name, "pelvis")) < 4.0
    for foot in ("foot_l", "foot_r"):
        assert np.ptp(play.joint(name, foot), axis=0).max() < 1e-3
    step = np.abs(np.diff(play.joint(name, "pelvis")[STEPS:], axis=0)).max()
    assert step * STEPS < 0.1


def test_weight_shifts_differ_from_person_to_person_and_not_by_the_order_of_the_cast() -> None:
    one, other = standing("at"), standing("ta")
    aside = [play.joint("a", "pelvis")[STEPS:, 2] for play in (one, other)]
    assert np.abs(aside[0] - aside[1]).max() < 1e-9
    # Of the same size, so that only the seeded phases set the two apart.
    twin = one.joint("twin", "pelvis")[STEPS:, 2]
    assert abs(np.corrcoef(aside[0], twin)[0, 1]) < 0.9


def test_a_person_told_to_freeze_stays_still() -> None:
    pelvis = standing("ac").joint("c", "pelvis")
    assert np.ptp(pelvis[STEPS:], axis=0).max() < 0.005


def test_a_person_that_freezes_in_fear_sways_on_feet_that_stay() -> None:
    play = play_scene(
        "duration: 7\ncast:\n  - {name: c, character: child, behaviours: [{freeze: d}]}\n"
        "  - {name: d, character: adult, at: [2, 0], heading_deg: 180}\n"
        "script: [{at: 0, who: d, do: stand}]\n"
    )
    assert play.records["frozen"][STEPS:, 0].all()
    assert longest_still(play.joint("c", "pelvis")[STEPS:]) < 4.0
    for foot in ("foot_l", "foot_r"):
        assert np.ptp(play.joint("c", foot)[STEPS:], axis=0).max() < 1e-3


def test_a_walker_that_looks_at_something_behind_still_sees_the_way() -> None:
    play = play_scene(
        "duration: 6\ncast: [{name: a, character: adult, at: [-3, 0]}]\nscript:\n"
        "  - {at: 0, who: a, do: {look_at: [-8, 1.6, 1]}}\n"
        "  - {at: 2, who: a, do: {go_to: [4, 0]}}\n"
    )
    gaze = play.records["gaze"][:, 0, 0]
    standing_turn = np.abs(gaze[: 2 * STEPS]).max()
    assert standing_turn > math.radians(100.0)
    v = np.gradient(play.joint("a", "pelvis")[:, [0, 2]], 1.0 / STEPS, axis=0)
    off = np.cos(gaze + np.arctan2(v[:, 1], v[:, 0]))
    brisk = np.hypot(v[:, 0], v[:, 1]) > 0.6
    assert brisk.sum() > STEPS
    assert (off[brisk] < 0.0).mean() < 0.03
    walking = np.abs(gaze[4 * STEPS : 5 * STEPS])
    assert walking.max() < MAX_WALKING_GAZE_YAW + math.radians(8.0)
    assert walking.min() > math.radians(45.0)
    assert np.abs(np.diff(gaze)).max() * STEPS < MAX_HEAD_SPEED + 0.1


def test_a_person_turning_on_the_spot_and_one_in_a_hug_shift_their_weight() -> None:
    turns = "".join(
        f"  - {{at: {0.3 + 1.6 * k:.1f}, who: a, do: {{turn_deg: 180}}}}\n" for k in range(4)
    )
    play = play_scene(
        "duration: 7\ncast:\n  - {name: a, character: child, at: [-3, 0]}\n"
        "  - {name: b, character: adult}\n"
        "  - {name: c, character: adult, at: [0.9, 0], heading_deg: 180}\n"
        f"script:\n{turns}"
        "  - {at: 0.1, who: b, do: {hug: c}}\n  - {at: 0.1, who: c, do: {hug: b}}\n"
    )
    for name in "abc":
        pelvis = play.joint(name, "pelvis")
        for start in range(3 * STEPS, len(pelvis) - 4 * STEPS + 1, STEPS):
            four_seconds = pelvis[start : start + 4 * STEPS]
            assert np.linalg.norm(four_seconds - four_seconds[0], axis=1).max() > 0.01


def test_the_head_leads_the_trunk_into_a_turn() -> None:
    play = play_scene(
        "duration: 3\ncast: [{name: a, character: adult}]\n"
        "script: [{at: 0.5, who: a, do: {go_to: [0, 4]}}]\n"
    )
    gaze, heading = play.records["gaze"][:, 0, 0], play.records["heading"][:, 0]
    half = math.radians(45.0)
    assert np.argmax(np.abs(gaze) > half) < np.argmax(np.abs(heading) > half) - 0.1 * STEPS


def test_feet_turn_with_the_pelvis_without_a_flip() -> None:
    play = play_scene(
        "duration: 5\ncast: [{name: a, character: adult, heading_deg: 200}]\n"
        "script: [{at: 1, who: a, do: {go_to: [1.5, -1]}}]\n"
    )
    yaw = play.records["yaw"][:, 0]
    turned = np.abs(np.angle(np.exp(1j * np.diff(yaw, axis=0))))
    assert turned.max() * STEPS < 20.0
    heading = play.records["heading"][:, 0]
    lag = np.unwrap(yaw, axis=0) - np.unwrap(heading)[:, None]
    # Both feet end up as the pelvis does, not a whole turn away from it.
    assert np.abs(lag[-1] - lag[0]).max() < 1.0


@pytest.mark.parametrize(("kind", "speed"), [("adult", 1.4), ("child", 1.1)])
def test_a_walkers_hips_stay_as_low_as_its_standing_legs_reach(kind: str, speed: float) -> None:
    persons = walk(kind, speed).records[:, 0]
    ways = persons["targets"][:, HIP : HIP + 2] - persons["targets"][:, FOOT : FOOT + 2]
    stretch = np.linalg.norm(ways, axis=2) / (persons["thigh"] + persons["shin"])[:, None]
    # Beyond that a knee has no direction to bend in, and springs round.
    assert stretch[persons["foot_state"] == STANCE].max() < 1.0


@pytest.mark.parametrize("speed", [0.8, 1.4, 2.6])
def test_feet_come_down_at_any_moment_of_a_step(speed: float) -> None:
    steps = [c for c in walk("adult", speed).contacts if ".foot_" in c.part]
    times = np.array([c.step + c.fraction for c in steps if c.part.endswith("_l")]) / STEPS
    assert len(np.unique(np.round([c.fraction for c in steps], 6))) > 2
    # In a steady walk one is as long after another as the next.
    assert np.ptp(np.diff(times)[1:-1]) < 0.1 * np.diff(times).mean()
