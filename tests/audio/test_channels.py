"""Channels: notes share, differ or give way, and what gives way is counted."""

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from audio.channels import CHANNELS, Placed, allocate

TAIL = 20


def note(track=0, start=0, end=10, program=0, pan=64, pitch=60, velocity=80):
    return Placed(track, start, end, program, pan, pitch, velocity)


def placed(*notes):
    ordered = sorted(notes, key=lambda n: (n.start, n.track))
    return allocate([replace(n) for n in ordered], TAIL)


def messages(played):
    """Return (tick, track, place, kind, note): a player's order, ends before onsets in a track."""
    ends = [(n.end, n.track, (0, i), "off", n) for i, n in enumerate(played)]
    onsets = [(n.start, n.track, (1, i), "on", n) for i, n in enumerate(played)]
    return sorted(ends + onsets, key=lambda m: m[:3])


def check(played):
    sounding, program, pan = {}, {}, {}
    for tick, _, _, kind, n in messages(played):
        if kind == "off":
            assert sounding.pop((n.channel, n.pitch)) is n
            assert tick > n.start
            continue
        assert n.channel in CHANNELS
        held = [key for key in sounding if key[0] == n.channel]
        assert not (held and (n.sets_program or n.sets_pan)), "changed under a sounding note"
        program |= {n.channel: n.program} if n.sets_program else {}
        pan |= {n.channel: n.pan} if n.sets_pan else {}
        assert (program[n.channel], pan[n.channel]) == (n.program, n.pan)
        assert (n.channel, n.pitch) not in sounding, "struck while it sounds"
        sounding[n.channel, n.pitch] = n


@settings(max_examples=300)
@given(
    st.lists(
        st.builds(
            lambda track, start, length, program, pan, pitch, velocity: note(
                track, start, start + length, program, pan, pitch, velocity
            ),
            st.integers(0, 3),
            st.integers(0, 8),
            st.integers(1, 6),
            st.integers(0, 6),
            st.sampled_from([0, 64, 127]),
            st.integers(60, 62),
            st.integers(1, 127),
        ),
        max_size=80,
    )
)
def test_however_notes_meet_a_player_hears_each_with_its_program_and_pan(notes):
    played, losses = placed(*notes)
    check(played)
    assert len(played) + losses.merged + losses.dropped == len(notes)


def test_notes_of_one_program_and_pan_share_a_channel():
    played, _ = placed(note(pitch=60), note(pitch=64), note(pitch=67))
    assert len({n.channel for n in played}) == 1
    assert [n.sets_program for n in played] == [True, False, False]


def test_the_same_pitch_again_has_another_channel_and_keeps_its_tail():
    played, losses = placed(note(start=0, end=10), note(start=5, end=15))
    assert played[0].channel != played[1].channel
    assert played[0].end == 10
    assert losses.cut_short == 0


def test_an_end_in_a_later_track_does_not_silence_an_onset_on_its_tick():
    played, _ = placed(note(track=1, end=10), note(track=0, start=10, end=20))
    assert played[0].channel != played[1].channel
    check(played)


def test_an_end_in_an_earlier_track_leaves_the_channel_for_its_tick():
    played, _ = placed(note(track=0, end=10), note(track=1, start=10, end=20))
    assert played[0].channel == played[1].channel


def test_equal_onsets_merge_into_the_harder_one():
    played, losses = placed(note(velocity=50), note(track=1, velocity=90))
    assert [n.velocity for n in played] == [90]
    assert losses.merged == 1


def test_a_sixteenth_program_is_dropped_while_fifteen_sound():
    played, losses = placed(*(note(track=i, program=i) for i in range(16)))
    assert len(played) == 15
    assert losses.dropped == 1


def test_a_sixteenth_direction_moves_to_the_nearest():
    pans = [8 * i for i in range(15)]
    played, losses = placed(*(note(pan=p) for p in pans), note(track=1, pan=27, pitch=61))
    assert played[-1].pan == 24
    assert (losses.moved, losses.dropped) == (1, 0)


def test_with_all_channels_held_a_pitch_struck_again_cuts_the_earlier_one():
    held = [note(program=i, end=50) for i in range(15)]
    played, losses = placed(*held, note(start=20, end=60, program=3))
    assert (played[3].end, played[15].start) == (20, 20)
    assert losses.cut_short == 1
    check(played)
    played, _ = placed(
        *(replace(n, track=1) for n in held), note(track=0, start=20, end=60, program=3)
    )
    assert played[3].end == 19
    check(played)


def test_a_dying_tail_is_taken_over_only_when_nothing_is_quiet():
    held = [note(program=i, end=10) for i in range(15)]
    _, losses = placed(*held, note(start=10 + TAIL, end=60, program=20))
    assert losses.tails_cut == 0
    _, losses = placed(*held, note(start=9 + TAIL, end=60, program=20))
    assert losses.tails_cut == 1
    _, losses = placed(*held[:14], note(start=11, end=60, program=20))
    assert losses.tails_cut == 0
