"""`pronk studio` as a process: its address, a taken port, missing packages, Ctrl-C."""

from __future__ import annotations

import http.client
import os
import signal
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import pipeline
from pipeline.studio.server import listener

ROOT = Path(pipeline.__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "pipeline.cli", "studio", "--no-browser", *arguments]


@pytest.mark.slow
def test_it_serves_the_folder_until_ctrl_c(tmp_path: Path) -> None:
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command("horse"), cwd=tmp_path, env=ENVIRONMENT, **pipes) as child:
        assert child.stdout is not None
        address = urlsplit(child.stdout.readline().strip())
        assert address.hostname == "127.0.0.1"
        client = http.client.HTTPConnection("127.0.0.1", address.port, timeout=30)
        client.request("GET", f"/?{address.query}")
        assert client.getresponse().status == 200
        client.close()
        child.send_signal(signal.SIGINT)
        out, error = child.communicate(timeout=30)
    assert (child.returncode, out, error) == (0, "", "")


def test_a_taken_port_is_one_line(tmp_path: Path) -> None:
    with listener(0) as bound:
        port = bound.getsockname()[1]
        ended = subprocess.run(
            command("--port", str(port)), cwd=tmp_path, env=ENVIRONMENT, capture_output=True
        )
    assert ended.returncode == 2
    assert ended.stderr.decode() == (
        f"error: --port {port}: address already in use; choose another one, or 0 for any that is "
        "free\n"
    )


def test_missing_packages_are_one_line(tmp_path: Path) -> None:
    # A module that cannot be imported stands before the installed one.
    (tmp_path / "starlette.py").write_text("raise ImportError('none', name='starlette')\n")
    environment = {**ENVIRONMENT, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    ended = subprocess.run(command(), cwd=tmp_path, env=environment, capture_output=True)
    assert ended.returncode == 2
    assert ended.stderr.decode() == (
        "error: the studio needs more packages: pip install 'pronk[studio]'\n"
    )


def test_a_document_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    ended = subprocess.run(command("hrose"), cwd=tmp_path, env=ENVIRONMENT, capture_output=True)
    assert ended.returncode == 2
    assert "did you mean 'horse'" in ended.stderr.decode()
