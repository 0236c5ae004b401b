"""Stems: the sound of each performer and cause as a WAV file of its own.

All stems have the gain of the master and of its limiter, so their sum is the track. They are 32-bit
floats, which do not clip.
"""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from audio.dsp import Gain, Signal
from audio.errors import ScoreError
from audio.names import file_stems
from audio.notes import Note, notes_of
from audio.score import Score
from audio.sound_files import write_sound_file
from audio.time_grid import SAMPLE_RATE, sample_of_frame
from audio.wav_file import ambience_of, mix_notes

AMBIENCE = "ambience"
"""Name of the stem of the ambient sound."""

_FLOAT_FORMAT = 3
_FRAME_BYTES = 8


@dataclass(frozen=True, slots=True)
class Stem:
    """A file with the sounds of one performer and cause.

    Attributes:
        performer: who sounds.
        cause: of the sounds.
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
    """

    performer: str
    cause: str
    path: Path
    changed: bool


def write_stems(
    score: Score, folder: Path, gain: Gain, curve: Signal | None = None, music: float = 1.0
) -> Iterator[Stem]:
    """Write the stems of a score, and yield each, by performer and cause.

    Args:
        score: the score; a SoundFont of it is not used.
        folder: that exists.
        gain: of the master, as a factor, at each sample (N, 1) where its limiter works.
        curve: of the limiter alone (N,), which works on the ambience, too; None without any.
        music: gain of the music before that of the master, as a factor.

    Raises:
        ScoreError: an event lies outside the score, or a SoundFont plays it.
        SoundFileError: a file could not be written.
    """
    if score.sound.soundfont is not None:
        raise ScoreError("a SoundFont plays the score as a whole; remove soundfont to write stems")
    samples = sample_of_frame(score.frames + 1, score.rate)
    groups: dict[tuple[str, str], list[Note]] = defaultdict(list)
    all_notes = notes_of(score)
    for note in all_notes:
        groups[note.event.who, note.event.cause].append(note)
    names = file_stems(sorted({performer for performer, _ in groups}))
    for (performer, cause), notes in sorted(groups.items(), key=lambda item: item[0]):
        mix = mix_notes(score, notes, samples, music=music, heard=all_notes) * gain
        path = folder / f"{names[performer]}_{cause}.wav"
        yield Stem(performer, cause, path, write_sound_file(path, float_wav_bytes(mix)))
    bed = ambience_of(score, all_notes, samples)
    if bed is not None:
        bed = bed if curve is None else bed * curve[:, None]
        path = folder / f"{AMBIENCE}.wav"
        yield Stem("", AMBIENCE, path, write_sound_file(path, float_wav_bytes(bed)))


def float_wav_bytes(samples: Signal) -> bytes:
    """Return the WAV file of samples: (N, 2) floats, 1 being full scale.

    Source: IBM and Microsoft 1991, with the format tag of IEEE floats and its chunk `fact`.
    """
    data = samples.astype("<f4").tobytes()
    rate = SAMPLE_RATE
    form = struct.pack("<HHIIHHH", _FLOAT_FORMAT, 2, rate, rate * _FRAME_BYTES, _FRAME_BYTES, 32, 0)
    chunks = [(b"fmt ", form), (b"fact", struct.pack("<I", np.shape(samples)[0])), (b"data", data)]
    body = b"".join(name + struct.pack("<I", len(content)) + content for name, content in chunks)
    return b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WAVE" + body
