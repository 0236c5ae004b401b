"""Score -> WAV: every event heard in its room, exact to the sample, and mastered."""

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
from audio.courses import gains_of
from audio.errors import ScoreError
from audio.files import put
from audio.grid import SAMPLE_RATE, sample_at, sample_of
from audio.mastering import FULL, decibels, mastered
from audio.mixing import Gain, add, faded, sides
from audio.rooms import Space, acoustics_of
from audio.score import Score
from audio.soundfont import played
from audio.voices import Note, notes_of

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
        lufs: integrated loudness [LUFS]; -inf for silence.
        true_peak_db: largest magnitude, between samples too [dB]; -inf for silence.
        gain_db: by which the mix was raised or lowered [dB].
        limited_db: the most that loud places were lowered by after that [dB].
    """

    path: Path
    changed: bool
    samples: int
    events: int
    muted: int
    peak_db: float
    rms_db: float
    lufs: float
    true_peak_db: float
    gain_db: float
    limited_db: float


def write_wav(score: Score, path: Path) -> WavReport:
    """Write a score as sound; an equal file is left alone, and on failure the earlier one stays.

    48 kHz, two sides, 24 bits; as long as the film to the nearest sample.

    Raises:
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
        SoundFontError: the SoundFont that shall play the score cannot be played.
    """
    path = Path(path)
    notes = notes_of(score)
    if score.sound.soundfont is None:
        mix = _mixed(score, notes)
    else:
        mix = played(score, Path(score.sound.soundfont), _samples_of(score))
    done = mastered(mix, score.sound.master, score.sound.volume_db)
    changed = put(path, _wav(done.samples))
    peak = int(np.abs(done.samples).max(initial=0))
    power = np.sum((done.samples / FULL) ** 2) / max(done.samples.size, 1)
    return WavReport(
        path=path,
        changed=changed,
        samples=done.samples.shape[0],
        events=sum(note.opens for note in notes),
        muted=len(score.events) - sum(note.opens for note in notes),
        peak_db=decibels(peak / FULL),
        rms_db=decibels(float(np.sqrt(power))),
        lufs=done.lufs,
        true_peak_db=done.true_peak_db,
        gain_db=done.gain_db,
        limited_db=done.limited_db,
    )


def _samples_of(score: Score) -> int:
    samples = sample_of(score.frames + 1, score.rate)
    if samples > _MAX_SAMPLES:
        hours = _MAX_SAMPLES / SAMPLE_RATE / 3600
        raise ScoreError(f"{samples} samples; a WAV file of this kind holds {hours:.1f} hours")
    return samples


def _mixed(score: Score, notes: tuple[Note, ...]) -> Signal:
    """Return all that is heard, before the master: (N, 2)."""
    samples = _samples_of(score)
    stereo = np.zeros((samples, 2))
    space = Space(acoustics_of(score.sound.room), samples)
    kept: OrderedDict[Blow, Signal] = OrderedDict()
    seen: dict[tuple[object, ...], int] = {}
    for note in notes:
        event = note.event
        happened = (event.frame, event.time, event.cause, event.who, event.part, event.other)
        seen[happened] = seen.get(happened, -1) + 1
        left = float(score.frames / score.rate - note.onset)
        blow, trim_db = blow_of(note, score.seed, seen[happened], left)
        gain = 10 ** ((note.level + trim_db) / 20)
        sound, start = _kept_or_sounded(kept, blow, score.seed), sample_at(note.onset)
        add(stereo, start, sound, _gains(note, gain, sound.size))
        space.hear(event, start, sound, gain, note.send)
    space.add_to(stereo)
    tail = samples - sample_of(score.frames, score.rate)
    faded(stereo, min(int(_END_FADE * SAMPLE_RATE), tail // 2))
    return stereo


def _gains(note: Note, gain: float, samples: int) -> tuple[Gain, Gain]:
    """Return the gains of left and right; of what moves, at each sample."""
    event = note.event
    if len(event.course) < 2:
        to_left, to_right = sides(note.side)
        return gain * to_left, gain * to_right
    left, right = gains_of(event.course, event.distance, event.duration, samples, note.pan)
    return gain * left, gain * right


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
