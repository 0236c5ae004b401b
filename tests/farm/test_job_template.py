"""Job templates pass the checker of their format, and run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.production.conftest import FRAMES, ROOT, Studio
from tests.production.killed_runs import contents_of

Pronk = Callable[..., tuple[int, str, str]]

needs_openjd = pytest.mark.skipif(
    find_spec("openjd") is None and not os.environ.get("PRONK_FARM"),
    reason="needs openjd-cli, which `make test-all` installs",
)


def openjd(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the tools of the format."""
    call = [sys.executable, "-m", "openjd", *map(str, arguments)]
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    return subprocess.run(
        call, capture_output=True, text=True, cwd=cwd, env=environment, check=False
    )


def exported(pronk: Pronk, *arguments: str | Path, place: Path) -> dict[str, Any]:
    code, out, err = pronk("farm", "export", *arguments, "--openjd", place)
    assert (code, out) == (0, f"{place}\n"), err
    template: dict[str, Any] = yaml.safe_load(place.read_text())
    return template


def test_a_template_has_three_steps_for_each_film(
    unmade: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    place = tmp_path / "jobs" / "job.yaml"
    place.parent.mkdir()
    shutil.copy(unmade.scene, tmp_path / "tiny.yaml")
    scenes = (tmp_path / "tiny.yaml", "first_steps")
    template = exported(
        pronk, *scenes, "--set", "seed=4", "--frames", "2-5", "--preset", "draft", place=place
    )
    assert [step["name"] for step in template["steps"]] == [
        *(f"{verb} tiny" for verb in ("Simulate", "Render", "Assemble")),
        *(f"{verb} first_steps" for verb in ("Simulate", "Render", "Assemble")),
    ]
    render = template["steps"][1]
    (frame,) = render["parameterSpace"]["taskParameterDefinitions"]
    assert (frame["type"], frame["range"]) == ("CHUNK[INT]", "2-5")
    args = render["script"]["actions"]["onRun"]["args"]
    assert args[:3] == ["farm", "frames", "{{Param.Scene1}}"]
    assert args[-2:] == ["--frames", "{{Task.Param.Frame}}"]
    assert {"film.preset=draft", "draft"} & set(args)
    assert "seed=4" in args
    # Scenes of files are parameters, by paths from the template; shipped ones have a name.
    parameters = {one["name"]: one for one in template["parameterDefinitions"]}
    assert parameters["Scene1"]["default"] == "../tiny.yaml"
    assert "Scene2" not in parameters
    assert template["steps"][3]["script"]["actions"]["onRun"]["args"][2] == "first_steps"


def test_a_film_of_several_segments_has_a_step_that_encodes_them(
    unmade: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    long = ("--set", "frames=500", "--frames", "11-500")
    template = exported(pronk, unmade.scene, *long, place=tmp_path / "job.yaml")
    names = [f"{verb} tiny" for verb in ("Simulate", "Render", "Encode", "Assemble")]
    assert [step["name"] for step in template["steps"]] == names
    encode, assemble = template["steps"][2:]
    assert encode["dependencies"] == [{"dependsOn": "Render tiny"}]
    assert assemble["dependencies"] == [{"dependsOn": "Encode tiny"}]
    (segment,) = encode["parameterSpace"]["taskParameterDefinitions"]
    assert (segment["type"], segment["range"]) == ("INT", "1-3")
    args = encode["script"]["actions"]["onRun"]["args"]
    assert args[:2] == ["farm", "encode"]
    assert args[-4:] == ["--frames", "11-500", "--shard", "{{Task.Param.Segment}}/3"]


def test_scenes_that_are_wrong_have_no_template(tmp_path: Path, pronk: Pronk) -> None:
    (tmp_path / "wrong.yaml").write_text("pronk: 1\nframes: x\n")
    code, _, _ = pronk("farm", "export", tmp_path / "wrong.yaml", "--openjd", tmp_path / "job.yaml")
    assert code == 3
    assert not (tmp_path / "job.yaml").exists()


@needs_openjd
@pytest.mark.nightly
def test_templates_pass_the_checker_of_the_format(
    unmade: Studio, tmp_path: Path, pronk: Pronk
) -> None:
    shutil.copy(unmade.scene, tmp_path / "tiny.yaml")
    place = tmp_path / "job.yaml"
    scenes = (tmp_path / "tiny.yaml", "first_steps")
    exported(pronk, *scenes, "--set", "frames=500", "--no-sound", place=place)
    done = openjd("check", place, "--extensions", "TASK_CHUNKING", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    done = openjd(
        *("summary", place, "-p", "Store=store", "--extensions", "TASK_CHUNKING"), cwd=tmp_path
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Total steps: 8" in done.stdout


@needs_openjd
@pytest.mark.nightly
def test_a_template_runs_and_makes_the_film(film: Studio, tmp_path: Path, pronk: Pronk) -> None:
    shutil.copy(film.scene, tmp_path / "tiny.yaml")
    place = tmp_path / "job.yaml"
    exported(pronk, tmp_path / "tiny.yaml", place=place)
    command = tmp_path / "pronk"
    command.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -c "from pipeline.cli import main; main()" "$@"\n'
    )
    command.chmod(0o755)
    done = openjd(
        *("run", place, "--step", "Assemble tiny", "--run-dependencies"),
        *("-p", f"Store={tmp_path / 'store'}", "-p", f"Pronk={command}"),
        *("-p", f"Out={tmp_path / 'out'}", "--extensions", "TASK_CHUNKING"),
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert contents_of(tmp_path / "out/tiny") == film.contents()
    assert len(list((tmp_path / "store/frames").iterdir())) == FRAMES
