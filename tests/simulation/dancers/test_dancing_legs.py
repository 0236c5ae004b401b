"""Tests of the hips and legs of dancers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.dancers.dancing_legs import (
    HEEL_LIFT,
    SHIFT,
    DancingLegs,
    DancingStyle,
    draw_style,
)
from pipeline.simulation.people.proportions import ADULT, CHILD, JOINTS, Proportions
from pipeline.simulation.seeds import generator
from pipeline.simulation.spatial import Array

DT, BEAT, SWAY = 1.0 / 96.0, 0.58, math.radians(4.0)


def _danced(legs: DancingLegs, seconds: float, sway: float = SWAY, since: float = 0.0) -> None:
    for k in range(round(seconds / DT)):
        legs.advance(DT, since + k * DT, BEAT, sway)


def _lengths(legs: DancingLegs, person: Proportions) -> Array:
    """Return by how much each bone of the legs differs from that at rest [m]."""
    rest, found = dict(zip(JOINTS, person.rest(), strict=True)), legs.legs()
    errors = []
    for side in "lr":
        hip, knee, ankle = (found[f"{name}_{side}"][1] for name in ("thigh", "shin", "foot"))
        at_rest = [rest[f"{joint}_{side}"] for joint in ("hip", "knee", "foot")]
        for k, (a, b) in enumerate(((hip, knee), (knee, ankle))):
            errors.append(np.linalg.norm(b - a) - np.linalg.norm(at_rest[k + 1] - at_rest[k]))
    return np.array(errors)


@pytest.mark.parametrize("person", [ADULT, CHILD])
@pytest.mark.parametrize("seed", range(4))
def test_bones_keep_their_lengths_and_feet_their_places(person: Proportions, seed: int) -> None:
    legs = DancingLegs(person, draw_style(generator(seed, "ida/legs")))
    balls = []
    for _ in range(24):
        _danced(legs, 0.1)
        assert np.abs(_lengths(legs, person)).max() < 1e-9
        for k, side in enumerate("rl"):
            R, ankle = legs.legs()[f"foot_{side}"]
            ball = ankle + person.height * R @ [0.42 * person.foot, -person.ankle, 0.0]
            balls.append((k, *ball))
    for k in (0, 1):
        places = np.array([row[1:] for row in balls if row[0] == k])
        # A leg that is stretched to its length lifts its foot by less than a sole gives.
        assert np.ptp(places, axis=0).max() < 0.002


def test_hips_go_to_both_sides_once_in_two_beats() -> None:
    legs = DancingLegs(ADULT, DancingStyle())
    _danced(legs, 6.0 * BEAT)
    shifts = []
    for k in range(round(2.0 * BEAT / DT)):
        legs.advance(DT, 6.0 * BEAT + k * DT, BEAT, SWAY)
        shifts.append(legs.motion.shift)
        assert min(legs.motion.right, legs.motion.left) < 0.5 * HEEL_LIFT
    assert 0.6 * SHIFT < max(shifts) < SHIFT
    assert -SHIFT < min(shifts) < -0.6 * SHIFT


def test_hips_come_to_rest_without_sway_and_before_the_first_beat() -> None:
    legs = DancingLegs(ADULT, DancingStyle())
    _danced(legs, 1.0, since=-1.0)
    assert legs.motion.shift == legs.motion.dip == 0.0
    _danced(legs, 3.0)
    assert abs(legs.motion.shift) + legs.motion.dip > 1e-3
    _danced(legs, 6.0, sway=0.0)
    assert abs(legs.motion.shift) + legs.motion.dip < 1e-5


def test_dancers_differ_by_name_and_agree_by_seed() -> None:
    first, again, other = (
        draw_style(generator(5, f"{name}/legs")) for name in ("adonis", "adonis", "hermes")
    )
    assert first == again
    assert first != other
