"""SoundFont playback of a score: the messages of its MIDI file through tinysoundfont.

tinysoundfont is an optional dependency.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mido
import numpy as np

from audio.dsp import Signal
from audio.errors import SoundFontError
from audio.midi_file import midi_bytes
from audio.score import Score
from audio.time_grid import SAMPLE_RATE, sample_at, tick_grid

_DRUM_CHANNEL, _MELODIC_BANK, _DRUM_BANK = 9, 0, 128
# Greatest number of simultaneous notes.
_MAX_VOICES = 1024
_MAX_BLOCK = SAMPLE_RATE


def play_soundfont(score: Score, font: Path, samples: int) -> Signal:
    """Return the score as played by a SoundFont, each message on its sample: (samples, 2).

    Raises:
        SoundFontError: the file is missing, is no SoundFont, or tinysoundfont is not installed.
    """
    player = _load_player(font)
    stereo = np.zeros((samples, 2))
    position = 0
    for sample, message in _messages(score):
        end = min(sample, samples)
        player.render(stereo[position:end])
        position = end
        player.send(message)
    player.render(stereo[position:])
    return stereo


def _load_player(font: Path) -> _Player:
    try:
        import tinysoundfont
    except ImportError as error:
        raise SoundFontError(
            f"{font}: SoundFonts are played by tinysoundfont, which is not installed ({error}); "
            "try: pip install --no-deps tinysoundfont"
        ) from error
    try:
        data = font.read_bytes()
    except OSError as error:
        raise SoundFontError(f"{font}: {error.strerror or error}") from error
    # The player does not check its input; a truncated file could crash it.
    if data[:4] != b"RIFF" or data[8:12] != b"sfbk":
        raise SoundFontError(f"{font}: is no SoundFont 2 (a RIFF file of the form 'sfbk')")
    if int.from_bytes(data[4:8], "little") + 8 > len(data):
        raise SoundFontError(f"{font}: is cut short, at {len(data)} bytes")
    synth = tinysoundfont.Synth(samplerate=SAMPLE_RATE)
    try:
        number = synth.sfload(data, max_voices=_MAX_VOICES)
    except Exception as error:
        raise SoundFontError(f"{font}: is a damaged SoundFont ({error})") from error
    return _Player(synth, number, font)


class _Player:
    """A synthesiser with one SoundFont.

    Args:
        synth: the synthesiser.
        number: of the font in the synthesiser.
        font: its file.
    """

    def __init__(self, synth: Any, number: int, font: Path) -> None:
        self._synth = synth
        self._melodic = _programs(synth, number, _MELODIC_BANK)
        self._drums = _programs(synth, number, _DRUM_BANK)
        if not self._melodic and not self._drums:
            raise SoundFontError(f"{font}: has no instrument in bank 0 and no drums")
        for channel in range(16):
            self._change_program(channel, 0)

    def _change_program(self, channel: int, program: int) -> None:
        """Set a channel's program, or the nearest one that the font has."""
        is_drums = bool(self._drums) and (channel == _DRUM_CHANNEL or not self._melodic)
        programs = self._drums if is_drums else self._melodic
        nearest = min(programs, key=lambda each: (abs(each - program), each))
        self._synth.program_change(channel, nearest, is_drums)

    def send(self, message: Any) -> None:
        """Apply a MIDI message."""
        synth, kind = self._synth, message.type
        if kind == "note_on" and message.velocity:
            synth.noteon(message.channel, message.note, message.velocity)
        elif kind in ("note_on", "note_off"):
            synth.noteoff(message.channel, message.note)
        elif kind == "control_change":
            synth.control_change(message.channel, message.control, message.value)
        elif kind == "program_change":
            self._change_program(message.channel, message.program)
        elif kind == "pitchwheel":
            # The synthesiser counts from 0, mido from the middle.
            synth.pitchbend(message.channel, message.pitch + 8192)

    def render(self, stereo: Signal) -> None:
        """Render the next samples into an array (N, 2)."""
        for start in range(0, stereo.shape[0], _MAX_BLOCK):
            part = stereo[start : start + _MAX_BLOCK]
            data = self._synth.generate_simple(part.shape[0])
            part[:] = np.frombuffer(data, np.float32).reshape(-1, 2)


def _programs(synth: Any, number: int, bank: int) -> list[int]:
    """Return the programs of a font's bank."""
    return [p for p in range(128) if synth.sfpreset_name(number, bank, p) is not None]


def _messages(score: Score) -> Iterator[tuple[int, Any]]:
    """Yield the messages of all tracks in playing order, each with its sample."""
    grid = tick_grid(score.rate)
    file = mido.MidiFile(file=io.BytesIO(midi_bytes(score)), charset="utf-8")
    timed = list[tuple[int, int, Any]]()
    for track in file.tracks:
        tick = 0
        for message in track:
            tick += message.time
            if not message.is_meta:
                timed.append((tick, len(timed), message))
    for tick, _, message in sorted(timed, key=lambda each: each[:2]):
        yield sample_at(grid.seconds(tick)), message
