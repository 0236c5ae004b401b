"""Motion goldens: changes are named with step and part, and equal motion passes."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from pipeline.errors import GoldenMissing, StoreError
from pipeline.production.goldens import motion_golden, motion_tolerance
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_digest import motion_digest
from pipeline.production.goldens.motion_file import encoded, read_golden, write_golden
from pipeline.production.goldens.motion_golden import MotionGolden, golden_of
from pipeline.production.goldens.motion_verdict import MotionOutcome, MotionVerdict
from pipeline.production.goldens.packed_series import Series
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, matrix, quaternion, rotation
from pipeline.simulation.take import Channel, Take, TakeNote
from pipeline.spec import load_scene
from pipeline.spec.scene_library import library

if TYPE_CHECKING:
    from tests.production.conftest import Studio

ROW, NODE = 13, "bug.l2.2"
"""Row at which takes are changed, between two frames; there is a row a step."""


@pytest.fixture(scope="module")
def golden(take: Take, tmp_path_factory: pytest.TempPathFactory) -> MotionGolden:
    path = tmp_path_factory.mktemp("goldens") / "tiny.json"
    write_golden(golden_of(take, "tiny"), path)
    return read_golden(path)


def _node(take: Take, name: str = NODE) -> int:
    return [node.name for node in take.nodes].index(name)


def _moved(take: Take, metres: float, row: int = ROW) -> Take:
    positions = take.positions.copy()
    positions[row, _node(take)] += metres * np.array([0.36, 0.48, 0.8])
    return replace(take, positions=positions)


def _turned(take: Take, radians: float) -> Take:
    rotations = take.rotations.copy()
    here = ROW, _node(take)
    turn = rotation(np.array([0.36, 0.48, 0.8]), radians)
    # The other sign is the same rotation.
    rotations[here] = -quaternion(matrix(rotations[here]) @ turn)
    return replace(take, rotations=rotations)


def _elsewhere(take: Take, **versions: str) -> Take:
    changed = {**take.header.versions, **versions}
    return replace(take, header=replace(take.header, versions=changed))


def _only(verdict: MotionVerdict) -> tuple[int, str, str]:
    assert verdict.outcome is MotionOutcome.CHANGED
    assert not verdict.passed
    assert len(verdict.differences) == 1, str(verdict)
    found = verdict.differences[0]
    return found.step, found.kind, found.who


def test_a_take_is_identical_to_its_golden(golden: MotionGolden, take: Take) -> None:
    verdict = compare(golden, take)
    assert verdict.outcome is MotionOutcome.IDENTICAL
    assert verdict.passed
    assert "exact" in verdict.rule
    assert verdict.first is None


def test_a_written_golden_is_read_back(take: Take, golden: MotionGolden) -> None:
    made = golden_of(take, "tiny")
    assert encoded(golden) == encoded(made)
    for name, series in made.series.items():
        assert np.array_equal(series.multiples, golden.series[name].multiples)
    assert (made.marks, made.fingerprints) == (golden.marks, golden.fingerprints)


@given(
    arrays(
        np.float64,
        array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=7),
        elements=st.floats(-1e7, 1e7) | st.sampled_from([np.nan, 0.0, -0.0]),
    ),
    st.sampled_from([1e-4, 0.15, 1.0]),
)
def test_series_come_back_to_half_a_quantum(values: Array, quantum: float) -> None:
    series = Series.of(values, np.full(values.shape[1], quantum))
    packed = json.loads(json.dumps(series.packed()))
    back = Series.unpacked(packed)
    assert np.array_equal(back.multiples, series.multiples)
    assert np.array_equal(np.isnan(back.values), np.isnan(values))
    error = np.abs(back.values - values)[~np.isnan(values)]
    assert (error <= quantum / 2 + 1e-8).all()


def test_the_digest_is_of_the_motion_alone(take: Take) -> None:
    header = replace(take.header, key="another", title="Another", format=9)
    same = [
        replace(take, header=header),
        _elsewhere(take, simulation="0123", python="9.9", machine="abacus"),
        replace(take, parts=take.parts[1:], meshes=take.meshes[1:]),
        replace(take, mechanisms=(), legs=(), aliases=()),
    ]
    assert take.legs
    assert {motion_digest(t) for t in same} == {motion_digest(take)}
    others = [
        _moved(take, 1e-15),
        replace(take, header=replace(take.header, seed=99)),
        replace(take, alive=~take.alive),
        replace(take, values=take.values + 1.0),
        replace(take, events=take.events[1:]),
        replace(take, contacts=take.contacts[1:]),
        replace(take, notes=(TakeNote("stopped", 3, "bug", "why"),)),
        replace(take, nodes=(replace(take.nodes[0], name="x"), *take.nodes[1:])),
        replace(take, terrain=replace(take.terrain, vertices=take.terrain.vertices + 1e-9)),
    ]
    digests = {motion_digest(take), *(motion_digest(other) for other in others)}
    assert len(digests) == 1 + len(others)


def test_only_twice_the_tolerance_is_reported(golden: MotionGolden, take: Take) -> None:
    verdict = compare(golden, _moved(take, 2 * motion_tolerance.POSITION))
    assert _only(verdict) == (ROW, "position", NODE)
    assert verdict.differences[0].excess == pytest.approx(2, abs=0.3)
    text = str(verdict)
    assert f"at step {ROW} (0.135 s, frame 5): {NODE} lies" in text
    assert "mm off (allowed: 0.5 mm)" in text
    assert f"position: 1 of {len(take.nodes)} differ" in text
    assert f"bits differ from step {ROW} on, in 1 of 33 rows and 1 of" in text


def test_a_rotation_is_named(golden: MotionGolden, take: Take) -> None:
    verdict = compare(golden, _turned(take, 2 * motion_tolerance.ROTATION))
    assert _only(verdict) == (ROW, "rotation", NODE)
    assert verdict.differences[0].excess == pytest.approx(2, abs=0.3)
    assert "degrees off" in str(verdict)


@pytest.mark.parametrize("share", [1e-9, 0.5])
def test_half_the_tolerance_passes_and_is_noted(
    golden: MotionGolden, take: Take, share: float
) -> None:
    for spoilt in (
        _moved(take, share * motion_tolerance.POSITION),
        _turned(take, share * motion_tolerance.ROTATION),
    ):
        verdict = compare(golden, spoilt)
        assert verdict.outcome is MotionOutcome.WITHIN
        assert verdict.passed
        assert "same class of processor" in verdict.rule
        assert f"bits differ from step {ROW} on" in verdict.bits
        assert verdict.bits.endswith(NODE)


def test_the_first_difference_is_the_earliest_and_nearest_to_the_root(
    golden: MotionGolden, take: Take
) -> None:
    positions = take.positions.copy()
    positions[20:, _node(take, "bug.body")] += 0.5
    positions[9:, [_node(take, "bug.l1.1"), _node(take, "bug.l1.2")]] += [[0.001], [0.1]]
    verdict = compare(golden, replace(take, positions=positions))
    assert verdict.first is not None
    assert (verdict.first.step, verdict.first.who) == (9, "bug.l1.1")
    assert [d.who for d in verdict.differences] == ["bug.l1.1", "bug.l1.2", "bug.body"]
    assert "position: 3 of 28 differ, most bug.body: 866 mm at step" in str(verdict)


def test_a_channel_is_named(golden: MotionGolden, take: Take) -> None:
    values, name = take.values.copy(), "bug.speed"
    column = [channel.name for channel in take.channels].index(name)
    values[16, column] += 2 * motion_tolerance.CHANNEL
    assert _only(compare(golden, replace(take, values=values))) == (16, "channel", name)


def test_phases_and_angles_are_periodic(golden: MotionGolden, take: Take) -> None:
    values = take.values.copy()
    for c, channel in enumerate(take.channels):
        if channel.name == "bug.gait_phase":
            values[16, c] += 1.0
        if channel.unit == "rad":
            values[16, c] -= 2.0 * np.pi
    verdict = compare(golden, replace(take, values=values))
    assert verdict.outcome is MotionOutcome.WITHIN


def test_nan_is_a_difference(golden: MotionGolden, take: Take) -> None:
    values = take.values.copy()
    values[16, 1] = np.nan
    spoilt = replace(take, values=values)
    assert _only(compare(golden, spoilt)) == (16, "channel", take.channels[1].name)
    assert compare(golden_of(spoilt, "tiny"), spoilt).outcome is MotionOutcome.IDENTICAL
    assert compare(golden_of(spoilt, "tiny"), _moved(spoilt, 1e-9)).outcome is MotionOutcome.WITHIN


def test_a_node_that_is_not_alive_is_named(golden: MotionGolden, take: Take) -> None:
    alive = take.alive.copy()
    alive[ROW:, _node(take)] = False
    assert _only(compare(golden, replace(take, alive=alive))) == (ROW, "alive", NODE)


def test_a_scale_is_named(take: Take) -> None:
    scales = np.ones((len(take.positions), 1, 3))
    scaled = replace(take, scales=scales, scaled=(_node(take),))
    other = replace(scaled, scales=scales + 0.1 * (np.arange(len(scales)) >= ROW)[:, None, None])
    assert _only(compare(golden_of(scaled, "tiny"), other)) == (ROW, "scale", NODE)


@pytest.mark.parametrize("field", ["contacts", "events"])
def test_missing_and_new_marks_are_named(golden: MotionGolden, take: Take, field: str) -> None:
    marks = list(getattr(take, field))
    mark = marks[2]
    fewer = replace(take, **{field: tuple(marks[:2] + marks[3:])})
    more = replace(take, **{field: (*marks, replace(mark, step=mark.step + 9))})
    for spoilt, text in ((fewer, "is missing"), (more, "is new")):
        verdict = compare(golden, spoilt)
        step = mark.step + 9 * (spoilt is more)
        assert _only(verdict) == (step, field[:-1], mark.part)
        assert text in str(verdict)


def test_an_event_moved_by_a_frame_is_named(golden: MotionGolden, take: Take) -> None:
    event = take.events[1]
    for changed in (
        replace(event, frame=event.frame + 1),
        replace(event, step=event.step + 4, frame=event.frame + 1),
    ):
        spoilt = replace(take, events=(take.events[0], changed, *take.events[2:]))
        verdict = compare(golden, spoilt)
        assert _only(verdict) == (event.step, "event", event.part)
        assert "moved" in str(verdict)
        assert "no bit of a pose or a channel differs" in verdict.bits


def test_an_event_within_a_step_may_cross_into_the_next_frame(take: Take) -> None:
    event = replace(take.events[0], step=7, fraction=0.98, frame=3)
    late = replace(event, step=8, fraction=0.01, frame=4)
    golden = golden_of(replace(take, events=(event,)), "tiny")
    assert compare(golden, replace(take, events=(late,))).outcome is MotionOutcome.WITHIN
    # Nothing explains this one: both moments belong to frame 3.
    wrong = replace(late, step=7, fraction=0.99)
    assert not compare(golden, replace(take, events=(wrong,))).passed


@pytest.mark.parametrize(("share", "passes"), [(0.5, True), (2.0, False)])
def test_contacts_have_tolerances_of_their_own(
    golden: MotionGolden, take: Take, share: float, passes: bool
) -> None:
    contact = take.contacts[3]
    x, y, z = contact.place
    bound = motion_tolerance.strength_tolerance(contact.speed)
    for changed in (
        replace(contact, place=(x, y, z + share * motion_tolerance.PLACE)),
        replace(contact, speed=contact.speed + share * bound),
        replace(contact, fraction=contact.fraction + share * motion_tolerance.MOMENT),
    ):
        spoilt = replace(take, contacts=(*take.contacts[:3], changed, *take.contacts[4:]))
        verdict = compare(golden, spoilt)
        assert verdict.passed == passes
        assert passes or _only(verdict) == (contact.step, "contact", contact.part)


def test_a_note_is_named(golden: MotionGolden, take: Take) -> None:
    note = TakeNote("stopped", 5, "bug", "no foothold")
    assert _only(compare(golden, replace(take, notes=(note,)))) == (5, "note", "bug")


def test_a_renamed_node_is_one_gone_and_one_new(golden: MotionGolden, take: Take) -> None:
    nodes = list(take.nodes)
    nodes[_node(take)] = replace(nodes[_node(take)], name="bug.m2.2")
    verdict = compare(golden, replace(take, nodes=tuple(nodes)))
    assert [(d.who, d.text) for d in verdict.differences] == [
        (NODE, "is gone: this node"),
        ("bug.m2.2", "is new: this node"),
    ]


def test_the_order_of_nodes_is_irrelevant(golden: MotionGolden, take: Take) -> None:
    last = [*range(1, len(take.nodes)), 0]
    turned = replace(
        take,
        nodes=tuple(take.nodes[j] for j in last),
        positions=take.positions[:, last],
        rotations=take.rotations[:, last],
        alive=take.alive[:, last],
    )
    assert compare(golden, turned).outcome is MotionOutcome.WITHIN
    assert _only(compare(golden, _moved(turned, 0.1))) == (ROW, "position", NODE)


@pytest.mark.parametrize(
    ("overrides", "who"),
    [
        (["fps=25"], "rate"),
        (["frames=9"], "frames"),
        (["seed=4"], "seed"),
        (["steps=8"], "steps"),
    ],
)
def test_another_length_or_rate_is_named(
    golden: MotionGolden, unmade: Studio, overrides: list[str], who: str
) -> None:
    verdict = compare(golden, simulate(unmade.load(*overrides)))
    assert not verdict.passed
    assert verdict.first is not None
    assert (verdict.first.kind, verdict.first.who) == ("take", who)
    assert "the golden's" in verdict.first.text


def test_another_unit_or_ground_is_named(golden: MotionGolden, take: Take) -> None:
    channels = (*take.channels[:1], Channel(take.channels[1].name, "km/h"), *take.channels[2:])
    assert _only(compare(golden, replace(take, channels=channels)))[2] == channels[1].name
    vertices = take.terrain.vertices.copy()
    vertices[40:42, 1] += 0.01
    land = replace(take.terrain, vertices=vertices)
    verdict = compare(golden, replace(take, terrain=land))
    assert _only(verdict)[1] == "ground"
    assert "differs at 2 of 81 places" in str(verdict)
    for land in (
        replace(take.terrain, forbidden=~take.terrain.forbidden),
        replace(take.terrain, material="grass"),
        replace(take.terrain, cells=(4, 16)),
    ):
        assert _only(compare(golden, replace(take, terrain=land)))[1] == "ground"


@pytest.mark.parametrize("name", ["machine", "numpy", "mujoco"])
def test_on_another_machine_the_tolerant_rule_is_used(
    golden: MotionGolden, take: Take, name: str
) -> None:
    there = _elsewhere(take, **{name: "another"})
    assert compare(golden, there).outcome is MotionOutcome.IDENTICAL
    near = compare(golden, _moved(there, 1e-9))
    assert near.outcome is MotionOutcome.WITHIN
    assert f"tolerant: {name} another, the golden's" in near.rule
    assert not near.bits
    far = compare(golden, _moved(there, 2 * motion_tolerance.POSITION))
    assert _only(far) == (ROW, "position", NODE)
    assert f"tolerant: {name} another" in str(far)


def test_other_code_is_held_to_the_same_golden(golden: MotionGolden, take: Take) -> None:
    newer = _elsewhere(take, pronk="9", simulation="0123", language="2", python="3.99")
    assert compare(golden, newer).outcome is MotionOutcome.IDENTICAL
    assert compare(golden, newer).elsewhere == ""


def test_a_long_take_keeps_fewer_rows(take: Take, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion_golden, "MAX_NUMBERS", 2_200)
    golden = golden_of(take, "tiny")
    assert golden.stride == 4
    assert len(golden.series["positions"].multiples) == 9
    assert len(encoded(golden)) < len(encoded(replace(golden, series=_every_row(take))))
    assert _only(compare(golden, _moved(take, 1e-3, row=16))) == (16, "position", NODE)
    # Between the rows that are kept, bits tell where, and only on the same class.
    between = compare(golden, _moved(take, 1e-3, row=ROW))
    assert between.outcome is MotionOutcome.WITHIN
    assert f"bits differ from step {ROW} on" in between.bits


def _every_row(take: Take) -> dict[str, Series]:
    nodes, channels = [n.name for n in take.nodes], [c.name for c in take.channels]
    kept = motion_golden.sampled(take, 1, nodes, channels)
    return {name: Series.of(v, np.full(v.shape[1], 1e-4)) for name, v in kept.items()}


BROKEN: dict[str, Callable[[str], str]] = {
    "cut short": lambda text: text[: len(text) // 2],
    "empty": lambda text: "",
    "no JSON": lambda text: "golden: yes\n",
    "a list": lambda text: "[1, 2]\n",
    "something else": lambda text: '{"manifest": 1}\n',
    "of another format": lambda text: text.replace('"motion golden": 1', '"motion golden": 7'),
    "without its marks": lambda text: text.replace('"marks"', '"remarks"'),
    "with a word cut short": lambda text: text.replace('"packed": "', '"packed": "0'),
    "without a node": lambda text: text.replace('"bug.body", ', ""),
}


@pytest.mark.parametrize("how", BROKEN)
def test_a_damaged_golden_is_one_clear_error(
    golden: MotionGolden, tmp_path: Path, how: str
) -> None:
    path = tmp_path / "tiny.json"
    path.write_text(BROKEN[how](encoded(golden)), encoding="utf-8")
    with pytest.raises(StoreError) as error:
        read_golden(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "golden" in str(error.value)
    if how == "of another format":
        assert "format 7, where 1 can be read" in str(error.value)


def test_a_missing_or_unwritable_golden_is_one_clear_error(
    golden: MotionGolden, tmp_path: Path
) -> None:
    with pytest.raises(GoldenMissing, match="no such golden"):
        read_golden(tmp_path / "none.json")
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError, match="could not be written"):
        write_golden(golden, tmp_path / "file" / "tiny.json")
    with pytest.raises(StoreError, match="could not be read"):
        read_golden(tmp_path)


def _first_steps(*overrides: str) -> Take:
    return simulate(
        load_scene(library() / "first_steps.yaml", [f"cast[0].walk.{key}" for key in overrides])
    )


@pytest.fixture(scope="module")
def first_steps() -> Take:
    return _first_steps()


def _default_bounciness() -> float:
    simulation = Simulation(load_scene(library() / "first_steps.yaml"))
    troupe = simulation.troupes[0]
    assert isinstance(troupe, WalkerTroupe)
    return float(troupe.herd.bounciness[0])


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("word", ["bounciness", "cycle", "speed"])
def test_a_slightly_different_walk_is_detected_at_its_first_difference(
    first_steps: Take, word: str
) -> None:
    bounciness = _default_bounciness() + 0.001
    values = {"bounciness": f"{bounciness!r}", "cycle": "0.722", "speed": "0.622"}
    other = _first_steps(f"{word}={values[word]}")
    verdict = compare(golden_of(first_steps, "first_steps"), other)
    assert not verdict.passed
    first = verdict.first
    assert first is not None
    # An independent look at both takes; the golden's rounding is 0.3 of the tolerance.
    if first.kind == "position":
        way = np.linalg.norm(other.positions - first_steps.positions, axis=-1)
        apart = way / motion_tolerance.POSITION
    else:
        assert first.kind == "rotation"
        cosine = np.abs((other.rotations * first_steps.rotations).sum(axis=-1))
        apart = 2.0 * np.arccos(np.minimum(cosine, 1.0)) / motion_tolerance.ROTATION
    assert apart[: first.step].max(initial=0.0) < 1.3
    assert 0.7 < apart[first.step, _node(other, first.who)] < 3.0
    if word == "bounciness":
        assert first.who == "bug.body"
        assert max(d.excess for d in verdict.differences if d.who == "bug.body") == pytest.approx(
            2.0, abs=0.3
        )


@pytest.mark.slow
def test_the_same_walk_written_out_is_identical(first_steps: Take) -> None:
    golden = golden_of(first_steps, "first_steps")
    same = _first_steps(f"bounciness={_default_bounciness()!r}", "cycle=0.72")
    assert compare(golden, same).outcome is MotionOutcome.IDENTICAL
