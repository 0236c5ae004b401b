"""Sound: how long a track takes, beside the time that it lasts and the voices that it has.

Each material's blows on soil and on stone, and each sound that lasts: time of synthesis as a share
of real time, for each voice that sounds at once. No two sounds are alike, so that none is kept
from an earlier one. A film's room and master come on top, by the second of film. Beside them
TinySoundFont and FluidSynth play the same notes with a General MIDI font, where they are
installed (`--font FILE` for another font).

    python benchmarks/sound.py
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from audio.acoustic_materials import FAMILIES
from audio.body_shape import BodyShape
from audio.cause_voices import CAUSE_VOICES
from audio.config.sound import Sound
from audio.midi_file import midi_bytes
from audio.notes import notes_of
from audio.score import Bearing, Score, ScoreEvent
from audio.soundfont import play_soundfont
from audio.synthesis import sound_parameters, synthesize
from audio.wav_file import write_wav

ALLOWED = 0.05
"""Share of real time that a voice may take."""

COUNT, SECONDS, SAMPLE_RATE = 48, 8, 48_000
COURSE = tuple(Bearing(abs(4 - i) + 1.0, i / 4 - 1, 8.0 - 2 * i) for i in range(9))
BRICK = BodyShape("box", 0.3, 0.15, 0.1)
SPEEDS = tuple(3.0 - abs(4 - i) / 2 for i in range(9))


def score_of(cause: str, material: str, surface: str, lasting: bool) -> Score:
    """Return a film of many sounds of one kind, all of sizes of their own."""
    frames = 24 * SECONDS
    words: dict[str, Any] = {"duration": 0.5, "speeds": SPEEDS, "course": COURSE} if lasting else {}
    events = [
        ScoreEvent(
            *(1 + i * (frames - 1) // COUNT, Fraction(0), cause, "one", f"part_{i}", "other"),
            *(material, surface, 3.0),
            size=0.05 + 0.002 * i,
            spot=i / COUNT,
            **words,
        )
        for i in range(COUNT)
    ]
    return Score(Fraction(24), frames, tuple(events), Sound())


def voices(score: Score) -> tuple[float, float]:
    """Return the time that synthesis takes, and how long all sounds last together [s]."""
    left = float(score.frames / score.rate)
    notes = notes_of(score)
    began = time.process_time()
    samples = [
        synthesize(sound_parameters(note, score.seed, 0, left)[0], score.seed).size
        for note in notes
    ]
    return time.process_time() - began, sum(samples) / SAMPLE_RATE


def measure(name: str, score: Score) -> float:
    """Print and return the share of real time that a voice takes."""
    runs = [voices(score) for _ in range(3)]
    lasts = runs[0][1]
    share = median(spent for spent, _ in runs) / lasts
    print(f"{name:28s} {100 * share:6.2f} % a voice; {lasts / COUNT:5.2f} s each")
    return share


def dense_tracks(folder: Path) -> None:
    """Print what a track takes by its impacts a second, each of a place and speed of its own."""
    for rate in (6, 25, 100):
        frames = 24 * SECONDS
        events = [
            ScoreEvent(
                1 + i * (frames - 1) // (rate * SECONDS),
                Fraction(0),
                "collision",
                "one",
                f"part_{i}",
                "other",
                "oak",
                "oak",
                0.2 * 1.07 ** (i % 50),
                size=0.3,
                spot=(i % 97) / 97,
                shape=BRICK,
                struck_shape=BRICK,
            )
            for i in range(rate * SECONDS)
        ]
        score = Score(Fraction(24), frames, tuple(events), Sound())
        began = time.process_time()
        write_wav(score, folder / "track.wav")
        spent = 100 * (time.process_time() - began) / SECONDS
        print(f"{rate:4d} impacts a second {spent:24.2f} % of real time")


def whole_track(folder: Path) -> None:
    """Print what a film's track takes besides its voices."""
    dry = Sound.model_validate({"room": "dry", "master": "off"})
    for name, sound in (("dry, no master", dry), ("open room, mastered", Sound())):
        film = score_of("footfall", "chitin", "dry soil", lasting=False)
        score = Score(film.rate, film.frames, film.events, sound)
        began = time.process_time()
        write_wav(score, folder / "track.wav")
        spent = time.process_time() - began
        print(f"whole track, {name:22s} {100 * spent / SECONDS:6.2f} % of real time")


def beside(folder: Path, font: Path | None) -> None:
    """Print what players of SoundFonts take for the same notes, where there are any."""
    score = score_of("collision", "wood", "stone", lasting=False)
    lasts = sum(note.seconds for note in notes_of(score))
    if font is None:
        print("TinySoundFont, FluidSynth: no General MIDI font found; name one with --font")
        return
    if importlib.util.find_spec("tinysoundfont") is None:
        print("TinySoundFont: not installed (pip install --no-deps tinysoundfont)")
    else:
        _told(
            "TinySoundFont", lambda: play_soundfont(score, font, SECONDS * SAMPLE_RATE), lasts, font
        )
    fluidsynth = shutil.which("fluidsynth")
    if fluidsynth is None:
        print("FluidSynth: not installed")
        return
    midi, wav = folder / "notes.mid", folder / "notes.wav"
    midi.write_bytes(midi_bytes(score))
    command = [
        fluidsynth,
        "-ni",
        "-q",
        "-r",
        str(SAMPLE_RATE),
        "-F",
        str(wav),
        str(font),
        str(midi),
    ]
    _told("FluidSynth", lambda: subprocess.run(command, check=True), lasts, font)


def _told(name: str, play: Callable[[], object], lasts: float, font: Path) -> None:
    began = time.perf_counter()
    play()
    spent = time.perf_counter() - began
    print(f"{name:28s} {100 * spent / lasts:6.2f} % a voice, the font's loading too ({font.name})")


def general_midi() -> Path | None:
    """Return a General MIDI font of this machine, None if none is found."""
    spec = importlib.util.find_spec("pretty_midi")
    folders = [Path(spec.origin).parent] if spec and spec.origin else []
    folders += [Path("/usr/share/sounds/sf2"), Path("/usr/share/soundfonts")]
    return next((font for folder in folders for font in sorted(folder.glob("*.sf2"))), None)


def main() -> None:
    """Measure and print all; say which voices take more than they may."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--font", type=Path, default=general_midi())
    font = parser.parse_args().font
    # What is done once is no part of any material's time.
    voices(score_of("collision", "wood", "stone", lasting=False))
    shares = {}
    for material in FAMILIES:
        for surface in ("dry soil", "stone"):
            name = f"{material} on {surface}"
            shares[name] = measure(name, score_of("collision", material, surface, lasting=False))
    for cause in (*CAUSE_VOICES, *CAUSE_VOICES):
        shares[cause] = measure(cause, score_of(cause, "wood", "stone", lasting=True))
    with tempfile.TemporaryDirectory() as folder:
        whole_track(Path(folder))
        dense_tracks(Path(folder))
        beside(Path(folder), font)
    slow = [name for name, share in shares.items() if share > ALLOWED]
    top = max(shares, key=shares.__getitem__)
    print(
        f"mean {100 * np.mean(list(shares.values())):.2f} %, most {100 * shares[top]:.2f} % ({top})"
    )
    print(f"over {100 * ALLOWED:.0f} %: {', '.join(slow) or 'none'}")


if __name__ == "__main__":
    main()
