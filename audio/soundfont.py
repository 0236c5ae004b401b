"""SoundFont playback of a score: the messages of its MIDI file through tinysoundfont.

tinysoundfont is an optional dependency. It plays in a child process, because a damaged SoundFont
can crash it.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import mido
import numpy as np

from audio.dsp import Signal
from audio.errors import SoundFontError, SoundFontPlayerError
from audio.midi_file import midi_bytes
from audio.score import Score
from audio.soundfont_reader import FRAME_BYTES
from audio.tempo_plan import tempo_plan
from audio.time_grid import SAMPLE_RATE, sample_at
from pipeline.foreign_files.reader_process import (
    ReaderMissing,
    ReaderProcessError,
    Reading,
    read_confined,
)
from pipeline.foreign_files.safe_file import SOUNDFONT, ForeignFileError, require_file
from pipeline.foreign_files.verdict_store import confirm

# The file itself, its samples as floats, and what the voices and the sound take.
_MEMORY, _MEMORY_PER_BYTE = 512 * 2**20, 4
# Processor time for loading and rehearsing a font, and per second of sound [s].
_LOADING_TIME, _TIME_PER_SECOND = 60.0, 20.0


def play_soundfont(score: Score, font: Path, samples: int) -> Signal:
    """Return the score as played by a SoundFont, each message on its sample: (samples, 2).

    Raises:
        SoundFontError: the file is missing, is no SoundFont, or cannot be played.
        SoundFontPlayerError: tinysoundfont is not installed or cannot be started.
    """
    stereo = np.zeros(2 * samples)
    filled = 0

    def receive(part: bytes) -> None:
        nonlocal filled
        values = np.frombuffer(part, np.float32)
        stereo[filled : filled + values.size] = values
        filled += values.size

    settings = {
        "messages": list(_messages(score)),
        "samples": samples,
        "sample_rate": SAMPLE_RATE,
    }
    seconds = _LOADING_TIME + _TIME_PER_SECOND * samples / SAMPLE_RATE
    try:
        read_confined(_reading("play", font, seconds, settings, samples * FRAME_BYTES), receive)
    except ForeignFileError as error:
        raise SoundFontError(f"{font}: {error}") from error
    except ReaderMissing as error:
        raise SoundFontPlayerError(f"{font}: {_not_installed(error)}") from error
    except ReaderProcessError as error:
        raise SoundFontPlayerError(str(error)) from error
    if not np.isfinite(stereo).all():
        raise SoundFontError(f"{font}: is a damaged SoundFont (it sounds infinitely loud)")
    return stereo.reshape(-1, 2)


def soundfont_fault(font: Path) -> str | None:
    """Return the error of a SoundFont file, None if every program of it can be played.

    Raises:
        SoundFontPlayerError: tinysoundfont is not installed or cannot be started.
    """
    reading = _reading("rehearse", font, _LOADING_TIME, {"sample_rate": SAMPLE_RATE})
    try:
        require_file(font, SOUNDFONT)
        confirm(reading, SOUNDFONT, ("tinysoundfont",))
    except ForeignFileError as error:
        return str(error)
    except ReaderMissing as error:
        raise SoundFontPlayerError(_not_installed(error)) from error
    except ReaderProcessError as error:
        raise SoundFontPlayerError(str(error)) from error
    return None


def _reading(
    function: str, font: Path, seconds: float, settings: dict[str, Any], max_bytes: int = 0
) -> Reading:
    memory = _MEMORY + _MEMORY_PER_BYTE * _size(font)
    reader = f"audio.soundfont_reader:{function}"
    return Reading(reader, font, memory, seconds, settings, max_bytes)


def _size(font: Path) -> int:
    """Return the size of a file; that of a missing one does not matter."""
    try:
        return min(font.stat().st_size, SOUNDFONT.max_bytes)
    except (OSError, ValueError):
        return 0


def _not_installed(error: Exception) -> str:
    return (
        f"SoundFonts are played by tinysoundfont, which is not installed ({error}); "
        "try: pip install --no-deps tinysoundfont"
    )


def _messages(score: Score) -> Iterator[tuple[int, str, int, int, int]]:
    """Yield the messages of all tracks in playing order, as `soundfont_reader` takes them.

    Channels count on from port to port. The player knows no MPE.
    """
    grid = tempo_plan(score).grid
    plain = replace(score, sound=score.sound.model_copy(update={"mpe": False}))
    file = mido.MidiFile(file=io.BytesIO(midi_bytes(plain)), charset="utf-8")
    timed = list[tuple[int, int, int, Any]]()
    for track in file.tracks:
        tick = 0
        port = next((message.port for message in track if message.type == "midi_port"), 0)
        for message in track:
            tick += message.time
            if not message.is_meta and message.type != "sysex":
                timed.append((tick, len(timed), port, message))
    for tick, _, port, message in sorted(timed, key=lambda each: each[:2]):
        kind, channel, number, value = _plain(message)
        yield sample_at(grid.seconds(tick)), kind, 16 * port + channel, number, value


def _plain(message: Any) -> tuple[str, int, int, int]:
    """Return kind, channel, number and value of a MIDI message."""
    match message.type:
        case "note_on" | "note_off":
            return message.type, message.channel, message.note, message.velocity
        case "control_change":
            return message.type, message.channel, message.control, message.value
        case "program_change":
            return message.type, message.channel, message.program, 0
        case "pitchwheel":
            return message.type, message.channel, message.pitch, 0
        case other:
            return other, 0, 0, 0
