"""`pronk studio` as a process: its address, a taken port, missing packages, Ctrl-C."""

from __future__ import annotations

import http.client
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import pipeline
from pipeline.errors import UsageError
from pipeline.studio.server import listener, serve

ROOT = Path(pipeline.__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "pipeline.cli", "studio", "--no-browser", *arguments]


@pytest.mark.slow
def test_it_serves_the_folder_until_ctrl_c(tmp_path: Path) -> None:
    with subprocess.Popen(
        command("horse"),
        cwd=tmp_path,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
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


def test_a_taken_port_is_one_line() -> None:
    with listener(0) as bound:
        port = bound.getsockname()[1]
        message = f"--port {port}: address already in use; choose another one, or 0 for any"
        with pytest.raises(UsageError, match=message):
            listener(port)


def test_answers_are_sent_at_once() -> None:
    # Of other sockets asyncio does not know that Nagle's algorithm would hold answers back.
    with listener(0) as bound:
        assert bound.proto == socket.IPPROTO_TCP
        assert bound.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize("package", ["uvicorn", "starlette.applications"])
def test_missing_packages_are_one_line(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "pipeline.studio.app", raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(UsageError, match=r"pip install 'pronk\[studio\]'"):
        serve(None, 0, False, print)


def test_a_document_of_another_folder_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "project").mkdir()
    (tmp_path / "other.yaml").write_text("pronk: 1\n")
    monkeypatch.chdir(tmp_path / "project")
    with pytest.raises(UsageError, match="start the studio in its folder"):
        serve(tmp_path / "other.yaml", 0, False, print)
