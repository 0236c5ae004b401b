"""Pain reflex: an order and the withdrawal from pain compete by obedience."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.characters.pain_reflex import withdrawal_facing
from pipeline.simulation.characters.person_record import PLACED
from pipeline.spec import read_scene
from tests.simulation.characters.mind_scenes import simulation, troupe

CAST = """
- {name: one, character: child, obedience: OBEDIENCE}
- {name: two, character: child, at: [0.5, 0]}
"""


@dataclass
class Course:
    """What became of a struck person.

    Attributes:
        least: x where it was farthest back [m].
        last: x at the end [m].
        shields: whether a hand came up.
        arrivals: number of orders done.
    """

    least: float
    last: float
    shields: bool
    arrivals: int


def struck(obedience: float, pain: float, order: str, seconds: float = 4.0) -> Course:
    """Return what becomes of a person under an order that is struck from ahead."""
    script = f"script:\n- {{at: 0, who: one, do: {order}}}"
    made = simulation(CAST.replace("OBEDIENCE", str(obedience)), seconds, script)
    characters = troupe(made)
    course = Course(0.0, 0.0, False, 0)
    while not made.finished:
        made.step()
        if made.step_number == 20:
            owner = characters.arrays.owners[0]
            owner.pain += pain
            link = characters.arrays.links[int(owner.links[0])]
            link.energy, link.touched_owner = pain * owner.pain_threshold, 1
            characters.pains.update()
        person = characters.persons[0]
        course.least = min(course.least, float(person.at[0]))
        course.shields |= bool((person.arm_mode == PLACED).any())
        course.arrivals += len(characters.facts().arrived)
    course.last = float(characters.persons[0].at[0])
    return course


@pytest.mark.parametrize(
    ("obedience", "pain", "steps_back", "flinches"),
    [
        (0.0, 0.5, True, True),
        (0.5, 4.0, True, True),
        (0.5, 2.0, False, True),
        (0.5, 1.0, False, False),
        (1.0, 30.0, False, False),
    ],
)
def test_pain_beyond_what_an_obedient_person_bears_makes_it_step_back(
    obedience: float, pain: float, steps_back: bool, flinches: bool
) -> None:
    course = struck(obedience, pain, "stand", 1.5)
    assert (course.least < -0.25) == steps_back
    assert course.shields == flinches


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_who_steps_back_aside_turns_to_its_way(side: float) -> None:
    way = side * np.radians(110.0)
    for heading in (-1.0, 0.0, 1.0):
        assert abs(withdrawal_facing(heading, 0.0, way) - way) < np.radians(60.0)
    # Straight back either shoulder serves: the nearer one.
    assert withdrawal_facing(0.2 * side, 0.0, np.pi) * side > 0.0


def test_an_order_goes_on_after_a_withdrawal() -> None:
    course = struck(0.2, 3.0, "{go_to: [-0.4, 1.2]}", 6.0)
    assert course.least < -0.5
    assert course.last == pytest.approx(-0.4, abs=0.1)
    assert course.arrivals == 1


def test_a_limp_person_obeys_nothing() -> None:
    member = "{name: a, character: adult, limp: true, obedience: 0}"
    with pytest.raises(SceneError, match="does not act; remove this"):
        read_scene(f"pronk: 1\ncast:\n- {member}")
