"""Films of a Ray cluster are those of one machine, whatever is killed while they are made."""

from __future__ import annotations

import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.production.conftest import ROOT, TINY
from tests.production.killed_runs import contents_of

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(
        find_spec("ray") is None and not os.environ.get("PRONK_FARM"),
        reason="needs Ray, which `make test-all` installs: it is larger than all else together",
    ),
]

FLAKY = Path(__file__).parent / "flaky"
SCENES, FRAMES = 6, 24


def isolated() -> list[str]:
    """Return the command that runs another without a network, where that is allowed."""
    if shutil.which("unshare") is None:
        return []
    allowed = subprocess.run(["unshare", "-n", "true"], capture_output=True, check=False)
    return [] if allowed.returncode else ["unshare", "-n"]


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with six scenes, and their films by an undisturbed run of one process."""
    folder = tmp_path_factory.mktemp("rendered")
    names = []
    for number in range(1, SCENES + 1):
        text = TINY.replace("seed: 3", f"seed: {number}").replace("frames: 8", f"frames: {FRAMES}")
        (folder / f"scene_{number}.yaml").write_text(text)
        names.append(f"scene_{number}.yaml")
    pronk("render", *names, cwd=folder)
    return folder


def pronk(*arguments: str, cwd: Path) -> None:
    call = [sys.executable, "-c", "from pipeline.cli import main; main()", *arguments]
    subprocess.run(call, cwd=cwd, check=True, env=environment())


def environment() -> dict[str, str]:
    paths = [str(ROOT), str(FLAKY), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}


def ran(spec: dict[str, Any], folder: Path) -> tuple[dict[str, Any], str]:
    """Return the report of a run on a cluster, and what it wrote to standard error."""
    (folder / "spec.json").write_text(json.dumps(spec))
    script = Path(__file__).parent / "cluster_run.py"
    done = subprocess.run(
        [*isolated(), sys.executable, str(script), str(folder / "spec.json")],
        capture_output=True,
        text=True,
        env=environment(),
        timeout=1800,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    report: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return report, done.stderr


def test_a_cluster_lets_nobody_in_without_its_token(rendered: Path, tmp_path: Path) -> None:
    scene = str(rendered / "scene_1.yaml")
    command = [scene, "--store", str(tmp_path / "store"), "--out", str(tmp_path / "out")]
    kills = {"node_kills": 0, "driver_kills": 0, "frames": FRAMES, "seed": 7}
    report, err = ran(
        {"command": command, "folder": str(tmp_path), "token": "b" * 64, **kills}, tmp_path
    )
    assert report["code"] == 4
    assert "RAY_AUTH_TOKEN has to hold its token" in err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("node_kills", "driver_kills", "protocol"),
    [(5, 0, "file"), (0, 5, "file"), (2, 2, "flaky")],
    ids=["nodes", "drivers", "flaky store"],
)
def test_films_of_a_disturbed_cluster_are_those_of_one_process(
    rendered: Path, tmp_path: Path, node_kills: int, driver_kills: int, protocol: str
) -> None:
    names = [f"scene_{number}.yaml" for number in range(1, SCENES + 1)]
    for name in names:
        shutil.copy(rendered / name, tmp_path / name)
    spec: dict[str, Any] = {
        "command": [
            *(*names, "--cores", "1"),
            *("--store", f"{protocol}://{tmp_path / 'store'}", "--out", str(tmp_path / "out")),
        ],
        "folder": str(tmp_path),
        "frames": SCENES * FRAMES,
        "node_kills": node_kills,
        "driver_kills": driver_kills,
        "seed": 7,
    }
    report, err = ran(spec, tmp_path)
    assert report["code"] == 0, err
    assert len(report["kills"]) == node_kills + driver_kills
    for name in names:
        made = tmp_path / "out" / Path(name).stem
        assert contents_of(made) == contents_of(rendered / "out" / Path(name).stem)
    # Nothing half written is left under the names of objects.
    assert len(list((tmp_path / "store/frames").iterdir())) == SCENES * FRAMES


def test_ctrl_c_ends_a_cluster_of_its_own(rendered: Path, tmp_path: Path) -> None:
    text = (rendered / "scene_1.yaml").read_text().replace(f"frames: {FRAMES}", "frames: 2000")
    (tmp_path / "long.yaml").write_text(text)
    call = "from pipeline.cli import main; main()"
    arguments = ("--store", "store", "--on", "auto", "--jobs", "2", "--cores", "1")
    script = (
        "import sys; sys.path.insert(0, sys.argv.pop(1))\n"
        "import contextlib; from cluster_run import raise_loopback\n"
        "with contextlib.suppress(OSError): raise_loopback()\n" + call
    )
    running = subprocess.Popen(
        [
            *(*isolated(), sys.executable, "-c", script, str(Path(__file__).parent)),
            *("farm", "render", "long.yaml", *arguments),
        ],
        cwd=tmp_path,
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    frames = tmp_path / "store/frames"
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline and not (frames.is_dir() and any(frames.iterdir())):
        time.sleep(0.1)
    os.killpg(running.pid, signal.SIGINT)
    began = time.monotonic()
    _, err = running.communicate(timeout=120)
    # A benchmark would be the place for a limit; the log of the nightly tier has the figure.
    logging.getLogger(__name__).info("ended after %.1f s", time.monotonic() - began)
    assert running.returncode == 130, err
    assert "stopped; what is in the store stays" in err
    assert "Traceback" not in err
    left = subprocess.run(["pgrep", "-f", str(tmp_path)], capture_output=True, check=False)
    assert left.stdout == b""
