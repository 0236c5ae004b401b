"""Hurdles: people step over low things that they see, and trip over those that they do not."""

from __future__ import annotations

import numpy as np
import pytest

from tests.simulation.characters.scripted_people import STEPS, Play, play_scene

SLAB = "{name: slab, prop: {shape: box, size: [0.25, 0.15, 1.2]}, at: [0, 0.075, 0]}"
HALF_DEPTH, RISE = 0.125, 0.15


def crossing(start: float, seconds: float, script: str) -> Play:
    return play_scene(
        f"duration: {seconds}\nterrain: flat\ncast:\n"
        f"  - {{name: ann, character: adult, at: [{start}, 0]}}\n  - {SLAB}\n"
        f"  - {{name: post, prop: {{shape: box, size: [0.2, 1, 0.2]}}, at: [-1.2, 0.5, 6]}}\n"
        f"script:\n{script}"
    )


def soles_over_slab(play: Play) -> np.ndarray:
    """Return the heights of the ankles, as they stand, while the feet are above the slab [m]."""
    found = []
    for side in "lr":
        foot = play.joint("ann", f"foot_{side}")
        found.append(foot[np.abs(foot[:, 0] + 0.05) < HALF_DEPTH, 1])
    return np.concatenate(found) - float(play.records["ankle"][0, 0])


@pytest.mark.nightly
def test_a_walker_that_looks_ahead_steps_over_a_slab_and_goes_straight_on() -> None:
    play = crossing(-1.6, 6.0, "  - {at: 0, who: ann, do: {go_to: [1.6, 0]}}\n")
    assert play.when("ann")
    assert np.abs(play.joint("ann", "pelvis")[:, 2]).max() < 0.15
    assert soles_over_slab(play).min() > RISE
    assert play.joint("ann", "pelvis")[:, 1].min() > 0.75
    assert play.records["trips"].max() == 0


@pytest.mark.nightly
def test_a_runner_that_looks_aside_trips_falls_and_gets_up() -> None:
    script = (
        "  - {at: 0, who: ann, do: {look_at: post}}\n"
        "  - {at: 0, who: ann, do: {speed: 3}}\n"
        "  - {at: 0.1, who: ann, do: {go_to: [5, 0]}}\n"
    )
    play = crossing(-3.6, 7.5, script)
    pelvis = play.joint("ann", "pelvis")
    assert play.records["trips"].max() == 1
    assert pelvis[:, 1].min() < 0.45
    assert pelvis[-1, 1] > 0.8
    assert pelvis[-1, 0] > 1.0


@pytest.mark.nightly
def test_feet_of_one_who_turns_back_over_a_slab_do_not_jump() -> None:
    script = (
        "  - {at: 0, who: ann, do: {go_to: [1.6, 0]}}\n"
        "  - {at: 1.8, who: ann, do: {go_to: [-1.6, 1.2]}}\n"
    )
    play = crossing(-1.6, 3.2, script)
    feet = np.stack([play.joint("ann", f"foot_{side}") for side in "lr"])
    changes = np.diff(feet, n=2, axis=1) * STEPS
    assert np.linalg.norm(changes, axis=-1).max() < 4.0


def test_what_an_order_is_about_is_no_hurdle() -> None:
    play = crossing(-1.4, 1.0, "  - {at: 0, who: ann, do: {sit: slab}}\n")
    assert play.records["hurdle"].max() == -1
    assert play.records["hurdle"].min() == -1
