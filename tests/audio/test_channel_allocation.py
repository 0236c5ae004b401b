"""Channel allocation: notes share, change or lose channels, and every compromise is counted."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.channel_allocation import CHANNELS, DRUM_CHANNEL, ChannelNote, allocate_channels
from audio.controller_curves import ControllerPoint

TAIL = 20


def note(track=0, start=0, end=10, program=0, pan=64, pitch=60, velocity=80, **rest):
    return ChannelNote(track, start, end, program, pan, pitch, velocity, **rest)


def slide(start=0, end=10, **fields):
    """Return a note whose pitch and loudness fall from tick to tick."""
    curve = tuple(
        ControllerPoint(t, -100 * (t - start), 127 - (t - start)) for t in range(start, end)
    )
    return note(start=start, end=end, curve=curve, **fields)


def allocated(*notes):
    ordered = sorted(notes, key=lambda n: (n.start, n.track))
    return allocate_channels([replace(n) for n in ordered], TAIL)


def messages(played):
    """Return (tick, track, order, kind, note) in playing order, ends before onsets in a track."""
    ends = [(n.end, n.track, (0, i), "off", n) for i, n in enumerate(played)]
    onsets = [(n.start, n.track, (1, i), "on", n) for i, n in enumerate(played)]
    return sorted(ends + onsets, key=lambda m: m[:3])


def check(played):
    sounding, program, pan, send, moved = {}, {}, {}, {}, set()
    for tick, _, _, kind, n in messages(played):
        if kind == "off":
            assert sounding.pop((n.channel, n.pitch)) is n
            assert tick > n.start
            continue
        assert (n.channel, n.pitch) not in sounding, "a note that sounds already"
        if n.drum:
            assert n.channel == DRUM_CHANNEL
            assert not any((n.sets_program, n.sets_pan, n.sets_send, n.curve))
            sounding[n.channel, n.pitch] = n
            continue
        assert n.channel in CHANNELS
        held = [key for key in sounding if key[0] == n.channel]
        told = program.get(n.channel), pan.get(n.channel), send.get(n.channel)
        changes = told != (n.program, n.pan, n.send)
        assert not (held and changes), "a change under a sounding note"
        assert not (held and (n.curve or n.channel in moved)), "a bend under a sounding note"
        assert not any(sounding[key].curve for key in held), "a note beside a controller curve"
        if n.curve:
            assert n.start == n.curve[0].tick
            assert n.curve[-1].tick < n.end
            moved.add(n.channel)
        else:
            assert n.resets_controllers or n.channel not in moved
            moved.discard(n.channel)
        program |= {n.channel: n.program} if n.sets_program else {}
        pan |= {n.channel: n.pan} if n.sets_pan else {}
        send |= {n.channel: n.send} if n.sets_send else {}
        told = program[n.channel], pan[n.channel], send[n.channel]
        assert told == (n.program, n.pan, n.send)
        sounding[n.channel, n.pitch] = n


def check_track_alone(played):
    """Assert that a track alone sets the controllers of its notes."""
    program, pan, send, ranged, moved = {}, {}, {}, set(), set()
    for n in played:
        if n.drum:
            continue
        program |= {n.channel: n.program} if n.sets_program else {}
        pan |= {n.channel: n.pan} if n.sets_pan else {}
        send |= {n.channel: n.send} if n.sets_send else {}
        told = program[n.channel], pan[n.channel], send[n.channel]
        assert told == (n.program, n.pan, n.send)
        ranged |= {n.channel} if n.sets_bend_range else set()
        assert not n.curve or n.channel in ranged
        moved -= {n.channel} if n.resets_controllers else set()
        assert n.curve or n.channel not in moved
        moved |= {n.channel} if n.curve else set()


@pytest.mark.slow
@settings(max_examples=300)
@given(
    st.lists(
        st.builds(
            lambda kind, start, length, **fields: (slide if kind == "slide" else note)(
                start=start,
                end=start + length,
                **fields,
                **{"drum": True} if kind == "drum" else {},
            ),
            st.sampled_from(["note", "note", "slide", "drum"]),
            st.integers(0, 8),
            st.integers(1, 6),
            track=st.integers(0, 3),
            program=st.integers(0, 20),
            pan=st.sampled_from([0, 64, 127]),
            send=st.sampled_from([0, 0, 64]),
            pitch=st.integers(60, 62),
            velocity=st.integers(1, 127),
        ),
        max_size=80,
    )
)
def test_any_notes_are_played_with_their_program_and_pan(notes):
    played, losses = allocated(*notes)
    check(played)
    for track in range(4):
        check_track_alone([n for n in played if n.track == track])
    assert len(played) + len(losses.merged) == len(notes)
    # Every merged note has an equal one at its tick or at the tick before.
    struck = {n.start for n in played}
    assert all(tick in struck or tick - 1 in struck for tick in losses.merged)


def test_notes_of_one_program_and_pan_share_a_channel():
    played, _ = allocated(note(pitch=60), note(pitch=64), note(pitch=67))
    assert len({n.channel for n in played}) == 1
    assert [n.sets_program for n in played] == [True, False, False]


def test_a_repeated_pitch_gets_another_channel_and_keeps_its_tail():
    played, losses = allocated(note(start=0, end=10), note(start=5, end=15))
    assert played[0].channel != played[1].channel
    assert played[0].end == 10
    assert losses.cut_short == 0


def test_an_end_in_a_later_track_does_not_silence_an_onset_on_its_tick():
    played, _ = allocated(note(track=1, end=10), note(track=0, start=10, end=20))
    assert played[0].channel != played[1].channel
    check(played)


def test_an_end_in_an_earlier_track_leaves_the_channel_for_its_tick():
    held = [note(program=i, end=99) for i in range(1, 15)]
    played, losses = allocated(note(track=0, end=10), *held, note(track=1, start=10, end=20))
    assert played[0].channel == played[-1].channel
    assert (played[0].end, losses.cut_short) == (10, 0)


def test_equal_notes_merge_into_the_louder_one():
    played, losses = allocated(note(velocity=50), note(velocity=90))
    assert [n.velocity for n in played] == [90]
    assert losses.merged == [0]


def test_equal_notes_of_two_tracks_merge_only_without_a_silent_channel():
    twins = [note(velocity=50), note(track=1, velocity=90)]
    played, losses = allocated(*twins)
    assert [(n.track, n.velocity) for n in played] == [(0, 50), (1, 90)]
    assert losses.merged == []
    played, losses = allocated(*twins, *(note(program=i) for i in range(1, 15)))
    assert [n.velocity for n in played if n.program == 0] == [90]
    assert losses.merged == [0]


def test_a_sixteenth_program_at_once_merges_with_the_most_similar_note():
    crowd = [note(track=i, program=i, pitch=60 + i) for i in range(15)]
    played, losses = allocated(*crowd, note(track=15, program=15, pitch=66, velocity=99))
    assert len(played) == 15
    assert losses.merged == [0]
    assert {n.pitch: n.velocity for n in played} == {n.pitch: 80 for n in crowd} | {66: 99}


def test_a_sixteenth_program_later_steals_the_oldest_channel():
    crowd = [note(start=i, end=50, program=i) for i in (3, 1, 2, *range(4, 16))]
    played, losses = allocated(*crowd, note(start=20, end=60, program=99))
    first = next(n for n in played if n.program == 1)
    assert (first.end, first.channel) == (20, played[-1].channel)
    assert (losses.cut_short, losses.merged) == (1, [])
    check(played)


def test_a_note_with_a_curve_has_its_channel_alone_and_resets_it():
    played, _ = allocated(
        slide(), note(start=5, pitch=64), note(start=40, end=50, pitch=62), slide(60, 70)
    )
    slid, beside, after, again = played
    assert slid.channel != beside.channel
    assert (slid.sets_bend_range, again.sets_bend_range and again.channel == slid.channel) == (
        True,
        False,
    )
    assert [n.resets_controllers for n in played] == [
        False,
        False,
        after.channel == slid.channel,
        False,
    ]
    check(played)


def test_a_note_on_a_used_channel_restores_its_controllers():
    others = [note(start=20, end=99, program=i) for i in range(1, 15)]
    played, _ = allocated(slide(), *others, note(start=50, end=60))
    assert (played[0].channel, played[-1].resets_controllers) == (played[-1].channel, True)
    check(played)


def test_a_curve_is_dropped_without_a_silent_channel():
    held = [note(program=i, end=50) for i in range(15)]
    played, losses = allocated(*held, slide(0, 60, program=3, pitch=64))
    assert played[-1].curve == ()
    assert (played[-1].channel, losses.without_curve) == (played[3].channel, 1)
    check(played)


def test_a_note_with_a_curve_steals_an_older_channel_without_one():
    held = [slide(0, 99), *(note(start=i, end=99, program=i) for i in range(1, 15))]
    played, losses = allocated(*held, slide(20, 60, program=20))
    assert (played[0].end, played[1].end, played[-1].channel) == (99, 20, played[1].channel)
    assert bool(played[-1].curve)
    assert (losses.without_curve, losses.cut_short) == (0, 1)
    check(played)


def test_each_track_sets_the_controllers_of_its_own_notes():
    played, _ = allocated(
        note(program=5, pan=0), note(track=1, start=40, end=50, program=5, pan=0), slide(60, 70),
        note(track=1, start=80, end=90),
    )  # fmt: skip
    first, other, slid, back = played
    assert other.channel == first.channel
    assert (other.sets_program, other.sets_pan) == (True, True)
    for track in (0, 1):
        check_track_alone([n for n in played if n.track == track])
    assert back.resets_controllers == (back.channel == slid.channel)


def test_drums_use_their_channel_and_a_key_sounds_once():
    played, losses = allocated(
        *(note(drum=True, pitch=38, program=i, pan=p) for i, p in ((0, 0), (5, 127))),
        note(start=5, end=15, drum=True, pitch=38),
        note(start=5, end=15, drum=True, pitch=42),
        note(start=5, end=15, pitch=38),
    )
    assert [(n.channel, n.start, n.end) for n in played] == [
        (9, 0, 5), (9, 5, 15), (9, 5, 15), (0, 5, 15),
    ]  # fmt: skip
    assert (losses.merged, losses.cut_short) == ([0], 1)
    check(played)


def test_a_sixteenth_pan_moves_to_the_nearest():
    pans = [8 * i for i in range(15)]
    played, losses = allocated(*(note(pan=p) for p in pans), note(track=1, pan=27, pitch=61))
    assert played[-1].pan == 24
    assert (losses.pan_changed, losses.merged) == (1, [])


def test_another_reverb_send_gets_another_channel_if_one_is_free():
    played, losses = allocated(note(send=0), note(send=64, pitch=64), note(send=0, pitch=67))
    assert [n.channel for n in played][::2] == [played[0].channel] * 2
    assert played[1].channel != played[0].channel
    assert [n.sets_send for n in played] == [True, True, False]
    assert losses.reverb_changed == 0


def test_without_a_free_channel_a_note_takes_the_nearest_reverb_send():
    held = [note(pan=0, send=s) for s in (0, 32)] + [note(program=i) for i in range(1, 14)]
    played, losses = allocated(*held, note(track=1, pan=0, send=96, pitch=61))
    assert (played[-1].pan, played[-1].send) == (0, 32)
    assert (losses.pan_changed, losses.reverb_changed, losses.merged) == (0, 1, [])
    check(played)


def test_without_a_free_channel_a_repeated_pitch_cuts_the_earlier_note():
    held = [note(program=i, end=50) for i in range(15)]
    played, losses = allocated(*held, note(start=20, end=60, program=3))
    assert (played[3].end, played[15].start) == (20, 20)
    assert losses.cut_short == 1
    check(played)
    played, _ = allocated(
        *(replace(n, track=1) for n in held), note(track=0, start=20, end=60, program=3)
    )
    assert played[3].end == 19
    check(played)


def test_a_ringing_channel_is_reused_only_if_none_is_quiet():
    held = [note(program=i, end=10) for i in range(15)]
    _, losses = allocated(*held, note(start=10 + TAIL, end=60, program=20))
    assert losses.tails_cut == 0
    _, losses = allocated(*held, note(start=9 + TAIL, end=60, program=20))
    assert losses.tails_cut == 1
    _, losses = allocated(*held[:14], note(start=11, end=60, program=20))
    assert losses.tails_cut == 0
