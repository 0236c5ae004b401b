"""Tests of people who walk together, queue, and make gestures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.person_record import PERSON, PLACED
from pipeline.simulation.characters.walking_group import _place, walks_with
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array
from pipeline.spec import read_scene
from pipeline.spec.behaviour import TAKE_NAMES
from tests.simulation.characters.mind_scenes import channel
from tests.simulation.characters.scripted_people import Play, play_scene, run_scene, troupe_of

GROUP = """
  - {name: anna, character: adult, at: [-10, 0], companions: [ben, kid]}
  - {name: ben, character: adult, at: [-10.1, 0.8]}
  - {name: kid, character: child, at: [-10, -0.8]}
"""
MEMBERS = ("anna", "ben", "kid")


def places(play: Play) -> Array:
    """Return (K, 3, 2) where the members of the group are on the ground [m]."""
    return np.stack([play.joint(name, "pelvis")[:, [0, 2]] for name in MEMBERS], axis=1)


def spread(at: Array) -> Array:
    """Return (K,) the greatest distance of a member from the middle [m]."""
    result: Array = np.linalg.norm(at - at.mean(axis=1, keepdims=True), axis=-1).max(axis=1)
    return result


def test_companions_come_along_side_by_side() -> None:
    play = play_scene(
        f"duration: 2.5\nterrain: {{kind: flat, size: [40, 40]}}\ncast:{GROUP}"
        "script:\n  - {at: 0, who: anna, do: {go_to: [10, 0]}}\n"
    )
    at = places(play)
    assert (at[-1, :, 0] - at[0, :, 0]).min() > 1.2
    assert np.ptp(at[-1, :, 0]) < 0.15
    assert 1.2 < np.ptp(at[-1, :, 1]) < 1.8
    assert play.records["comes_along"][-1].tolist() == [False, True, True]


def test_who_is_ahead_waits_for_who_falls_behind() -> None:
    cast = GROUP.replace("at: [-10, -0.8]", "at: [-13.5, -0.8]")
    play = play_scene(
        f"duration: 2.5\nterrain: {{kind: flat, size: [40, 40]}}\ncast:{cast}"
        "script:\n  - {at: 0, who: anna, do: {go_to: [10, 0]}}\n"
    )
    at = places(play)[:, :, 0]
    assert at[-1, 0] - at[0, 0] < 0.5
    assert at[-1, 2] - at[0, 2] > 1.2
    assert play.records["group_wait"][-1][0] > 0.0


@pytest.mark.parametrize(
    ("room", "vee", "ahead", "across"),
    [(1.0, 0.0, 0.0, 0.77), (0.0, 0.0, -1.29, 0.0), (1.0, 1.0, 0.13, 0.62)],
    ids=["side by side", "single file", "a V in a crowd"],
)
def test_the_row_fits_the_room(room: float, vee: float, ahead: float, across: float) -> None:
    persons = zero_records(1, PERSON)
    persons["group_size"], persons["group_rank"], persons["group_file"] = 3, 2, 2
    persons["group_room"], persons["group_vee"] = room, vee
    plain: Any = _place
    assert plain.py_func(persons[0], 1.72) == pytest.approx((ahead, across), abs=0.01)


def test_those_of_another_group_are_no_company() -> None:
    persons = zero_records(2, PERSON)
    persons["group"], persons["group_size"] = [0, 1], 2
    plain: Any = walks_with
    assert not plain.py_func(persons[0], persons[1])
    persons["group"] = 0
    assert plain.py_func(persons[0], persons[1])


def crowd(seed: int) -> str:
    """Return a scene in which a group walks 20 m through 16 people who come towards it."""
    rng = np.random.default_rng(seed)
    cast, script = [GROUP], ["  - {at: 0, who: anna, do: {go_to: [10, 0]}}"]
    for k in range(16):
        x, z = rng.uniform(-4, 12), -5 + 10 * (k + 0.5) / 16 + rng.uniform(-0.3, 0.3)
        cast.append(
            f"  - {{name: p{k}, character: adult, at: [{x:.2f}, {z:.2f}], heading_deg: 180}}\n"
        )
        script.append(f"  - {{at: 0, who: p{k}, do: {{go_to: [{x - 22:.2f}, {z:.2f}]}}}}")
    head = "duration: 23\nterrain: {kind: flat, size: [80, 80]}\n"
    return f"{head}cast:{''.join(cast)}script:\n" + "\n".join(script)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_crowd_passes_around_a_group(seed: int) -> None:
    pains = list[str]()

    def watch(troupe: Characters, step: int) -> None:
        pains.extend(signal.who for signal in troupe.facts().signals if signal.kind == "pain")

    play = play_scene(crowd(seed), watch)
    at = places(play)
    assert not pains
    # Without companions they are up to 2.1 to 2.8 m from their middle.
    assert spread(at).max() < 1.1
    assert at[-1, :, 0].min() > 8.5
    others = [name for name in play.firsts if name not in MEMBERS]
    for name in others:
        own = play.joint(name, "pelvis")[:, [0, 2]]
        for a, b in ((0, 1), (0, 2)):
            assert not _passes_between(own, at[:, a], at[:, b]), name


def _passes_between(own: Array, one: Array, other: Array) -> bool:
    """Tell whether a path (K, 2) crosses the line between two others."""
    along, offset = other - one, own - one
    side = along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
    share = (offset * along).sum(axis=1) / (along * along).sum(axis=1)
    return bool(((side[1:] * side[:-1] < 0.0) & (share[1:] > 0.0) & (share[1:] < 1.0)).any())


@pytest.mark.nightly
def test_a_group_passes_a_gate_one_after_the_other() -> None:
    cast = GROUP.replace("-10", "-4")
    for k, z in enumerate((2.7, -2.7)):
        cast += f"  - {{name: w{k}, prop: {{shape: box, size: [0.3, 2, 4]}}, at: [0, 0, {z}]}}\n"
    play = play_scene(
        f"duration: 10\ncast:{cast}script:\n  - {{at: 0, who: anna, do: {{go_to: [4, 0]}}}}\n"
    )
    at = places(play)
    assert at[-1, :, 0].min() > 2.5
    passed = [int(np.argmax(at[:, k, 0] > 0.0)) for k in range(3)]
    assert min(passed) > 0
    assert np.ptp(passed) > 48
    assert spread(at).max() < 1.5


COUNTER = """
  - {name: counter, prop: {shape: box, size: [0.8, 1.0, 2.4]}, at: [-3, 0]}
  - {name: ann, character: adult, at: [-1.6, 0], heading_deg: 180}
  - {name: bob, character: adult, at: [-0.5, 0.7], heading_deg: 180}
"""
TURNS = """
  - {at: 0, who: ann, do: {queue: counter, lasts: 0.4}}
  - {at: 0, who: bob, do: {queue: counter, lasts: 0.4}}
"""


def test_people_queue_and_are_served_in_turn() -> None:
    scene = f"pronk: 1\nduration: 6\ncast:{COUNTER}script:{TURNS}"
    simulation = Simulation(read_scene(scene))
    troupe = troupe_of(simulation)
    served, lines = list[str](), list[list[str]]()
    while not simulation.finished and len(served) < 2:
        simulation.step()
        served += [s.who for s in troupe.facts().signals if s.kind == "served"]
        queue = troupe.dispatcher.view.queues.lines.get("counter")
        if queue is not None and queue.persons not in lines:
            lines.append(list(queue.persons))
        assert not [s for s in troupe.facts().signals if s.kind == "pain"]
    assert served == ["ann", "bob"]
    assert ["ann", "bob"] in lines
    assert lines[-1] == []
    at = troupe.persons["at"]
    assert np.hypot(*(at[0] - at[1])) > 0.5


ONE = "  - {name: ann, character: adult, at: [0, 0]}\n  - {name: ball, character: ball, at: [3, 1]}"


@pytest.mark.parametrize("kind", ["greet", "point", "refuse"])
def test_a_gesture_takes_a_hand_while_one_walks_on(kind: str) -> None:
    script = (
        "  - {at: 0, who: ann, do: {go_to: [6, 0]}}\n"
        f"  - {{at: 0.2, who: ann, do: {{{kind}: ball}}}}\n"
    )
    play = play_scene(f"duration: 3.2\ncast:\n{ONE}\nscript:\n{script}")
    modes = play.records["arm_mode"][:, 0]
    assert (modes == PLACED).any(axis=1).sum() > 96
    rise = play.joint("ann", "hand_r")[:, 1] - play.joint("ann", "shoulder_r")[:, 1]
    assert rise.max() > {"greet": 0.1, "point": -0.35, "refuse": -0.15}[kind]
    # The arm hangs again, and the walk has gone on.
    assert (modes[-1] == 0).all()
    assert rise[-1] < -0.4
    assert play.joint("ann", "pelvis")[-1, 0] > 2.0


def test_people_point_at_places() -> None:
    play = play_scene(
        "duration: 2\nterrain: flat\ncast:\n  - {name: ann, character: adult, at: [0, 0]}\n"
        "script:\n  - {at: 0.2, who: ann, do: {point: [1.5, 1.6, 0.4]}}\n"
    )
    sides = [(play.joint("ann", f"shoulder_{s}"), play.joint("ann", f"hand_{s}")) for s in "lr"]
    cosines = []
    for shoulder, hand in sides:
        way, to = hand - shoulder, np.array([1.5, 1.6, 0.4]) - shoulder
        long = np.linalg.norm(way, axis=-1) * np.linalg.norm(to, axis=-1)
        cosines.append((way * to).sum(axis=-1) / long)
    assert np.max(cosines) > 0.97


def test_a_hand_is_laid_on_the_shoulder_of_who_is_comforted() -> None:
    cast = ONE + "\n  - {name: kid, character: child, at: [0.75, 0], heading_deg: 180}"
    script = "  - {at: 0, who: ann, do: {soothe: kid}}\n"
    play = play_scene(f"duration: 4\ncast:\n{cast}\nscript:\n{script}")
    shoulders = np.stack([play.joint("kid", f"shoulder_{side}") for side in "lr"])
    near = np.linalg.norm(shoulders - play.joint("ann", "hand_r"), axis=-1).min()
    assert near < 0.16
    assert play.when("ann")
    assert (play.records["arm_mode"][-1] == 0).all()
    assert not [one for one in play.contacts if one.energy > 5.0 and one.kind == "hit"]


FRIENDS = """
  - {name: anna, character: child, at: [-4, 0], traits: {}, behaviours: [{approach: ben}]}
  - {name: ben, character: child, at: [0.5, 0.5], heading_deg: 180, traits: {}}
"""


def test_friends_who_meet_greet_each_other_once() -> None:
    story = "\n  relations: [{friend: ben, of: anna}]"
    take = run_scene(FRIENDS, 3, story=story).take()
    greeting = TAKE_NAMES.index("greet")
    for name in ("anna", "ben"):
        doing = channel(take, f"{name}.behaviour") == greeting
        assert np.count_nonzero(np.diff(doing.astype(int)) == 1) == 1
    alone = run_scene(FRIENDS, 3).take()
    assert greeting not in channel(alone, "anna.behaviour")


def test_the_order_of_the_cast_has_no_effect_on_company() -> None:
    lines = [line for line in (GROUP + COUNTER).split("\n") if line]
    script = f"script:{TURNS}  - {{at: 0, who: anna, do: {{go_to: [-7, 0]}}}}\n"
    head = "pronk: 1\nduration: 0.8\nterrain: {kind: flat, size: [40, 40]}\ncast:\n"
    found = []
    for order in (lines, lines[::-1]):
        take = simulate(read_scene(head + "\n".join(order) + "\n" + script))
        nodes = {(n.performer, n.name): k for k, n in enumerate(take.nodes)}
        found.append({key: take.positions[:, k].tobytes() for key, k in nodes.items()})
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("companions: [bem]", "nobody in the cast is called 'bem', did you mean 'ben'?"),
        ("companions: [ann]", "'ann' is no companion of itself; name another"),
        ("companions: [ball]", "'ball' is a ball; name a child or an adult"),
    ],
)
def test_wrong_companions_are_refused(line: str, message: str) -> None:
    scene = (
        "pronk: 1\nframes: 1\ncast:\n"
        f"  - {{name: ann, character: adult, {line}}}\n"
        "  - {name: ben, character: adult, at: [1, 0]}\n"
        "  - {name: ball, character: ball, at: [3, 0]}\n"
    )
    with pytest.raises(SceneError, match=r"(?s)scene:4:") as error:
        read_scene(scene)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("{at: 0, who: ann, do: {queue: countr}}", "did you mean 'counter'?"),
        ("{at: 0, who: ann, do: {queue: counter, last: 2}}", "did you mean 'lasts'?"),
        ("{at: 0, who: ann, do: {gret: bob}}", "did you mean 'greet'?"),
        ("{when: {served: bab}, who: ann, do: sit}", "did you mean 'bob'?"),
        ("{when: {served: counter}, who: ann, do: sit}", "'counter' is a prop"),
        ("{at: 0, who: ann, do: {soothe: counter}}", "'counter' is a prop; name a child"),
    ],
)
def test_wrong_queues_and_gestures_are_refused(script: str, message: str) -> None:
    scene = f"pronk: 1\nframes: 1\ncast:{COUNTER}script:\n  - {script}\n"
    with pytest.raises(SceneError, match=r"scene:8:") as error:
        read_scene(scene)
    assert message in str(error.value)
