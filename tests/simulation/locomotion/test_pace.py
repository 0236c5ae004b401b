"""Changes of gait and mood while walking: no slip, no jump of a joint, orders carried out."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation.locomotion.gaits.gait_transition import PaceTransition
from pipeline.simulation.locomotion.gaits.pace import Pace
from pipeline.simulation.locomotion.gaits.pace_schedule import PaceSchedule
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.spec.mood import MOODS
from tests.simulation.conftest import Walk, scene_of, walk_through

ROW = 1 / 96
MILLIMETRE = 1e-3

LONG = "{kind: flat, size: [80, 30]}"
"""Terrain that no creature leaves: a horse canters 28 m."""


def walk_with_script(figure: str, walk: str, *script: str, duration: float = 6) -> Walk:
    """Return the walk of one creature with a script."""
    orders = ", ".join(f"{{at: {2 + 2 * i}, who: it, do: {do}}}" for i, do in enumerate(script))
    more = f"script: [{orders}]\n" if script else ""
    member = f"{{name: it, figure: {figure}, at: [-12, 0], walk: {walk}}}"
    return walk_through(scene_of(member, terrain=LONG, duration=duration, more=more))


def speed(walk: Walk, time: float) -> float:
    """Return the mean speed of the body over a cycle from `time` on [m/s]."""
    first, cycle = round(time / ROW), float(walk.walkers.progress.cycle[0])
    rows = round(cycle / ROW)
    x = walk.take.positions[:, 0, [0, 2]]
    return float(np.linalg.norm(x[first + rows] - x[first])) / (rows * ROW)


def steady(walk: Walk, first: float, last: float) -> np.ndarray:
    """Return which joint accelerations (L,) are greatest between two times [rad/s²]."""
    q = walk.q[round(first / ROW) : round(last / ROW)]
    return np.abs(np.diff(q, 2, axis=0)).max(axis=(0, 2)) / ROW**2


CHANGES = {
    "horse": ("{gait: walk}", "{gait: trot}", "{gait: canter}", "{gait: walk}"),
    "person": ("{gait: walk}", "{gait: run}", "{gait: hop}", "{gait: walk}"),
    "beetle": ("{gait: tripod}", "{gait: wave}", "{gait: ripple, speed: 0.5}", "{gait: tripod}"),
    "spider": ("{gait: ripple}", "{mood: sneaking}", "{mood: impatient}", "{gait: trot}"),
}


@pytest.mark.nightly
@pytest.mark.parametrize("figure", CHANGES)
def test_gait_changes_are_smooth(figure: str) -> None:
    walk = walk_with_script(figure, *CHANGES[figure], duration=9)
    # The abdomen of a spider that sneaks grazes the ground.
    assert {note.kind for note in walk.take.notes} <= {"passes_through"}
    down = walk.standing[1:] & walk.standing[:-1]
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    assert moved[down].max() < 0.1 * MILLIMETRE
    foot_radius = walk.walkers.herd.foot_radius
    assert (walk.tips[..., 1] - foot_radius).min() > -0.1 * MILLIMETRE
    # Joints accelerate no more than in the gaits themselves.
    plain = max(steady(walk_through(s), 0.5, 3).max() for s in _alone(figure))
    assert steady(walk, 0, 9).max() < 2.0 * plain


def _alone(figure: str) -> list[object]:
    gaits = [change for change in CHANGES[figure] if "gait" in change]
    scenes = [scene_of(f"{{figure: {figure}, walk: {gait}}}", duration=3.5) for gait in gaits]
    moods = [change for change in CHANGES[figure] if "mood" in change]
    members = [f"{{figure: {figure}, walk: {gaits[0]}, {mood[1:-1]}}}" for mood in moods]
    return scenes + [scene_of(member, duration=3.5) for member in members]


def test_feet_follow_the_new_gait_after_a_change() -> None:
    walk = walk_with_script("horse", "{gait: walk}", "{gait: trot}", duration=8)
    walkers = walk.walkers
    gait = walkers.progress.paces.last(0).gait
    end = walkers.progress.paces.changes[0][-1].gaits.end
    names = [f"it.{leg}" for leg in walkers.herd.leg_names]
    late = 0
    for contact in walk.take.contacts:
        before, after = (walk.phases[contact.step + k][0] for k in (0, 1))
        phase = before + contact.fraction * (after - before)
        if phase > end + 1.0:
            off = phase - gait.down[names.index(contact.part)]
            assert abs(off - round(off)) < 1e-9
            late += 1
    assert late >= 4


@pytest.mark.slow
def test_each_foot_lands_once_after_each_lift_off() -> None:
    walk = walk_with_script(
        "beetle", "{gait: tripod}", "{gait: wave}", "{gait: tripod}", duration=7
    )
    swinging = np.array(walk.swinging).astype(int)
    ups = (np.diff(swinging, axis=0) == 1).sum(axis=0)
    downs = (np.diff(swinging, axis=0) == -1).sum(axis=0)
    assert (np.abs(ups - downs) <= 1).all()
    assert len(walk.take.contacts) == downs.sum()


@pytest.mark.nightly
def test_new_gait_has_its_default_or_ordered_speed() -> None:
    walk = walk_with_script("horse", "{gait: walk}", "{gait: trot, speed: 1.4}", duration=8)
    assert speed(walk, 6.2) == pytest.approx(1.4, rel=1e-6)
    own = walk_with_script("horse", "{gait: walk}", "{gait: canter}", duration=8)
    pace = own.walkers.progress.paces.last(0)
    assert speed(own, 6.2) == pytest.approx(pace.stride / pace.cycle, rel=1e-6)


@pytest.mark.nightly
def test_distance_does_not_depend_on_frame_rate() -> None:
    ends = []
    for fps in (24, 30, 60):
        more = "script: [{at: 1, who: it, do: {gait: wave}}]\n" + f"fps: {fps}\n"
        scene = scene_of("{name: it, figure: beetle, walk: {}}", duration=4, more=more)
        simulation = Simulation(scene)
        while not simulation.finished:
            simulation.step()
        troupe = simulation.troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        ends.append(float(troupe.travelled[0]))
    np.testing.assert_allclose(ends, ends[0], atol=2e-3)


def test_distance_is_the_integral_of_the_stride() -> None:
    walk = walk_with_script("beetle", "{}", "{gait: wave}", duration=3)
    paces: PaceSchedule = walk.walkers.progress.paces
    (change,) = paces.changes[0]
    phase = np.linspace(change.gaits.start - 1.0, change.gaits.end + 1.0, 20001)
    stride = paces.number("stride", 0, phase)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (stride[1:] + stride[:-1]) * np.diff(phase))])
    np.testing.assert_allclose(
        paces.distances(np.zeros(1, dtype=np.int64), phase[:1], phase[None])[0], summed, atol=1e-8
    )


@pytest.mark.nightly
def test_second_change_waits_for_the_first() -> None:
    more = "script: [{at: 1, who: it, do: {gait: wave}}, {at: 1.2, who: it, do: {gait: tripod}}]\n"
    scene = scene_of("{name: it, figure: beetle, walk: {}}", duration=6, more=more)
    first, second = walk_through(scene).walkers.progress.paces.changes[0]
    assert second.gaits.start == first.gaits.end
    assert second.before is first.after


def test_pace_transition_is_smooth_at_both_ends() -> None:
    walk = walk_with_script("beetle", "{}", "{gait: wave}", duration=3)
    (change,) = walk.walkers.progress.paces.changes[0]
    assert isinstance(change, PaceTransition)
    edge = np.array([change.gaits.start, change.gaits.end])
    slope = (change.done(edge + 1e-4) - change.done(edge - 1e-4)) / 2e-4
    np.testing.assert_allclose(slope, 0.0, atol=1e-6)


# --- one foot ---------------------------------------------------------------------


@pytest.mark.nightly
def test_person_hops_on_one_foot() -> None:
    walk = walk_with_script(
        "person", "{gait: hop, legs: [r1], path: [[2, 0], [2, 2], [0, 2]], repeat: loop}"
    )
    assert walk.take.notes == ()
    assert {contact.part for contact in walk.take.contacts} == {"it.r1"}
    left = walk.walkers.herd.leg_names.index("l1")
    body = walk.take.positions[:, 0]
    assert (walk.tips[:, left, 1] > 0.15).all()
    # The carrying foot lands under the body.
    right = walk.tips[:, 1 - left]
    stands = walk.standing[:, 1 - left]
    middle = np.median(np.linalg.norm((right - body)[stands][:, [0, 2]], axis=-1))
    assert middle < 0.3


def test_script_holds_a_foot_up_and_puts_it_down() -> None:
    walk = walk_with_script(
        "person", "{gait: walk}", "{gait: hop, legs: [r1]}", "{gait: walk}", duration=8
    )
    assert walk.take.notes == ()
    times = {
        leg: np.array([c.step * ROW for c in walk.take.contacts if c.part == f"it.{leg}"])
        for leg in ("l1", "r1")
    }
    gap = np.diff(times["l1"]).max()
    assert gap > 1.8
    assert np.diff(times["r1"]).max() < 1.3
    assert times["l1"].max() > 7.0
    moved = np.linalg.norm(np.diff(walk.tips, axis=0), axis=-1)
    down = walk.standing[1:] & walk.standing[:-1]
    assert moved[down].max() < 0.1 * MILLIMETRE
    # The foot moves smoothly.
    assert (moved / ROW).max() < 8.0


# --- moods ------------------------------------------------------------------------


def test_mood_factors_scale_with_the_weight_as_powers() -> None:
    def pace(mood: str) -> Pace:
        member = f"{{figure: beetle, walk: {{}}, mood: {mood}}}"
        more = "moods: {heavy: {stride: 0.64, cycle: 1.21, body_bob: 0.25, step_height: 1.44}}\n"
        troupe = Simulation(scene_of(member, more=more)).troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        return troupe.herd.paces[0]

    plain, whole, half = pace("{}"), pace("heavy"), pace("{heavy: 0.5}")
    for name, factor in {
        "stride": 0.64,
        "cycle": 1.21,
        "bounciness": 0.25,
        "step_height": 1.44,
    }.items():
        assert getattr(whole, name) == pytest.approx(factor * getattr(plain, name))
        assert getattr(half, name) == pytest.approx(factor**0.5 * getattr(plain, name))


@pytest.mark.nightly
@pytest.mark.parametrize(
    "figure",
    [
        pytest.param("antelope", marks=pytest.mark.nightly),
        "beetle",
        pytest.param("camel", marks=pytest.mark.nightly),
        pytest.param("centipede", marks=pytest.mark.nightly),
        pytest.param("hopper", marks=pytest.mark.nightly),
        pytest.param("horse", marks=pytest.mark.nightly),
        pytest.param("kangaroo", marks=pytest.mark.nightly),
        pytest.param("ostrich", marks=pytest.mark.nightly),
        "person",
        pytest.param("scorpion", marks=pytest.mark.nightly),
        pytest.param("spider", marks=pytest.mark.nightly),
        pytest.param("tripod", marks=pytest.mark.nightly),
    ],
)
def test_legs_can_follow_every_mood(figure: str) -> None:

    for mood in MOODS:
        for weight in (1.0, 2.0):
            member = f"{{figure: {figure}, walk: {{}}, mood: {{{mood}: {weight}}}}}"
            troupe = Simulation(scene_of(member, duration=0.1)).troupes[0]
            assert isinstance(troupe, WalkerTroupe)
            pace = troupe.herd.paces[0]
            assert 0.0 < pace.stride <= pace.longest + 1e-12
            assert pace.body_height <= troupe.herd.leg_layouts[0].tallest() + 1e-12


@pytest.mark.nightly
def test_moods_of_a_script_change_the_walk_and_back() -> None:
    walk = walk_with_script("person", "{gait: walk}", "{mood: sneaking}", "{mood: {}}", duration=12)
    assert walk.take.notes == ()
    before, sneaking, after = (speed(walk, t) for t in (0.5, 3.8, 10.8))
    assert sneaking < 0.7 * before
    assert after == pytest.approx(before, rel=1e-3)
    y = walk.take.positions[:, 0, 1]
    assert y[round(3.9 / ROW)] < 0.9 * y[: round(1.5 / ROW)].min()


# --- refusals ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("do", "message"),
    [
        ("{gait: canter}", "script[0].do.gait: a gait 'canter' needs two pairs of legs"),
        ("{gait: tripod, stride: 30}", "script[0].do: a stride (speed × cycle) of 30"),
        ("{gait: wave, legs: [l9]}", "script[0].do.legs[0]: 'beetle' has no leg 'l9'"),
        ("{gait: wave, speed: 1, cycle: 1, stride: 2}", "script[0].do.stride: stride = speed"),
        ("{mood: hapy}", "script[0].do.mood: no mood is called 'hapy', did you mean 'happy'?"),
        ("{mood: {sad: 5}}", "script[0].do.mood.sad: must be at most 2"),
    ],
)
def test_impossible_gaits_are_refused_before_the_start(do: str, message: str) -> None:
    member, script = (
        "{name: it, figure: beetle, walk: {}}",
        f"script: [{{at: 1, who: it, do: {do}}}]",
    )
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(member, more=script))
    assert message in str(caught.value)
