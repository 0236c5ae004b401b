"""Jump report: its values are those of the simulated jumps."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline import cli
from pipeline.commands import options
from pipeline.errors import UsageError
from pipeline.production.reports.jump_report import facts, report_jumps, table
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.jump_summaries import JumpSummary, jump_summaries
from pipeline.simulation.locomotion.pronking.hop_simulation import HopSimulation
from pipeline.simulation.locomotion.pronking.hopper_troupe import HopperTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, read_scene

pytestmark = pytest.mark.nightly

HEAD = "pronk: 1\nduration: 9\nterrain: flat\ncast:\n"
ROO = (
    "{name: roo, figure: kangaroo, pronk: {distance: 1.6, height: 0.8, crouch: 0.6, max_force: 6}}"
)
CAST = (
    ROO,
    "{name: tic, figure: beetle, scale: 0.6, at: [0, 3], pronk: {speed: 3, direction_deg: 90}}",
    "{name: toc, figure: hopper, at: [0, 6], pronk: {land_at: [[1, 6], [2, 6.5]]}}",
    "{name: tac, figure: antelope, at: [0, 9], pronk: {distance: 2, speed: 5, balance: 3}}",
    "{name: weak, figure: antelope, at: [0, 12], pronk: {height: 1, max_force: 0.4}}",
)


def scene_of(*cast: str) -> Scene:
    return read_scene(HEAD + "".join(f"- {member}\n" for member in cast))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scene_of(*CAST)


@pytest.fixture(scope="module")
def found(scene: Scene) -> dict[str, JumpSummary]:
    """Return the jump plans of the scene."""
    return {plan.name: plan for plan in jump_summaries(scene)}


def forces(hopping: HopSimulation) -> np.ndarray:
    """Return the magnitude of the mean leg force of each row [N]."""
    legs = hopping.leg_forces()
    return np.linalg.norm(legs.sum(axis=0)) / len(legs)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name", ["roo", *(pytest.param(x, marks=pytest.mark.nightly) for x in ("tic", "tac"))]
)
def test_the_report_agrees_with_the_simulated_jump(
    found: dict[str, JumpSummary], scene: Scene, name: str
) -> None:
    row = facts(found[name])
    simulation = Simulation(scene)
    (troupe,) = (t for t in simulation.troupes if isinstance(t, HopperTroupe))
    hopping = troupe.simulations[troupe.herd.names.index(name)]
    seen: dict[str, list[float]] = {"pushing": [], "landing": []}
    lifts, crouches, touches = [], [], []
    while hopping.state.jump_count < 5 and not simulation.finished:
        before = hopping.state.phase
        simulation.step()
        state = hopping.state
        if state.jump_count == 4 and state.phase in seen and state.down.all():
            seen[state.phase].append(float(forces(hopping)))
        if before == "landing" and state.phase == "pushing":
            crouches.append(float(state.p[1]) - hopping.hopper.mass.centre[1])
        lifts += [h.time for h in hopping.events if h.kind == "lift"]
        touches += [h.time for h in hopping.events if h.kind == "touch"]
    n = len(hopping.hopper.hips)
    assert np.median(seen["pushing"]) == pytest.approx(row["push_force_newtons"], rel=0.01)
    assert np.median(seen["landing"]) == pytest.approx(row["landing_force_newtons"], rel=0.01)
    assert row["flight"] == pytest.approx(max(touches[: 4 * n]) - lifts[3 * n], rel=0.01)
    assert crouches[-1] == pytest.approx(row["crouch"], rel=0.05)
    p, v = state.lift_off
    assert np.hypot(v[0], v[2]) == pytest.approx(row["forward"], rel=1e-3)
    assert v[1] == pytest.approx(row["up"], rel=1e-3)
    rise = p[1] - hopping.hopper.mass.centre[1] - row["crouch"]
    assert row["rise"] == pytest.approx(rise, rel=0.02)


def test_the_values_of_a_jump_are_consistent(found: dict[str, JumpSummary]) -> None:
    for plan in found.values():
        row = facts(plan)
        assert row["up"] ** 2 == pytest.approx(2.0 * GRAVITY * row["height"])
        assert row["max_force"] * row["mass"] * GRAVITY == pytest.approx(row["max_force_newtons"])
        assert row["rise"] == pytest.approx(0.5 * row["up"] * row["push_seconds"])
        # A push carries the weight and accelerates the mass to its lift-off speed.
        lift = row["mass"] * row["up"] / row["push_seconds"]
        assert row["push_force_newtons"] * row["legs"] >= 0.999 * (lift + row["mass"] * GRAVITY)
        assert sorted(row["asked"] + row["resolved"]) == sorted(
            ["distance", "height", "speed", "crouch", "max_force", "balance"]
        )
        if row["distance"] is not None:
            v2 = GRAVITY * row["distance"] ** 2 / (8 * row["height"]) + 2 * GRAVITY * row["height"]
            assert row["speed"] ** 2 == pytest.approx(v2)


def test_the_report_lists_requested_and_resolved_parameters(
    found: dict[str, JumpSummary],
) -> None:
    roo, toc = facts(found["roo"]), facts(found["toc"])
    assert roo["asked"] == ["distance", "height", "crouch", "max_force"]
    assert (roo["distance"], roo["height"], roo["crouch"]) == (1.6, 0.8, 0.6)
    assert roo["max_force"] == pytest.approx(6.0)
    assert facts(found["tac"])["asked"] == ["distance", "speed", "balance"]
    assert facts(found["tac"])["balance"] == pytest.approx(3.0)
    assert toc["distance"] is toc["speed"] is toc["flight"] is None
    lines = table(found["roo"]).splitlines()
    assert lines[0].startswith("roo (kangaroo, ")
    assert next(line.split() for line in lines if "distance " in line)[1:3] == ["1.6", "m"]
    assert "from distance and height" in table(found["roo"])
    assert "from distance and speed" in table(found["tac"])
    assert "each jump as far as its place" in table(found["toc"])


def test_saturated_legs_are_reported(found: dict[str, JumpSummary]) -> None:
    assert facts(found["weak"])["saturated"]
    assert "more than there is" in table(found["weak"])
    assert not facts(found["roo"])["saturated"]
    assert "more than there is" not in table(found["roo"])


def test_walkers_are_omitted_and_scenes_without_jumps_refused() -> None:
    walker = "{name: w, figure: beetle, walk: {}}"
    assert [row["name"] for row in report_jumps(scene_of(walker, ROO)).facts] == ["roo"]
    with pytest.raises(UsageError, match="nobody in this scene hops"):
        report_jumps(scene_of(walker))


@pytest.mark.nightly
def test_jumps_command_prints_tables_or_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(cli, "listen", lambda: None)
    monkeypatch.setattr(options.CURRENT, "options", options.Verbosity())
    Path("play.yaml").write_text(f"{HEAD}- {ROO}\n")
    for flags in ([], ["--json"]):
        monkeypatch.setattr(sys, "argv", ["pronk", "jumps", "play", *flags])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert not end.value.code
    table_, line = capfd.readouterr().out.rstrip().rsplit("\n", 1)
    (roo,) = json.loads(line)["jumps"]
    assert f"{roo['speed']:.4g} m/s" in table_
    assert roo["name"] == "roo"
    assert not Path("out").exists()
