"""Waveform: the outline of a sound file, as editing programs draw it."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np

from audio.banks import Signal
from audio.errors import SoundFileError

_FULL = 2.0**31
_AT_ONCE = 2**20


def outline(path: Path, columns: int) -> Signal:
    """Return the least and the greatest sample of each side in equal stretches of time.

    Args:
        path: a WAV file of 24 bits and two sides, as `write_wav` writes it.
        columns: how many stretches.

    Returns:
        (columns, 2, 2) least and greatest of left and right, -1 to 1.

    Raises:
        SoundFileError: the file cannot be read, or is of another kind.
    """
    try:
        with wave.open(str(path), "rb") as file:
            if (file.getsampwidth(), file.getnchannels()) != (3, 2):
                raise SoundFileError(f"{path}: is no WAV file of 24 bits and two sides")
            return _outlined(file, columns)
    except (OSError, EOFError, wave.Error) as error:
        raise SoundFileError(f"{path}: cannot be read as a WAV file ({error})") from error


def _outlined(file: wave.Wave_read, columns: int) -> Signal:
    samples = file.getnframes()
    found = np.zeros((columns, 2, 2))
    edges = np.linspace(0, samples, columns + 1).round().astype(np.int64)
    column = 0
    # A film of hours has gigabytes of sound; some columns at a time stay small.
    each = max(int(_AT_ONCE * columns / max(samples, 1)), 1)
    while column < columns:
        last = min(column + each, columns)
        data = file.readframes(int(edges[last] - edges[column]))
        sound = _decoded(data)
        for k in range(column, last):
            piece = sound[edges[k] - edges[column] : edges[k + 1] - edges[column]]
            if len(piece):
                found[k, :, 0], found[k, :, 1] = piece.min(axis=0), piece.max(axis=0)
        column = last
    return found


def _decoded(data: bytes) -> Signal:
    """Return samples (N, 2) of 24 bits as numbers, -1 to 1."""
    low = np.frombuffer(data, np.uint8).reshape(-1, 3)
    whole = np.zeros((len(low), 4), np.uint8)
    # As the upper three bytes of 32 they keep their sign.
    whole[:, 1:] = low
    return whole.view("<i4").reshape(-1, 2) / _FULL
