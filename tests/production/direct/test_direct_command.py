"""The command `pronk direct`, in a process of its own, and the example that directs by it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.simulation.take_store import read_take
from tests.production.direct.direct_client import STAGE, replayed, request

ROOT = Path(__file__).parents[3]
PRONK = [sys.executable, "-c", "from pipeline.cli import main; main()"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the stage scene."""
    (tmp_path / "stage.yaml").write_text(STAGE, encoding="utf-8")
    return tmp_path


def _started(folder: Path, *arguments: str, scene: str = "stage.yaml") -> subprocess.Popen[bytes]:
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.Popen(
        [*PRONK, "direct", scene, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def _ended(folder: Path, run: subprocess.Popen[bytes], text: bytes = b"") -> tuple[int, str, str]:
    out, err = run.communicate(text, timeout=120)
    return run.returncode, out.decode("ascii"), err.decode()


@pytest.mark.slow
@pytest.mark.nightly
def test_standard_output_has_only_messages(folder: Path) -> None:
    text = b"\n".join([b"nonsense", request("step", 1, frames=3), request("end", 2)])
    code, out, err = _ended(folder, _started(folder, "--name", "other", "-v"), text)
    assert code == 0, err
    answers = [json.loads(line) for line in out.splitlines()]
    assert [one["id"] for one in answers] == [None, 1, 2]
    assert answers[-1]["result"]["take"] == str(Path("out/other/take.zarr"))
    assert "Traceback" not in err
    assert replayed(folder / "out/other/other.yaml").digest == answers[-1]["result"]["digest"]


@pytest.mark.nightly
def test_ctrl_c_leaves_a_finished_take(folder: Path) -> None:
    run = _started(folder)
    assert run.stdin is not None
    assert run.stdout is not None
    run.stdin.write(request("command", 1, who="bug", do="stop") + b"\n")
    run.stdin.write(request("step", 2, frames=3) + b"\n")
    run.stdin.flush()
    for _ in range(2):
        assert run.stdout.readline()
    run.send_signal(signal.SIGINT)
    code, _, err = _ended(folder, run)
    assert (code, "Traceback" in err) == (0, False), err
    take = read_take(folder / "out/stage_directed/take.zarr")
    assert take.digest == replayed(folder / "out/stage_directed/stage_directed.yaml").digest
    assert take.orders[0].text == "stop"


TWO = """\
pronk: 1
duration: 7
terrain: {kind: flat, size: [20, 12], cells: [8, 8]}
cast:
  - {name: ann, figure: beetle, scale: 0.5, walk: {speed: 0.8}}
  - {name: bob, figure: beetle, scale: 0.5, at: [0, 2.6], walk: {speed: 0.5}}
  - {name: box, prop: {shape: box, size: [0.2, 0.2, 0.2]}, at: [3, 3]}
"""


def _brought_together(folder: Path, *arguments: str) -> None:
    """Run the drama manager, and check what has become of its scene."""
    (folder / "two.yaml").write_text(TWO)
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    end = subprocess.run(
        [sys.executable, str(ROOT / "docs/examples/drama_manager.py"), *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    assert end.returncode == 0, end.stderr
    assert "ann has come to bob" in end.stdout
    take = read_take(folder / "out/two_directed/take.zarr")
    assert take.digest == replayed(folder / "out/two_directed/two_directed.yaml").digest
    # Where they met they are within reach, which they were not at first.
    first = {node.performer: i for i, node in reversed(list(enumerate(take.nodes)))}
    way = take.positions[:, first["ann"]] - take.positions[:, first["bob"]]
    gap = (way[:, [0, 2]] ** 2).sum(axis=1) ** 0.5
    assert gap[0] > 2.5
    assert gap.min() < 1.8  # beetles of 1.45 m


@pytest.mark.nightly
def test_the_drama_manager_brings_a_cast_together(folder: Path) -> None:
    _brought_together(folder, "two.yaml", "--pronk", f"'{PRONK[0]}' -c '{PRONK[2]}'")


@pytest.mark.nightly
def test_the_drama_manager_directs_at_a_port(folder: Path) -> None:
    (folder / "two.yaml").write_text(TWO)
    run = _started(folder, "--port", "0", "--token-file", "t", scene="two.yaml")
    assert run.stderr is not None
    for line in run.stderr:
        if found := re.fullmatch(rb"waiting at (\S+)\n", line):
            break
    assert found
    _brought_together(folder, found[1].decode(), "--token-file", "t")
    code, out, err = _ended(folder, run)
    assert (code, out) == (0, ""), err
    # The director said hello at once, and stayed until the end.
    assert "refused" not in err
    assert "disconnected" not in err
    assert not (folder / "t").exists()
