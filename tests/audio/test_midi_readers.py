"""The MIDI file in other libraries: exact onsets over hours, names and instruments."""

from __future__ import annotations

import io
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mido
import pretty_midi
import pytest
import symusic

from audio.midi_file import midi_bytes

NTSC = [Fraction(r * 1000, 1001) for r in (24, 30, 60)]
RATES = [Fraction(r) for r in (10, 12, 15, 16, 18, 24, 25, 30, 48, 50, 60, 72, 90, 100, 120)]
RATES += [Fraction(144), Fraction(240), *NTSC]


def with_mido(data: bytes) -> list[Fraction]:
    """Return the exact times of all onsets [s] from ticks and tempo as mido reads them."""
    file = mido.MidiFile(file=io.BytesIO(data), charset="utf-8")
    assert file.type == 1
    (tempo,) = [m.tempo for track in file.tracks for m in track if m.type == "set_tempo"]
    tick = Fraction(tempo, file.ticks_per_beat * 1_000_000)
    onsets = []
    for track in file.tracks:
        now = 0
        for message in track:
            now += message.time
            if message.type == "note_on" and message.velocity:
                onsets.append(now * tick)
    return sorted(onsets)


def with_symusic(data: bytes) -> list[Fraction]:
    """Return the exact times of all onsets [s] from ticks and tempo as symusic reads them."""
    score = symusic.Score.from_midi(data)
    (tempo,) = score.tempos
    tick = Fraction(tempo.mspq, score.ticks_per_quarter * 1_000_000)
    return sorted(note.time * tick for track in score.tracks for note in track.notes)


READERS = {"mido": with_mido, "symusic": with_symusic}


@pytest.fixture(params=READERS.values(), ids=READERS)
def times(request: pytest.FixtureRequest) -> Callable[[bytes], list[Fraction]]:
    """Return a reader of exact onsets."""
    reader: Callable[[bytes], list[Fraction]] = request.param
    return reader


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_every_reader_finds_exact_onsets(
    step: Any, score_of: Any, times: Any, rate: Fraction
) -> None:
    shown = [1, 2, 3, 24, 1001, 2998, 3000]
    data = midi_bytes(score_of([step(frame) for frame in shown], 3000, rate))
    assert times(data) == [(frame - 1) / rate for frame in shown]


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_pretty_midi_reads_onsets_within_a_microsecond(
    step: Any, score_of: Any, rate: Fraction
) -> None:
    shown = [1, 2, 3, 24, 1001, 2998, 3000]
    data = midi_bytes(score_of([step(frame) for frame in shown], 3000, rate))
    read = pretty_midi.PrettyMIDI(io.BytesIO(data))
    onsets = [note.start for instrument in read.instruments for note in instrument.notes]
    # Its seconds are floats, its ticks are not.
    assert sorted(onsets) == pytest.approx([float((f - 1) / rate) for f in shown], abs=1e-6)
    ticks = sorted(round(read.time_to_tick(onset)) for onset in onsets)
    tick = Fraction(1) / (rate * (ticks[1] - ticks[0]))
    assert [t * tick for t in ticks] == [(f - 1) / rate for f in shown]


THREE_HOURS = 3 * 3600 * 60


@pytest.mark.parametrize("rate", [Fraction(60), Fraction(60000, 1001)], ids=str)
def test_three_hours_at_sixty_frames_a_second_stay_exact(
    step: Any, score_of: Any, read_smf: Any, check_laws: Any, times: Any, rate: Fraction
) -> None:
    shown = [1, *range(59, THREE_HOURS, 9973), THREE_HOURS]
    data = midi_bytes(score_of([step(frame) for frame in shown], THREE_HOURS, rate))
    assert times(data) == [(frame - 1) / rate for frame in shown]
    smf = read_smf(data)
    assert [smf.seconds(tick) for tick, *_ in smf.onsets()] == times(data)
    check_laws(smf, THREE_HOURS, rate)


def test_pretty_midi_stops_at_ten_million_ticks(step: Any, score_of: Any) -> None:
    """Pins a limit that the documentation mentions."""
    last = 10_000_000 // 40 - 1
    pretty_midi.PrettyMIDI(io.BytesIO(midi_bytes(score_of([step(1)], last))))
    with pytest.raises(ValueError, match="largest tick"):
        pretty_midi.PrettyMIDI(io.BytesIO(midi_bytes(score_of([step(1)], last + 1))))


def test_one_event_on_the_last_frame_is_one_note_as_long_as_that_frame(
    step: Any, score_of: Any, read_smf: Any, check_laws: Any, times: Any
) -> None:
    data = midi_bytes(score_of([step(48)], 48))
    assert times(data) == [Fraction(47, 24)]
    check_laws(read_smf(data), 48, Fraction(24))
    ((note,),) = (track.notes for track in symusic.Score.from_midi(data).tracks)
    assert (note.time, note.duration) == (47 * 40, 40)


def test_a_score_without_events_has_no_notes(score_of: Any, times: Any) -> None:
    assert times(midi_bytes(score_of(frames=48))) == []


def test_names_survive_a_round_trip(step: Any, score_of: Any) -> None:
    who = "Käfer ☃ 甲虫"
    data = midi_bytes(score_of([step(1, who=who)], title="Über"))
    assert [track.name for track in symusic.Score.from_midi(data).tracks] == [who]
    file = mido.MidiFile(file=io.BytesIO(data), charset="utf-8")
    assert [track.name for track in file.tracks] == ["Über", who]


def test_each_track_keeps_its_instruments_in_other_readers(step: Any, score_of: Any) -> None:
    happened = [
        step(1 + 3 * i, who=f"bug {i % 7}", material=("steel", "glass")[i % 2], azimuth=i % 3 - 1)
        for i in range(200)
    ]
    data = midi_bytes(score_of(happened, 700))
    for tracks in (
        symusic.Score.from_midi(data).tracks,
        pretty_midi.PrettyMIDI(io.BytesIO(data)).instruments,
    ):
        assert sum(len(track.notes) for track in tracks) == 200
        assert {track.program for track in tracks} == {11, 8}
        assert {track.name for track in tracks} == {f"bug {i}" for i in range(7)}


def test_other_readers_recognise_drums(step: Any, score_of: Any) -> None:
    sound = {"voices": [{"drum": "cowbell"}]}
    data = midi_bytes(score_of([step(1), step(9)], sound=sound))
    (track,) = symusic.Score.from_midi(data).tracks
    assert (track.is_drum, [note.pitch for note in track.notes]) == (True, [56, 56])
    (kit,) = pretty_midi.PrettyMIDI(io.BytesIO(data)).instruments
    assert (kit.is_drum, len(kit.notes)) == (True, 2)
