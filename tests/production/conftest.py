"""A tiny film that is rendered once, and ways to run the command line on copies of it."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pipeline import cli
from pipeline.commands import options
from pipeline.production.run.order import Order
from pipeline.production.run.production import render
from pipeline.production.run.progress import Reporter
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene, load_scene
from tests.production.killed_runs import contents_of

FRAMES = 8

TINY = f"""\
pronk: 1
title: Tiny
fps: 24
frames: {FRAMES}
seed: 3
terrain: {{kind: flat, size: [8, 8], cells: [8, 8], material: ground, scatter: none}}
cast:
  - name: bug
    figure: beetle
    scale: 0.6
    walk: {{gait: tripod, cycle: 0.3, speed: 0.6}}
materials:
  ground: {{preset: dry soil}}
camera: {{follow: bug}}
light: studio
film: {{size: [64, 36], samples: 1, depth: 2, denoise: "off"}}
"""

ROOT = Path(cli.__file__).parents[1]

State = dict[str, tuple[int, str]]


@dataclass(frozen=True)
class Studio:
    """A folder with the scene tiny.yaml and an out folder.

    Attributes:
        folder: that holds both.
    """

    folder: Path

    @property
    def scene(self) -> Path:
        """The scene."""
        return self.folder / "tiny.yaml"

    @property
    def made(self) -> Path:
        """The folder of its outputs."""
        return self.folder / "out" / "tiny"

    def frame(self, number: int) -> Path:
        """Return the file of a frame."""
        return self.made / "frames" / f"{number:04d}.png"

    def load(self, *sets: str) -> Scene:
        """Return the scene with overrides."""
        return load_scene(self.scene, sets)

    def order(self, *sets: str, **more: Any) -> Order:
        """Return the order of a command line."""
        return Order(self.load(*sets), "tiny", self.folder / "out", **more)

    def render(self, *sets: str, **more: Any) -> None:
        """Make the film."""
        render(self.order(*sets, **more), Reporter())

    def state(self) -> State:
        """Return time stamp and digest of every file in the output."""
        return {
            str(path.relative_to(self.made)): (
                path.stat().st_mtime_ns,
                hashlib.blake2b(path.read_bytes()).hexdigest(),
            )
            for path in sorted(self.made.rglob("*"))
            if path.is_file()
        }

    def contents(self) -> dict[str, str]:
        """Return the digest of every file but the manifest, whose seconds never repeat."""
        return contents_of(self.made)

    def changes(self, before: State) -> set[str]:
        """Return files created, deleted or written since `before`, the take's as one."""
        after = self.state()
        names = {n for n in before.keys() | after.keys() if before.get(n) != after.get(n)}
        return {"take.zarr" if name.startswith("take.zarr/") else name for name in names}

    def copied(self, place: Path) -> Studio:
        """Copy it all to `place`."""
        shutil.copytree(self.folder, place)
        return Studio(place)


@pytest.fixture(scope="session")
def unmade(tmp_path_factory: pytest.TempPathFactory) -> Studio:
    """Return a studio with a scene and no film, shared by tests that do not write."""
    studio = Studio(tmp_path_factory.mktemp("unmade"))
    studio.scene.write_text(TINY, encoding="utf-8")
    return studio


@pytest.fixture(scope="session")
def film(unmade: Studio, tmp_path_factory: pytest.TempPathFactory) -> Studio:
    """Return a finished tiny film, shared by tests that do not write."""
    studio = unmade.copied(tmp_path_factory.mktemp("film") / "studio")
    studio.render()
    return studio


@pytest.fixture
def studio(film: Studio, tmp_path: Path) -> Studio:
    """Return a copy of the finished film, time stamps and all."""
    return film.copied(tmp_path / "studio")


@pytest.fixture(scope="session")
def take(unmade: Studio) -> Take:
    return simulate(unmade.load())


@pytest.fixture(scope="session")
def hills() -> tuple[Scene, Take]:
    """Return a scene on steep hills, and its take."""
    scene = load_scene(
        ROOT / "scenes" / "first_steps.yaml",
        ["frames=60", "terrain.cells=[96,96]", "terrain.size=[16,16]"],
    )
    return scene, simulate(scene)


@pytest.fixture
def pronk(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs a command in this process: exit code, output, errors."""

    def run(*arguments: str | Path, cwd: Path | None = None) -> tuple[int, str, str]:
        capfd.readouterr()
        monkeypatch.setattr(sys, "argv", ["pronk", *map(str, arguments)])
        monkeypatch.setattr(options.CURRENT, "options", options.Verbosity())
        # The test runner listens to Ctrl-C itself.
        monkeypatch.setattr(cli, "listen", lambda: None)
        if cwd is not None:
            monkeypatch.chdir(cwd)
        with pytest.raises(SystemExit) as end:
            cli.main()
        captured = capfd.readouterr()
        code = end.value.code
        return (
            (code if isinstance(code, int) else 0 if code is None else 1),
            captured.out,
            captured.err,
        )

    return run


class Running:
    """A command in its own process, to interrupt or kill.

    Args:
        arguments: of `pronk`.
        cwd: its working folder.
        messages: file of its standard input.
        before: Python code that runs before the command.
    """

    def __init__(
        self,
        arguments: tuple[str | Path, ...],
        cwd: Path,
        messages: Path | None = None,
        before: str = "",
    ) -> None:
        paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        with contextlib.ExitStack() as files:
            self.process = subprocess.Popen(
                [
                    *(sys.executable, "-c", f"{before}\nfrom pipeline.cli import main; main()"),
                    *map(str, arguments),
                ],
                cwd=cwd,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
                stdin=files.enter_context(messages.open("rb")) if messages else None,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                # A process group, as of a terminal, so that Ctrl-C reaches the workers too.
                start_new_session=True,
            )

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.killpg(self.process.pid, signal.SIGINT)

    def kill(self) -> None:
        """Kill this process alone, as the system does when memory is short."""
        self.process.kill()

    def end(self) -> tuple[int, str, str]:
        """Wait for the end; return exit code, output and errors.

        Raises:
            TimeoutExpired: the command hangs.
        """
        out, err = self.process.communicate(timeout=300)
        return self.process.returncode, out, err


@pytest.fixture
def start() -> Iterator[Callable[..., Running]]:
    """Return a function that starts a command; running commands are killed at the end."""
    running: list[Running] = []

    def begin(
        *arguments: str | Path, cwd: Path, messages: Path | None = None, before: str = ""
    ) -> Running:
        running.append(Running(arguments, cwd, messages, before))
        return running[-1]

    yield begin
    for one in running:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(one.process.pid, signal.SIGKILL)
        one.end()
