"""Song file: a MIDI file of a user as notes on beats.

Its bytes are foreign: every length is checked before it is used, and everything is bounded.

Source: MMA 1996, The Complete MIDI 1.0 Detailed Specification, "Standard MIDI Files".
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from math import inf
from pathlib import Path

from audio.controller_range import BEND_RANGE
from audio.general_midi import INSTRUMENTS, LOWEST_DRUM_KEY
from audio.music.piece import Bend, PieceNote
from audio.parts import DRUM_CHANNEL, DRUMS
from pipeline.foreign_files.safe_file import SONG, ForeignFileError, read_file

MAX_NOTES = 100_000
"""Greatest number of notes of a song."""

MAX_BENDS = 500_000
"""Greatest number of changes of pitch that the notes of a song have together."""

_MAX_TRACKS = 1024
_MAX_TICK = 2**31
_MAX_TEMPOS = 4096
_DEFAULT_TEMPO = 500_000
_HIGHEST_DRUM_KEY = LOWEST_DRUM_KEY + 46
_FULL, _CENTRE = 127, 64
_VOLUME, _PAN, _REVERB, _EXPRESSION, _PEDAL = 7, 10, 91, 11, 64
# A pedal is down from half-way on. Registered parameter 0 is the range of the pitch bend, two
# semitones where a file does not set it.
_HALF_DOWN, _DATA, _PARAMETER, _USUAL_RANGE, _CENTRED = 64, 6, (101, 100), 2, 8192
# Points of a bend that a note keeps, and the least change of one [semitones].
_MAX_BENDS, _LEAST_BEND = 256, 0.05
# Where the range of the bend of a channel is kept among its controllers, which end at 127.
_RANGE = 128
# General MIDI's volume of a channel at the start, at which gain is 0 dB here.
_USUAL_VOLUME = 100


@dataclass(frozen=True, slots=True)
class SongTempo:
    """A tempo from a tick on [microseconds a beat]."""

    tick: int
    microseconds: int


@dataclass(frozen=True, slots=True)
class SongNote:
    """A note of a song, in ticks.

    Attributes:
        tick: of its onset.
        end: of its key.
        note: without its times.
        pedal: ticks from which, and until which, the pedal is down that holds it.
        rings: tick at which it ends under the pedal.
    """

    tick: int
    end: int
    note: PieceNote
    pedal: tuple[int, int] | None = None
    rings: int = 0


@dataclass(frozen=True, slots=True)
class Song:
    """A MIDI file.

    Attributes:
        division: ticks a beat.
        notes: in the order of time.
        tempos: in the order of time; the first from tick 0.
    """

    division: int
    notes: tuple[SongNote, ...]
    tempos: tuple[SongTempo, ...]

    @property
    def tempo(self) -> Fraction:
        """Quarter notes a minute at its start, as its composer will have written them."""
        exact = Fraction(60_000_000, self.tempos[0].microseconds)
        # 103 beats a minute are written as 582,524 microseconds.
        nearest = Fraction(round(exact * 100), 100)
        return nearest if round(60_000_000 / nearest) == self.tempos[0].microseconds else exact

    def piece(self, in_its_tempo: bool) -> Iterator[PieceNote]:
        """Yield the notes on beats.

        Args:
            in_its_tempo: whether beats are those of its first tempo throughout, so that its own
                changes of tempo are heard; else every beat of the file is one of the score.
        """
        first = self.tempos[0].microseconds
        tempos = self.tempos if in_its_tempo else (SongTempo(0, first),)
        starts, beats = [tempo.tick for tempo in tempos], [Fraction(0)]
        for tempo, following in pairwise(tempos):
            length = Fraction((following.tick - tempo.tick) * tempo.microseconds, first)
            beats.append(beats[-1] + length / self.division)

        def beat(tick: int) -> Fraction:
            k = bisect_right(starts, tick) - 1
            length = Fraction((tick - starts[k]) * tempos[k].microseconds, first)
            return beats[k] + length / self.division

        for each in self.notes:
            start, end = beat(each.tick), beat(each.end)
            note = each.note
            held = each.pedal is not None
            yield replace(
                note,
                beat=start,
                beats=end - start,
                pedal=(beat(each.pedal[0]), beat(each.pedal[1])) if each.pedal else None,
                rings=beat(each.rings) - start if held else None,
            )


def read_song(path: Path) -> Song:
    """Return the song of a file.

    Raises:
        ForeignFileError: it is no MIDI file, damaged, too large or of a kind that is not played.
    """
    return parse_song(read_file(path, SONG))


def parse_song(data: bytes) -> Song:
    """Return the song of the bytes of a file; raises as `read_song` does."""
    if data[:4] == b"RIFF" and data[8:12] == b"RMID":
        data = data[20:]
    division, tracks = _parse_header(data)
    state = _State()
    for number, track in enumerate(tracks, start=1):
        _TrackReader(track, number, state).read()
    if not state.notes:
        raise ForeignFileError("is a MIDI file without notes")
    tempos = sorted(state.tempos.items())
    if not tempos or tempos[0][0]:
        tempos.insert(0, (0, _DEFAULT_TEMPO))
    held = _under_pedals(state)
    notes = sorted(held, key=lambda each: (each.tick, each.note.part, each.note.pitch))
    return Song(division, tuple(notes), tuple(SongTempo(*tempo) for tempo in tempos))


def _under_pedals(state: _State) -> Iterator[SongNote]:
    """Yield the notes of a song as the pedals of their channels hold them."""
    ends = max(each.end for each in state.notes)
    by_channel: dict[int, list[SongNote]] = defaultdict(list)
    for channel, note in zip(state.channels, state.notes, strict=True):
        by_channel[channel].append(note)
    for channel, notes in by_channel.items():
        changes = sorted(state.pedals.get(channel, ()), key=lambda change: change[0])
        spans: list[tuple[int, int]] = []
        down: int | None = None
        for tick, is_down in changes:
            if down is not None and not is_down:
                spans.append((down, tick))
            down = (tick if down is None else down) if is_down else None
        if down is not None and down < ends:
            spans.append((down, ends))
        starts = [span[0] for span in spans]
        following: dict[int, int] = {}
        for each in sorted(notes, key=lambda note: note.tick, reverse=True):
            k = bisect_right(starts, each.end - 1) - 1
            if k >= 0 and starts[k] < each.end < spans[k][1]:
                until = min(spans[k][1], following.get(each.note.pitch, spans[k][1]))
                yield replace(each, pedal=spans[k], rings=max(until, each.end))
            else:
                yield each
            following[each.note.pitch] = each.tick


def _parse_header(data: bytes) -> tuple[int, Iterator[bytes]]:
    """Return ticks a beat, and the content of the tracks."""
    if data[:4] != b"MThd" or len(data) < 14:
        raise ForeignFileError("is no MIDI file")
    size = int.from_bytes(data[4:8])
    kind, count, division = (int.from_bytes(data[at : at + 2]) for at in (8, 10, 12))
    if size < 6 or kind > 2:
        raise ForeignFileError("is a damaged MIDI file (its header is wrong)")
    if kind == 2:
        raise ForeignFileError("is a MIDI file of type 2, of separate patterns; save it as type 1")
    if division & 0x8000 or not division:
        raise ForeignFileError("counts in frames of SMPTE; save it with ticks per quarter note")
    if count > _MAX_TRACKS:
        raise ForeignFileError(f"has {count} tracks; at most {_MAX_TRACKS} are read")
    return division, _tracks(data, 8 + size, count)


def _tracks(data: bytes, at: int, count: int) -> Iterator[bytes]:
    """Yield the content of so many tracks; chunks of other kinds are skipped."""
    found = 0
    while found < count:
        if at + 8 > len(data):
            raise ForeignFileError(
                f"is a damaged MIDI file (it ends after {found} tracks of {count})"
            )
        length = int.from_bytes(data[at + 4 : at + 8])
        if at + 8 + length > len(data):
            raise ForeignFileError(f"is a damaged MIDI file (track {found + 1} ends early)")
        if data[at : at + 4] == b"MTrk":
            found += 1
            yield data[at + 8 : at + 8 + length]
        at += 8 + length


@dataclass(slots=True)
class _State:
    """What tracks of a file share.

    Attributes:
        notes: that have ended.
        started: number of notes that have begun.
        tempos: tick -> microseconds a beat.
        programs: of channels.
        values: of controllers by (channel, number).
        channels: of the notes.
        pedals: of channels, ticks and whether the pedal is down from there on.
        bent: number of points of the bends of all notes.
    """

    notes: list[SongNote] = field(default_factory=list)
    started: int = 0
    tempos: dict[int, int] = field(default_factory=dict)
    programs: dict[int, int] = field(default_factory=dict)
    values: dict[tuple[int, int], int] = field(default_factory=dict)
    channels: list[int] = field(default_factory=list)
    pedals: dict[int, list[tuple[int, bool]]] = field(default_factory=dict)
    bent: int = 0


class _TrackReader:
    """Reads the events of one track."""

    def __init__(self, data: bytes, number: int, state: _State) -> None:
        self._data, self._number, self._state = data, number, state
        self._at = self._tick = 0
        self._sounding: dict[tuple[int, int], list[tuple[int, PieceNote]]] = defaultdict(list)
        # Ticks and semitones from there on, of each channel.
        self._bends: dict[int, list[tuple[int, float]]] = defaultdict(list)

    def read(self) -> None:
        """Read all events; notes that never end do so at the end of the track."""
        running = 0
        while self._at < len(self._data):
            self._tick += self._number_of_bytes()
            if self._tick > _MAX_TICK:
                raise self._damaged("is longer than is read")
            status = self._byte()
            if status == 0xFF:
                if self._meta():
                    break
                running = 0
            elif status in (0xF0, 0xF7):
                self._take(self._number_of_bytes())
                running = 0
            else:
                running = self._channel_event(status, running)
        for channel, key in list(self._sounding):
            while self._sounding[channel, key]:
                self._end(channel, key)

    def _channel_event(self, byte: int, running: int) -> int:
        """Read an event of a channel from its first byte; return its status."""
        if byte >= 0xF0:
            raise self._damaged(f"has the byte {byte:#x}, which no file has")
        status, first = (byte, self._byte()) if byte >= 0x80 else (running, byte)
        if not status:
            raise self._damaged("has data without an event")
        second = 0 if status & 0xF0 in (0xC0, 0xD0) else self._byte()
        if max(first, second) > 0x7F:
            raise self._damaged("has an event that is cut off")
        self._message(status & 0xF0, status & 15, first, second)
        return status

    def _message(self, kind: int, channel: int, first: int, second: int) -> None:
        state = self._state
        if kind == 0x90 and second:
            is_drum = channel == DRUM_CHANNEL
            if is_drum and not LOWEST_DRUM_KEY <= first <= _HIGHEST_DRUM_KEY:
                return
            note = self._note(channel, first, second, is_drum)
            self._sounding[channel, first].append((self._tick, note))
            state.started += 1
            if state.started > MAX_NOTES:
                raise ForeignFileError(f"has more than {MAX_NOTES} notes")
        elif kind in (0x80, 0x90):
            if self._sounding[channel, first]:
                self._end(channel, first)
        elif kind == 0xB0:
            self._control(channel, first, second)
        elif kind == 0xE0:
            self._bend(channel, (first + 128 * second - _CENTRED) / _CENTRED)
        elif kind == 0xC0:
            state.programs[channel] = first

    def _control(self, channel: int, number: int, value: int) -> None:
        """Read a change of a controller."""
        values = self._state.values
        values[channel, number] = value
        parameter = tuple(values.get((channel, each), 127) for each in _PARAMETER)
        if number == _PEDAL:
            changes = self._state.pedals.setdefault(channel, [])
            changes.append((self._tick, value >= _HALF_DOWN))
        elif number == _DATA and parameter == (0, 0):
            values[channel, _RANGE] = value

    def _bend(self, channel: int, amount: float) -> None:
        """Read a pitch bend, from -1 to 1 of its range."""
        semitones = amount * self._state.values.get((channel, _RANGE), _USUAL_RANGE)
        semitones = min(max(semitones, -BEND_RANGE), float(BEND_RANGE))
        bends = self._bends[channel]
        if abs(semitones - (bends[-1][1] if bends else 0.0)) >= _LEAST_BEND or not semitones:
            bends.append((self._tick, semitones))

    def _bend_of(self, channel: int, start: int, end: int) -> Bend:
        """Return the bend of a note of this track: the last before it, and those within it."""
        bends = self._bends[channel]
        if channel == DRUM_CHANNEL or not bends:
            return ()
        first = max(bisect_right(bends, (start, inf)) - 1, 0)
        last = bisect_right(bends, (end - 1, inf), first)
        points, value = [(0.0, 0.0)], 0.0
        for tick, semitones in bends[first : min(last, first + _MAX_BENDS)]:
            share = max(tick - start, 0) / (end - start)
            if not share:
                points = [(0.0, semitones)]
            else:
                # A bend holds until the next.
                points += [(share, value), (share, semitones)]
            value = semitones
        if not any(semitones for _, semitones in points):
            return ()
        self._state.bent += len(points)
        if self._state.bent > MAX_BENDS:
            raise ForeignFileError(f"bends its notes more than {MAX_BENDS} times")
        return tuple(points)

    def _note(self, channel: int, key: int, velocity: int, is_drum: bool) -> PieceNote:
        values = self._state.values
        program = DRUMS if is_drum else self._state.programs.get(channel, 0)
        name = "drums" if is_drum else INSTRUMENTS[program]
        volume = values.get((channel, _VOLUME), _USUAL_VOLUME) / _USUAL_VOLUME
        volume *= values.get((channel, _EXPRESSION), _FULL) / _FULL
        pan = (values.get((channel, _PAN), _CENTRE) - _CENTRE) / (_FULL - _CENTRE)
        return PieceNote(
            beat=Fraction(0),
            beats=Fraction(0),
            part=f"{channel + 1} {name}",
            program=program,
            pitch=key,
            velocity=min(max(round(velocity * volume), 1), _FULL),
            pan=max(pan, -1.0),
            reverb=values.get((channel, _REVERB), 32) / 128,
        )

    def _end(self, channel: int, key: int) -> None:
        start, note = self._sounding[channel, key].pop(0)
        # A note without a length is a stroke of a drum, as some programs write it.
        end = max(self._tick, start + 1)
        note = replace(note, bend=self._bend_of(channel, start, end))
        self._state.notes.append(SongNote(start, end, note))
        self._state.channels.append(channel)

    def _meta(self) -> bool:
        """Read a meta event; return whether it ends the track."""
        kind = self._byte()
        data = self._take(self._number_of_bytes())
        if kind == 0x51:
            tempo = int.from_bytes(data)
            if len(data) != 3 or not tempo:
                raise self._damaged("has a tempo that is none")
            self._state.tempos[self._tick] = tempo
            if len(self._state.tempos) > _MAX_TEMPOS:
                raise ForeignFileError(f"has more than {_MAX_TEMPOS} tempos")
        return kind == 0x2F

    def _byte(self) -> int:
        return self._take(1)[0]

    def _take(self, size: int) -> bytes:
        part = self._data[self._at : self._at + size]
        if len(part) < size:
            raise self._damaged("ends within an event")
        self._at += size
        return part

    def _number_of_bytes(self) -> int:
        value = 0
        for _ in range(4):
            byte = self._byte()
            value = value << 7 | byte & 0x7F
            if byte < 0x80:
                return value
        raise self._damaged("has a number of more than four bytes")

    def _damaged(self, what: str) -> ForeignFileError:
        return ForeignFileError(f"is a damaged MIDI file (track {self._number} {what})")
