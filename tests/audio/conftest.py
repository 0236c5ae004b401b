"""Independent readers of MIDI and WAV files, and factories of scores."""

from __future__ import annotations

import struct
import wave
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from audio.config.sound import Sound
from audio.harmony import Scale
from audio.score import Score, ScoreEvent
from audio.wav_file import write_wav


@dataclass
class Smf:
    """A MIDI file as read from its bytes.

    Attributes:
        division: ticks a beat.
        tracks: of (tick, status, data); a meta event has status 0xFF00 + type, a system exclusive
            message 0xF000.
    """

    division: int
    tracks: list[list[tuple[int, int, bytes]]] = field(default_factory=list)

    @property
    def tempos(self) -> list[tuple[int, int]]:
        """Ticks and microseconds a beat of all tempo events."""
        return [
            (tick, int.from_bytes(data))
            for track in self.tracks
            for tick, kind, data in track
            if kind == 0xFF51
        ]

    @property
    def meters(self) -> list[tuple[int, int, int]]:
        """Tick, beats and unit of all time signatures."""
        return [
            (tick, data[0], 2 ** data[1])
            for track in self.tracks
            for tick, kind, data in track
            if kind == 0xFF58
        ]

    def seconds(self, tick: int) -> Fraction:
        """Return the exact time of a tick."""
        (first, *later), time = self.tempos, 0
        assert first[0] == 0
        now, tempo = first
        for start, following in later:
            if start >= tick:
                break
            time += (start - now) * tempo
            now, tempo = start, following
        return Fraction(time + (tick - now) * tempo, self.division * 1_000_000)

    def texts(self, kind: int) -> list[tuple[int, str]]:
        """Return the texts of one meta type, of all tracks."""
        return [(t, d.decode("utf-8")) for track in self.tracks for t, k, d in track if k == kind]

    def onsets(self) -> list[tuple[int, int, int, int]]:
        """Return (tick, channel, pitch, velocity) of all onsets."""
        return sorted(
            (tick, status & 15, data[0], data[1])
            for track in self.tracks
            for tick, status, data in track
            if status & 0xF0 == 0x90 and status < 0xF000 and data[1] > 0
        )

    def played(self) -> list[tuple[int, int, bytes]]:
        """Return all events in playing order: by tick, then by track."""
        merged = [
            (tick, index, place, status, data)
            for index, track in enumerate(self.tracks)
            for place, (tick, status, data) in enumerate(track)
        ]
        return [(tick, status, data) for tick, _, _, status, data in sorted(merged)]


def _length(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for used in range(4):
        byte = data[at + used]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, at + used + 1
    raise AssertionError("a length of more than four bytes")


def _track(data: bytes) -> list[tuple[int, int, bytes]]:
    events = []
    at = tick = running = 0
    while at < len(data):
        delta, at = _length(data, at)
        tick += delta
        if data[at] == 0xFF:
            kind = 0xFF00 + data[at + 1]
            size, at = _length(data, at + 2)
            events.append((tick, kind, data[at : at + size]))
            at += size
            running = 0
            continue
        if data[at] == 0xF0:
            size, at = _length(data, at + 1)
            events.append((tick, 0xF000, data[at : at + size]))
            at += size
            running = 0
            continue
        if data[at] >= 0x80:
            running, at = data[at], at + 1
        assert 0x80 <= running < 0xF0, "neither a voice message nor a meta event"
        size = 1 if running & 0xF0 in (0xC0, 0xD0) else 2
        body = data[at : at + size]
        assert max(body) < 0x80
        events.append((tick, running, body))
        at += size
    assert at == len(data)
    return events


def parse_smf(data: bytes) -> Smf:
    """Parse a MIDI file of type 1; fails for any invalid byte."""
    assert data[:4] == b"MThd"
    size, kind, count, division = struct.unpack(">IHHH", data[4:14])
    assert (size, kind) == (6, 1)
    assert 0 < division < 0x8000
    smf = Smf(division)
    at = 14
    for _ in range(count):
        assert data[at : at + 4] == b"MTrk"
        (size,) = struct.unpack(">I", data[at + 4 : at + 8])
        smf.tracks.append(_track(data[at + 8 : at + 8 + size]))
        at += 8 + size
    assert at == len(data)
    return smf


def parse_wav(path: Path) -> Any:
    """Return the samples of a WAV file: (N, 2) within -1 to 1."""
    with wave.open(str(path)) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (2, 3, 48_000)
        raw = np.frombuffer(file.readframes(file.getnframes()), np.uint8).reshape(-1, 3)
    whole = np.zeros((raw.shape[0], 4), np.uint8)
    whole[:, 1:] = raw
    return (whole.view("<i4")[:, 0] / 2**31).reshape(-1, 2)


def is_on_scale(pitch: int, scale: Scale) -> bool:
    """Return whether a MIDI pitch belongs to a scale."""
    return (pitch - scale.root) % 12 in scale.intervals


_END = 0xFF2F


def _laws(smf: Smf, frames: int, rate: Any, drums: bool = False) -> None:
    """Assert the invariants of every file: length, no overlapping notes, ends at the last frame."""
    end = smf.tracks[0][-1][0]
    # Whole microseconds a beat, and before bar 1 the nearest tick.
    assert abs(smf.seconds(end) - frames / rate) <= 1e-5 + smf.seconds(1) / 2
    for track in smf.tracks:
        assert [tick for tick, kind, _ in track if kind == _END] == [end]
        assert track[-1][1] == _END
    sounding: dict[tuple[int, int, int], int] = {}
    programs: set[tuple[int, int]] = set()
    resets: set[int] = set()
    values: dict[tuple[int, int, int], bytes] = {}
    for tick, port, status, data in _by_port(smf):
        kind, channel = status & 0xF0, status & 15
        if status == 0xF000:
            assert (tick, data) == (0, b"\x7e\x7f\x09\x01\xf7"), "GM System On"
            resets.add(port)
        if status >= 0xF000:
            continue
        assert port in resets, "a port that is not reset at the start"
        key = port, channel, data[0]
        if kind == 0x90:
            assert key not in sounding, "a note that sounds already"
            sounding[key] = tick
        elif kind == 0x80:
            assert tick > sounding.pop(key), "shorter than a tick"
        elif kind == 0xC0:
            assert (port, channel) not in programs, "a program that changes"
            assert tick == 0
            programs.add((port, channel))
        elif kind == 0xE0 or (kind == 0xB0 and data[0] == 11):
            controller = port, status, data[0] if kind == 0xB0 else -1
            held = [each for each in sounding if each[:2] == (port, channel)]
            assert values.get(controller) == data or len(held) <= 1, "a bend of several notes"
            values[controller] = data
        assert drums or channel != 9, "the channel of drums"
    assert not sounding, "a note without an end"


def _by_port(smf: Smf) -> list[tuple[int, int, int, bytes]]:
    """Return (tick, port, status, data) of all events in playing order."""
    events = []
    for index, track in enumerate(smf.tracks):
        (port,) = [data[0] for _, kind, data in track if kind == 0xFF21] or [0]
        events += [
            (tick, index, place, port, status, data)
            for place, (tick, status, data) in enumerate(track)
        ]
    return [(tick, port, status, data) for tick, _, _, port, status, data in sorted(events)]


@pytest.fixture(scope="session")
def check_laws() -> Callable[..., None]:
    """Return the check of parsed MIDI files: file, frames and rate."""
    return _laws


@pytest.fixture(scope="session")
def read_smf() -> Callable[[bytes], Smf]:
    """Return the reader of MIDI bytes."""
    return parse_smf


@pytest.fixture(scope="session")
def read_wav() -> Callable[[Path], Any]:
    """Return the reader of WAV files."""
    return parse_wav


def _step(frame: int = 1, **changes: Any) -> ScoreEvent:
    fields: dict[str, Any] = {
        "time": Fraction(0),
        "cause": "footfall",
        "who": "bug",
        "part": "foot_l1",
        "other": "terrain",
        "material": "green chitin",
        "surface": "dry soil",
        "strength": 0.5,
        "size": 0.04,
        "distance": 4.0,
    }
    return ScoreEvent(frame=frame, **{**fields, **changes})


@pytest.fixture(scope="session")
def step() -> Callable[..., ScoreEvent]:
    """Return a factory of footfalls: frame, and fields that differ."""
    return _step


def _score(
    events: Any = (), frames: int = 24, rate: Any = 24, sound: Any = None, **rest: Any
) -> Score:
    config = Sound.model_validate(sound or {})
    return Score(Fraction(rate), frames, tuple(events), config, **rest)


@pytest.fixture(scope="session")
def score_of() -> Callable[..., Score]:
    """Return a factory of scores: events, frames, rate and sound configuration."""
    return _score


@pytest.fixture
def render(read_wav: Callable[[Path], Any], tmp_path: Path) -> Callable[..., Any]:
    """Return a function that renders a score in a dry room without mastering: (N, 2)."""

    def play(*args: Any, sound: Any = None, **fields: Any) -> Any:
        config = {"room": "dry", "master": "off", **(sound or {})}
        write_wav(_score(*args, sound=config, **fields), tmp_path / "render.wav")
        return read_wav(tmp_path / "render.wav")

    return play
