"""SoundFont reader: plays messages with tinysoundfont, in a child process.

tinysoundfont trusts its file: offsets and counts within a damaged one lead it anywhere. Therefore
only `reader_process` calls these functions. Messages are lists `[sample, kind, channel, number,
value]`, by the kinds of mido.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pipeline.foreign_files.reader_child import Reply
from pipeline.foreign_files.safe_file import SOUNDFONT, ForeignFileError, read_file

FRAME_BYTES = 8
"""Of one sample of both sides, as 32-bit floats."""

_DRUM_CHANNEL, _MELODIC_BANK, _DRUM_BANK = 9, 0, 128
# Greatest number of simultaneous notes.
_MAX_VOICES = 1024
# Samples rendered at once.
_MAX_BLOCK = 16_384

_REHEARSED_KEYS = range(12, 121, 12)
# Samples of a rehearsal with the keys held and with them released.
_REHEARSED_SAMPLES = 4096


def play(path: Path, settings: dict[str, Any]) -> Reply:
    """Return the samples of messages: (`samples`, 2) 32-bit floats.

    Args:
        path: of the font.
        settings: `messages` in the order of time, `samples` and `sample_rate`.

    Raises:
        ForeignFileError: the file is no SoundFont, or has nothing to play.
    """
    player = _load_player(path, settings["sample_rate"])
    samples = settings["samples"]
    return Reply(size=samples * FRAME_BYTES, content=_played(player, settings["messages"], samples))


def rehearse(path: Path, settings: dict[str, Any]) -> Reply:
    """Play some keys of every program of the font, to see that it can be played.

    Raises:
        ForeignFileError: the file is no SoundFont, or has nothing to play.
    """
    player = _load_player(path, settings["sample_rate"])
    for channel, programs in ((0, player.melodic), (_DRUM_CHANNEL, player.drums)):
        for program in programs:
            _rehearse_program(player, channel, program)
    return Reply({"melodic": player.melodic, "drums": player.drums})


def _rehearse_program(player: _Player, channel: int, program: int) -> None:
    player.send("program_change", channel, program, 0)
    for kind in ("note_on", "note_off"):
        for key in _REHEARSED_KEYS:
            player.send(kind, channel, key, 100)
        for _ in player.render(_REHEARSED_SAMPLES):
            pass
    player.silence(channel)


def _played(player: _Player, messages: Sequence[Any], samples: int) -> Iterator[memoryview]:
    position = 0
    for sample, kind, channel, number, value in messages:
        end = min(sample, samples)
        yield from player.render(end - position)
        position = end
        player.send(kind, channel, number, value)
    yield from player.render(samples - position)


def _load_player(path: Path, sample_rate: int) -> _Player:
    import tinysoundfont

    data = read_file(path, SOUNDFONT)
    if data[:4] != b"RIFF" or data[8:12] != b"sfbk":
        raise ForeignFileError("is no SoundFont 2 (a RIFF file of the form 'sfbk')")
    if int.from_bytes(data[4:8], "little") + 8 > len(data):
        raise ForeignFileError(f"is cut short, at {len(data)} bytes")
    synth = tinysoundfont.Synth(samplerate=sample_rate)
    try:
        number = synth.sfload(data, max_voices=_MAX_VOICES)
    except MemoryError:
        raise
    except Exception as error:
        raise ForeignFileError(f"is a damaged SoundFont ({error})") from error
    return _Player(synth, number)


class _Player:
    """A synthesiser with one SoundFont.

    Attributes:
        melodic: programs of its melodic bank.
        drums: programs of its drum bank.
    """

    def __init__(self, synth: Any, number: int) -> None:
        self._synth, self._number = synth, number
        self.melodic = _programs(synth, number, _MELODIC_BANK)
        self.drums = _programs(synth, number, _DRUM_BANK)
        if not self.melodic and not self.drums:
            raise ForeignFileError("has no instrument in bank 0 and no drums")
        self._channels: set[int] = set()

    def _change_program(self, channel: int, program: int) -> None:
        """Set a channel's program, or the nearest one that the font has."""
        is_drums = bool(self.drums) and (channel % 16 == _DRUM_CHANNEL or not self.melodic)
        programs = self.drums if is_drums else self.melodic
        nearest = min(programs, key=lambda each: (abs(each - program), each))
        # The player gives its font to sixteen channels alone; those of later ports need it, too.
        self._synth.program_select(channel, self._number, _MELODIC_BANK, nearest, is_drums)

    def send(self, kind: str, channel: int, number: int, value: int) -> None:
        """Apply a message; channels count on from port to port, 16 a port."""
        synth = self._synth
        if channel not in self._channels:
            self._channels.add(channel)
            self._change_program(channel, 0)
        if kind == "note_on" and value:
            synth.noteon(channel, number, value)
        elif kind in ("note_on", "note_off"):
            synth.noteoff(channel, number)
        elif kind == "control_change":
            synth.control_change(channel, number, value)
        elif kind == "program_change":
            self._change_program(channel, number)
        elif kind == "pitchwheel":
            # The synthesiser counts from 0, mido from the middle.
            synth.pitchbend(channel, number + 8192)

    def silence(self, channel: int) -> None:
        """End the sounds of a channel at once."""
        self._synth.sounds_off(channel)

    def render(self, samples: int) -> Iterator[memoryview]:
        """Yield the next samples, in blocks of two sides of 32-bit floats."""
        for start in range(0, samples, _MAX_BLOCK):
            yield self._synth.generate_simple(min(samples - start, _MAX_BLOCK))


def _programs(synth: Any, number: int, bank: int) -> list[int]:
    """Return the programs of a font's bank."""
    return [program for program in range(128) if _has_preset(synth, number, bank, program)]


def _has_preset(synth: Any, number: int, bank: int, program: int) -> bool:
    try:
        return synth.sfpreset_name(number, bank, program) is not None
    except UnicodeDecodeError:
        # A name in another alphabet is a name.
        return True
