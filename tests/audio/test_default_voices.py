"""Default voices: every material, cause and figure is audible and distinct."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.acoustic_materials import FAMILIES, family_name
from audio.cause_voices import CAUSE_VOICES
from audio.general_midi import INSTRUMENTS, program_number, usual_range
from audio.harmony import parse_scale
from audio.notes import Note, notes_of
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score as placed
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import library
from render.config.material import MATERIALS
from tests.audio.conftest import is_on_scale

ALIKE = ({"stone", "brick", "gravel"}, {"flesh", "soil", "sand", "grass", "snow"})
"""Families that share an instrument: hard and dull ones, and soft ones."""

# Usual speeds of causes [m/s].
USUAL = {"scuff": 0.5, "swoosh": 8.0, "whistle": 15.0, "squeak": 0.5, "squawk": 1.5, "boing": 2.5}

LEVEL_RANGE = (-40.0, 0.0)
"""Range of levels at a distance of four metres [dBFS]."""


def heard(step: Any, score_of: Any, **fields: Any) -> Note:
    (note,) = notes_of(score_of([step(1, **fields)]))
    return note


@pytest.mark.sample(5)
@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@given(size=st.floats(0.01, 2.0), strength=st.floats(0.15, 1.0))
def test_every_material_is_audible_in_its_instruments_usual_range(
    step: Any, score_of: Any, family: str, size: float, strength: float
) -> None:
    for cause in ("footfall", "collision"):
        note = heard(step, score_of, cause=cause, material=family, size=size, strength=strength)
        assert INSTRUMENTS[note.program] == FAMILIES[family].instrument
        lowest, highest = usual_range(note.program)
        assert lowest <= note.pitch <= highest
        assert is_on_scale(note.pitch, parse_scale("C minor pentatonic"))
        assert LEVEL_RANGE[0] <= note.level <= LEVEL_RANGE[1]
        assert 0.1 <= note.seconds <= 2


def test_different_materials_have_different_instruments(step: Any, score_of: Any) -> None:
    programs = {name: heard(step, score_of, material=name).program for name in FAMILIES}
    for one, other in combinations(FAMILIES, 2):
        alike = any({one, other} <= group for group in ALIKE)
        assert (programs[one] == programs[other]) == alike, (one, other)


@pytest.mark.parametrize("cause", CAUSE_VOICES)
def test_every_cause_with_a_voice_is_audible(step: Any, score_of: Any, cause: str) -> None:
    note = heard(step, score_of, cause=cause, strength=USUAL.get(cause, 1.0), size=0.3)
    lowest, highest = usual_range(note.program)
    assert lowest <= note.pitch <= highest
    assert LEVEL_RANGE[0] <= note.level <= LEVEL_RANGE[1]


def test_usual_ranges_hold_two_octaves_and_instruments_are_distinct() -> None:
    for program in range(128):
        lowest, highest = usual_range(program)
        assert 0 <= lowest <= highest - 24
        assert highest <= 127
    used = {family.instrument for family in FAMILIES.values()}
    assert len({program_number(name) for name in used}) == len(used) >= 10


def test_every_material_of_the_library_has_a_family() -> None:
    # The last known word of a name counts, so only unknown names leave both words standing.
    unnamed = {
        name
        for name in MATERIALS
        if all(family_name(f"{word} {name}") == word for word in ("glass", "water"))
    }
    assert unnamed <= {"feathers", "white feathers", "eye", "eye white", "flame", "smoke"}


FIGURES = sorted(path.stem for path in (library() / "figures").glob("*.yaml"))
STILL = {"robot_arm"}
FEW = {"beetle"}


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "figure",
    [
        pytest.param(name, marks=[] if name in FEW else [pytest.mark.slow])
        for name in FIGURES
        if name not in STILL
    ],
)
def test_every_figure_that_walks_has_audible_feet_of_distinct_pitch(
    figure: str, tmp_path: Path
) -> None:
    path = tmp_path / "walk.yaml"
    path.write_text(f"pronk: 1\nduration: 4\ncast: [{{figure: {figure}, walk: {{}}}}]\n")
    scene = load_scene(path)
    take = simulate(scene)
    score, _ = placed(scene, take, ShotBuilder(scene, take).poses)
    near = replace(score, events=tuple(replace(event, distance=4.0) for event in score.events))
    notes = [note for note in notes_of(near) if note.event.cause == "footfall"]
    assert notes
    for note in notes:
        lowest, highest = usual_range(note.program)
        assert lowest <= note.pitch <= highest
        # A hop lands harder than a step.
        assert LEVEL_RANGE[0] <= note.level <= LEVEL_RANGE[1] + 3
    pitches = {note.event.part: note.pitch for note in notes}
    steps = 2 * len(parse_scale(scene.sound.scale).intervals)
    assert len(set(pitches.values())) == min(len(pitches), steps)
