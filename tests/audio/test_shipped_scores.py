"""Scores of all shipped scenes: notes on their frames in three readers."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mido
import pytest
import symusic

from audio.midi_file import write_midi
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


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", SCENES)
def test_every_note_of_a_shipped_scene_is_on_its_frame(
    name: str, read_smf: Any, check_laws: Any, tmp_path: Path
) -> None:
    scene = load_scene(library() / (name + SUFFIX))
    take = simulate(scene)
    score, _ = build_score(scene, take, ShotBuilder(scene, take).poses)
    path = tmp_path / "score.mid"
    drums = any(voice.drum for voice in scene.sound.voices)
    for rate in {*RATES, scene.rate}:
        report = write_midi(replace(score, rate=rate), path)
        data = path.read_bytes()
        smf = read_smf(data)
        check_laws(smf, score.frames, rate, drums)
        ticks = sorted(tick for tick, *_ in smf.onsets())
        assert sorted(with_symusic(data)) == sorted(with_mido(data)) == ticks
        events = len(score.events) - report.muted
        assert len(ticks) == report.notes == events + report.added - len(report.losses.merged)
        cues = {tick for tick, _ in smf.texts(0xFF07)}
        assert cues <= set(ticks)
        assert all((smf.seconds(tick) * rate).denominator == 1 for tick in ticks)
        if not report.added:
            assert cues == set(ticks)
        if not (report.muted or report.added or scene.sound.quantise):
            shown = {(event.frame - 1) / rate for event in score.events}
            assert {smf.seconds(tick) for tick in ticks} == shown
    exact = replace(score, subframe=True)
    write_midi(exact, path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, score.frames, score.rate, drums)
    if not (report.muted or scene.sound.quantise):
        times = sorted(event.time for event in score.events)
        cues_at = [smf.seconds(at) for at, _ in smf.texts(0xFF07)]
        off = [abs(cue - time) for cue, time in zip(cues_at, times, strict=True)]
        assert max(off, default=0) <= smf.seconds(1) / 2
