"""Render queue: films of the project's scenes, one after the other, each by `pronk render`.

A process of its own makes each film, so that the page stays quick and a film that fails or is
stopped ends nothing else. What is finished stays, and the same render goes on there.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import typer

from pipeline.errors import UsageError
from pipeline.production.run.outputs import Outputs
from pipeline.terminal_text import escaped_line
from render.config.film import Preset

PRESETS: tuple[str, ...] = get_args(Preset)

MAX_RENDERS = 100
"""Films that are remembered; the oldest that ended are forgotten."""

PRONK = """\
import signal
from pipeline.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""
"""Program that makes a film: a studio in the background inherits that interrupts are ignored."""

STOP_TIMEOUT = 10.0
"""Time that a film has to end after it is stopped [s]."""


@dataclass(slots=True)
class Render:
    """A film that is wanted.

    Attributes:
        number: that the page knows it by.
        scene: file of the scene, below the project's folder.
        preset: quality of its frames.
        state: "waiting", "rendering", "done", "failed" or "stopped".
        stage: what is being made, with numbers.
        text: the last message.
    """

    number: int
    scene: str
    preset: str
    state: str = "waiting"
    stage: str = ""
    text: str = ""
    process: subprocess.Popen[str] | None = field(default=None, repr=False)

    @property
    def facts(self) -> dict[str, Any]:
        """What the page shows."""
        names = ("number", "scene", "preset", "state", "stage", "text")
        return {name: getattr(self, name) for name in names}


class RenderQueue:
    """Renders scenes in their order.

    Args:
        folder: returns the project's folder, in which `out` is.
    """

    def __init__(self, folder: Callable[[], Path]) -> None:
        self._folder = folder
        self._renders: list[Render] = []
        self._lock = threading.Lock()
        self._count = 0
        self._thread: threading.Thread | None = None

    def add(self, scene: str, preset: str) -> Render:
        """Append a film and return it.

        Raises:
            UsageError: there is no such preset, or too much is waiting.
        """
        if preset not in PRESETS:
            raise UsageError(f"no preset is called '{preset}'; {', '.join(PRESETS)}")
        with self._lock:
            if len(self._renders) >= MAX_RENDERS:
                ended = [one for one in self._renders if one.state not in ("waiting", "rendering")]
                if not ended:
                    raise UsageError(f"{MAX_RENDERS} films are waiting already")
                self._renders.remove(ended[0])
            self._count += 1
            render = Render(self._count, scene, preset)
            self._renders.append(render)
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="renders", daemon=True)
                self._thread.start()
            return render

    def listed(self) -> list[dict[str, Any]]:
        """Return all films, the newest first."""
        with self._lock:
            return [render.facts for render in reversed(self._renders)]

    def find(self, number: object) -> Render:
        """Return a film by its number.

        Raises:
            UsageError: there is none.
        """
        with self._lock:
            for render in self._renders:
                if render.number == number:
                    return render
        raise UsageError("there is no such render")

    def stop(self, render: Render) -> None:
        """Stop a film that waits or is being made; what is finished of it stays."""
        with self._lock:
            if render.state not in ("waiting", "rendering"):
                return
            # One whose process has not started yet sees its state before it does.
            render.state = "stopped"
            if render.process is not None:
                _interrupt(render.process)

    def stop_all(self) -> None:
        """Stop all films and wait for their processes."""
        with self._lock:
            renders = list(self._renders)
        # Those that wait first: else one begins when the one before it has ended.
        for render in reversed(renders):
            self.stop(render)
        for render in renders:
            if render.process is not None:
                try:
                    render.process.wait(STOP_TIMEOUT)
                except subprocess.TimeoutExpired:
                    render.process.kill()

    def outputs(self, render: Render) -> Outputs:
        """Return where a film and its frames are."""
        name = Path(render.scene).stem
        return Outputs(self._folder() / "out" / name, name)

    def open_folder(self, render: Render) -> Path:
        """Show the folder of a film in the file manager of this machine; return it.

        Raises:
            UsageError: it is not there yet, or there is no file manager.
        """
        folder = self.outputs(render).folder
        if not folder.is_dir():
            raise UsageError(f"there is no folder '{escaped_line(str(folder))}' yet")
        if typer.launch(str(folder)) != 0:
            raise UsageError(f"no file manager opens it; the folder is {escaped_line(str(folder))}")
        return folder

    def frame(self, render: Render) -> bytes | None:
        """Return the newest frame of a film as PNG, None before the first."""
        frames = self.outputs(render).frames
        pictures = [path for path in frames.glob("[0-9]*.png") if path.is_file()]
        newest = max(pictures, key=lambda path: path.stat().st_mtime_ns, default=None)
        return None if newest is None else newest.read_bytes()

    def _next(self) -> Render | None:
        with self._lock:
            for render in self._renders:
                if render.state == "waiting":
                    render.state = "rendering"
                    return render
            self._thread = None
            return None

    def _work(self) -> None:
        while (render := self._next()) is not None:
            try:
                self._make(render)
            except OSError as error:
                with self._lock:
                    render.state, render.text = "failed", f"cannot start ({error.strerror})"

    def _make(self, render: Render) -> None:
        # -P: modules of the project's folder are not those of pronk.
        command = [sys.executable, "-P", "-c", PRONK, "render", f"./{render.scene}"]
        with self._lock:
            if render.state != "rendering":
                return
            render.process = subprocess.Popen(
                [*command, "--preset", render.preset, "--json"],
                cwd=self._folder(),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                encoding="utf-8",
                errors="replace",
            )
        assert render.process.stdout is not None
        with render.process.stdout as lines:
            for line in lines:
                _read(render, line)
        code = render.process.wait()
        with self._lock:
            if render.state == "rendering":
                render.state = "failed" if code else "done"


def _interrupt(process: subprocess.Popen[str]) -> None:
    """Stop a process as Ctrl-C does, where the system can."""
    if sys.platform == "win32":
        process.terminate()
    else:
        process.send_signal(signal.SIGINT)


def _read(render: Render, line: str) -> None:
    """Take in a line of the render's report."""
    try:
        event = json.loads(line)
    except ValueError:
        event = None
    if not isinstance(event, dict):
        render.text = line.strip() or render.text
    elif event.get("event") == "progress":
        done, total = event.get("done", ""), event.get("total", "")
        render.stage = f"{event.get('stage', '')} {done} of {total}"
    elif isinstance(event.get("text"), str):
        render.text = event["text"]
    elif isinstance(event.get("message"), str):
        render.text = event["message"]
