"""Random voices, grids and curves: the MIDI file is valid and on frames."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from audio.config.quantisation import GRIDS
from audio.midi_file import write_midi
from audio.tempo_plan import tempo_plan

RATES = [Fraction(r) for r in (10, 12, 15, 18, 24, 25, 30, 50, 60, 72, 144, 240)]
RATES += [Fraction(r * 1000, 1001) for r in (24, 30, 60)]

NAMES = ("bug", "Käfer", "甲虫")
CAUSES = ("footfall", "roll", "boing", "swoosh")

steps = st.one_of(
    st.integers(-20, 20),
    st.lists(st.integers(-20, 20), min_size=1, max_size=5),
    st.fixed_dictionaries({"chord": st.sampled_from(["Am9", "C", "F#m7b5"])}),
)
phrases = st.builds(
    lambda steps, unit, time: {"steps": [0, "rest", *steps], unit: time},
    st.lists(steps, max_size=5),
    st.sampled_from(["beats", "seconds"]),
    st.floats(0.01, 1.5),
)
whens = st.fixed_dictionaries(
    {},
    optional={
        "who": st.sampled_from(NAMES),
        "cause": st.sampled_from(CAUSES),
        "strength": st.just({"above": 2}),
    },
)
plain = {
    "octave": st.integers(-8, 8),
    "transpose": st.integers(-48, 48),
    "pitch": st.sampled_from(["by foot", "by size", "by part from D2", 0, 127]),
    "scale": st.sampled_from(["Am7", "D dorian", "chromatic"]),
    "pan": st.floats(-1, 1),
    "reverb": st.floats(0, 1),
    "velocity": st.integers(1, 127) | st.sampled_from([{"curve": "linear"}, {"exponent": 2.0}]),
    "quantise": st.booleans(),
    "mute": st.booleans(),
}
voices = st.one_of(
    st.fixed_dictionaries({"when": whens}, optional={**plain, "phrase": phrases}),
    st.fixed_dictionaries({"when": whens, "chord": st.just("Em7")}, optional=plain),
    st.fixed_dictionaries({"when": whens, "drum": st.just("maracas")}),
)
grids = st.fixed_dictionaries(
    {"grid": st.sampled_from(GRIDS)},
    optional={
        "strength": st.floats(0, 1),
        "swing": st.floats(0.5, 0.75),
        "offset": st.floats(-2, 2),
        "mode": st.sampled_from(["nearest", "next"]),
    },
)
sounds = st.fixed_dictionaries(
    {"voices": st.lists(voices, max_size=4), "tempo_bpm": st.floats(10, 480)},
    optional={
        "quantise": grids,
        "reverb": st.floats(0, 1),
        "tracks": st.sampled_from(["performer", "cause"]),
    },
)


@st.composite
def happenings(draw: Any, step: Any, frames: int) -> Any:
    return step(
        draw(st.sampled_from([1, frames]) | st.integers(1, frames)),
        who=draw(st.sampled_from(NAMES)),
        part=draw(st.sampled_from(["foot_l1", "foot_r1", "fuß", ""])),
        cause=draw(st.sampled_from(CAUSES)),
        strength=draw(st.floats(0, 20)),
        distance=draw(st.floats(0, 100)),
        azimuth=draw(st.floats(-3, 3)),
        duration=draw(st.sampled_from([0.0, 0.4])),
        speeds=draw(st.sampled_from([(), (1.0, 2.0, 1.0)])),
    )


@pytest.mark.slow
@settings(max_examples=80)
@given(data=st.data(), rate=st.sampled_from(RATES), frames=st.integers(1, 60), sound=sounds)
def test_any_configuration_gives_a_valid_file_on_frames(
    step: Any,
    score_of: Any,
    read_smf: Any,
    check_laws: Any,
    tmp_path_factory: Any,
    data: Any,
    rate: Fraction,
    frames: int,
    sound: dict[str, Any],
) -> None:
    happened = data.draw(st.lists(happenings(step, frames), max_size=25))
    path = tmp_path_factory.mktemp("any") / "score.mid"
    score = score_of(happened, frames, rate, sound)
    report = write_midi(score, path)
    smf = read_smf(path.read_bytes())
    check_laws(smf, frames, rate, drums=True)
    grid = tempo_plan(score).grid
    starts = {grid.tick(frame) for frame in range(1, frames + 1)}
    at = {tick for tick, *_ in smf.onsets()}
    assert at <= starts
    opened = len(happened) - report.muted
    assert len(smf.onsets()) == report.notes == opened + report.added - len(report.losses.merged)
    cues = [tick for tick, _ in smf.texts(0xFF07)]
    assert len(cues) == opened
    # A merged note is never a frame's only note.
    assert set(cues) <= set(at)
