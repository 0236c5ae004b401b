"""A SoundFont of the author's plays the score: the same messages as in the MIDI file.

TinySoundFont plays them; it belongs to nothing that pronk needs, and is asked for when wanted.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mido
import numpy as np

from audio.banks import Signal
from audio.errors import SoundFontError
from audio.grid import SAMPLE_RATE, grid_of, sample_at
from audio.midi import midi_bytes
from audio.score import Score

# The channel of drums, and where fonts have them.
_DRUMS, _DRUM_BANK = 9, 128
# More notes at once than this cut one another off.
_VOICES = 1024
_LONGEST_BLOCK = SAMPLE_RATE


def played(score: Score, font: Path, samples: int) -> Signal:
    """Return the score as a SoundFont plays it, each message on its sample: (samples, 2).

    Raises:
        SoundFontError: there is no such file, it is no SoundFont, or no player is installed.
    """
    player = _player(font)
    stereo = np.zeros((samples, 2))
    at = 0
    for sample, message in _messages(score):
        until = min(sample, samples)
        player.fill(stereo[at:until])
        at = until
        player.send(message)
    player.fill(stereo[at:])
    return stereo


def _player(font: Path) -> _Player:
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
    # The player believes what it reads; a form that is cut short must not reach it.
    if data[:4] != b"RIFF" or data[8:12] != b"sfbk":
        raise SoundFontError(f"{font}: is no SoundFont 2 (a RIFF file of the form 'sfbk')")
    if int.from_bytes(data[4:8], "little") + 8 > len(data):
        raise SoundFontError(f"{font}: is cut short, at {len(data)} bytes")
    synth = tinysoundfont.Synth(samplerate=SAMPLE_RATE)
    try:
        number = synth.sfload(data, max_voices=_VOICES)
    except Exception as error:
        raise SoundFontError(f"{font}: is a damaged SoundFont ({error})") from error
    return _Player(synth, number, font)


class _Player:
    """A synthesiser with one SoundFont, which is sent the messages of a score.

    Args:
        synth: the synthesiser.
        number: of the font.
        font: its file.
    """

    def __init__(self, synth: Any, number: int, font: Path) -> None:
        self._synth = synth
        has = {bank: _presets(synth, number, bank) for bank in (0, _DRUM_BANK)}
        if not any(has.values()):
            raise SoundFontError(f"{font}: has no instrument in bank 0 and no drums")
        self._tuned, self._drums = (has[bank] for bank in (0, _DRUM_BANK))
        for channel in range(16):
            self._choose(channel, 0)

    def _choose(self, channel: int, program: int) -> None:
        """Give a channel a program; where the font has it not, the one of the nearest number."""
        drums = bool(self._drums) and (channel == _DRUMS or not self._tuned)
        has = self._drums if drums else self._tuned
        nearest = min(has, key=lambda each: (abs(each - program), each))
        self._synth.program_change(channel, nearest, drums)

    def send(self, message: Any) -> None:
        """Take in a message of MIDI."""
        synth, kind = self._synth, message.type
        if kind == "note_on" and message.velocity:
            synth.noteon(message.channel, message.note, message.velocity)
        elif kind in ("note_on", "note_off"):
            synth.noteoff(message.channel, message.note)
        elif kind == "control_change":
            synth.control_change(message.channel, message.control, message.value)
        elif kind == "program_change":
            self._choose(message.channel, message.program)
        elif kind == "pitchwheel":
            # The synthesiser counts from 0, mido from the middle.
            synth.pitchbend(message.channel, message.pitch + 8192)

    def fill(self, stereo: Signal) -> None:
        """Fill samples (N, 2) with what sounds."""
        for start in range(0, stereo.shape[0], _LONGEST_BLOCK):
            part = stereo[start : start + _LONGEST_BLOCK]
            heard = np.frombuffer(self._synth.generate_simple(part.shape[0]), np.float32)
            part[:] = heard.reshape(-1, 2)


def _presets(synth: Any, number: int, bank: int) -> list[int]:
    """Return the programs that a font has in a bank."""
    return [p for p in range(128) if synth.sfpreset_name(number, bank, p) is not None]


def _messages(score: Score) -> Iterator[tuple[int, Any]]:
    """Give the messages of all tracks in the order of a player, each with its sample."""
    grid = grid_of(score.rate)
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
