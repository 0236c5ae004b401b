"""Impossible scenes are refused before the first step, with path and suggestion."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.errors import SceneError, SimulationError
from pipeline.simulation.simulate import Simulation, simulate

if TYPE_CHECKING:
    from pipeline.spec import Scene

    SceneOf = Callable[..., Scene]

FOUR = (
    "figures: {dog: {nodes: {a: [0, -1], b: [0, 1], k1: [1, -1], f1: [2, -1], k2: [1, 1],"
    " f2: [2, 1]}, chains: [[a, b], [a, k1, f1], [b, k2, f2]], then: [{mirror: x}]},"
    " worm: {nodes: {a: [0, 0], b: [0, 1]}, chains: [[a, b]]}}"
)
STANDS = "{figure: beetle, name: other, at: [5, 5]}"


@pytest.mark.parametrize(
    ("member", "path", "phrases"),
    [
        ("{figure: beetle, walk: {speed: 9, cycle: 2}}", "walk", ["stride", "18", "at most"]),
        ("{figure: beetle, walk: {stride: 3}}", "walk", ["stride", "at most"]),
        ("{figure: beetle, walk: {body_height: 2.5}}", "walk.body_height", ["2.5", "less than"]),
        ("{figure: dog, walk: {gait: tripod}}", "walk.gait", ["6 legs", "'dog' has 4", "trot"]),
        ("{figure: dog, walk: {gait: hop}}", "walk.gait", ["one leg or one pair", "or bound"]),
        ("{figure: beetle, walk: {gait: canter}}", "walk.gait", ["two pairs", "(3 left, 3 right)"]),
        (
            "{figure: hopper, walk: {gait: run}}",
            "walk.gait",
            ["one pair", "1 leg (0 left"],
        ),
        (
            "{figure: dog, walk: {gait: {up: {l1: 0, x: 0.5}, down: {l1: 0.5, x: 0}}}}",
            "walk.gait.up",
            ["l1, l2, r1, r2", "at fault: l2, r1, r2, x"],
        ),
        ("{figure: worm, walk: {}}", "walk", ["no legs", "'worm'"]),
    ],
)
@pytest.mark.parametrize("number", [0, 1])
def test_walks_that_a_figure_cannot_do_are_refused(
    scene_of: SceneOf, member: str, path: str, phrases: list[str], number: int
) -> None:
    cast = [STANDS] * number + [member]
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(*cast, more=FOUR))
    (problem,) = caught.value.problems
    assert problem.path == f"cast[{number}].{path}"
    for phrase in phrases:
        assert phrase in problem.message


def test_greatest_stride_and_height_of_the_message_work(scene_of: SceneOf) -> None:
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of("{figure: beetle, walk: {stride: 3}}"))
    most = float(caught.value.problems[0].message.split("at most ")[1].split(";")[0])
    member = f"{{figure: beetle, walk: {{stride: {0.995 * most}}}}}"
    take = simulate(scene_of(member, duration=3))
    assert not take.notes
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of("{figure: beetle, walk: {body_height: 2.5}}"))
    highest = float(caught.value.problems[0].message.split("less than ")[1].split(" ")[0])
    Simulation(
        scene_of(f"{{figure: beetle, walk: {{body_height: {0.9 * highest}, stride: 0.05}}}}")
    )


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize(
    "walk_config",
    [
        {"stride": 3},
        {"speed": 4, "cycle": 0.9},
        {"speed": 4, "cycle": 0.9, "duty": 0.7},
        {"stride": 3, "body_height": 0.6},
        {"stride": 3, "speed": 2, "gait": "ripple"},
        {"stride": 3, "speed": 2, "cycle": 1.5},
    ],
)
def test_every_suggestion_for_a_stride_works(
    scene_of: SceneOf, walk_config: dict[str, float | str]
) -> None:
    def scene(changed: dict[str, float | str]) -> Scene:
        walk = ", ".join(f"{key}: {value}" for key, value in changed.items())
        return scene_of(f"{{figure: beetle, walk: {{{walk}}}}}")

    with pytest.raises(SceneError) as caught:
        Simulation(scene(walk_config))
    suggestions = re.split(", | or ", caught.value.problems[0].message.split("; take ")[1])
    assert len(suggestions) >= 2
    for suggestion in suggestions:
        Simulation(scene({**walk_config, **dict(re.findall(r"(\w+): ([\d.]+)", suggestion))}))


def test_a_start_without_a_foothold_is_refused_at_its_line(scene_of: SceneOf) -> None:
    terrain = "{kind: fractal, height: 8, roughness: 0.7, size: [20, 20]}"
    scene = scene_of("{figure: beetle, name: bug, at: [0, 0]}", terrain=terrain)
    with pytest.raises(SceneError) as caught:
        Simulation(scene)
    (problem,) = caught.value.problems
    assert problem.path == "cast[0].at"
    assert problem.line
    assert "of 'bug' finds no foothold around its start at [0, 0]" in problem.message
    assert "`at`" in problem.message


def test_divergence_names_step_and_node(scene_of: SceneOf, monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = Simulation(scene_of("{figure: beetle, name: bug, walk: {}}"))
    for _ in range(3):
        simulation.step()
    troupe = simulation.troupes[0]
    write = troupe.write

    def spoil(rows: object) -> None:
        write(rows)  # type: ignore[arg-type]
        rows.positions[4, 4] = np.nan  # type: ignore[attr-defined]

    monkeypatch.setattr(troupe, "write", spoil)

    def run_through() -> None:
        while not simulation.finished:
            simulation.step()

    with pytest.raises(SimulationError, match=r"step 4 .*bug\.l2\.1"):
        run_through()


def test_a_figure_without_legs_lies_still(scene_of: SceneOf) -> None:
    take = simulate(scene_of("{figure: worm}", more=FOUR))
    assert np.ptp(take.positions, axis=0).max() == 0.0
    assert not take.contacts


def test_figures_of_all_kinds_walk_together(scene_of: SceneOf) -> None:
    take = simulate(
        scene_of(
            "{figure: worm, at: [6, 6]}",
            "{figure: dog, walk: {gait: wave}}",
            "{figure: beetle, at: [-6, 0], walk: {gait: tripod}}",
            "{figure: dog, at: [0, 7], scale: 0.5, walk: {gait: trot}}",
            more=FOUR,
        )
    )
    assert not take.notes
    assert {c.performer for c in take.contacts} == {"dog", "beetle", "dog_2"}
    assert len({n.name for n in take.nodes}) == len(take.nodes)


def test_mistakes_of_places_walks_and_attachments_are_told_at_once(scene_of: SceneOf) -> None:
    off_terrain, too_long = "{figure: beetle, at: [500, 0]}", "{figure: beetle, walk: {stride: 3}}"
    with pytest.raises(SceneError) as caught:
        Simulation(scene_of(off_terrain, too_long))
    assert [p.path for p in caught.value.problems] == ["cast[0].at", "cast[1].walk"]
    with pytest.raises(SceneError) as caught:
        Simulation(
            scene_of(
                "{name: bug, figure: beetle, walk: {}}",
                "{prop: {shape: box}, parent: bug.hat, at: [0, 1, 0]}",
                more="script: [{at: 0, who: bug, do: {look_at: box.lid}}]",
            )
        )
    assert [p.path for p in caught.value.problems] == ["cast[1].parent", "script[0].do.look_at"]
