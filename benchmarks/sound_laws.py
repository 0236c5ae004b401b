"""Scores and tracks of all scenes: what they promise, measured by readers that are not pronk's.

For each scene: notes off their frames at six frame rates, as fractions, by three readers of MIDI;
performers that sound and have no note; parts whose program changes; notes that a fourth reader
counts otherwise; the share of notes within half a frame of a sixteenth, where events are meant on
beats;
the share of the film below -60 dBFS; the distance from the target loudness and the true peak, by
another meter; what the master takes from the crest of its blows, but for the fiftieth that it
takes most from; how far the sum of the stems is from the track; and the time that the track takes.

    python benchmarks/sound_laws.py [SCENE...]
"""

from __future__ import annotations

import argparse
import io
import os
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import mido
import music21
import numpy as np
import pretty_midi
import pyloudnorm
import symusic
from scipy.signal import resample_poly

from audio.dsp import decibels
from audio.midi_file import write_midi
from audio.notes import notes_of
from audio.score import Score
from audio.stems import write_stems
from audio.tempo_plan import tempo_plan
from audio.time_grid import SAMPLE_RATE, sample_at
from audio.wav_file import read_samples, write_wav
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes

RATES = (*map(Fraction, (24, 25, 30, 60)), *(Fraction(1000 * r, 1001) for r in (24, 30)))

MOST_SILENT, MOST_LUFS, MOST_SHARE = 0.3, 0.3, 0.1
"""Share of the film that may be below -60 dBFS, distance from the target [LU], share of real time
that a track may take."""

LEAST_ON_GRID = 0.95
"""Share of the notes of a pulse that has to be on its sixteenths."""

MOST_CREST = 1.0
"""What the master may take from the crest of a blow [dB]."""

MOST_STEM_DB, TRUE_PEAK_DB = -80.0, -1.0
"""Of the sum of the stems beside the track, and of true peaks [dB]."""

MOST_STEMS = 120
"""Stems of a scene that are added up; a crowd has hundreds."""


@dataclass(frozen=True, slots=True)
class Laws:
    """What was measured of one scene.

    Attributes:
        notes: in the score at its own frame rate.
        off_frame: notes off their frames, over all rates and readers.
        empty: performers that sound and have no note.
        programs: parts that set a program twice.
        unread: difference of the number of notes of a fourth reader.
        on_grid: share of notes on sixteenths; None where events are meant on no beat.
        silent: share of the film below -60 dBFS.
        lufs_error: distance from the target [LU].
        true_peak: [dB].
        limited: reduction of the highest peak [dB].
        crest: what the master takes from the peaks of 49 of 50 blows beside their mean [dB].
        stem_error: of the sum of the stems, beside the track's peak [dB]; None where not summed.
        share: of real time that the track took.
    """

    notes: int
    off_frame: int
    empty: int
    programs: int
    unread: int
    on_grid: float | None
    silent: float
    lufs_error: float
    true_peak: float
    limited: float
    crest: float
    stem_error: float | None
    share: float

    @property
    def broken(self) -> tuple[str, ...]:
        """Names of what does not hold."""
        checks = {
            "notes off frames": self.off_frame,
            "empty parts": self.empty,
            "programs": self.programs,
            "reader": self.unread,
            "beats": self.on_grid is not None and self.on_grid < LEAST_ON_GRID,
            "silent": self.silent > MOST_SILENT,
            "loudness": abs(self.lufs_error) > MOST_LUFS,
            "true peak": self.true_peak > TRUE_PEAK_DB,
            "limiter": self.limited > 6.05,
            "crest": self.crest > MOST_CREST,
            "stems": (self.stem_error or -np.inf) > MOST_STEM_DB,
            "cost": self.share > MOST_SHARE,
        }
        return tuple(name for name, is_broken in checks.items() if is_broken)


def onsets(data: bytes) -> Iterator[list[int]]:
    """Yield the ticks of onsets as each of three readers finds them, sorted."""
    played: Any = symusic.Score.from_midi(data)
    yield sorted(note.time for track in played.tracks for note in track.notes)
    found = []
    for track in mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks:
        now = 0
        for message in track:
            now += message.time
            if message.type == "note_on" and message.velocity:
                found.append(now)
    yield sorted(found)
    file, found = music21.midi.MidiFile(), []
    file.readstr(data)
    for track in file.tracks:
        now = 0
        for event in track.events:
            if event.isDeltaTime():
                now += event.time
            elif event.isNoteOn() and event.velocity:
                found.append(now)
    yield sorted(found)


def off_frame(score: Score, path: Path) -> int:
    """Return the number of notes of events that are on no frame, over all rates and readers."""
    count = 0
    for rate in {*RATES, score.rate}:
        # Music is on its beats, not on frames.
        config = score.sound.model_copy(update={"music": None})
        film = replace(score, rate=rate, sound=config)
        write_midi(film, path)
        grid = tempo_plan(film).grid
        frames = {grid.tick(frame) for frame in range(1, film.frames + 1)}
        for ticks in onsets(path.read_bytes()):
            count += sum(tick not in frames for tick in ticks)
            # After bar 1 the ticks of frames are exact fractions of a second.
            count += sum(
                (grid.seconds(tick) * rate).denominator != 1
                for tick in set(ticks)
                if tick >= grid.bar_line
            )
    return count


def measure(score: Score, folder: Path) -> Laws:
    """Return what was measured of a score."""
    wrong = off_frame(score, folder / "rates.mid")
    report = write_midi(score, folder / "score.mid")
    data = (folder / "score.mid").read_bytes()
    quantised = score.sound.quantise is not None
    has_pulse = report.tempo.source == "events" or score.dance is not None or quantised
    notes = notes_of(score)
    heard = {note.event.who for note in notes}
    played = {each.part.key.performer for each in report.parts if each.notes}
    counts = Counter[tuple[int, int]]()
    for number, track in enumerate(mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks):
        counts.update((number, m.channel) for m in track if m.type == "program_change")
    read = sum(len(each.notes) for each in pretty_midi.PrettyMIDI(io.BytesIO(data)).instruments)
    began = time.process_time()
    track = write_wav(score, folder / "track.wav")
    spent = time.process_time() - began
    sound = read_samples(folder / "track.wav", 0, track.samples)
    blocks = sound[: len(sound) // 2400 * 2400].reshape(-1, 4800)
    level = np.sqrt((blocks**2).mean(axis=1))
    has_sound = np.isfinite(track.target)
    loudness = pyloudnorm.Meter(SAMPLE_RATE).integrated_loudness(sound) if has_sound else 0.0
    peak = max(float(np.abs(resample_poly(side, 8, 1)).max()) for side in sound.T)
    error = None
    if len({(note.event.who, note.event.cause) for note in notes}) <= MOST_STEMS:
        total = np.zeros_like(sound)
        stems = folder / "stems"
        stems.mkdir(exist_ok=True)
        for stem in write_stems(score, stems, track.gain, track.curve, track.music_gain):
            raw = stem.path.read_bytes()
            total += np.frombuffer(raw[raw.index(b"data") + 8 :], "<f4").reshape(-1, 2)
            stem.path.unlink()
        top = float(np.abs(sound).max())
        error = decibels(float(np.abs(total - sound).max()) / top) if top else None
    return Laws(
        notes=report.notes,
        off_frame=wrong,
        empty=len(heard - played),
        programs=sum(count > 1 for count in counts.values()),
        unread=abs(read - report.notes),
        on_grid=report.tempo.on_grid if has_pulse else None,
        silent=float(np.mean(level <= 1e-3)),
        lufs_error=loudness - track.target if has_sound else 0.0,
        true_peak=decibels(peak),
        limited=track.limited_db,
        crest=lost_crest(sound, track.curve, sorted({sample_at(note.onset) for note in notes})),
        stem_error=error,
        share=spent / float(score.frames / score.rate),
    )


def lost_crest(sound: Any, curve: Any, onsets: list[int]) -> float:
    """Return what a limiter takes from the crests of 49 of 50 sounds, at most [dB].

    Args:
        sound: (N, 2) track.
        curve: (N,) gain of the limiter; None without any.
        onsets: of the sounds [samples].
    """
    if curve is None:
        return 0.0
    lost = []
    for onset in onsets:
        part = slice(onset, onset + 2400)
        after = sound[part]
        if np.abs(after).max(initial=0.0) > 0:
            lost.append(crest(after / curve[part, None]) - crest(after))
    return float(np.quantile(lost, 0.98, method="lower")) if lost else 0.0


def crest(sound: Any) -> float:
    """Return the peak of a sound over its mean [dB]."""
    return decibels(float(np.abs(sound).max() / np.sqrt(np.mean(sound**2))))


def score_of(name: str) -> Score:
    """Return the score of a shipped scene."""
    scene = load_scene(library() / (name + SUFFIX))
    take = simulate(scene)
    return build_score(scene, take, ShotBuilder(scene, take).poses)[0]


def main() -> None:
    """Measure and print all scenes; say what does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*")
    names = parser.parse_args().scenes or shipped_scenes()
    head = "notes off_frame empty programs unread on_grid silent% LU_error true_peak limited crest"
    print(f"{'scene':22s} {head}  stems  cost%")
    broken = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            laws = measure(score_of(name), Path(folder))
            print_row(name, laws)
            if laws.broken:
                broken[name] = laws.broken
    print("does not hold:", broken or "nothing")


def print_row(name: str, laws: Laws) -> None:
    """Print what was measured of a scene."""
    grid = "-" if laws.on_grid is None else f"{laws.on_grid:.2f}"
    stems = "-" if laws.stem_error is None else f"{laws.stem_error:.0f}"
    print(
        f"{name:22s} {laws.notes:5d} {laws.off_frame:6d} {laws.empty:5d} {laws.programs:6d}"
        f" {laws.unread:6d} {grid:>8s} {100 * laws.silent:7.1f} {laws.lufs_error:8.2f}"
        f" {laws.true_peak:8.2f} {laws.limited:7.2f} {laws.crest:5.2f} {stems:>6s}"
        f" {100 * laws.share:6.1f}"
        f"  {', '.join(laws.broken)}",
        flush=True,
    )


if __name__ == "__main__":
    main()
