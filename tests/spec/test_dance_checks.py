"""Configuration of dances: errors with their lines, library lookup, and move times."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from pipeline.errors import SceneError
from pipeline.simulation.dancers.body_surfaces import body_surfaces
from pipeline.simulation.dancers.dance_moves import beat_duration, plan_moves
from pipeline.simulation.dancers.torso import ARM, JOINT_AXES, WRIST
from pipeline.simulation.people.proportions import ADULT
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene, simulation_key
from pipeline.spec.dance import ARM_JOINTS, BODY_PLACES, TRUNK_JOINTS

SCENE = """pronk: 1
duration: 1
dances:
  own:
    bar: 4
    drums: {{tom: {{at: [0.4, 1.0, 0]}}}}
    subtasks:
      - {subtask}
cast:
  - {{dancer: torso, dance: own, {config}}}
"""

GOOD = "{touch: chest}"


def error_text(subtask: str = GOOD, config: str = "start: 0.5") -> str:
    with pytest.raises(SceneError) as caught:
        Simulation(read_scene(SCENE.format(subtask=subtask, config=config)))
    assert len(caught.value.problems) == 1, caught.value
    return str(caught.value)


def test_config_and_torso_name_same_places_and_joints() -> None:
    assert set(body_surfaces(ADULT)) == set(BODY_PLACES)
    assert ARM_JOINTS == (*ARM, *WRIST)
    assert {*ARM_JOINTS, *TRUNK_JOINTS} == set(JOINT_AXES)


@pytest.mark.parametrize(
    ("subtask", "config", "path", "message"),
    [
        ("{touch: sholder_l}", "", "subtasks[0].touch", "did you mean 'shoulder_l'"),
        ("{touch: tam}", "", "subtasks[0].touch", "no place is called 'tam', did you mean 'tom'"),
        ("{touch: chest, via: [nowhere]}", "", "subtasks[0].via[0]", "no place is called"),
        ("{touch: chest, reach: [0.3, 1, 0]}", "", "subtasks[0].reach", "conflicts with touch"),
        ("{hand: r}", "", "subtasks[0]", "has no goal; write touch, reach, trace or joints"),
        ("{joints: {elbow_deg: 3}}", "", "joints.elbow_deg", "did you mean 'elbow_flexion_deg'"),
        ("{reach: [1.2, 1, 0]}", "", "subtasks[0].reach", "is 1.28 m from the shoulder"),
        ("{reach: [-0.25, 1.3, 0.1]}", "", "subtasks[0].reach", "cannot be reached: a joint limit"),
        ("{hand: l, reach: [0.1, 1.3, 0.45]}", "", "subtasks[0].reach", "cannot be reached"),
        ("{touch: chest, via: [[0.1, 1.3, -0.45]]}", "", "subtasks[0].via[0]", "cannot be reached"),
        ("{trace: [[0.4, 1.2, 0], [2, 1, 0]]}", "", "subtasks[0].trace[1]", "is 2.05 m from"),
        (
            "{touch: chest, via: [[0.9, 1.2, 0]]}",
            "",
            "subtasks[0].via[0]",
            "the arm reaches 0.65 m",
        ),
        (
            "{reach: [0, 1.2, 0]}",
            "",
            "subtasks[0].reach",
            "inside the body, 5 cm deep in the ribs",
        ),
        (
            *("{touch: chest, via: [[0.02, 1.62, 0]]}", "", "subtasks[0].via[0]"),
            "deep in the head; move it out, or touch a place on the body",
        ),
        (
            *("{joints: {elbow_flexion_deg: 190}}", "", "subtasks[0].joints.elbow_flexion_deg"),
            "is 190 degrees, but the joint goes from 0 to 150",
        ),
        ("{touch: chest, joints: {waist_bend_deg: -90}}", "", "waist_bend_deg", "from -25 to 25"),
        (
            *(GOOD, "pose: [{at: 0.5, joints: {elbow_r_flexion_deg: -40}}]"),
            *("cast[0].pose[0].joints.elbow_r_flexion_deg", "the joint goes from 0 to 150"),
        ),
        ("{touch: chest, on: [6]}", "", "subtasks[0].on[0]", "the bar has beats 1 to 4"),
        ("{touch: chest, beats: 9}", "", "dances.own.bar", "take 9 beats, and a bar has 4"),
        (GOOD, "durations: human", "cast[0].durations", "no durations called 'human'"),
        (GOOD, "durations: [1, 2]", "cast[0].durations", "2 times are given for the 1 subtasks"),
        (GOOD, "durations: 2, tempo_bpm: 100", "cast[0].tempo_bpm", "takes 2 s, but its"),
        (GOOD, "combine: winner", "cast[0].combine", "needs a force-field controller"),
        (GOOD, "tempo_bpm: 5", "cast[0].tempo_bpm", "10"),
        (GOOD, "beat: 3, start: 1", "cast[0].start", "conflicts with beat; remove one"),
        (GOOD, "beat: 0", "cast[0].beat", "1"),
        (
            *(GOOD, "beat: 3, tempo_bpm: 100", "cast[0].tempo_bpm"),
            "100 beats a minute do not fit beat 3 of a score at 120; remove this to dance at 120, "
            "or write 60 or 240",
        ),
        (GOOD, "controller: magic", "cast[0].controller", "force-field"),
    ],
)
def test_invalid_config_is_refused_with_its_path(subtask, config, path, message) -> None:
    text = error_text(subtask, config or "start: 0.5")
    assert path in text
    assert message in text
    assert text.startswith("scene:")


def test_unknown_dance_suggests_name() -> None:
    with pytest.raises(SceneError, match="no dance is called 'macarana', did you mean 'macarena'"):
        read_scene("pronk: 1\nduration: 1\ncast: [{dancer: torso, dance: macarana}]\n")


def test_script_finds_dances_in_library_and_beside_scene(tmp_path: Path) -> None:
    text = "pronk: 1\nduration: 1\ncast: [{dancer: torso, name: a}]\n"
    script = "script: [{at: 0.5, who: a, do: {dance: NAME, bars: 1}}]\n"
    for name in ("waving", "applauding"):
        assert name in read_scene(text + script.replace("NAME", name)).dances
    with pytest.raises(SceneError, match="no dance is called 'wavin', did you mean 'waving'"):
        read_scene(text + script.replace("NAME", "wavin"))
    (tmp_path / "bow.yaml").write_text("pronk: 1\ndance: {subtasks: [{touch: belly}]}\n")
    assert "bow" in read_scene(text + script.replace("NAME", "bow"), beside=tmp_path).dances


def test_dance_beside_scene_overrides_library(tmp_path: Path) -> None:
    (tmp_path / "dances").mkdir()
    own = "pronk: 1\ndance: {subtasks: [{touch: belly}]}\n"
    (tmp_path / "dances" / "macarena.yaml").write_text(own)
    text = "pronk: 1\nduration: 1\ncast: [{dancer: torso}]\n"
    assert len(read_scene(text, beside=tmp_path).dances["macarena"].subtasks) == 1
    assert len(read_scene(text).dances["macarena"].subtasks) == 12
    (tmp_path / "dances" / "macarena.yaml").write_text(own.replace("belly", "bely"))
    with pytest.raises(SceneError, match="did you mean 'belly'") as caught:
        read_scene(text, beside=tmp_path)
    assert "macarena.yaml:2:" in str(caught.value)


def test_simulation_key_contains_dances() -> None:
    text = "pronk: 1\nduration: 1\ncast: [{prop: {shape: box}}]\n"
    dances = "dances: {one: {subtasks: [{touch: chest}]}}\n"
    plain, more = read_scene(text), read_scene(text + dances)
    assert simulation_key(plain) != simulation_key(more)
    assert "dances" not in plain.model_fields_set


def test_hands_arrive_on_beats_without_overlap() -> None:
    text = "pronk: 1\nduration: 40\ncast: [{dancer: torso, tempo_bpm: 90, start: 2, bars: 2}]\n"
    scene = read_scene(text)
    member, dance = scene.dancers[0][1], scene.dances["macarena"]
    moves = plan_moves(member, dance, 40.0, "cast[0]")
    beat = beat_duration(member, dance)
    assert beat == pytest.approx(60 / 90)
    landings = sorted(m.land for rows in moves.values() for m in rows)
    wanted = [2 + (16 * bar + k + 1) * beat for bar in range(2) for k in range(12)]
    assert landings == pytest.approx(wanted)
    for rows in moves.values():
        for move, following in itertools.pairwise(rows):
            assert move.begin < move.land <= following.begin


def test_moves_with_durations_are_consecutive() -> None:
    text = "pronk: 1\nduration: 40\ncast: [{dancer: torso, durations: force, bars: 1}]\n"
    scene = read_scene(text)
    member, dance = scene.dancers[0][1], scene.dances["macarena"]
    moves = plan_moves(member, dance, 40.0, "cast[0]")
    rows = sorted((m for hand_moves in moves.values() for m in hand_moves), key=lambda m: m.begin)
    assert [m.subtask + 1 for m in rows] == [1, 2, 5, 6, 7, 8, 9, 10, 11, 12]
    for move, following in itertools.pairwise(rows):
        assert following.begin == pytest.approx(move.land)
    assert [m.land - m.begin for m in rows] == pytest.approx(
        [time for time in dance.durations["force"] if time]
    )


LOCKED = """pronk: 1
duration: 20
sound: {sound}
cast:
  - {{dancer: torso, dance: drumming, {config}}}
"""


@pytest.mark.parametrize(
    ("sound", "config", "start", "tempo"),
    [
        ("{tempo_bpm: 90}", "beat: 1", 0.0, 90),
        ("{tempo_bpm: 90}", "beat: 5", 4 * 60 / 90, 90),
        ("{tempo_bpm: 90, quantise: {offset: 0.25}}", "beat: 2.5", 0.25 + 1.0, 90),
        ("{tempo_bpm: 120}", "beat: 3, tempo_bpm: 60", 1.0, 60),
        ("{tempo_bpm: 60}", "beat: 2, tempo_bpm: 180", 1.0, 180),
    ],
)
def test_dance_locked_to_score_beat(sound, config, start, tempo) -> None:
    scene = read_scene(LOCKED.format(sound=sound, config=config))
    member, dance = scene.dancers[0][1], scene.dances["drumming"]
    assert member.start == pytest.approx(start)
    moves = plan_moves(member, dance, 20.0, "cast[0]")
    # The right hand plays eighths of the dance.
    eighths = [(m.land - start) * tempo / 30 for m in moves["r"]]
    assert eighths == pytest.approx([round(position) for position in eighths])
    # The first of the second bar is on a half beat of the faster tempo.
    first = next(m.land for m in moves["r"] if m.bar == 1)
    offset = scene.sound.quantise.offset if scene.sound.quantise else 0.0
    halves = (first - offset) * max(scene.sound.tempo_bpm, tempo) / 30
    assert halves == pytest.approx(round(halves))


def test_beat_before_film_is_refused() -> None:
    with pytest.raises(SceneError, match=r"beat 1 of the score is at -0\.5 s, before the film"):
        read_scene(LOCKED.format(sound="{quantise: {offset: -0.5}}", config="beat: 1"))


def test_score_tempo_changes_key_of_locked_dances_only() -> None:
    keys = [
        simulation_key(read_scene(LOCKED.format(sound=f"{{tempo_bpm: {tempo}}}", config=config)))
        for config in ("start: 1", "beat: 3")
        for tempo in (90, 120)
    ]
    assert keys[0] == keys[1]
    assert keys[2] != keys[3]


def test_the_material_of_a_drum_must_exist():
    with pytest.raises(SceneError) as caught:
        read_scene(
            "pronk: 1\nframes: 24\ncast: [{dancer: torso, dance: d}]\ndances:\n  d:\n"
            "    subtasks: [{touch: tom}]\n"
            "    drums: {tom: {at: [0.4, 0.9, 0.2], material: lether}}\n"
        )
    (problem,) = caught.value.problems
    assert problem.path == "dances.d.drums.tom.material"
    assert "no material is called 'lether', did you mean 'leather'?" in problem.message
