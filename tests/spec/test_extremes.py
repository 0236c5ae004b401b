"""Numbers and names at the ends of what a file can hold: refused at their place, at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import SceneError
from pipeline.production.run.scene_check import check_scene
from pipeline.spec import load_scene, read_scene

SCENE = "pronk: 1\nduration: 0.2\ncast: [{member}]\n"

TINY = {
    "{figure: beetle, walk: {speed: §}}": "cast[0].walk.speed",
    "{figure: beetle, walk: {stride: §}}": "cast[0].walk.stride",
    "{figure: beetle, scale: §, walk: {}}": "cast[0].scale",
    "{figure: kangaroo, pronk: {speed: §}}": "cast[0].pronk.speed",
    "{body: {shape: cube, density: §}, at: [0, 3, 0]}": "cast[0].body.density",
    "{body: {shape: cube, size: §}, at: [0, 3, 0]}": "cast[0].body.size",
}


@pytest.mark.parametrize("value", ["1e-320", "5e-324", "1e-30", "9e-10"])
@pytest.mark.parametrize("member", TINY)
def test_positive_numbers_too_small_to_divide_by_are_refused(member: str, value: str) -> None:
    with pytest.raises(SceneError) as refused:
        check_scene(read_scene(SCENE.replace("{member}", member.replace("§", value))))
    (problem,) = refused.value.problems
    assert (problem.line, problem.path) == (3, TINY[member])
    assert problem.message == f"must be at least 1e-09, is {float(value)!r}"


@pytest.mark.parametrize(
    "walk", ["{cycle: 1.0e-6}", "{cycle: 0.001}", "{speed: 1000}", "{speed: 2, stride: 1.0e-4}"]
)
@pytest.mark.parametrize("figure", ["beetle", "inchworm"])
def test_cycles_shorter_than_a_step_are_refused(figure: str, walk: str) -> None:
    with pytest.raises(SceneError, match=r"0\.005|times a second") as refused:
        check_scene(read_scene(SCENE.replace("{member}", f"{{figure: {figure}, walk: {walk}}}")))
    (problem,) = refused.value.problems
    assert problem.line == 3


@pytest.mark.parametrize("member", ["{figure: §}", "{dancer: torso, dance: §}", "{figure: ./§}"])
def test_a_name_longer_than_files_may_have_is_refused_at_its_place(
    tmp_path: Path, member: str
) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.replace("{member}", member.replace("§", "x" * 300)), "utf-8")
    with pytest.raises(SceneError) as refused:
        load_scene(path)
    assert {problem.line for problem in refused.value.problems} == {3}
