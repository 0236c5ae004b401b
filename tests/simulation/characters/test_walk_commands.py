"""Walk commands of minds, and how fast people walk who do not see where they step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from pipeline.simulation.characters.body_arrays import NOBODY, IntArray
from pipeline.simulation.characters.mind.motor_command import MotorCommand
from pipeline.simulation.characters.mind.walk_command import (
    MIN_PACE,
    write_manner,
    write_walk_command,
)
from pipeline.simulation.characters.pelvis_motion import (
    BACKWARD_FROUDE,
    BLIND_TURN,
    _walk_vector,
)
from pipeline.simulation.characters.person_record import (
    PERSON,
    PLACED,
    REACHING,
    SITTING,
    STANDING,
    SWINGING,
)
from pipeline.simulation.dynamics.compiled import Records, entry
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.record_array import zero_records

PACE = 1.1
HIP_HEIGHT = 0.8


def sitting_person() -> tuple[Records, IntArray]:
    """Return a person that sits with its hands in use, and its grips: the right hand holds."""
    persons: Any = zero_records(1, PERSON)
    persons["posture"], persons["arm_mode"] = SITTING, PLACED
    persons["goal"], persons["facing"], persons["partner"] = (5.0, 6.0), 2.0, 7
    persons["stop_distance"] = persons["neighbour_distance"] = 0.3
    return persons, np.array([[NOBODY, NOBODY], [3, 4], [NOBODY, NOBODY]])


@pytest.mark.parametrize(("reaching", "mode"), [(True, REACHING), (False, SWINGING)])
def test_a_command_to_walk_sets_the_goal_and_leaves_hands_that_hold(
    reaching: bool, mode: int
) -> None:
    persons, grips = sitting_person()
    write_walk_command(persons, grips, 0, True, 1.0, 2.0, 3, True, 0.5, reaching)
    person = persons[0]
    assert person["posture"] == STANDING
    assert person["has_goal"]
    assert person["goal"].tolist() == [1.0, 2.0]
    assert person["has_facing"]
    assert person["facing"] == 0.5
    assert person["partner"] == 3
    assert person["stop_distance"] == 0.0
    assert person["neighbour_distance"] == math.inf
    assert person["arm_mode"].tolist() == [mode, PLACED]


def test_a_command_to_stand_ends_the_walk_and_the_facing_alone() -> None:
    persons, grips = sitting_person()
    persons["has_goal"] = persons["has_facing"] = True
    write_walk_command(persons, grips, 0, False, 1.0, 2.0, 3, False, 0.5, False)
    person = persons[0]
    assert person["posture"] == STANDING
    assert not person["has_goal"]
    assert not person["has_facing"]
    assert person["goal"].tolist() == [5.0, 6.0]
    assert person["facing"] == 2.0
    assert person["partner"] == 7
    assert person["stop_distance"] == 0.3


def test_a_manner_says_how_fast_still_and_startled_a_person_is() -> None:
    person: Any = zero_records(1, PERSON)[0]
    write_manner(person, MotorCommand(pace=0.0, frozen=True, startled=True), False)
    assert person["frozen"]
    assert person["fearful"]
    assert not person["startled"]
    assert person["pace"] == MIN_PACE
    write_manner(person, MotorCommand(pace=PACE), True)
    assert not person["frozen"]
    assert not person["fearful"]
    assert person["startled"]
    assert person["pace"] == PACE


@entry
def walk_vector_of(persons: Records) -> tuple[float, float]:
    """Return the wanted velocity of the first person along x and z [m/s]."""
    return _walk_vector(persons[0])


def wanted_speed(startled: bool, gaze: float) -> float:
    """Return the speed at which a person steps back along -x that keeps facing +x [m/s]."""
    persons: Any = zero_records(1, PERSON)
    persons["hip_height"], persons["thigh"], persons["shin"] = HIP_HEIGHT, 0.4, 0.4
    persons["pace"], persons["has_goal"], persons["goal"] = PACE, True, (-6.0, 0.0)
    persons["has_facing"], persons["startled"] = True, startled
    persons["gaze"][:, 0] = gaze
    x, z = walk_vector_of(persons)
    assert x < 0.0
    assert z == pytest.approx(0.0, abs=1e-12)
    return -x


def test_who_starts_back_is_slow_until_its_head_has_turned_to_the_way() -> None:
    feeling = BACKWARD_FROUDE * math.sqrt(GRAVITY * HIP_HEIGHT)
    assert feeling < 0.5 * PACE
    just_blind, just_seeing = math.pi - BLIND_TURN - 0.01, math.pi - BLIND_TURN + 0.01
    assert wanted_speed(True, 0.0) == pytest.approx(feeling)
    assert wanted_speed(True, just_blind) == pytest.approx(feeling)
    assert wanted_speed(True, just_seeing) == pytest.approx(PACE)
    assert wanted_speed(True, math.pi) == pytest.approx(PACE)


def test_who_is_not_startled_feels_its_way_back_wherever_it_looks() -> None:
    feeling = BACKWARD_FROUDE * math.sqrt(GRAVITY * HIP_HEIGHT)
    assert wanted_speed(False, 0.0) == pytest.approx(feeling)
    assert wanted_speed(False, math.pi) == pytest.approx(feeling)
