"""Score -> WAV: every event synthesised to the sample, mixed in its room and mastered."""

from __future__ import annotations

import io
import wave
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from audio.ambience import USUAL_LUFS, ambient_sound
from audio.buses import bus_gain_db, ducked
from audio.dsp import Gain, Signal, decibels, fade_out, mix_in, pan_gains, silence
from audio.errors import ScoreError, SoundFileError
from audio.layouts import STEREO, Layout
from audio.mastering import FULL_SCALE, master_mix
from audio.music_mix import mix_music, music_gain
from audio.notes import Note, notes_of
from audio.room_acoustics import Reverberator, room_acoustics
from audio.score import Score
from audio.sound_files import write_sound_file
from audio.soundfont import play_soundfont
from audio.source_motion import moving_gains, surrounding_gains
from audio.synthesis import SOUNDS, sound_parameters
from audio.time_grid import SAMPLE_RATE, sample_at, sample_of_frame

_CHANNELS, _SAMPLE_BYTES = 2, 3
# Sizes in a WAV file have 32 bits.
_MAX_SAMPLES = (2**32 - 1024) // (_CHANNELS * _SAMPLE_BYTES)
# Longest fade at the end [s]; never longer than half the last frame.
_END_FADE = 0.004
# 24 bits in the upper bytes of 32.
_FULL_SCALE_32 = 2.0**31
# Samples read at once.
_READ_CHUNK = 2**20


@dataclass(frozen=True, slots=True)
class WavReport:
    """Measurements of a WAV file.

    Attributes:
        path: of the file.
        changed: whether the file was written; False if it held these bytes already.
        samples: of each side; exactly the film's length.
        events: number of events that sound.
        muted: number of muted events.
        peak_db: largest sample [dBFS]; -inf for silence.
        rms_db: root mean square over both sides and the whole length [dBFS]; -inf for silence.
        lufs: integrated loudness [LUFS]; -inf for silence.
        true_peak_db: largest magnitude, between samples too [dB]; -inf for silence.
        gain_db: of the whole mix [dB].
        limited_db: reduction of the highest peak after that gain [dB].
        target: loudness that was aimed at [LUFS]; see `Mastered`.
        curve: gain of the limiter (N,), None where it had nothing to do.
        music: number of notes of the music.
        music_gain: of the music before that of the master, as a factor.
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
    target: float = -np.inf
    curve: Signal | None = None
    music: int = 0
    music_gain: float = 1.0

    @property
    def gain(self) -> Gain:
        """Factor of the master on the mix, at each sample (N, 1) where its limiter works."""
        factor = 10 ** (self.gain_db / 20)
        return factor if self.curve is None else factor * self.curve[:, None]


def write_wav(score: Score, path: Path) -> WavReport:
    """Write a score as sound; an equal file is left alone, and on failure the earlier one stays.

    48 kHz, two sides, 24 bits; as long as the film to the nearest sample.

    Raises:
        ScoreError: an event lies outside the score, or the score is too long for the format.
        SoundFileError: the file could not be written.
        SoundFontError: the configured SoundFont cannot be played.
    """
    path = Path(path)
    notes = notes_of(score)
    samples = sample_of_frame(score.frames + 1, score.rate)
    if samples > _MAX_SAMPLES:
        hours = _MAX_SAMPLES / SAMPLE_RATE / 3600
        raise ScoreError(f"{samples} samples; a WAV file of this kind holds {hours:.1f} hours")
    music = 1.0
    if score.sound.soundfont is None:
        mix, music = mix_score(score, notes, samples)
    else:
        mix = play_soundfont(score, Path(score.sound.soundfont), samples)
    bed = ambience_of(score, notes, samples)
    track = master_mix(mix, score.sound.master, score.sound.volume_db, bed)
    changed = write_sound_file(path, wav_bytes(track.samples))
    peak = int(np.abs(track.samples).max(initial=0))
    power = np.sum((track.samples / FULL_SCALE) ** 2) / max(track.samples.size, 1)
    events = sum(note.is_first for note in notes)
    return WavReport(
        path=path,
        changed=changed,
        samples=track.samples.shape[0],
        events=events,
        music_gain=music,
        music=len(notes) - sum(not note.is_music for note in notes),
        muted=len(score.events) - events,
        peak_db=decibels(peak / FULL_SCALE),
        rms_db=decibels(float(np.sqrt(power))),
        lufs=track.lufs,
        true_peak_db=track.true_peak_db,
        gain_db=track.gain_db,
        limited_db=track.limited_db,
        target=track.target,
        curve=track.curve,
    )


def ambience_of(score: Score, notes: Sequence[Note], samples: int) -> Signal | None:
    """Return the ambient sound of a score, (N, 2), None for silence."""
    if score.ambience is None:
        return None
    bed = ambient_sound(score.ambience, samples, score.seed, ambience_target(score))
    return bed * ducked(score.sound.mix, notes, samples)


def ambience_target(score: Score) -> float:
    """Return the loudness of a track beside which the ambience of a score has its own [LUFS]."""
    sound = score.sound
    target = USUAL_LUFS if sound.master is None else sound.master.lufs
    return target + sound.volume_db


def mix_score(score: Score, notes: Sequence[Note], samples: int) -> tuple[Signal, float]:
    """Return the mix of a score in stereo, and the gain that its music has in it, as a factor."""
    played = [note for note in notes if note.is_music]
    mix = mix_notes(score, [note for note in notes if not note.is_music], samples)
    if not played:
        return mix, 1.0
    music = mix_notes(score, played, samples, heard=notes)
    gain = music_gain(score.sound, mix, music)
    mix += gain * music
    return mix, gain


def mix_notes(
    score: Score,
    notes: Sequence[Note],
    samples: int,
    layout: Layout = STEREO,
    music: float = 1.0,
    heard: Sequence[Note] | None = None,
) -> Signal:
    """Return the sounds of notes in their room, before mastering: (N, C).

    Args:
        score: the score.
        notes: that are mixed.
        samples: of the film.
        layout: of the channels.
        music: gain of the music, as a factor.
        heard: all notes of the score, to whose voices the music gives way; `notes` by default.
    """
    mix = silence(samples, len(layout.channels))
    reverberator = Reverberator(room_acoustics(score.sound.room), samples, layout)
    occurrences = Counter[tuple[object, ...]]()
    end = float(score.frames / score.rate)
    for note in notes:
        if note.is_music:
            continue
        remaining = end - float(note.onset)
        occurrence = occurrences[note.event.key]
        occurrences[note.event.key] += 1
        parameters, jitter_db = sound_parameters(note, score.seed, occurrence, remaining)
        level = note.level + jitter_db + bus_gain_db(score.sound.mix, note.event.cause)
        gain = 10 ** (level / 20)
        sound, start = SOUNDS.sound(parameters, score.seed), sample_at(note.onset)
        mix_in(mix, start, sound, _gains(note, gain, sound.size, layout))
        reverberator.feed(note.event, start, sound, gain, note.send)
    reverberator.add_to(mix)
    mix_music(mix, score.sound, notes, notes if heard is None else heard, music, layout)
    last_frame = samples - sample_of_frame(score.frames, score.rate)
    fade_out(mix, min(int(_END_FADE * SAMPLE_RATE), last_frame // 2))
    return mix


def _gains(note: Note, gain: float, samples: int, layout: Layout) -> tuple[Gain, ...]:
    """Return the gains of the channels; of a moving source, at each sample."""
    event = note.event
    moves = len(event.course) >= 2
    if layout is STEREO:
        if not moves:
            left, right = pan_gains(note.effective_pan)
            return gain * left, gain * right
        sides = moving_gains(event.course, event.distance, event.duration, samples, note.pan)
        return tuple(gain * side for side in sides)
    if note.pan is not None or not moves:
        azimuth = event.azimuth if note.pan is None else float(np.arcsin(note.pan))
        return tuple(gain * level for level in layout.gains(azimuth))
    around = surrounding_gains(
        *(event.course, event.distance, event.duration, samples, layout.gains)
    )
    return tuple(gain * channel for channel in around)


def wav_bytes(samples: NDArray[np.int32]) -> bytes:
    """Return the file of samples: (N, 2) integers of 24 bits."""
    out = io.BytesIO()
    with wave.open(out, "wb") as file:
        file.setnchannels(_CHANNELS)
        file.setsampwidth(_SAMPLE_BYTES)
        file.setframerate(SAMPLE_RATE)
        file.writeframes(packed_samples(samples))
    return out.getvalue()


def packed_samples(samples: NDArray[np.int32]) -> bytes:
    """Return integers of 24 bits (N, C) as a WAV file holds them."""
    # The low three bytes of each little-endian integer.
    return np.ascontiguousarray(samples, "<i4").view(np.uint8).reshape(-1, 4)[:, :3].tobytes()


def read_waveform(path: Path, columns: int) -> Signal:
    """Return the least and the greatest sample of each side in equal stretches of time.

    Args:
        path: a WAV file as `write_wav` writes it.
        columns: number of stretches.

    Returns:
        (columns, 2, 2) least and greatest of left and right, -1 to 1.

    Raises:
        SoundFileError: the file cannot be read, or has another format.
    """
    try:
        with wave.open(str(path), "rb") as file:
            if (file.getsampwidth(), file.getnchannels()) != (_SAMPLE_BYTES, _CHANNELS):
                raise SoundFileError(f"{path}: is no WAV file of 24 bits and two sides")
            return _extrema(file, columns)
    except (OSError, EOFError, wave.Error) as error:
        raise SoundFileError(f"{path}: cannot be read as a WAV file ({error})") from error


def read_samples(path: Path, first: int, count: int) -> Signal:
    """Return samples of a WAV file as `write_wav` writes it: (up to count, 2), -1 to 1.

    Raises:
        OSError, EOFError, wave.Error: it cannot be read.
    """
    with wave.open(str(path), "rb") as file:
        if (file.getsampwidth(), file.getnchannels()) != (_SAMPLE_BYTES, _CHANNELS):
            raise wave.Error("not of 24 bits and two sides")
        file.setpos(min(first, file.getnframes()))
        return _decode(file.readframes(count))


def _extrema(file: wave.Wave_read, columns: int) -> Signal:
    samples = file.getnframes()
    extrema = np.zeros((columns, 2, 2))
    edges = np.linspace(0, samples, columns + 1).round().astype(np.int64)
    column = 0
    # Read in parts: a film of hours has gigabytes of sound.
    columns_per_part = max(int(_READ_CHUNK * columns / max(samples, 1)), 1)
    while column < columns:
        last = min(column + columns_per_part, columns)
        sound = _decode(file.readframes(int(edges[last] - edges[column])))
        for k in range(column, last):
            part = sound[edges[k] - edges[column] : edges[k + 1] - edges[column]]
            if len(part):
                extrema[k, :, 0], extrema[k, :, 1] = part.min(axis=0), part.max(axis=0)
        column = last
    return extrema


def _decode(data: bytes) -> Signal:
    """Return 24-bit samples as numbers from -1 to 1: (N, 2)."""
    low = np.frombuffer(data, np.uint8).reshape(-1, _SAMPLE_BYTES)
    words = np.zeros((len(low), 4), np.uint8)
    # In the upper three bytes of 32 bits they keep their sign.
    words[:, 1:] = low
    return words.view("<i4").reshape(-1, 2) / _FULL_SCALE_32
