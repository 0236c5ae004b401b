"""Jump parameters: the formula, and errors whose suggested values work."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.locomotion.pronking.jump_parameters import (
    FORMULA,
    Jump,
    jump_heights,
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
    pronk: {config}
"""

ADVICE = re.compile(r"\b(distance|height|speed): ([0-9.e+-]+)")


def build_hoppers(figure: str, config: str) -> HopperTroupe:
    """Return the troupe of a scene with one hopper."""
    (troupe,) = Simulation(read_scene(SCENE.format(figure=figure, config=config))).troupes
    assert isinstance(troupe, HopperTroupe)
    return troupe


def refusal(figure: str, config: str) -> SceneError:
    """Return the error of a `pronk` block."""
    with pytest.raises(SceneError) as caught:
        build_hoppers(figure, config)
    return caught.value


def random_values(number: int) -> dict[str, float]:
    """Return two or three random values of a jump."""
    rng = np.random.default_rng([number, 7])
    config = {
        "distance": 0.0 if rng.random() < 0.1 else float(np.exp(rng.uniform(-4.0, 4.0))),
        "height": float(np.exp(rng.uniform(-4.0, 3.0))),
        "speed": float(np.exp(rng.uniform(-2.0, 3.0))),
    }
    if rng.random() < 0.5:
        del config[str(rng.choice(["distance", "height"]))]
    return config


def error_message(config: dict[str, float]) -> str:
    """Return the error message of a `pronk` block; empty if it is valid."""
    try:
        resolve_jump("cast[0].pronk", Pronk(**config), 1.0)
    except SceneError as error:
        (problem,) = error.problems
        assert problem.path == "cast[0].pronk.speed"
        return problem.message
    return ""


def test_jump_agrees_with_the_flight_of_a_mass():
    jump = Jump(1.6, 0.8)
    assert jump.speed**2 == pytest.approx(GRAVITY * 1.6**2 / (8 * 0.8) + 2 * GRAVITY * 0.8)
    time = 2 * jump.up / GRAVITY
    assert jump.forward * time == pytest.approx(1.6)
    assert jump.up**2 / (2 * GRAVITY) == pytest.approx(0.8)


@pytest.mark.parametrize(("distance", "speed"), [(1.0, 3.2), (1.6, 4.4), (0.3, 7.0)])
def test_both_heights_of_a_distance_and_speed(distance, speed):
    for height in jump_heights(distance, speed):
        assert Jump(distance, height).speed == pytest.approx(speed, rel=1e-12)


def test_consistent_values_are_accepted():
    jump = Jump(1.6, 0.8)
    config = Pronk(distance=1.6, height=0.8, speed=jump.speed)
    assert resolve_jump("", config, 1.0) == jump


@pytest.mark.parametrize(
    ("config", "remedies"),
    [
        (
            Pronk(distance=1.6, height=0.8, speed=6.0),
            ("speed: 4.429", "distance: 3.639", "height: 1.743"),
        ),
        (Pronk(distance=4.0, speed=3.0), ("speed: 6.265", "distance: 0.9174")),
        (Pronk(height=2.0, speed=3.0), ("speed: 6.265", "height: 0.4587")),
    ],
)
def test_error_has_the_formula_and_suggested_values(config, remedies):
    with pytest.raises(SceneError) as caught:
        resolve_jump("cast[0].pronk", config, 1.0)
    message = caught.value.problems[0].message
    assert "speed² = g distance² / (8 height) + 2 g height" in message
    for remedy in remedies:
        assert remedy in message


def test_suggested_values_work() -> None:
    refusal = 0
    for number in range(400):
        config = random_values(number)
        message = error_message(config)
        if not message:
            continue
        refusal += 1
        assert FORMULA in message
        advice = ADVICE.findall(message.split("take ")[1])
        assert advice
        for key, value in advice:
            assert error_message({**config, key: float(value)}) == "", (config, key, value)
        spare = re.search("leave out ([a-z ]+), or", message)
        for key in spare[1].split(" or ") if spare else ():
            assert error_message({k: v for k, v in config.items() if k != key}) == "", (config, key)
    assert refusal > 200


def test_suggested_values_are_the_nearest() -> None:
    # Suggested values fulfil the formula.
    for number in range(200):
        config = random_values(number)
        message = error_message(config)
        if len(config) == 3 and message:
            for key, value in ADVICE.findall(message.split("take ")[1]):
                right = {**config, key: float(value)}
                jump = Jump(right["distance"], right["height"])
                assert jump.speed == pytest.approx(right["speed"], rel=1e-4)
        elif message:
            for key, value in ADVICE.findall(message.split("take ")[1]):
                # Slightly nearer to the requested value the formula is violated.
                beyond = float(value) + 2e-3 * (config[key] - float(value))
                assert error_message({**config, key: beyond}) or beyond == pytest.approx(
                    float(value), rel=2e-3
                )


@pytest.mark.nightly
@pytest.mark.parametrize("figure", ["kangaroo", "hopper", "beetle", "tripod"])
@pytest.mark.parametrize("crouch", [0.01, 5.0])
def test_suggested_crouch_works(figure: str, crouch: float) -> None:
    (problem,) = refusal(figure, f"{{crouch: {crouch}}}").problems
    assert (problem.path, problem.line) == ("cast[0].pronk.crouch", 6)
    nearest, low, high = re.search(
        r"take ([0-9.]+), or another one from ([0-9.]+) to ([0-9.]+)", problem.message
    ).groups()
    assert nearest == (low if crouch < 1.0 else high)
    for value in (low, high):
        (hopper,) = build_hoppers(figure, f"{{crouch: {value}}}").hoppers
        assert hopper.crouch_height == float(value)
    stands = hopper.standing_height
    assert stands * (1.0 - 2e-3) < float(high) < stands
    assert hopper.lowest_height <= float(low) < hopper.lowest_height * (1.0 + 1e-3)


@pytest.mark.sample(2)
@pytest.mark.parametrize("figure", ["kangaroo", "hopper", "tripod", "centipede"])
def test_suggested_leg_force_works(figure: str) -> None:
    (problem,) = refusal(figure, "{max_force: 0.01}").problems
    assert (problem.path, problem.line) == ("cast[0].pronk.max_force", 6)
    force = re.search(r"take ([0-9.]+) or more", problem.message)[1]
    (hopper,) = build_hoppers(figure, f"{{max_force: {force}}}").hoppers
    assert 1.0 < hopper.max_leg_force * len(hopper.hips) / hopper.weight < 1.002
    refusal(figure, f"{{max_force: {0.999 * float(force):.6g}}}")


@pytest.mark.parametrize("key", ["distance: 2", "speed: 3", "jumps: 2", "turn_deg: 5"])
def test_land_at_excludes_distance_keys(key: str) -> None:
    config = f"{{land_at: [[1, 0]], {key}}}"
    (problem,) = refusal("kangaroo", config).problems
    assert problem.path == f"cast[0].pronk.{key.split(':')[0]}"
    column = SCENE.format(figure="kangaroo", config=config).splitlines()[5].index(key) + 1
    assert (problem.line, problem.column) == (6, column)
    assert "conflicts with land_at; remove one" in problem.message


def test_all_errors_are_reported_at_once() -> None:
    scene = read_scene(
        "pronk: 1\nduration: 1\ncast:\n"
        "- {figure: kangaroo, pronk: {crouch: 9}}\n"
        "- {figure: hopper, pronk: {distance: 9, speed: 1}}\n"
    )
    with pytest.raises(SceneError) as caught:
        Simulation(scene)
    assert [problem.line for problem in caught.value.problems] == [4, 5]


def test_documented_jump_is_simulated() -> None:
    config: dict[str, Any] = {"distance": 1.6, "height": 0.8, "crouch": 0.6, "max_force": 6}
    text = ", ".join(f"{key}: {value}" for key, value in config.items())
    (hopper,) = build_hoppers("kangaroo", f"{{{text}}}").hoppers
    assert hopper.lowest_height < hopper.crouch_height == 0.6 < hopper.standing_height
    assert hopper.max_leg_force == pytest.approx(6.0 * hopper.weight)
    assert hopper.jump == Jump(1.6, 0.8)
