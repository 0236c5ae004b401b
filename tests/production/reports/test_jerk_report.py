"""Jerk report of figure 3, and the fit of gains."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.production.reports.jerk_fit import fit_jerk
from pipeline.production.reports.jerk_report import report_jerk
from pipeline.production.reports.jerk_trials import agreements, trials_of
from pipeline.production.run.order import Order
from pipeline.production.run.reporters import reporter_for
from pipeline.simulation.dancers.paper_jerk import PAPER_JERK
from pipeline.spec import read_scene

SCENE = "pronk: 1\nduration: 12\ncast: [{name: adonis, dancer: torso}]\n"

SHORT = """pronk: 1
duration: 5
dances:
  two: {bar: 2, subtasks: [{touch: belly, hand: r}, {reach: [0.4, 1.4, -0.3], hand: l}]}
cast: [{name: adonis, dancer: torso, dance: two, tempo_bpm: 60}]
"""


@pytest.fixture(scope="module")
def trials():
    return {trial.name: trial for trial in trials_of(read_scene(SCENE))}


@pytest.mark.nightly
def test_trials_have_figure_threes_durations_and_equal_ones(trials) -> None:
    names = ["figure 3's durations", "human durations", "equal durations, 1 s"]
    assert list(trials) == names
    dance = read_scene(SCENE).dances["macarena"]
    for by, column in trials[names[0]].columns.items():
        for k, one in column.movements.items():
            assert one.jerk.time == pytest.approx(dance.durations[by][k])
    for column in trials[names[2]].columns.values():
        assert {round(one.jerk.time, 9) for one in column.movements.values()} == {1.0}
    # Fields turn no hands.
    for trial in trials.values():
        assert set(trial.columns["torque"].movements) == set(range(12))
        assert set(trial.columns["force"].movements) == set(range(12)) - {2, 3}


@pytest.mark.nightly
def test_no_subtask_beats_its_floor_and_every_one_is_bounded(trials) -> None:
    for trial in trials.values():
        for column in trial.columns.values():
            for k, one in column.movements.items():
                # Between its own ends, but for what the filter and differences round.
                assert one.jerk.integral > 0.9 * one.floor, (trial.name, column.name, k)
                assert one.energy < 150.0
                assert one.torque < 120.0
                assert np.isfinite(one.jerk.integral)


@pytest.mark.nightly
def test_no_subtask_has_less_jerk_than_the_best_timing_of_its_path(trials) -> None:
    for trial in trials.values():
        for column in trial.columns.values():
            assert set(column.smoothest) == set(column.movements)
            for k, best in column.smoothest.items():
                one, what = column.movements[k], (trial.name, column.name, k)
                assert best.danced == one.jerk.integral, what
                assert best.integral <= one.jerk.integral, what
                # A straight path between the same ends has no more.
                assert best.integral > 0.95 * one.floor, what
                # Where a hand moves, better timing alone lowers the jerk.
                if one.jerk.distance > 0.05:
                    assert best.integral < 0.95 * one.jerk.integral, what


@pytest.mark.nightly
def test_at_equal_durations_the_ranks_of_torques_agree_with_the_paper(trials) -> None:
    found = {(a.ours, a.theirs): a.rank for a in agreements(trials["equal durations, 1 s"])}
    # Subtasks of high jerk in the paper have high jerk here.
    assert found["torque", "torque"] > 0.6
    assert found["force", "force"] > 0.3
    # Slow fields have less jerk than quick torques, at figure 3's durations, for slowness alone.
    columns = trials["figure 3's durations"].columns
    quick, slow = (
        sum(one.jerk.integral for k, one in columns[by].movements.items() if k not in (2, 3))
        for by in ("torque", "force")
    )
    assert slow < 0.1 * quick


@pytest.mark.nightly
def test_the_report_has_both_columns_and_writes_table_and_plots(tmp_path: Path) -> None:
    order = Order(read_scene(SCENE), "adonis", tmp_path)
    report = report_jerk(order, reporter_for(False, True, False))
    for column in PAPER_JERK.values():
        for value in column:
            assert f" {value} " in report.text or value is None
    for word in ("10 Hz", "60 Hz", "720", "m²/s⁵", "m²/s⁶", "compensated", "subtasks 3 and 4"):
        assert word in report.text
    table = (tmp_path / "adonis" / "adonis_jerk.csv").read_text().splitlines()
    rows = list(csv.DictReader(table))
    assert len(rows) == 3 * (12 + 10)
    for row in rows:
        mean = float(row["C_m2_s5"]) / float(row["T_s"])
        assert float(row["mean_m2_s6"]) == pytest.approx(mean, rel=1e-4, abs=1e-4)
        assert float(row["same_way_m2_s5"]) <= float(row["C_m2_s5"])
    assert (tmp_path / "adonis" / "adonis_jerk.svg").read_text().count("<path") > 40
    assert (tmp_path / "adonis" / "adonis_jerk.png").stat().st_size > 20_000
    json.dumps(report.facts)
    assert len(report.facts) == 3


@pytest.mark.slow
def test_other_dances_are_reported_without_figure_three(tmp_path: Path) -> None:
    report = report_jerk(
        Order(read_scene(SHORT), "two", tmp_path), reporter_for(False, True, False)
    )
    assert "1998" not in report.text
    assert "at equal durations, 1 s" in report.text
    assert (tmp_path / "two" / "two_jerk.png").stat().st_size > 5_000
    (facts,) = report.facts
    assert facts["rank_correlations"] == {}
    for column in facts["columns"].values():
        assert column["2"]["dimensionless"] > 600


@pytest.mark.nightly
def test_fitted_gains_lower_the_jerk_and_still_reach() -> None:
    fitted = fit_jerk(read_scene(SHORT), reporter_for(False, True, False))
    assert fitted.facts[0]["less"] > 0.005
    gains = ", ".join(f"{name}: {value}" for name, value in fitted.facts[0]["gains"].items())
    again = read_scene(SHORT.replace("tempo_bpm", f"gains: {{{gains}}}, tempo_bpm"))
    assert again.dancers[0][1].gains.model_dump() | fitted.facts[0]["gains"] == (
        again.dancers[0][1].gains.model_dump()
    )


def test_a_scene_without_dancers_is_refused_with_a_hint() -> None:
    from pipeline.errors import UsageError

    scene = read_scene("pronk: 1\nduration: 1\ncast: [{prop: {shape: box}}]\n")
    with pytest.raises(UsageError, match="give a dancer: dancer: torso"):
        trials_of(scene)
