"""Quantisation: onsets on the grid of a tempo and on frames, and the statistics of the shifts."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.beat_clock import beat_clock
from audio.config.quantisation import GRIDS, Quantisation, beats_of_grid
from audio.midi_file import midi_bytes, write_midi
from audio.notes import arrange, notes_of
from audio.quantisation import quantise
from audio.wav_file import write_wav

RATES = [Fraction(r) for r in (10, 12, 24, 25, 30, 50, 60, 72, 144)]
RATES += [Fraction(r * 1000, 1001) for r in (24, 30, 60)]


def on_grid(score_of, frames_shown, step, tempo=120.0, frames=96, rate=24, **config):
    """Return a score of quantised steps at frames."""
    subframe = config.pop("subframe", False)
    sound = {"tempo_bpm": tempo, "quantise": config}
    events = [step(f, part=f"foot_{i}") for i, f in enumerate(frames_shown)]
    return score_of(events, frames, rate, sound, subframe=subframe)


def onset_frames(score):
    return [note.onset * score.rate + 1 for note in notes_of(score)]


def test_grids_are_note_values():
    assert [beats_of_grid(g) for g in ("1/4", "1/8", "1/16", "1/8T", "1/8D", "1/1")] == [
        1, Fraction(1, 2), Fraction(1, 4), Fraction(1, 3), Fraction(3, 4), 4,
    ]  # fmt: skip
    assert len({beats_of_grid(grid) for grid in GRIDS}) == len(GRIDS)


def test_without_quantisation_nothing_moves(step, score_of):
    score = score_of([step(f) for f in (2, 5, 11)])
    assert onset_frames(score) == [2, 5, 11]
    assert arrange(score).shifts.events == 0


def test_notes_move_to_the_nearest_grid_point_the_later_of_two(step, score_of):
    # At 120 beats a minute eighths are six frames: 1, 7, 13, 19 ...
    score = on_grid(score_of, (1, 3, 4, 9, 12, 96), step, grid="1/8")
    assert onset_frames(score) == [1, 1, 7, 7, 13, 91]
    shifts = arrange(score).shifts
    assert (shifts.events, shifts.moved, shifts.earlier) == (6, 5, 3)
    assert shifts.greatest == Fraction(5, 24)
    assert shifts.mean == Fraction(2 + 3 + 2 + 1 + 5, 5 * 24)


def test_mode_next_never_sounds_before_its_cause(step, score_of):
    score = on_grid(score_of, (1, 2, 6, 7, 96), step, grid="1/8", mode="next")
    # After frame 91 the film has no grid point left.
    assert onset_frames(score) == [1, 7, 7, 7, 96]


def test_half_strength_moves_half_the_way_to_a_whole_frame(step, score_of):
    score = on_grid(score_of, (3, 11), step, grid="1/8", strength=0.5)
    assert onset_frames(score) == [2, 12]
    assert onset_frames(on_grid(score_of, (3, 11), step, grid="1/8", strength=0)) == [3, 11]


def test_swing_delays_every_second_grid_point_and_offset_all(step, score_of):
    swung = on_grid(score_of, (1, 7, 9, 13), step, grid="1/8", swing=0.75)
    assert onset_frames(swung) == [1, 10, 10, 13]
    assert onset_frames(on_grid(score_of, (1, 7), step, grid="1/8", offset=0.125)) == [4, 10]


def test_a_voice_can_opt_out_of_quantisation(step, score_of):
    sound = {"quantise": {"grid": "1/4"}, "voices": [{"when": {"who": "b"}, "quantise": False}]}
    score = score_of([step(6, who="a"), step(6, who="b")], sound=sound)
    assert {n.event.who: n.onset * 24 + 1 for n in notes_of(score)} == {"a": 1, "b": 6}
    assert arrange(score).shifts.events == 1


@settings(max_examples=150)
@given(
    rate=st.sampled_from(RATES),
    tempo=st.floats(10, 480),
    grid=st.sampled_from(GRIDS),
    frame=st.integers(1, 50),
    strength=st.floats(0, 1),
    swing=st.floats(0.5, 0.75),
    mode=st.sampled_from(["nearest", "next"]),
    offset=st.floats(-5, 5),
)
def test_quantised_onsets_satisfy_the_definition_of_the_grid(
    step, score_of, rate, tempo, grid, frame, strength, swing, mode, offset
):
    config = Quantisation(grid=grid, strength=strength, swing=swing, mode=mode, offset=offset)
    score = score_of(frames=50, rate=rate)
    onset = Fraction(frame - 1) / rate
    clock = beat_clock(Fraction(str(tempo)), Fraction(str(offset)))
    drawn = quantise(onset, config, score, clock)
    assert (drawn * rate).denominator == 1
    assert 0 <= drawn < 50 / rate
    pair = 2 * 60 / Fraction(str(tempo)) * beats_of_grid(grid)
    # At most the wider of two steps, and half a frame of rounding.
    far = pair * Fraction(str(swing))
    assert abs(drawn - onset) <= far + Fraction(1, 2) / rate
    if mode == "next":
        assert drawn >= onset
    if strength == 0:
        assert drawn == onset
    if strength == 1 and drawn != onset:
        into = (drawn - Fraction(str(offset))) % pair
        gaps = [into, pair - into, abs(into - pair * Fraction(str(swing)))]
        assert min(gaps) <= Fraction(1, 2) / rate


@pytest.mark.sample(4)
@pytest.mark.slow
@pytest.mark.parametrize("rate", RATES, ids=str)
def test_quantised_midi_is_on_frames_and_the_sound_follows(
    step, score_of, read_smf, check_laws, read_wav, tmp_path, rate
):
    score = on_grid(score_of, range(2, 60, 5), step, 97.0, 60, rate, grid="1/8T", swing=0.6)
    report = write_midi(score, tmp_path / "score.mid")
    smf = read_smf((tmp_path / "score.mid").read_bytes())
    check_laws(smf, 60, rate)
    grid = arrange(score).plan.grid
    ticks = {tick for tick, *_ in smf.onsets()}
    at = {note.onset for note in notes_of(score)}
    assert ticks == {grid.tick_at(time) for time in at} == {tick for tick, _ in smf.texts(0xFF07)}
    assert all((time * rate).denominator == 1 for time in at)
    assert all(abs(smf.seconds(tick) - grid.seconds(tick)) <= 1e-5 for tick in ticks)
    assert report.shifts.moved > 0
    write_wav(score, tmp_path / "score.wav")
    sound = abs(read_wav(tmp_path / "score.wav")).max(axis=1)
    first = min(at)
    sample = int(first * 48_000 + Fraction(1, 2))
    assert not sound[:sample].any()
    assert sound[sample : sample + 24].any()


def test_subframe_notes_are_exactly_on_the_grid(step, score_of):
    score = on_grid(score_of, (3, 9), step, 97.0, grid="1/8", subframe=True)
    eighth = Fraction(30, 97)
    assert all((note.onset / eighth).denominator == 1 for note in notes_of(score))


def test_a_phrase_starts_at_the_quantised_onset(step, score_of):
    sound = {
        "quantise": {"grid": "1/4"},
        "voices": [{"phrase": {"steps": [0, 1], "beats": 0.25}}],
    }
    score = score_of([step(11)], 48, sound=sound)
    assert onset_frames(score) == [13, 16]


def test_one_event_on_the_last_frame_and_no_events(step, score_of, read_smf, check_laws):
    for shown in ((24,), ()):
        score = on_grid(score_of, shown, step, frames=24, grid="1/1")
        smf = read_smf(midi_bytes(score))
        check_laws(smf, 24, Fraction(24))
        assert len(smf.onsets()) == len(shown)
        assert arrange(score).shifts.events == len(shown)
