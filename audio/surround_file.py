"""Surround file: a score as a track of more than two channels, beside the stereo track.

The same events with the same gain, each from its own direction, in the room and the ambience
around; a limiter keeps all channels together below the ceiling.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from audio.ambience import ambient_sound
from audio.buses import ducked
from audio.dsp import Signal
from audio.layouts import LAYOUTS, Layout
from audio.mastering import FULL_SCALE, ceiling_of, limiting_gain
from audio.notes import notes_of
from audio.score import Score
from audio.sound_files import write_sound_file
from audio.time_grid import SAMPLE_RATE, sample_of_frame
from audio.wav_file import WavReport, ambience_target, mix_notes, packed_samples

_EXTENSIBLE, _BITS, _BYTES = 0xFFFE, 24, 3
# The identifier of integer samples in a file of this form.
_PCM = bytes.fromhex("0100000000001000800000aa00389b71")


def write_surround(score: Score, path: Path, layout: str, track: WavReport) -> bool:
    """Write a score in a layout; return whether it was written, False if it is there already.

    Args:
        score: that has no SoundFont.
        path: of the WAV file; an earlier one stays on failure.
        layout: its name.
        track: the stereo track, whose gain it has.

    Raises:
        ScoreError: an event lies outside the score.
        SoundFileError: the file could not be written.
    """
    channels, samples = LAYOUTS[layout], sample_of_frame(score.frames + 1, score.rate)
    notes = notes_of(score)
    mix = mix_notes(score, notes, samples, channels, track.music_gain)
    mix *= 10 ** (track.gain_db / 20)
    if score.ambience is not None:
        mix += _bed(score, channels, samples) * ducked(score.sound.mix, notes, samples)
    curve = limiting_gain(mix, ceiling_of(score.sound.master))
    mix = mix if curve is None else mix * curve[:, None]
    return write_sound_file(path, _wav_bytes(mix, channels))


def _bed(score: Score, layout: Layout, samples: int) -> Signal:
    """Return the ambience all around: stereo beds, each from the sides of its own: (N, C)."""
    assert score.ambience is not None
    whole = np.zeros((samples, len(layout.channels)))
    for number, sides in enumerate(layout.bed):
        bed = ambient_sound(
            score.ambience, samples, score.seed + 7919 * number, ambience_target(score)
        )
        for side, azimuth in enumerate(sides):
            whole += bed[:, side : side + 1] * layout.gains(azimuth)
    return np.asarray(whole / np.sqrt(len(layout.bed)))


def _wav_bytes(mix: Signal, layout: Layout) -> bytes:
    """Return a WAV file with the places of its channels.

    Source: Microsoft 2007, multiple channel audio data and WAVE files.
    """
    count = len(layout.channels)
    data = packed_samples(np.rint(mix * FULL_SCALE).astype(np.int32))
    form = struct.pack(
        "<HHIIHHHHI",
        *(_EXTENSIBLE, count, SAMPLE_RATE, SAMPLE_RATE * count * _BYTES, count * _BYTES, _BITS),
        *(22, _BITS, layout.mask),
    )
    chunks = [(b"fmt ", form + _PCM), (b"data", data + b"\0" * (len(data) % 2))]
    body = b"".join(name + struct.pack("<I", len(content)) + content for name, content in chunks)
    return b"RIFF" + struct.pack("<I", 4 + len(body)) + b"WAVE" + body
