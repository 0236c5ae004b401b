"""Laws of animals: gaits, strides and duty factors by size and speed, and what is refused."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.locomotion.gaits import scaling_laws
from pipeline.simulation.locomotion.gaits.pace import Pace, is_same_pace
from pipeline.simulation.locomotion.gaits.scaling_laws import Build
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.spec.walk import Walk
from tests.simulation.conftest import scene_of, walk_through

HORSE, PERSON = Build("quadruped", 1.3, 500.0), Build("biped", 0.9, 75.0)
MOUSE, ROACH = Build("quadruped", 0.03, 0.025), Build("sprawler", 0.02, 0.00083)
FIGURES = ("horse", "person", "beetle", "spider")
SPEEDS = np.geomspace(0.05, 20.0, 60)


def pace_of(figure: str, walk: str, scale: float = 1.0) -> Pace:
    member = f"{{figure: {figure}, scale: {scale}, walk: {walk}}}"
    troupe = Simulation(scene_of(member, duration=0.1)).troupes[0]
    assert isinstance(troupe, WalkerTroupe)
    return troupe.herd.paces[0]


@pytest.mark.nightly
def test_speed_and_gait_that_are_automatic_are_left_out() -> None:
    assert Walk.model_validate({"speed": "auto", "gait": "auto"}) == Walk()
    given, free = pace_of("horse", "{speed: auto, gait: trot}"), pace_of("horse", "{gait: trot}")
    assert is_same_pace(given, free)


@pytest.mark.parametrize("build", [HORSE, PERSON, MOUSE, ROACH])
@pytest.mark.parametrize("style", ["walking", "running"])
def test_strides_and_cadence_grow_and_stances_shrink_with_speed(
    build: Build, style: scaling_laws.Style
) -> None:
    strides = np.array([scaling_laws.stride_at(build, v, style) for v in SPEEDS])
    duties = np.array([scaling_laws.duty_at(build, v, style) for v in SPEEDS])
    assert (np.diff(strides) > 0.0).all()
    assert (np.diff(SPEEDS / strides) > 0.0).all()
    assert (np.diff(duties) <= 0.0).all()


def test_animals_of_equal_froude_number_move_alike() -> None:
    large = Build("quadruped", 2.6, 1500.0)
    stride = scaling_laws.stride_at(HORSE, 3.0, "running")
    faster = 3.0 * 2.0**0.5
    assert scaling_laws.stride_at(large, faster, "running") == pytest.approx(2.0 * stride)
    assert scaling_laws.gait_at(large, 4, faster) == scaling_laws.gait_at(HORSE, 4, 3.0)


def test_gaits_change_at_their_speeds_and_not_back_at_once() -> None:
    names = [scaling_laws.gait_at(HORSE, 4, v) for v in (1.5, 3.5, 6.5, 12.0)]
    assert names == ["walk", "trot", "canter", "transverse gallop"]
    change = HORSE.speed_at(scaling_laws.WALK_TO_TROT)
    for factor, walks, trots in (
        (0.8, "walk", "walk"),
        (1.0, "walk", "trot"),
        (1.2, "trot", "trot"),
    ):
        assert scaling_laws.gait_at(HORSE, 4, factor * change, "walk") == walks
        assert scaling_laws.gait_at(HORSE, 4, factor * change, "trot") == trots
    assert scaling_laws.gait_at(Build("quadruped", 1.9, 3500.0), 4, 6.0) == "amble"


def test_lighter_animals_move_their_legs_more_often() -> None:
    heavy = Build("quadruped", 1.3, 2000.0)
    most = scaling_laws.greatest_frequency
    assert most(heavy) < most(HORSE) < most(MOUSE)


@pytest.mark.nightly
def test_a_gallop_without_a_speed_is_a_gallop() -> None:
    pace = pace_of("horse", "{gait: rotary gallop}")
    assert 6.0 < pace.speed < 11.0
    assert pace.flight is not None


@pytest.mark.sample(2)
@pytest.mark.parametrize("figure", FIGURES)
def test_the_greatest_speed_that_a_refusal_advises_works(figure: str) -> None:
    with pytest.raises(SceneError, match="more than the legs can do") as refused:
        pace_of(figure, "{speed: 500}")
    (speed,) = re.findall(r"take speed: ([0-9.]+)", str(refused.value))
    pace = pace_of(figure, f"{{speed: {speed}}}")
    assert pace.speed == pytest.approx(float(speed))
    assert pace.stride <= pace.longest
    with pytest.raises(SceneError):
        pace_of(figure, f"{{speed: {1.02 * float(speed)}}}")


def test_a_cadence_beyond_muscles_is_refused_with_one_that_works() -> None:
    with pytest.raises(SceneError, match="times a second") as refused:
        pace_of("horse", "{cycle: 0.1, speed: 1}")
    (cycle,) = re.findall(r"cycle: ([0-9.]+)", str(refused.value).split("take ")[1].split("\n")[0])
    assert pace_of("horse", f"{{cycle: {cycle}, speed: 1}}").cycle == float(cycle)


@pytest.mark.nightly
def test_a_small_figure_takes_shorter_and_quicker_strides() -> None:
    large, small = pace_of("horse", "{}"), pace_of("horse", "{}", 0.5)
    assert small.stride < 0.7 * large.stride
    assert small.cycle < 0.9 * large.cycle
    assert small.speed == pytest.approx(large.speed * 0.5**0.5, rel=0.01)


def test_gait_and_stance_follow_ordered_speeds() -> None:
    more = "script: [{at: 0.5, who: it, do: {speed: 6.5}}]\n"
    member = "{name: it, figure: horse, at: [-12, 0], walk: {}}"
    walk = walk_through(scene_of(member, duration=4, more=more))
    paces = walk.walkers.progress.paces
    assert [change.after.gait_name for change in paces.changes[0]] == ["trot", "canter"]
    last = paces.last(0)
    assert last.speed == pytest.approx(6.5)
    assert last.gait.duty.max() < 0.35
    # Long strides never come with long stances.
    for change in paces.changes[0]:
        phases = np.linspace(change.gaits.start, change.gaits.end, 30)
        swings = np.array([change.gaits._swing(np.full(4, phase)) for phase in phases])
        stance = (1.0 - swings).max(axis=1) * paces.number("stride", 0, phases)
        ends = [pace.gait.duty.max() * pace.stride for pace in (change.before, change.after)]
        assert stance.max() <= max(ends) * (1.0 + 1e-9)
    down = walk.standing[1:] & walk.standing[:-1]
    assert np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)[down].max() < 1e-4


@pytest.mark.parametrize(
    ("walk", "advice"),
    [
        ("{cycle: 0.01}", "leave out `cycle`"),
        ("{stride: 9, cycle: 0.02}", "leave out `cycle` and `stride`"),
    ],
)
def test_keys_that_no_value_of_another_mends_are_left_out(walk: str, advice: str) -> None:
    with pytest.raises(SceneError, match=re.escape(advice)):
        pace_of("horse", walk)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(8))
def test_every_advice_works_when_tried(seed: int) -> None:
    rng = np.random.default_rng(seed)
    figures = ("horse", "antelope", "camel", "person", "ostrich", *FIGURES[2:], "centipede")
    for _ in range(12):
        figure, scale = rng.choice(figures), float(rng.choice([0.1, 0.5, 1.0, 2.0]))
        v, cycle = (float(f"{x:.3g}") for x in np.exp(rng.uniform(-2.0, [4.0, 1.0])))
        walk = rng.choice([f"speed: {v}", f"speed: {v}, cycle: {cycle}", f"stride: {v}"])
        keys = dict(part.split(": ") for part in str(walk).split(", "))
        try:
            pace_of(str(figure), f"{{{walk}}}", scale)
        except SceneError as error:
            message = str(error).split("\n")[0]
            if "leave out " in message:
                left_out = set(re.findall(r"`(\w+)`", message.split("leave out ")[1]))
                left = ", ".join(f"{key}: {keys[key]}" for key in keys.keys() - left_out)
                assert pace_of(str(figure), f"{{{left}}}", scale).speed > 0.0
                continue
            advice = message.split("take ")[1]
            for choice in re.split(r", | or ", advice):
                changes = dict(part.split(": ") for part in choice.split(" with ") if ": " in part)
                tried = ", ".join(f"{key}: {value}" for key, value in (keys | changes).items())
                if changes:
                    assert pace_of(str(figure), f"{{{tried}}}", scale).speed > 0.0
