"""Parts: one channel for an instrument of a performer, and what its notes share."""

from __future__ import annotations

import io
from collections import Counter, defaultdict
from fractions import Fraction
from typing import Any

import mido
import pretty_midi
import pytest
import symusic
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.controller_curves import ControllerPoint
from audio.errors import ScoreError
from audio.midi_file import midi_bytes, write_midi
from audio.part_notes import PartNote, settle_notes
from audio.parts import DRUM_CHANNEL, DRUMS, MEMBER_CHANNELS, Part, PartKey, lay_out

MPE = {"mpe": True}


def key(performer: str, program: int = 0) -> PartKey:
    return PartKey(performer, performer, program)


def note(start: int = 0, end: int = 10, pitch: int = 60, velocity: int = 80, **rest: Any) -> Any:
    return PartNote(start, end, pitch, velocity, **rest)


def slide(start: int = 0, end: int = 10, **fields: Any) -> Any:
    curve = tuple(ControllerPoint(t, start - t, 127 - t + start) for t in range(start, end))
    return note(start, end, curve=curve, **fields)


PART = Part(key("a"), 0, 0)
MPE_PART = Part(key("a"), 0, 0, mpe=True)


def test_each_part_has_a_channel_for_itself() -> None:
    keys = [key(f"p{i}", program) for i in range(30) for program in (8, 11, DRUMS)]
    tracks = lay_out(keys)
    parts = [part for track in tracks for part in track.parts]
    assert sorted(part.key for part in parts) == sorted(keys)
    assert len({(part.port, part.channel) for part in parts}) == len(parts)
    assert all((part.channel == DRUM_CHANNEL) == (part.key.program == DRUMS) for part in parts)
    # A performer with room on one port is one track.
    assert [track.name for track in tracks] == sorted({each.track for each in keys})


def test_fifteen_parts_and_drums_need_one_port() -> None:
    keys = [key(f"p{i:02d}", i) for i in range(15)]
    assert {track.port for track in lay_out([*keys, key("p00", DRUMS)])} == {0}
    assert {track.port for track in lay_out([*keys, key("p15")])} == {0, 1}


def test_two_drummers_have_two_ports() -> None:
    assert [track.port for track in lay_out([key("ida", DRUMS), key("tom", DRUMS)])] == [0, 1]


def test_a_performer_with_many_instruments_has_several_tracks() -> None:
    tracks = lay_out([key("orchestra", program) for program in range(40)])
    assert [(track.name, track.port, len(track.parts)) for track in tracks] == [
        ("orchestra", 0, 15), ("orchestra", 1, 15), ("orchestra", 2, 10),
    ]  # fmt: skip


def test_more_parts_than_ports_hold_are_refused() -> None:
    lay_out([key(f"p{i}", DRUMS) for i in range(128)])
    with pytest.raises(ScoreError, match="need 129 MIDI ports"):
        lay_out([key(f"p{i}", DRUMS) for i in range(129)])


def test_with_mpe_each_part_has_a_port() -> None:
    tracks = lay_out([key("a", 3), key("a", 4), key("b", 3), key("b", DRUMS)], mpe=True)
    assert [(track.name, track.port) for track in tracks] == [
        ("a", 0), ("a", 1), ("b", 2), ("b", 3),
    ]  # fmt: skip
    assert [part.mpe for track in tracks for part in track.parts] == [True, True, True, False]


def test_a_key_struck_twice_on_a_tick_is_one_note_the_louder_and_longer() -> None:
    played, losses = settle_notes(PART, [note(velocity=90), note(end=20, velocity=50)])
    assert [(n.velocity, n.end) for n in played] == [(90, 20)]
    assert losses.merged == [0]


def test_notes_of_one_tick_have_one_place() -> None:
    notes = [note(pan=0, velocity=90), note(pitch=62, pan=90, velocity=30), note(5, pan=127)]
    played, _ = settle_notes(PART, notes)
    assert [n.pan for n in played] == [23, 23, 127]


def test_a_key_struck_within_its_length_ends_its_earlier_note() -> None:
    played, losses = settle_notes(PART, [slide(), note(4, 14), note(14, 20)])
    assert [(n.start, n.end) for n in played] == [(0, 4), (4, 14), (14, 20)]
    assert all(point.tick < 4 for point in played[0].curve)
    assert (losses.merged, losses.cut_short, losses.without_curve) == ([], 1, 0)


def test_a_note_bends_where_it_sounds_alone() -> None:
    alone = [slide(), slide(10, 20, pitch=62)]
    played, losses = settle_notes(PART, alone)
    assert all(n.curve for n in played)
    together = [slide(), slide(5, 15, pitch=62)]
    played, losses = settle_notes(PART, together)
    assert not any(n.curve for n in played)
    assert losses.without_curve == 2
    played, losses = settle_notes(MPE_PART, [slide(), slide(5, 15, pitch=62)])
    assert all(n.curve for n in played)
    assert len({n.channel for n in played}) == 2


def test_with_mpe_a_key_sounds_on_several_channels() -> None:
    played, losses = settle_notes(MPE_PART, [note() for _ in range(15)])
    assert sorted(n.channel for n in played) == list(MEMBER_CHANNELS)
    _, losses = settle_notes(MPE_PART, [note() for _ in range(17)])
    assert len(losses.merged) == 2


@pytest.mark.slow
@settings(max_examples=200)
@given(
    st.lists(
        st.builds(
            lambda bends, start, length, **fields: (slide if bends else note)(
                start, start + length, **fields
            ),
            st.booleans(),
            st.integers(0, 8),
            st.integers(1, 6),
            pitch=st.integers(60, 62),
            velocity=st.integers(1, 127),
        ),
        max_size=60,
    ),
    st.booleans(),
)
def test_any_notes_are_played_or_counted(notes: list[Any], mpe: bool) -> None:
    notes.sort(key=lambda n: (n.start, -n.velocity))
    struck = Counter((n.start, n.pitch) for n in notes)
    played, losses = settle_notes(MPE_PART if mpe else PART, notes)
    assert len(played) + len(losses.merged) == len(notes)
    assert {(n.start, n.pitch) for n in played} == set(struck)
    for i, a in enumerate(played):
        assert a.end > a.start
        assert all(a.start <= point.tick < a.end for point in a.curve)
        for b in played[i + 1 :]:
            overlap = a.channel == b.channel and a.start < b.end and b.start < a.end
            assert not (overlap and (a.pitch == b.pitch or a.curve or b.curve))


def test_two_performers_never_merge(step: Any, score_of: Any, tmp_path: Any) -> None:
    sound = {"voices": [{"drum": "hand clap"}]}
    clap = [step(frame, who=who) for frame in (1, 13) for who in ("ida", "tom")]
    report = write_midi(score_of(clap, sound=sound), tmp_path / "score.mid")
    assert [(p.part.key.performer, len(p.notes)) for p in report.parts] == [("ida", 2), ("tom", 2)]
    assert report.losses.merged == []
    data = (tmp_path / "score.mid").read_bytes()
    for tracks in (
        symusic.Score.from_midi(data).tracks,
        pretty_midi.PrettyMIDI(io.BytesIO(data)).instruments,
    ):
        assert [(track.name, len(track.notes)) for track in tracks] == [("ida", 2), ("tom", 2)]
        assert all(track.is_drum for track in tracks)


def test_a_crowd_keeps_its_programs(
    step: Any, score_of: Any, read_smf: Any, check_laws: Any
) -> None:
    materials = ("chitin", "wood", "steel", "glass")
    crowd = [
        step(1 + i % 40, who=f"p{i % 24}", material=materials[i % 4], azimuth=i % 7 / 3 - 1)
        for i in range(960)
    ]
    data = midi_bytes(score_of(crowd, 48))
    check_laws(read_smf(data), 48, Fraction(24))
    changes: dict[str, list[int]] = defaultdict(list)
    for track in mido.MidiFile(file=io.BytesIO(data), charset="utf-8").tracks:
        now = 0
        for message in track:
            now += message.time
            if message.type == "program_change":
                changes[track.name].append(now)
    assert set(changes) == {f"p{i}" for i in range(24)}
    assert all(not any(ticks) for ticks in changes.values())


def test_with_mpe_notes_bend_by_themselves(step: Any, score_of: Any, read_smf: Any) -> None:
    slides = [
        step(1 + i, cause="slide", part=f"p{i}", size=0.1 + i / 20, duration=1.0, speeds=(2.0, 1.0))
        for i in range(3)
    ]
    plain = read_smf(midi_bytes(score_of(slides, 48)))
    bends = [k for track in plain.tracks for _, k, _ in track if k < 0xF000 and k & 0xF0 == 0xE0]
    assert not bends
    smf = read_smf(midi_bytes(score_of(slides, 48, sound=MPE)))
    messages = [(k, d) for track in smf.tracks for _, k, d in track if k < 0xF000]
    bent = {k & 15 for k, _ in messages if k & 0xF0 == 0xE0}
    pressed = {k & 15 for k, _ in messages if k & 0xF0 == 0xD0}
    assert len(bent) == 3
    assert bent == pressed == {channel for _, channel, *_ in smf.onsets()} <= set(MEMBER_CHANNELS)
    # The manager's channel has the zone of fifteen channels.
    configured = [d for k, d in messages if k == 0xB0]
    assert configured[:3] == [bytes([101, 0]), bytes([100, 6]), bytes([6, 15])]


def test_the_file_resets_its_receivers_first(step: Any, score_of: Any) -> None:
    (conductor, track) = mido.MidiFile(file=io.BytesIO(midi_bytes(score_of([step(1)])))).tracks
    assert [m.bytes() for m in conductor if m.type == "sysex"] == [
        [0xF0, 0x7E, 0x7F, 0x09, 0x01, 0xF7]
    ]
    assert [m.type for m in track if not m.is_meta][:2] == ["program_change", "control_change"]
