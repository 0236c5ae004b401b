"""Words of jumps that contradict one another: each message names values, and those work."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.pronking.jump_parameters import (
    FORMULA,
    Jump,
    resolve_jump,
)
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene
from pipeline.spec.creature import Pronk

SCENE = """\
pronk: 1
duration: 1
cast:
  - name: one
    figure: {figure}
    pronk: {words}
"""

ADVICE = re.compile(r"\b(distance|height|speed): ([0-9.e+-]+)")


def begun(figure: str, words: str) -> HopperTroupe:
    """Return the creatures of a scene of one that hops as it is told."""
    (troupe,) = Simulation(read_scene(SCENE.format(figure=figure, words=words))).troupes
    assert isinstance(troupe, HopperTroupe)
    return troupe


def refusal(figure: str, words: str) -> SceneError:
    """Return the error that words get."""
    with pytest.raises(SceneError) as caught:
        begun(figure, words)
    return caught.value


def drawn(number: int) -> dict[str, float]:
    """Return two or three words of a jump that nobody reckoned."""
    chance = np.random.default_rng([number, 7])
    words = {
        "distance": 0.0 if chance.random() < 0.1 else float(np.exp(chance.uniform(-4.0, 4.0))),
        "height": float(np.exp(chance.uniform(-4.0, 3.0))),
        "speed": float(np.exp(chance.uniform(-2.0, 3.0))),
    }
    if chance.random() < 0.5:
        del words[str(chance.choice(["distance", "height"]))]
    return words


def told(words: dict[str, float]) -> str:
    """Return what is wrong with them, nothing if they are taken."""
    try:
        resolve_jump("cast[0].pronk", Pronk(**words), 1.0)
    except SceneError as error:
        (problem,) = error.problems
        assert problem.path == "cast[0].pronk.speed"
        return problem.message
    return ""


def test_whatever_is_contradictory_gets_the_formula_and_values_that_work() -> None:
    refused = 0
    for number in range(400):
        words = drawn(number)
        message = told(words)
        if not message:
            continue
        refused += 1
        assert FORMULA in message
        advice = ADVICE.findall(message.split("take ")[1])
        assert advice
        for word, value in advice:
            assert told({**words, word: float(value)}) == "", (words, word, value)
        spare = re.search("leave out ([a-z ]+), or", message)
        for word in spare[1].split(" or ") if spare else ():
            assert told({k: v for k, v in words.items() if k != word}) == "", (words, word)
    assert refused > 200


def test_values_that_are_named_are_the_nearest_ones() -> None:
    # Each other speed, distance or height is off the formula: those named are on it.
    for number in range(200):
        words = drawn(number)
        message = told(words)
        if len(words) == 3 and message:
            for word, value in ADVICE.findall(message.split("take ")[1]):
                right = {**words, word: float(value)}
                jump = Jump(right["distance"], right["height"])
                assert jump.speed == pytest.approx(right["speed"], rel=1e-4)
        elif message:
            for word, value in ADVICE.findall(message.split("take ")[1]):
                # A little beyond, on the side of what was asked for, nothing works.
                beyond = float(value) + 2e-3 * (words[word] - float(value))
                assert told({**words, word: beyond}) or beyond == pytest.approx(
                    float(value), rel=2e-3
                )


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["kangaroo", "hopper", "beetle", "tripod"])
@pytest.mark.parametrize("crouch", [0.01, 5.0])
def test_a_crouch_that_is_refused_gets_one_that_works(figure: str, crouch: float) -> None:
    (problem,) = refusal(figure, f"{{crouch: {crouch}}}").problems
    assert (problem.path, problem.line) == ("cast[0].pronk.crouch", 6)
    nearest, low, high = re.search(
        r"take ([0-9.]+), or another one from ([0-9.]+) to ([0-9.]+)", problem.message
    ).groups()
    assert nearest == (low if crouch < 1.0 else high)
    for value in (low, high):
        (of,) = begun(figure, f"{{crouch: {value}}}").hoppers
        assert of.crouch_height == float(value)
    stands = of.standing_height
    assert stands * (1.0 - 2e-3) < float(high) < stands
    assert of.lowest_height <= float(low) < of.lowest_height * (1.0 + 1e-3)


@pytest.mark.parametrize("figure", ["kangaroo", "hopper", "tripod", "centipede"])
def test_legs_that_are_too_weak_get_a_force_that_works(figure: str) -> None:
    (problem,) = refusal(figure, "{max_force: 0.01}").problems
    assert (problem.path, problem.line) == ("cast[0].pronk.max_force", 6)
    force = re.search(r"take ([0-9.]+) or more", problem.message)[1]
    (of,) = begun(figure, f"{{max_force: {force}}}").hoppers
    assert 1.0 < of.max_leg_force * len(of.hips) / of.weight < 1.002
    refusal(figure, f"{{max_force: {0.999 * float(force):.6g}}}")


@pytest.mark.parametrize("word", ["distance: 2", "speed: 3", "jumps: 2", "turn_deg: 5"])
def test_who_is_told_where_to_land_is_not_told_how_far(word: str) -> None:
    words = f"{{land_at: [[1, 0]], {word}}}"
    (problem,) = refusal("kangaroo", words).problems
    assert problem.path == f"cast[0].pronk.{word.split(':')[0]}"
    column = SCENE.format(figure="kangaroo", words=words).splitlines()[5].index(word) + 1
    assert (problem.line, problem.column) == (6, column)
    assert "take one of the two away" in problem.message


def test_all_who_are_wrong_are_told_at_once() -> None:
    scene = read_scene(
        "pronk: 1\nduration: 1\ncast:\n"
        "- {figure: kangaroo, pronk: {crouch: 9}}\n"
        "- {figure: hopper, pronk: {distance: 9, speed: 1}}\n"
    )
    with pytest.raises(SceneError) as caught:
        Simulation(scene)
    assert [problem.line for problem in caught.value.problems] == [4, 5]


def test_the_jump_that_the_manual_explains_works() -> None:
    words: dict[str, Any] = {"distance": 1.6, "height": 0.8, "crouch": 0.56, "max_force": 6}
    text = ", ".join(f"{word}: {value}" for word, value in words.items())
    (of,) = begun("kangaroo", f"{{{text}}}").hoppers
    assert of.lowest_height < of.crouch_height == 0.56 < of.standing_height
    assert of.max_leg_force == pytest.approx(6.0 * of.weight)
    assert of.jump == Jump(1.6, 0.8)
