"""Buses: gains by cause, and an ambience that gives way to voices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from audio.ambience import AMBIENCES
from audio.buses import BUS_OF, bus_of
from audio.cause_voices import CAUSE_VOICES
from audio.notes import MUSIC, notes_of
from audio.time_grid import SAMPLE_RATE
from audio.wav_file import ambience_of, mix_notes, read_samples, write_wav


def test_every_cause_has_a_bus() -> None:
    assert BUS_OF.keys() <= {*CAUSE_VOICES, "footfall", MUSIC}
    causes = {*CAUSE_VOICES, "footfall", "collision"}
    assert {bus_of(cause) for cause in causes} == {"steps", "impacts", "voices", "motions"}


@pytest.mark.parametrize(("cause", "bus"), [("footfall", "steps"), ("collision", "impacts")])
def test_a_bus_turns_its_own_sounds_down(step, score_of, cause: str, bus: str) -> None:
    def level(**gains: float) -> float:
        score = score_of([step(2, cause=cause)], 24, sound={"mix": gains})
        return float(np.abs(mix_notes(score, notes_of(score), SAMPLE_RATE)).max())

    assert level(**{f"{bus}_db": -20}) == pytest.approx(0.1 * level(), rel=1e-6)
    assert level(motions_db=-20, ambience_db=-20) == level()


def test_the_ambience_gives_way_to_a_cry(step, score_of) -> None:
    samples = 6 * SAMPLE_RATE
    cry = step(49, cause="cry", duration=1.5)

    def bed(**mix: float) -> np.ndarray:
        score = score_of([cry], 144, sound={"mix": mix}, ambience=AMBIENCES["room"])
        found = ambience_of(score, notes_of(score), samples)
        assert found is not None
        return found

    ends = slice(100, -100)
    full, low = (np.abs(bed(duck_db=depth)).sum(axis=1) for depth in (0.0, 12.0))
    ratio = np.ones(samples)
    ratio[ends] = low[ends] / full[ends]
    assert ratio[SAMPLE_RATE] == pytest.approx(1.0, abs=1e-3)
    assert ratio[round(2.7 * SAMPLE_RATE)] == pytest.approx(10 ** (-12 / 20), abs=1e-3)
    assert ratio[round(4.5 * SAMPLE_RATE)] == pytest.approx(1.0, abs=1e-3)


def test_an_ambience_can_be_turned_up(score_of, tmp_path: Path) -> None:
    def level(gain: float) -> float:
        sound = {"mix": {"ambience_db": gain}}
        score = score_of([], 24, sound=sound, ambience=AMBIENCES["room"])
        report = write_wav(score, tmp_path / "a.wav")
        return float(np.sqrt(np.mean(read_samples(report.path, 0, SAMPLE_RATE) ** 2)))

    assert level(12) == pytest.approx(10 ** (12 / 20) * level(0), rel=0.01)
