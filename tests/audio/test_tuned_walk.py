"""The scene tuned_walk: notes in the scale, gaits in time with the tempo."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import pytest

from audio.harmony import parse_steps
from audio.notes import Note, arrange
from audio.score import Score
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library
from tests.audio.conftest import is_on_scale

pytestmark = pytest.mark.nightly

BAR = 36
"""Frames of two beats at 80 a minute."""

FEET = {"mare": 4, "trio": 3, "anna": 2}


@pytest.fixture(scope="module")
def score() -> Score:
    scene = load_scene(library() / ("tuned_walk" + SUFFIX))
    take = simulate(scene)
    return build_score(scene, take, ShotBuilder(scene, take).poses)[0]


@pytest.fixture(scope="module")
def notes(score: Score) -> tuple[Note, ...]:
    return arrange(score).notes


def frames_of(notes: tuple[Note, ...], who: str, part: str = "") -> list[Fraction]:
    return [
        note.onset * 24
        for note in notes
        if note.is_first
        and note.event.who == who
        and note.event.cause == "footfall"
        and part in (note.event.part, "")
    ]


def test_every_pitch_belongs_to_the_scale(notes: tuple[Note, ...]) -> None:
    scale = parse_steps("A minor pentatonic")
    tuned = [note for note in notes if not note.drum]
    assert len(tuned) > 150
    assert all(is_on_scale(note.pitch, scale) for note in tuned)


@pytest.mark.parametrize("who", FEET)
def test_each_foot_sounds_once_a_bar(notes: tuple[Note, ...], who: str) -> None:
    own = [n for n in notes if n.event.who == who and n.event.cause == "footfall"]
    pitches = {note.event.part: note.pitch for note in own}
    assert len(set(pitches.values())) == len(pitches) == FEET[who]
    assert all(pitches[note.event.part] == note.pitch for note in own)
    for part in pitches:
        at = frames_of(notes, who, part)
        assert {b - a for a, b in itertools.pairwise(at)} == {BAR}


def test_four_feet_against_three_against_two(notes: tuple[Note, ...]) -> None:
    for who, feet in FEET.items():
        at = [frame for frame in frames_of(notes, who) if frame >= BAR]
        assert {b - a for a, b in itertools.pairwise(at)} == {BAR // feet}
        assert all(frame % (BAR // feet) == 0 for frame in at)


def test_the_kangaroo_hops_four_times_in_three_bars(notes: tuple[Note, ...]) -> None:
    # The first hop is from standing.
    landings = frames_of(notes, "roo")[1:]
    hops = [b - a for a, b in itertools.pairwise(landings)]
    assert len(hops) >= 9
    assert set(hops) == {3 * BAR // 4}


def test_jumps_play_phrases_and_landings_chords(notes: tuple[Note, ...]) -> None:
    pushes = [n for n in notes if n.event.cause == "boing"]
    first = pushes[0].onset
    phrase = [(n.onset - first, n.pitch) for n in pushes[:5]]
    assert phrase == [(Fraction(3 * k, 24), p) for k, p in enumerate((69, 72, 74, 76, 81))]
    landing = frames_of(notes, "roo")[0]
    chord = {n.pitch for n in notes if n.onset * 24 == landing and n.event.who == "roo"}
    assert chord >= {57, 60, 64, 67}


def test_gaits_need_no_quantisation_beyond_one_frame(score: Score) -> None:
    walkers = tuple(event for event in score.events if event.who in FEET)
    shifts = arrange(replace(score, events=walkers)).shifts
    assert shifts.events > 80
    assert shifts.greatest <= Fraction(1, 24)
