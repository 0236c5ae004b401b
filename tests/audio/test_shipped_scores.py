"""Scores of all shipped scenes: notes on their frames in three readers."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mido
import numpy as np
import pytest
import symusic

from audio.midi_file import write_midi
from audio.notes import notes_of
from audio.tempo_plan import tempo_plan
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes

RATES = [Fraction(r) for r in (10, 12, 15, 16, 18, 24, 25, 30, 48, 50, 60, 72, 90, 100, 120)]
RATES += [Fraction(144), Fraction(240), *(Fraction(r * 1000, 1001) for r in (24, 30, 60))]

BY_DAY = ("pass_by", "squeaky_robot", "kangaroo_hills", "rocks")
"""Scenes of every kind of cause, and with phrases; the others are nightly."""


def _tier(name: str) -> list[pytest.MarkDecorator]:
    if name == "first_steps":
        return []
    return [pytest.mark.slow if name in BY_DAY else pytest.mark.nightly]


SCENES = [pytest.param(name, marks=_tier(name)) for name in shipped_scenes()]


def with_symusic(data: bytes) -> Iterator[int]:
    """Yield the ticks of onsets as symusic reads them."""
    for track in symusic.Score.from_midi(data).tracks:
        yield from (note.time for note in track.notes)


def with_mido(data: bytes) -> Iterator[int]:
    """Yield the ticks of onsets as mido reads them."""
    for track in mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks:
        now = 0
        for message in track:
            now += message.time
            if message.type == "note_on" and message.velocity:
                yield now


def music_ticks(smf: Any) -> list[int]:
    """Return the ticks of onsets of the parts of the music, which have tracks of their own."""
    tracks = [
        track
        for track in smf.tracks
        if any(kind == 0xFF03 and data.startswith(b"music ") for _, kind, data in track)
    ]
    return [
        tick
        for track in tracks
        for tick, status, data in track
        if status < 0xF000 and status & 0xF0 == 0x90 and data[1]
    ]


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", SCENES)
def test_every_note_of_a_shipped_scene_is_on_its_frame(
    name: str, read_smf: Any, check_laws: Any, tmp_path: Path
) -> None:
    scene = load_scene(library() / (name + SUFFIX))
    take = simulate(scene)
    score, _ = build_score(scene, take, ShotBuilder(scene, take).poses)
    path = tmp_path / "score.mid"
    drums = scene.sound.music is not None or any(voice.drum for voice in scene.sound.voices)
    for rate in {*RATES, scene.rate}:
        report = write_midi(replace(score, rate=rate), path)
        data = path.read_bytes()
        smf = read_smf(data)
        check_laws(smf, score.frames, rate, drums)
        ticks = sorted(tick for tick, *_ in smf.onsets())
        assert sorted(with_symusic(data)) == sorted(with_mido(data)) == ticks
        events = len(score.events) - report.muted + report.music
        assert len(ticks) == report.notes == events + report.added - len(report.losses.merged)
        grid = tempo_plan(replace(score, rate=rate)).grid
        music = music_ticks(smf)
        assert bool(music) == (scene.sound.music is not None)
        # Music is on the nearest ticks of its beats' parts, of which none is finer than these.
        steps = [Fraction(48 * (tick - grid.bar_line), smf.division) for tick in music]
        assert all(abs(step - round(step)) <= Fraction(24, smf.division) for step in steps)
        ticks = sorted((Counter(ticks) - Counter(music)).elements())
        cues = {tick for tick, _ in smf.texts(0xFF07)}
        assert cues <= set(ticks)
        frames = {grid.tick(frame): frame for frame in range(1, score.frames + 1)}
        assert set(ticks) <= set(frames)
        after = [tick for tick in ticks if tick >= grid.bar_line]
        assert all((grid.seconds(tick) * rate).denominator == 1 for tick in after)
        assert all(abs(smf.seconds(tick) - grid.seconds(tick)) <= 1e-5 for tick in ticks)
        if not report.added:
            assert cues == set(ticks)
        if not (report.muted or report.added or scene.sound.quantise):
            shown = {event.frame for event in score.events}
            assert {frames[tick] for tick in ticks} == shown
    exact = replace(score, subframe=True)
    write_midi(exact, path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, score.frames, score.rate, drums)
    if not (report.muted or scene.sound.quantise):
        times = sorted(event.time for event in score.events)
        grid = tempo_plan(exact).grid
        cues_at = [grid.seconds(at) for at, _ in smf.texts(0xFF07)]
        off = [abs(cue - time) for cue, time in zip(cues_at, times, strict=True)]
        coarsest = min(span.ticks_per_frame for span in grid.spans)
        assert max(off, default=0) <= 1 / (2 * coarsest * score.rate)


DANCES = ("drummer", "clapping", "macarena")
"""Scenes whose events are meant on beats."""


@pytest.mark.sample(1)
@pytest.mark.slow
@pytest.mark.parametrize("rate", [24, 25, 30, 60, "24000/1001", "30000/1001"])
@pytest.mark.parametrize("name", DANCES)
def test_touches_of_a_dance_are_on_the_beats_of_the_file(name: str, rate: Any) -> None:
    scene = load_scene(library() / (name + SUFFIX), [f"fps={rate}"])
    take = simulate(scene)
    score, _ = build_score(scene, take, ShotBuilder(scene, take).poses)
    plan = tempo_plan(score)
    (member, *_) = [member for _, member in scene.dancers]
    assert plan.clock.spans[0].time == Fraction(str(member.start))
    assert abs(plan.grid.seconds(plan.grid.bar_line) - plan.clock.spans[0].time) <= 1 / score.rate
    notes = [note for note in notes_of(score) if not note.is_music]
    # Hands brush their own arms between the beats, too.
    onsets = [note.onset for note in notes if not note.event.is_passing]
    # Hands that brush past each other or past the head on their way are not meant.
    assert len(onsets) >= 0.6 * len(notes)
    # A touch is a little ahead of its beat, and heard with the first frame that shows it.
    late = plan.grid_distances(onsets, Fraction(1, 4))
    assert (np.abs(late) < 1.0).mean() >= 0.95
    assert np.ptp(np.quantile(late, [0.05, 0.95])) < 1.0 + 1e-9
