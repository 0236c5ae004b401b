"""Efforts: weight, flights, work, and the command that reports them."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline import cli
from pipeline.commands import options
from pipeline.errors import UsageError
from pipeline.production.reports.effort_report import facts, legged_of, torques_csv
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.effort import Effort, efforts_of
from pipeline.simulation.figures.inverse_dynamics import finite_difference_motion
from pipeline.simulation.simulate import simulate
from pipeline.simulation.spatial import Array, rotation
from pipeline.simulation.take_store import read_take, write_take
from pipeline.spec import read_scene

pytestmark = pytest.mark.nightly

HEAD = "pronk: 1\nduration: {}\nterrain: {{kind: flat, size: [60, 60]}}\ncast:\n"
CAST = """\
- {name: stool, figure: tripod}
- {name: mare, figure: horse, at: [0, 5], walk: {}}
- {name: pip, figure: person, at: [0, -5], walk: {gait: run, duty: 0.3}}
- {name: looper, figure: inchworm, at: [0, 9], walk: {}}
"""


@pytest.fixture(scope="module")
def found() -> dict[str, Effort]:
    """Efforts of a stool, a horse and a running person."""
    scene = read_scene(HEAD.format(2) + CAST)
    return {e.name: e for e in efforts_of(simulate(scene), legged_of(scene))}


@pytest.mark.slow
def test_every_creature_on_legs_has_an_effort(found: dict[str, Effort]) -> None:
    assert list(found) == ["stool", "mare", "pip"]


def test_a_standing_creature_carries_its_weight_and_does_no_work(
    found: dict[str, Effort],
) -> None:
    stool = found["stool"]
    total = stool.foot_forces.sum(axis=1)
    assert np.allclose(total, [0.0, stool.mass * GRAVITY, 0.0], rtol=1e-9, atol=1e-6)
    assert np.abs(stool.unbalanced_moment).max() < 1e-9 * stool.mass * GRAVITY
    assert (stool.foot_forces[..., 1] > 0.0).all()
    assert stool.energy == pytest.approx(0.0, abs=1e-6)
    assert stool.cost_of_transport is None


def test_a_walking_creature_carries_its_weight_on_average(found: dict[str, Effort]) -> None:
    """Over whole cycles the body rises as much as it falls."""
    mare = found["mare"]
    assert np.abs(mare.unsupported_force).max() < 1e-9 * mare.mass * GRAVITY
    up = mare.foot_forces[..., 1].sum(axis=1).mean()
    assert up == pytest.approx(mare.mass * GRAVITY, rel=0.03)


def test_a_creature_in_flight_falls_freely(found: dict[str, Effort]) -> None:
    """In mid-flight only the swinging limbs leave a residual force."""
    pip = found["pip"]
    flies = ~np.abs(pip.foot_forces).any(axis=(1, 2))
    deep = flies[:-4] & flies[1:-3] & flies[2:-2] & flies[3:-1] & flies[4:]
    assert deep.any()
    weight = pip.mass * GRAVITY
    assert np.abs(pip.unsupported_force[2:-2][deep, 1]).max() < 0.75 * weight
    # Feet that turn to come down on their soles add to that of thighs and shanks.
    assert np.abs(pip.unsupported_force[2:-2][deep, 1]).mean() < 0.37 * weight


def test_costs_of_transport_are_in_the_range_of_animals(found: dict[str, Effort]) -> None:
    """Costs of transport lie between those of passive walkers and of machines."""
    for name in ("mare", "pip"):
        effort = found[name]
        assert effort.cost_of_transport is not None
        assert 0.05 < effort.cost_of_transport < 3.0
        assert effort.mean_power * (effort.times[-1] - effort.times[0]) == pytest.approx(
            effort.energy
        )


def _error(rows: int) -> Array:
    """Return the errors of the derivatives of a motion in closed form."""
    t = np.linspace(0.0, 1.0, rows)
    axis = np.array([0.6, 0.0, 0.8])
    R, p = rotation(axis, np.sin(3 * t)), np.stack([np.cos(t), t**3, np.exp(t)], axis=-1)
    motion = finite_difference_motion(np.sin(2 * t)[:, None], R, p, float(t[1]))
    t = t[1:-1]
    expected = (
        (motion.speeds[:, 0], 2 * np.cos(2 * t)),
        (motion.accelerations[:, 0], -4 * np.sin(2 * t)),
        (motion.spin @ axis, 3 * np.cos(3 * t)),
        (motion.spin_rate @ axis, -9 * np.sin(3 * t)),
        (motion.acceleration[:, 0], -np.cos(t)),
    )
    return np.array([np.abs(a - b).max() for a, b in expected])


def test_a_stored_take_gives_the_same_efforts(tmp_path: Path) -> None:
    scene = read_scene(HEAD.format(0.5) + "- {name: bug, figure: beetle, walk: {}}\n")
    take = simulate(scene)
    write_take(take, tmp_path / "take.zarr")
    fresh, stored = (efforts_of(t, ["bug"])[0] for t in (take, read_take(tmp_path / "take.zarr")))
    assert fresh.torques.tobytes() == stored.torques.tobytes()
    assert facts(fresh) == facts(stored)


def test_derivatives_of_rows_are_of_second_order() -> None:
    coarse, fine = _error(51), _error(101)
    assert (fine < 1e-2).all()
    assert np.allclose(coarse / fine, 4.0, rtol=0.05)


def test_the_csv_holds_all_torques(found: dict[str, Effort]) -> None:
    rows = list(csv.reader(torques_csv([found["mare"], found["pip"]]).splitlines()))
    columns = found["mare"].torques.shape[1] + found["pip"].torques.shape[1]
    assert {len(row) for row in rows} == {1 + columns}
    values = np.array(rows[1:], dtype=float)
    assert np.allclose(values[:, 0], found["mare"].times, atol=1e-6)
    assert np.allclose(
        values[:, 1 + found["mare"].torques.shape[1] :], found["pip"].torques, rtol=1e-5
    )
    hip = rows[0].index("pip.l1.base_pitch")
    largest = facts(found["pip"])["largest_torques"]["l1.base_pitch"]
    assert np.abs(values[:, hip]).max() == pytest.approx(largest, rel=1e-5)


def called(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run a command and return its exit code."""
    monkeypatch.setattr(sys, "argv", ["pronk", *arguments])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, which holds scenes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "listen", lambda: None)
    monkeypatch.setattr(options.CURRENT, "options", options.Verbosity())
    bug = "- {name: bug, figure: beetle, walk: {}}\n"
    (tmp_path / "play.yaml").write_text(HEAD.format(0.5) + bug)
    (tmp_path / "flash.yaml").write_text(
        HEAD.format(0.5).replace("duration: 0.5", "frames: 1\nrows_per_frame: 1") + bug
    )
    (tmp_path / "worm.yaml").write_text(HEAD.format(0.5) + "- {figure: inchworm, walk: {}}\n")
    return tmp_path


def test_effort_command_prints_a_table_or_json_and_writes_a_csv(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert called(monkeypatch, "effort", "play", "--csv") == 0
    lines = capfd.readouterr().out.splitlines()
    assert lines[0].split()[:3] == ["mass", "way", "mean"]
    assert lines[1].startswith("bug")
    assert len((folder / lines[-1]).read_text().splitlines()) == 0.5 * 96
    assert called(monkeypatch, "effort", "play", "--json") == 0
    (bug,) = json.loads(capfd.readouterr().out.splitlines()[-1])["effort"]
    assert bug["name"] == "bug"
    assert f"{bug['energy']:.4g} J" in lines[1]


@pytest.mark.parametrize(
    ("name", "phrase"),
    [("flash", "too few to tell accelerations"), ("worm", "nobody in this scene stands on legs")],
)
def test_effort_command_refuses_with_one_message(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    name: str,
    phrase: str,
) -> None:
    assert called(monkeypatch, "effort", name) == UsageError.exit_code
    message = capfd.readouterr().err
    assert phrase in message
    assert "Traceback" not in message
    assert not (folder / "out" / name).exists()
