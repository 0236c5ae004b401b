"""The MIDI file, read by an independent parser and by symusic."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import pytest
import symusic
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.errors import AudioError, ScoreError, SoundFileError
from audio.midi_file import midi_bytes, write_midi
from audio.score import Marker

RATES = [Fraction(r) for r in (10, 12, 15, 16, 24, 25, 30, 48, 50, 60, 100, 120, 240)]
RATES += [Fraction(r * 1000, 1001) for r in (24, 30, 60)]
RATES += [Fraction(r) for r in (18, 72, 90, 144)]

CUE, MARKER, NAME, TITLE, SMPTE = 0xFF07, 0xFF06, 0xFF03, 0xFF01, 0xFF54


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_every_onset_is_exactly_on_its_frame(step, score_of, read_smf, check_laws, rate):
    frames = 3000
    shown = [1, 2, 3, 5, 47, 999, 1000, 1001, 2398, 2999, 3000]
    data = midi_bytes(score_of([step(frame) for frame in shown], frames, rate))
    smf = read_smf(data)
    assert [smf.seconds(tick) for tick, *_ in smf.onsets()] == [(f - 1) / rate for f in shown]
    assert [smf.seconds(tick) for tick, _ in smf.texts(CUE)] == [(f - 1) / rate for f in shown]
    check_laws(smf, frames, rate)

    other = symusic.Score.from_midi(data)
    (tempo,) = other.tempos
    beat = Fraction(tempo.mspq, 1_000_000)
    times = sorted(
        note.time * beat / other.ticks_per_quarter for track in other.tracks for note in track.notes
    )
    assert times == [(f - 1) / rate for f in shown]


names = st.text(st.characters(exclude_categories=["Cc"]), max_size=12)


@st.composite
def events(draw, step, frames):
    return step(
        draw(st.sampled_from([1, frames]) | st.integers(1, frames)),
        who=draw(st.sampled_from(["bug", "Käfer", "甲虫", "\ud800"]) | names),
        part=draw(st.sampled_from(["foot_l1", "foot_r1", ""])),
        cause=draw(st.sampled_from(["footfall", "collision", "swoosh", "boing"])),
        material=draw(st.sampled_from(["chitin", "wood", "steel", "glass", "bone", "rock", ""])),
        strength=draw(st.floats(-1e300, 1e300)),
        energy=draw(st.floats(0, 1e300)),
        size=draw(st.floats(1e-300, 1e300)),
        distance=draw(st.floats(0, 1e300)),
        azimuth=draw(st.floats(-7, 7)),
        duration=draw(st.floats(0, 3)),
        speeds=tuple(draw(st.lists(st.floats(0, 1e300), max_size=5))),
    )


@pytest.mark.slow
@settings(max_examples=60)
@given(data=st.data(), rate=st.sampled_from(RATES), frames=st.integers(1, 40))
def test_any_score_gives_a_valid_file_and_counts_its_losses(
    step, score_of, read_smf, check_laws, tmp_path_factory, data, rate, frames
):
    happened = data.draw(st.lists(events(step, frames), max_size=60))
    path = tmp_path_factory.mktemp("midi") / "score.mid"
    report = write_midi(score_of(happened, frames, rate), path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, frames, rate)
    assert len(smf.onsets()) == report.notes
    assert report.notes + len(report.losses.merged) + report.muted == len(happened)
    cues = Counter(tick for tick, _ in smf.texts(CUE))
    ticks = smf.seconds(1)
    assert cues == Counter(int((e.frame - 1) / rate / ticks) for e in happened)
    # Every frame with a cause has an onset: what is lost is never a frame's only note.
    assert {tick for tick, *_ in smf.onsets()} == set(cues)


@pytest.mark.slow
def test_five_thousand_events_in_two_seconds_are_all_accounted_for(
    step, score_of, read_smf, check_laws, tmp_path
):
    materials = ("chitin", "wood", "steel", "glass", "bone", "rock", "rubber", "plastic")
    crash = [
        step(
            1 + i % 48,
            who=f"brick {i % 40}",
            part=f"corner {i % 17}",
            material=materials[i % 8],
            size=0.02 + i % 17 / 10,
            azimuth=i % 31 / 10 - 1.5,
            strength=1 + i % 5,
        )
        for i in range(5000)
    ]
    path = tmp_path / "crash.mid"
    report = write_midi(score_of(crash, 48), path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, 48, Fraction(24))
    assert len(smf.texts(CUE)) == 5000
    assert len(report.losses.merged) > 0
    assert sum(report.merged_by_frame.values()) == len(report.losses.merged)
    assert {tick for tick, *_ in smf.onsets()} == {40 * i for i in range(48)}
    assert report.notes == len(smf.onsets()) == 5000 - len(report.losses.merged)
    read = symusic.Score.from_midi(path.read_bytes())
    assert sum(len(track.notes) for track in read.tracks) == report.notes


def test_the_order_of_events_does_not_matter(step, score_of):
    happened = [step(1 + i % 7, part=f"foot_{i % 5}", azimuth=i / 9 - 1) for i in range(40)]
    assert midi_bytes(score_of(happened)) == midi_bytes(score_of(happened[::-1]))


def test_names_title_and_causes_are_utf8(step, score_of, read_smf):
    happened = [step(3, who="Käfer", part="fuß", other="甲")]
    smf = read_smf(midi_bytes(score_of(happened, title="Über Stock ☃")))
    assert [text for _, text in smf.texts(NAME)] == ["Über Stock ☃", "Käfer"]
    assert "title: Über Stock ☃" in [text for _, text in smf.texts(TITLE)]
    assert smf.texts(CUE) == [(80, "footfall: Käfer.fuß > 甲")]


def test_each_performer_has_one_track_with_its_own_notes(step, score_of, read_smf):
    happened = [step(1, who="b"), step(2, who="a"), step(3, who="b", part="foot_l2")]
    smf = read_smf(midi_bytes(score_of(happened)))
    named = {
        track[0][2].decode(): sum(s & 0xF0 == 0x90 for _, s, _ in track if s < 0xF000)
        for track in smf.tracks
    }
    assert named == {"score": 0, "a": 1, "b": 2}


def test_tracks_by_cause_on_request(step, score_of, read_smf):
    happened = [step(1, who="b"), step(2, who="a"), step(3, who="b", cause="collision")]
    smf = read_smf(midi_bytes(score_of(happened, sound={"tracks": "cause"})))
    assert [text for _, text in smf.texts(NAME)] == ["score", "collision", "footfall"]
    strikes = [sum(s & 0xF0 == 0x90 for _, s, _ in t if s < 0xF000) for t in smf.tracks]
    assert strikes == [0, 1, 2]


def test_markers_and_cues_are_on_their_frames(step, score_of, read_smf):
    markers = (Marker(3, "cut", "side of Käfer"), Marker(7, "script", "Käfer: go_to [3, 4]"))
    smf = read_smf(midi_bytes(score_of([step(7)], markers=markers)))
    assert smf.texts(MARKER) == [
        (80, "cut: side of Käfer"),
        (240, "script: Käfer: go_to [3, 4]"),
    ]
    assert {tick for tick, kind, _ in smf.tracks[0] if kind in (MARKER, CUE)} == {80, 240}


def test_drums_use_the_drum_channel(step, score_of, read_smf, check_laws):
    sound = {"voices": [{"when": {"who": "b"}, "drum": "Low Wood-Block"}]}
    happened = [step(1, who="a"), step(1, who="b"), step(1, who="c"), step(2, who="b")]
    smf = read_smf(midi_bytes(score_of(happened, sound=sound)))
    drummed = [(tick, pitch) for tick, channel, pitch, _ in smf.onsets() if channel == 9]
    assert drummed == [(0, 77), (40, 77)]
    assert len(smf.onsets()) == 4
    check_laws(smf, 24, Fraction(24), drums=True)


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_subframe_onsets_are_within_half_a_tick_of_their_causes(
    step, score_of, read_smf, check_laws, rate
):
    times = [Fraction(frame, 1) / rate - Fraction(1, 7919 + frame) / rate for frame in range(1, 48)]
    happened = [step(int(t * rate) + 2, time=t) for t in times]
    smf = read_smf(midi_bytes(score_of(happened, 60, rate, subframe=True)))
    check_laws(smf, 60, rate)
    for (tick, *_), (cue, _), time in zip(smf.onsets(), smf.texts(CUE), times, strict=True):
        assert abs(smf.seconds(tick) - time) <= smf.seconds(1) / 2
        assert cue == tick


def test_a_subframe_time_outside_the_film_is_refused(step, score_of):
    for time in (Fraction(-1, 10**9), Fraction(1)):
        with pytest.raises(ScoreError, match="lies outside the film"):
            midi_bytes(score_of([step(1, time=time)], subframe=True))


def test_no_events_give_a_silent_file_of_full_length(score_of, read_smf, check_laws):
    smf = read_smf(midi_bytes(score_of(frames=48)))
    check_laws(smf, 48, Fraction(24))
    assert smf.onsets() == []


@pytest.mark.parametrize(
    ("rate", "code"), [(24, 0), (25, 1), ("30000/1001", 2), (30, 3), (48, None), (60, None)]
)
def test_the_smpte_offset_exists_for_rates_with_a_code(score_of, read_smf, rate, code):
    smf = read_smf(midi_bytes(score_of(rate=Fraction(rate))))
    found = [data for _, kind, data in smf.tracks[0] if kind == SMPTE]
    assert found == ([] if code is None else [bytes([code << 5, 0, 0, 0, 0])])


def _struck(smf):
    """Return the (program, pan) of each note, in playing order."""
    program, pan, struck = {}, {}, []
    for _, status, data in smf.played():
        channel = status & 15
        if status >= 0xF000:
            continue
        if status & 0xF0 == 0xC0:
            program[channel] = data[0]
        elif status & 0xF0 == 0xB0 and data[0] == 10:
            pan[channel] = data[1]
        elif status & 0xF0 == 0x90:
            struck.append((program[channel], pan[channel]))
    return struck


def test_each_note_has_its_own_program_and_pan(step, score_of, read_smf):
    happened = [
        step(1, who="a", material="chitin", azimuth=-1.5),
        step(1, who="b", material="steel", azimuth=0),
        step(1, who="c", material="glass", azimuth=1.5),
        step(5, who="a", material="oak", azimuth=0.5),
    ]
    smf = read_smf(midi_bytes(score_of(happened)))
    assert _struck(smf) == [(108, 0), (11, 64), (8, 127), (12, 95)]


def test_pan_follows_the_azimuth(step, score_of, read_smf):
    angles = (-1.57, -0.8, -0.3, 0, 0.3, 0.8, 1.57)
    smf = read_smf(midi_bytes(score_of([step(i + 1, azimuth=a) for i, a in enumerate(angles)])))
    pans = [pan for _, pan in _struck(smf)]
    assert pans == sorted(set(pans))
    assert (pans[0], pans[3], pans[-1]) == (0, 64, 127)


@pytest.mark.parametrize(
    ("field", "values"),
    [("strength", (0.1, 0.5, 2.0)), ("distance", (20, 6, 2)), ("energy", (0.01, 0.1, 1))],
)
def test_stronger_nearer_and_heavier_events_have_higher_velocities(
    step, score_of, read_smf, field, values
):
    happened = [step(i + 1, **{field: value}) for i, value in enumerate(values)]
    hardness = [v for *_, v in read_smf(midi_bytes(score_of(happened))).onsets()]
    assert hardness == sorted(set(hardness))


def test_the_configured_length_is_the_notes_length(step, score_of, read_smf):
    sound = {"voices": [{"length": 0.25}]}
    smf = read_smf(midi_bytes(score_of([step(1)], sound=sound)))
    ticks = [tick for tick, status, _ in smf.tracks[1] if status & 0xF0 in (0x80, 0x90)][:2]
    assert smf.seconds(ticks[1] - ticks[0]) == Fraction(1, 4)


def test_a_muted_event_leaves_no_trace(step, score_of, tmp_path):
    sound = {"voices": [{"when": {"who": "b"}, "mute": True}]}
    both = score_of([step(1, who="a"), step(2, who="b")], sound=sound)
    report = write_midi(both, tmp_path / "both.mid")
    assert (report.notes, report.muted) == (1, 1)
    alone = midi_bytes(score_of([step(1, who="a")], sound=sound))
    assert (tmp_path / "both.mid").read_bytes() == alone


@pytest.mark.parametrize(
    "changes",
    [
        {"frame": 0},
        {"frame": 25},
        {"strength": float("nan")},
        {"azimuth": float("inf")},
        {"size": 0.0},
        {"distance": -1.0},
    ],
)
def test_an_invalid_event_is_refused(step, score_of, changes):
    with pytest.raises(ScoreError, match=r"footfall of bug\.foot_l1"):
        midi_bytes(score_of([replace(step(), **changes)]))


@pytest.mark.parametrize(("frames", "rate"), [(0, 24), (24, 0), (24, -24)])
def test_a_score_without_length_or_rate_is_refused(score_of, frames, rate):
    with pytest.raises(AudioError):
        midi_bytes(score_of(frames=frames, rate=rate))


def test_a_silence_longer_than_a_gap_of_the_format_is_written_in_parts(score_of, read_smf):
    longest = (2**28 - 1) // 40
    for frames in (longest, 3 * longest):
        smf = read_smf(midi_bytes(score_of(frames=frames)))
        assert smf.tracks[0][-1][0] == frames * 40


def test_an_equal_file_keeps_its_time_stamp_and_a_different_one_is_replaced(
    step, score_of, tmp_path
):
    path = tmp_path / "score.mid"
    assert write_midi(score_of([step(1)]), path).changed
    before = path.stat()
    assert not write_midi(score_of([step(1)]), path).changed
    assert path.stat().st_mtime_ns == before.st_mtime_ns
    assert path.stat().st_ino == before.st_ino
    assert write_midi(score_of([step(2)]), path).changed
    assert path.read_bytes() == midi_bytes(score_of([step(2)]))
    assert [p.name for p in tmp_path.iterdir()] == ["score.mid"]


def test_a_failure_keeps_the_earlier_file_and_leaves_no_partial_file(
    step, score_of, tmp_path, monkeypatch
):
    path = tmp_path / "score.mid"
    write_midi(score_of([step(1)]), path)
    earlier = path.read_bytes()

    def fail(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pipeline.atomic_file.os.replace", fail)
    with pytest.raises(SoundFileError, match="No space left"):
        write_midi(score_of([step(2)]), path)
    with pytest.raises(ScoreError):
        write_midi(score_of([step(99)]), path)
    assert path.read_bytes() == earlier
    assert [p.name for p in tmp_path.iterdir()] == ["score.mid"]


def test_a_missing_folder_is_an_audio_error(score_of, tmp_path):
    with pytest.raises(AudioError, match="nowhere"):
        write_midi(score_of(), tmp_path / "nowhere" / "score.mid")


def test_a_scuff_has_its_own_note_and_each_foot_its_pitch(step, score_of, read_smf):
    events = [
        step(1, cause="footfall", part="l1"),
        step(5, cause="scuff", part="l1"),
        step(9, cause="scuff", part="r1"),
    ]
    smf = read_smf(midi_bytes(score_of(events)))
    fall, left, right = ((pitch, velocity) for _, _, pitch, velocity in smf.onsets())
    assert left[0] == fall[0] != right[0]
    assert left[1] == right[1] < fall[1]
    programs = [program for program, _ in _struck(smf)]
    assert programs == [108, 120, 120]
