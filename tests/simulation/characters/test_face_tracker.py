"""Faces of acting people: what they are told, feel and look at, and how they blink."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.production.goldens.motion_digest import motion_digest
from pipeline.simulation.characters.person_record import persons_of
from pipeline.simulation.characters.pose_output import eye_aims
from pipeline.simulation.expressions import AT_EASE, EXPRESSIONS
from pipeline.simulation.face_units import COLUMNS, EYE_TURN, HANDS, UNITS
from pipeline.simulation.people.face_tracker import (
    BLINK,
    BLINK_PAUSE,
    MAX_EYE_SIDE,
    FaceInputs,
    FaceTracker,
)
from pipeline.simulation.people.proportions import ADULT
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import read_take, write_take
from pipeline.spec import read_scene
from pipeline.spec.expression import EMOTIONS
from tests.simulation.characters.scripted_people import run_scene

DT = 1.0 / 96.0

SMILE = UNITS.index("smile")


def rows(count: int, **changes: Array) -> list[FaceInputs]:
    """Return the inputs of rows of one person; changes have a row each, (count, ...)."""
    calm = FaceInputs.calm(1)
    return [
        replace(calm, **{name: value[k][None] for name, value in changes.items()})
        for k in range(count)
    ]


def faces(inputs: list[FaceInputs], names: tuple[str, ...] = ("ann",)) -> Array:
    """Return the faces (K, P, n) of people that all have the inputs of one."""
    several = [
        FaceInputs(*(np.repeat(getattr(row, f.name), len(names), axis=0) for f in fields(row)))
        for row in inputs
    ]
    return FaceTracker(names, 3, DT).faces(several).astype(float)


def wanted_eyes(count: int, **record: object) -> Array:
    """Return the turns of the eyes (count, 2) that a standing person's record asks for."""
    people = persons_of([ADULT], [0], np.zeros((1, 2)), np.zeros(1), np.zeros(1))
    persons = np.tile(np.array(people), (count, 1))
    for name, value in record.items():
        persons[name] = value
    return eye_aims(persons)[:, 0]


def of(emotion: str) -> Array:
    return np.eye(len(EMOTIONS))[EMOTIONS.index(emotion)]


def test_what_is_told_shows_and_what_is_felt_comes_back() -> None:
    count = 400
    told = np.tile(of("joy"), (count, 1))
    told[200:] = np.nan
    felt = np.tile(of("sadness"), (count, 1))
    shown = faces(rows(count, told=told, felt=felt))[:, 0]
    down = UNITS.index("corner_down")
    assert shown[199, SMILE] > 0.95 * EXPRESSIONS["joy"]["smile"]
    assert shown[199, down] < 0.01
    assert shown[-1, SMILE] < 0.1
    assert shown[-1, down] > 0.9
    # Within a tenth of a second or two, without a jump.
    assert 0.5 < shown[20, SMILE] < 1.0
    assert np.abs(np.diff(shown[:, SMILE])).max() < 0.15


def test_a_blow_shows_whatever_is_told_and_fades() -> None:
    count = 500
    told, pain = np.tile(of("joy"), (count, 1)), np.where(np.arange(count) < 100, 0.0, 2.0)
    shown = faces(rows(count, told=told, pain=pain))[:, 0]
    hurt = UNITS.index("lip_up")
    assert shown[99, SMILE] > 0.9
    assert shown[140, hurt] > 0.8
    assert shown[140, SMILE] < 0.6
    assert shown[-1, SMILE] > 0.8


def test_eyes_reach_a_target_before_the_head_and_hold_it_while_the_head_follows() -> None:
    count, aim = 96, np.radians(60.0)
    head = np.minimum(np.arange(count) / 60.0, 1.0) * aim
    gaze = np.stack([head, np.zeros(count)], axis=-1)[:, None]
    look = np.array([10.0 * np.cos(aim), 1.6, -10.0 * np.sin(aim)])
    targets = np.zeros((16, 3))
    targets[:, 1] = 1.6
    wanted = wanted_eyes(count, gaze=gaze, look_at=look, has_look_target=True, targets=targets)
    eyes = faces(rows(count, eyes=wanted))[:, 0, EYE_TURN]
    assert eyes[8] > 0.9 * MAX_EYE_SIDE
    assert eyes.max() <= MAX_EYE_SIDE + 1e-6
    # The gaze is held within a few degrees from where eyes and head together reach it.
    assert np.abs((eyes + head - aim)[40:]).max() < np.radians(3.0)
    assert abs(eyes[-1]) < np.radians(1.0)


def test_people_blink_about_seventeen_times_a_minute_each_by_itself() -> None:
    count = 96 * 60
    shut = faces(rows(count), ("ann", "ben"))[..., BLINK]
    starts = (shut[1:] > 0.5) & (shut[:-1] <= 0.5)
    assert (12 <= starts.sum(axis=0)).all()
    assert (starts.sum(axis=0) <= 25).all()
    assert not (starts[:, 0] == starts[:, 1]).all()
    for k in (0, 1):
        pauses = np.diff(np.flatnonzero(starts[:, k])) * DT
        assert pauses.min() > BLINK_PAUSE[0] - 2 * DT
    alone = faces(rows(count), ("ben",))[..., BLINK]
    np.testing.assert_array_equal(alone[:, 0], shut[:, 1])


def hand(shown: Array, unit: str) -> Array:
    return shown[:, 0, COLUMNS.index(unit)]


def test_an_angry_person_makes_fists_with_hands_that_have_nothing_to_do() -> None:
    count = 120
    anger, right = np.tile(of("anger"), (count, 1)), np.tile([0.0, 1.0], (count, 1))
    free, holding = (
        faces(rows(count, told=anger)),
        faces(rows(count, told=anger, grips=right)),
    )
    assert hand(free, "fist_r")[-1] > 0.9
    assert hand(holding, "fist_l")[-1] > 0.9
    assert hand(holding, "fist_r")[-1] < 0.05
    assert hand(holding, "grip_r")[-1] > 0.95
    # A hand takes its time.
    assert np.abs(np.diff(hand(holding, "grip_r"))).max() < 0.15
    stretched = faces(rows(count, told=anger, flat=right))
    assert hand(stretched, "flat_r")[-1] > 0.95
    assert hand(stretched, "fist_r")[-1] < 0.05
    calm = faces(rows(count))
    assert not calm[..., [COLUMNS.index(name) for name in HANDS]].any()


WALKERS = (
    "  - {name: eve, figure: person}\n  - {name: cy, character: adult, limp: true, at: [6, 0]}\n"
)
OTHERS = (
    "  - {name: doll, character: ragdoll, at: [9, 0]}\n",
    "  - {name: dan, dancer: torso, dance: macarena, controller: joint-torque, at: [3, 0]}\n",
)


@pytest.mark.parametrize(
    ("other", "faced"),
    [
        (OTHERS[0], {"eve", "cy"}),
        pytest.param(OTHERS[1], {"eve", "cy", "dan"}, marks=pytest.mark.nightly),
    ],
)
@pytest.mark.nightly
def test_walking_persons_limp_people_and_dancers_blink(other: str, faced: set[str]) -> None:
    take = run_scene(WALKERS + other, 6.0).take()
    assert {face.performer for face in take.faces} == faced
    shut = take.expressions[:, :, BLINK].T
    for face, own in zip(take.faces, shut, strict=True):
        assert own.max() > 0.9, face.performer
        assert own.min() == 0.0, face.performer
    # Nobody blinks with another.
    assert not (shut[0] == shut[1]).all()


CAST = "  - {name: ann, character: adult}\n  - {name: ben, character: child, at: [2, 0]}\n"


def take_of(script: str = "") -> Take:
    return run_scene(CAST, 1.0, script).take()


def test_takes_hold_faces_and_motion_does_not_depend_on_them(tmp_path: Path) -> None:
    plain, joyful = (
        take_of(),
        take_of("  - {at: 0.1, who: ben, do: {express: joy, strength: 0.5}}\n"),
    )
    assert [face.performer for face in joyful.faces] == ["ann", "ben"]
    assert joyful.expressions.shape == (len(joyful.positions), 2, len(COLUMNS))
    assert joyful.expressions[-1, 1, SMILE] == pytest.approx(0.5, abs=0.02)
    assert joyful.expressions[-1, 0, SMILE] == pytest.approx(AT_EASE[SMILE])
    assert joyful.digest != plain.digest
    assert motion_digest(joyful) == motion_digest(plain)
    write_take(joyful, tmp_path / "take.zarr")
    again = read_take(tmp_path / "take.zarr")
    assert again.digest == joyful.digest
    np.testing.assert_array_equal(again.expressions, joyful.expressions)


def test_takes_without_faces_are_stored_and_read(tmp_path: Path) -> None:
    """As those of earlier versions are."""
    empty = np.zeros((0, 0, 0), np.float32)
    take = take_of()
    bare = [
        replace(
            m,
            targets=np.zeros((0, 2), np.int32),
            offsets=np.zeros((0, 3), np.float32),
            creases=np.zeros((0, 3), np.float32),
            twists=np.zeros((0, 3), np.float32),
        )
        for m in take.meshes
    ]
    old = replace(take, faces=(), expressions=empty, meshes=tuple(bare))
    assert not {"expressions", "meshes/targets"} & {name for name, _ in old.arrays()}
    write_take(old, tmp_path / "take.zarr")
    assert read_take(tmp_path / "take.zarr").digest == old.digest


@pytest.mark.parametrize(
    ("order", "message"),
    [
        ("{express: joyy}", "do.express: must be .* did you mean 'joy'"),
        ("{express: joy, strength: 2}", "do.strength: must be at most 1"),
        ("{expres: joy}", "no order is called 'expres', did you mean 'express'"),
    ],
)
def test_bad_expressions_are_refused_with_their_line(order: str, message: str) -> None:
    text = f"pronk: 1\nframes: 1\ncast:\n{CAST}script:\n  - {{at: 0, who: ann, do: {order}}}\n"
    with pytest.raises(SceneError, match=rf":7:.*{message}"):
        read_scene(text)


def test_only_people_express() -> None:
    text = "pronk: 1\nframes: 1\ncast: [{name: mare, figure: horse, walk: {}}]\n"
    with pytest.raises(SceneError, match="express is no order"):
        read_scene(text + "script: [{at: 0, who: mare, do: {express: joy}}]\n")


def test_each_input_of_a_calm_face_is_its_own() -> None:
    """Inputs that share an array would move the eyes by how hands grip."""
    calm = FaceInputs.calm(2)
    for field in fields(FaceInputs):
        values = getattr(calm, field.name)
        others = [getattr(calm, f.name) for f in fields(FaceInputs) if f.name != field.name]
        assert not any(np.shares_memory(values, other) for other in others)
