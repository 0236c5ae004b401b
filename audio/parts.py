"""Parts: the instruments of the performers, each with a channel of its own for the whole film.

A port has sixteen channels, of which channel 10 plays drums. Parts that do not fit go to further
ports, so nobody changes its program and no two performers share a channel. With MPE each part has
a port for itself: channel 1 is the manager, and each sounding note has another channel.

Source: MIDI Polyphonic Expression 1.0 (M1-100-UM), MMA 2018.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from audio.errors import ScoreError
from audio.general_midi import INSTRUMENTS

DRUM_CHANNEL = 9
"""The channel on which each key is a drum."""

MELODIC_CHANNELS = tuple(channel for channel in range(16) if channel != DRUM_CHANNEL)
MANAGER_CHANNEL = 0
"""Channel of what all notes of a part with MPE share."""

MEMBER_CHANNELS = tuple(range(1, 16))
"""Channels of the notes of a part with MPE."""

MAX_PORTS = 128
"""Ports that the event of the port can tell."""

DRUMS = -1
"""In place of the program of a part of drums."""


@dataclass(frozen=True, slots=True, order=True)
class PartKey:
    """Identity of a part.

    Attributes:
        track: name of its track: the performer, or the cause.
        performer: who sounds.
        program: General MIDI program, or `DRUMS`.
    """

    track: str
    performer: str
    program: int

    @property
    def instrument(self) -> str:
        """Name of its instrument."""
        return "drums" if self.program == DRUMS else INSTRUMENTS[self.program]

    @property
    def _order(self) -> tuple[str, bool, str, int]:
        return self.track, self.program == DRUMS, self.performer, self.program


@dataclass(frozen=True, slots=True)
class Part:
    """A part and its place in the file.

    Attributes:
        key: its identity.
        port: from 0.
        channel: 0 to 15; with MPE that of the manager.
        mpe: whether each of its notes has a channel of its own.
    """

    key: PartKey
    port: int
    channel: int
    mpe: bool = False


@dataclass(frozen=True, slots=True)
class TrackLayout:
    """A track of a file: parts of one name on one port."""

    name: str
    port: int
    parts: tuple[Part, ...]


@dataclass(slots=True)
class _Port:
    """Channels of a port that are free."""

    melodic: list[int] = field(default_factory=lambda: list(MELODIC_CHANNELS))
    has_drums: bool = False


def lay_out(keys: Iterable[PartKey], mpe: bool = False) -> tuple[TrackLayout, ...]:
    """Return the tracks of parts, each part with its port and channel.

    The parts of a track share a port where it has room for all; a drum kit is played by one
    performer of a port, because a key of it sounds for one.

    Raises:
        ScoreError: there are more parts than the ports of a file have channels.
    """
    tracks: list[TrackLayout] = []
    ports: list[_Port] = []
    for bundle in _bundles(sorted(set(keys), key=lambda key: key._order), mpe):
        melodic = [key for key in bundle if key.program != DRUMS]
        number = 0
        while number < len(ports) and not _has_room(ports[number], bundle, mpe):
            number += 1
        if number == len(ports):
            ports.append(_Port())
        port = ports[number]
        parts = []
        for key in bundle:
            if key.program == DRUMS:
                port.has_drums = True
                parts.append(Part(key, number, DRUM_CHANNEL))
            elif mpe:
                port.melodic.clear()
                port.has_drums = True
                parts.append(Part(key, number, MANAGER_CHANNEL, mpe=True))
            else:
                parts.append(Part(key, number, port.melodic.pop(0)))
        assert len(melodic) <= len(MELODIC_CHANNELS)
        tracks.append(TrackLayout(bundle[0].track, number, tuple(parts)))
    if len(ports) > MAX_PORTS:
        raise ScoreError(
            f"the parts of the score need {len(ports)} MIDI ports, and a file can tell "
            f"{MAX_PORTS} apart; give fewer performers drums, mute some, or set mpe: false"
        )
    return tuple(tracks)


def _has_room(port: _Port, bundle: list[PartKey], mpe: bool) -> bool:
    melodic = sum(key.program != DRUMS for key in bundle)
    drums = len(bundle) - melodic
    if mpe and melodic:
        return len(port.melodic) == len(MELODIC_CHANNELS) and not port.has_drums
    return len(port.melodic) >= melodic and not (drums and port.has_drums)


def _bundles(keys: list[PartKey], mpe: bool) -> Iterator[list[PartKey]]:
    """Yield parts of one track that a port can hold, in their order."""
    bundle: list[PartKey] = []
    for key in keys:
        kits = sum(each.program == DRUMS for each in bundle)
        full = len(bundle) - kits == len(MELODIC_CHANNELS) and key.program != DRUMS
        second_kit = kits and key.program == DRUMS
        if bundle and (mpe or full or second_kit or key.track != bundle[0].track):
            yield bundle
            bundle = []
        bundle.append(key)
    if bundle:
        yield bundle
