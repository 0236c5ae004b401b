"""Phrases: the notes that answer an event, on frames."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.midi_file import midi_bytes, write_midi
from audio.notes import arrange, notes_of

RATES = [Fraction(r) for r in (10, 12, 24, 25, 30, 50, 60, 72, 144)]
RATES += [Fraction(r * 1000, 1001) for r in (24, 30, 60)]


def phrased(score_of, events, phrase, frames=240, rate=24, sound=(), voice=(), **rest):
    voices = [{"pitch": 60, "phrase": phrase, **dict(voice)}]
    return score_of(events, frames, rate, {"voices": voices, **dict(sound)}, **rest)


def test_degrees_count_scale_steps_from_the_events_pitch(step, score_of):
    score = phrased(score_of, [step(25)], [0, 1, "rest", [0, 2], -5, {"chord": "Fm"}])
    notes = notes_of(score)
    # C minor pentatonic; at 120 beats a minute a step of half a beat is six frames.
    assert [(n.onset * 24 + 1, n.pitch) for n in notes] == [
        (25, 60), (31, 63), (43, 60), (43, 65), (49, 48), (55, 65), (55, 68), (55, 72),
    ]  # fmt: skip
    assert [n.is_first for n in notes] == [True] + [False] * 7


def test_a_phrase_off_the_scale_keeps_its_first_note(step, score_of):
    notes = notes_of(phrased(score_of, [step()], [0, 5, 10], voice={"pitch": 61}))
    assert [n.pitch for n in notes] == [61, 73, 85]


@pytest.mark.parametrize(
    ("timing", "frames"),
    [
        ({"beats": 1}, [1, 19, 37]),
        ({"seconds": 0.25}, [1, 7, 13]),
        ({"frames": 5}, [1, 6, 11]),
        # 0.31 s are 7.44 frames: places are rounded, not lengths, so nothing adds up.
        ({"seconds": 0.31}, [1, 8, 16]),
    ],
)
def test_step_lengths_in_every_unit(step, score_of, timing, frames):
    score = phrased(score_of, [step()], {"steps": [0, 1, 2], **timing}, sound={"tempo_bpm": 80})
    assert [n.onset * 24 + 1 for n in notes_of(score)] == frames


def test_a_step_sets_its_own_time_gain_and_length(step, score_of):
    steps = [{"degrees": [0], "frames": 3, "gain_db": -6, "length": 2}, {"degrees": [1]}]
    first, second = notes_of(phrased(score_of, [step()], {"steps": steps, "frames": 8}))
    assert (first.onset, second.onset) == (0, Fraction(3, 24))
    assert second.level - first.level == pytest.approx(6)
    assert (first.seconds, second.seconds) == (2, 8 / 24)


steps = st.integers(-9, 9) | st.lists(st.integers(-9, 9), min_size=1, max_size=4)
timings = st.one_of(
    st.fixed_dictionaries({"beats": st.floats(0.01, 3)}),
    st.fixed_dictionaries({"seconds": st.floats(0.001, 1)}),
    st.fixed_dictionaries({"frames": st.integers(1, 20)}),
    st.just({}),
)


@settings(max_examples=60)
@given(
    phrase=st.lists(steps, min_size=1, max_size=8),
    timing=timings,
    rate=st.sampled_from(RATES),
    shown=st.lists(st.integers(1, 40), max_size=12),
    tempo=st.floats(10, 480),
)
def test_every_phrase_note_is_on_a_frame_or_counted_as_dropped(
    step, score_of, read_smf, check_laws, tmp_path_factory, phrase, timing, rate, shown, tempo
):
    events = [step(frame, part=f"foot_{i}") for i, frame in enumerate(shown)]
    score = phrased(
        score_of, events, {"steps": phrase, **timing}, 40, rate, sound={"tempo_bpm": tempo}
    )
    path = tmp_path_factory.mktemp("phrase") / "score.mid"
    report = write_midi(score, path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, 40, rate)
    grid = arrange(score).plan.grid
    frames = {grid.tick(frame): frame for frame in range(1, 41)}
    at = {tick for tick, *_ in smf.onsets()}
    assert at <= set(frames)
    assert set(shown) <= {frames[tick] for tick in at}
    wanted = sum(len(set(s)) if isinstance(s, list) else 1 for s in phrase) * len(shown)
    assert report.notes + len(report.losses.merged) + report.after_the_end == wanted
    assert len(smf.onsets()) == report.notes
    assert len(smf.texts(0xFF07)) == len(shown)


def test_a_subframe_phrase_continues_from_the_exact_time(step, score_of):
    time = Fraction(1, 24) - Fraction(1, 1000)
    score = phrased(
        score_of, [step(2, time=time)], {"steps": [0, 1], "seconds": 0.1}, subframe=True
    )
    assert [n.onset for n in notes_of(score)] == [time, time + Fraction(1, 10)]


def test_notes_after_the_last_frame_are_dropped_and_counted(step, score_of, read_smf, check_laws):
    score = phrased(score_of, [step(24)], {"steps": [0, 1, 2], "frames": 1}, frames=24)
    spoken = arrange(score)
    assert (len(spoken.notes), spoken.after_the_end) == (1, 2)
    smf = read_smf(midi_bytes(score))
    check_laws(smf, 24, Fraction(24))
    assert [smf.seconds(t) for t, *_ in smf.onsets()] == [Fraction(23, 24)]


def test_a_sustained_sound_happens_once_in_its_phrase(step, score_of):
    event = step(1, cause="roll", duration=1.0, speeds=(1.0, 2.0, 1.0))
    first, second = notes_of(phrased(score_of, [event], [0, 1]))
    assert first.event == event
    assert (second.event.duration, second.event.speeds) == (0.0, ())


def test_a_drum_plays_the_rhythm_of_a_phrase(step, score_of):
    voices = [{"drum": "maracas", "phrase": {"steps": [0, 0, "rest", 0], "frames": 2}}]
    notes = notes_of(score_of([step()], sound={"voices": voices}))
    assert not any(note.tuned for note in notes)
    assert [(n.onset * 24, n.pitch, n.drum) for n in notes] == [(f, 70, True) for f in (0, 2, 6)]
