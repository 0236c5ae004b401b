"""Binary glTF under Khronos's own validator, where `npm ci` of the page's source installed it."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from pipeline.production.gltf.take_file import take_glb
from pipeline.simulation.simulate import simulate
from pipeline.spec import library, load_scene, read_scene
from pipeline.studio.app import PAGE

SOURCE = Path(str(PAGE)) / "source"

REPORT = """\
const fs = require("fs");
require("gltf-validator")
  .validateBytes(new Uint8Array(fs.readFileSync(0)), {maxIssues: 20})
  .then((report) => console.log(JSON.stringify(report.issues)));
"""

CHANGING = """\
pronk: 1
frames: 24
terrain: {kind: flat, size: [8, 8], cells: [8, 8], material: sand}
cast:
  - {name: bug, figure: beetle, walk: {}}
  - {name: tom, figure: cat, at: [0, 2], walk: {}}
  - {name: crystal, body: {shape: box}, at: [2, 1, 0]}
"""
"""Skins with helper joints, a body, and tracks that stand still beside those that move."""

pytestmark = pytest.mark.nightly


def issues_of(content: bytes) -> dict[str, Any]:
    """Return what the validator says of a file."""
    node = shutil.which("node")
    if node is None or not (SOURCE / "node_modules" / "gltf-validator").is_dir():
        pytest.skip(f"no glTF validator: it needs Node, and `npm ci` in {SOURCE.name}")
    done = subprocess.run(
        [node, "-e", REPORT], input=content, cwd=SOURCE, capture_output=True, check=True
    )
    issues: dict[str, Any] = json.loads(done.stdout)
    return issues


@pytest.mark.parametrize("name", ["sitting_circle", "through_the_wall", "macarena", "boulders"])
def test_a_scene_of_the_library_has_no_issues(name: str) -> None:
    scene = load_scene(library() / f"{name}.yaml").model_copy(
        update={"frames": 24, "duration": None}
    )
    assert issues_of(take_glb(simulate(scene), scene.materials))["messages"] == []


def test_a_file_without_its_ground_has_no_issues() -> None:
    take = simulate(read_scene(CHANGING, "it"))
    assert issues_of(take_glb(take, ground=False))["messages"] == []


def test_a_damaged_file_has_errors() -> None:
    content = take_glb(simulate(read_scene(CHANGING, "it")), ground=False)
    damaged = content.replace(b'"VEC4"', b'"VEC3"')
    assert damaged != content
    assert issues_of(damaged)["numErrors"] > 0
