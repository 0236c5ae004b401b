"""Score -> WAV: every event struck on a bank of modes, exact to the sample."""

from __future__ import annotations

import io
import wave
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from audio.banks import Signal
from audio.blows import Blow, blow_of, sounded
from audio.errors import ScoreError
from audio.files import put
from audio.grid import SAMPLE_RATE, sample_at, sample_of
from audio.mixing import add, faded, limited, sides
from audio.score import Score
from audio.voices import Note, notes_of

_FULL = 2**23 - 1
_BYTES_A_SAMPLE = 6
# Sizes in a WAV file have 32 bits.
_MAX_SAMPLES = (2**32 - 1024) // _BYTES_A_SAMPLE
# Sounds kept for blows to come; a scene has some dozens.
_KEPT = 512
# At most so much is faded at the end, and never more than the last frame.
_END_FADE = 0.004


@dataclass(frozen=True, slots=True)
class WavReport:
    """What a WAV file holds.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        samples: of each side; exactly the film's length.
        events: that sound.
        muted: events that the author silenced.
        peak_db: largest sample [dBFS]; -inf for silence.
        rms_db: root mean square over both sides and the whole length [dBFS]; -inf for silence.
        limited_db: the most that loud places were lowered by [dB].
    """

    path: Path
    changed: bool
    samples: int
    events: int
    muted: int
    peak_db: float
    rms_db: float
    limited_db: float


def write_wav(score: Score, path: Path) -> WavReport:
    """Write a score as sound; an equal file is left alone, and on failure the earlier one stays.

    48 kHz, two sides, 24 bits; as long as the film to the nearest sample.

    Raises:
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
    """
    path = Path(path)
    notes = notes_of(score)
    stereo, limited_db = _mixed(score, notes)
    whole = np.rint(stereo * _FULL).astype("<i4")
    changed = put(path, _wav(whole))
    peak = int(np.abs(whole).max(initial=0))
    rms = float(np.sqrt(np.sum(stereo**2) / max(stereo.size, 1)))
    return WavReport(
        path=path,
        changed=changed,
        samples=whole.shape[0],
        events=sum(note.opens for note in notes),
        muted=len(score.events) - sum(note.opens for note in notes),
        peak_db=_decibels(peak / _FULL),
        rms_db=_decibels(rms),
        limited_db=limited_db,
    )


def _decibels(level: float) -> float:
    return float(20 * np.log10(level)) if level > 0 else -np.inf


def _mixed(score: Score, notes: tuple[Note, ...]) -> tuple[Signal, float]:
    samples = sample_of(score.frames + 1, score.rate)
    if samples > _MAX_SAMPLES:
        hours = _MAX_SAMPLES / SAMPLE_RATE / 3600
        raise ScoreError(f"{samples} samples; a WAV file of this kind holds {hours:.1f} hours")
    stereo = np.zeros((samples, 2))
    kept: OrderedDict[Blow, Signal] = OrderedDict()
    seen: dict[tuple[object, ...], int] = {}
    for note in notes:
        event = note.event
        happened = (event.frame, event.time, event.cause, event.who, event.part, event.other)
        seen[happened] = seen.get(happened, -1) + 1
        left = float(score.frames / score.rate - note.onset)
        blow, trim_db = blow_of(note, score.seed, seen[happened], left)
        gain = 10 ** ((note.level + trim_db) / 20)
        to_left, to_right = sides(note.side)
        add(
            stereo,
            sample_at(note.onset),
            _kept_or_sounded(kept, blow, score.seed),
            (gain * to_left, gain * to_right),
        )
    tail = samples - sample_of(score.frames, score.rate)
    faded(stereo, min(int(_END_FADE * SAMPLE_RATE), tail // 2))
    return limited(stereo)


def _kept_or_sounded(kept: OrderedDict[Blow, Signal], blow: Blow, seed: int) -> Signal:
    if blow not in kept:
        kept[blow] = sounded(blow, seed)
        if len(kept) > _KEPT:
            kept.popitem(last=False)
    kept.move_to_end(blow)
    return kept[blow]


def _wav(whole: NDArray[np.int32]) -> bytes:
    """Return the file of samples: (N, 2) integers of 24 bits."""
    out = io.BytesIO()
    with wave.open(out, "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(3)
        file.setframerate(SAMPLE_RATE)
        # The low three bytes of each little-endian integer.
        file.writeframes(whole.astype("<i4").view(np.uint8).reshape(-1, 4)[:, :3].tobytes())
    return out.getvalue()
