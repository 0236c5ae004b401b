"""Joined sound: stretches of WAV files, one after the other or faded into each other."""

from __future__ import annotations

import wave
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from audio.dsp import Signal
from audio.errors import SoundFileError
from audio.mastering import FULL_SCALE
from audio.sound_files import write_sound_file
from audio.wav_file import read_samples, wav_bytes


@dataclass(frozen=True, slots=True)
class SoundPiece:
    """A stretch of a WAV file in a longer sound.

    Attributes:
        path: of the file.
        first: its first sample in the file.
        count: number of its samples.
        at: samples before it in the whole.
        rise: samples over which it comes up from silence, along a line.
        fall: samples over which it goes down.
    """

    path: Path
    first: int
    count: int
    at: int
    rise: int = 0
    fall: int = 0

    @property
    def gain(self) -> Signal:
        """Its gain at each sample, (count,).

        Two that go over into each other add up to 1, so that no sum is louder than its parts.
        """
        k = np.arange(self.count) + 0.5
        return np.minimum(
            np.minimum(k / max(self.rise, 1e-9), (self.count - k) / max(self.fall, 1e-9)), 1.0
        )


def write_joined_sound(path: Path, pieces: Sequence[SoundPiece], samples: int) -> bool:
    """Write pieces as one WAV file; return whether it was written, False if it is there already.

    Args:
        path: of the file; an earlier one stays on failure.
        pieces: at their places; where they overlap they are added.
        samples: of the whole.

    Raises:
        SoundFileError: a piece cannot be read, or the file cannot be written.
    """
    whole = np.zeros((samples, 2))
    for piece in pieces:
        try:
            sound = read_samples(piece.path, piece.first, piece.count)
        except (OSError, EOFError, wave.Error) as error:
            raise SoundFileError(f"{piece.path}: cannot be read as a WAV file ({error})") from error
        end = min(piece.at + len(sound), samples)
        part = sound[: end - piece.at]
        whole[piece.at : end] += part * piece.gain[: len(part), None]
    scaled = np.clip(np.round(whole * FULL_SCALE), -FULL_SCALE, FULL_SCALE).astype(np.int32)
    return write_sound_file(path, wav_bytes(scaled))
