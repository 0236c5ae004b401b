"""Pan and reverb: from where a sound is, or as the author says."""

from math import sqrt

import pytest
import symusic
from hypothesis import given
from hypothesis import strategies as st

from audio.loudness_at_listener import CRITICAL_DISTANCE, reverb_send
from audio.midi_file import midi_bytes
from audio.notes import notes_of


def test_at_the_critical_distance_room_and_source_have_the_same_power():
    assert reverb_send(CRITICAL_DISTANCE, 1.0) == pytest.approx(sqrt(0.5))
    for distance in (0.1, 1.0, 30.0):
        room = reverb_send(distance, 1.0) ** 2
        assert room / (1 - room) == pytest.approx((distance / CRITICAL_DISTANCE) ** 2)


@given(st.floats(0, 1e300), st.floats(0, 1e300), st.floats(0, 1))
def test_farther_is_wetter_and_never_more_than_is_asked_for(one, other, reverb):
    near, far = sorted((one, other))
    assert 0 <= reverb_send(near, reverb) <= reverb_send(far, reverb) <= reverb


def test_a_voice_says_its_own_share_and_side(step, score_of):
    events = [step(1, who="a", azimuth=1.0), step(1, who="b", azimuth=1.0)]
    sound = {"reverb": 0.8, "voices": [{"when": {"who": "b"}, "reverb": 0, "pan": -1}]}
    a, b = notes_of(score_of(events, sound=sound))
    assert (a.send, b.send) == (reverb_send(4.0, 0.8), 0.0)
    assert a.effective_pan == pytest.approx(0.8415, abs=1e-4)
    assert b.effective_pan == -1


def test_the_score_says_side_and_reverb_to_another_reader(step, score_of):
    events = [step(1, distance=0.1), step(9, distance=10.0), step(17, distance=1e4)]
    sound = {"reverb": 1.0, "voices": [{"pan": 1}]}
    tracks = symusic.Score.from_midi(midi_bytes(score_of(events, sound=sound))).tracks
    told = sorted((c.time, c.number, c.value) for track in tracks for c in track.controls)
    assert [value for _, number, value in told if number == 91] == [0, 96, 127]
    assert {value for _, number, value in told if number == 10} == {127}


def test_without_words_a_walk_by_a_camera_needs_few_steps_of_reverb(step, score_of):
    events = [step(i + 1, distance=1 + i / 2) for i in range(40)]
    data = midi_bytes(score_of(events, 48))
    reverbs = [
        c.value for t in symusic.Score.from_midi(data).tracks for c in t.controls if c.number == 91
    ]
    assert set(reverbs) == {0, 32, 64}
