"""Recorder of a directed scene: its take, and a scene whose script repeats it."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import StoreError, UsageError
from pipeline.production.run import production
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs, opened
from pipeline.production.run.progress import Reporter
from pipeline.production.run.reporters import LogReporter
from pipeline.production.run.take_stage import take_key
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene, dump, load_scene
from pipeline.spec.model_base import NAME_PATTERN
from pipeline.spec.script import Instruction

NAME_SUFFIX = "_directed"
"""Default ending of the name of a directed scene."""


@dataclass(frozen=True, slots=True)
class RecordedScene:
    """Files of a directed scene.

    Attributes:
        scene: file.
        take: folder.
        digest: of the take.
        frames: of the film.
    """

    scene: Path
    take: Path
    digest: str
    frames: int


@dataclass(frozen=True, slots=True)
class SceneRecorder:
    """Writer of a directed scene.

    Attributes:
        name: of the directed scene.
        out: folder that holds the scenes' folders.
        reporter: of progress.
    """

    name: str
    out: Path
    reporter: Reporter

    @property
    def outputs(self) -> Outputs:
        """The files of the directed scene."""
        return Outputs(self.out / self.name, self.name)

    def check(self) -> None:
        """Check that the folder can be written to, before there is anything to lose.

        Raises:
            StoreError: it cannot.
        """
        with opened(self.outputs):
            pass

    def record(self, scene: Scene, simulation: Simulation, end_now: bool) -> RecordedScene:
        """Write the directed scene and its take.

        Args:
            scene: before it was directed.
            simulation: of it, at its end unless the film ends now. The shorter scene is then
                simulated again, because its length decides how its sounds end.
            end_now: whether the film ends with the present frame.

        Raises:
            PronkError: something cannot be written.
        """
        file = self.write_scene(scene, simulation, end_now)
        order = Order(load_scene(file), self.name, self.out)
        if end_now and not simulation.finished:
            outputs, take = production.simulate_only(order, self.reporter)
        else:
            take = _take_with_key(simulation, take_key(order.scene))
            outputs = production.store_only(order, take, self.reporter)
        return RecordedScene(file, outputs.take, take.digest, take.header.frames)

    def write_scene(self, scene: Scene, simulation: Simulation, end_now: bool) -> Path:
        """Write the directed scene and return its file."""
        file = self.outputs.folder / f"{self.name}.yaml"
        text = dump(recorded_scene(scene, simulation, end_now), in_full=False)
        try:
            make_folder(file.parent)
            write_if_changed(file, f"# As it was directed.\n{text}".encode())
        except OSError as error:
            raise StoreError(f"{file}: could not be written ({error})") from error
        return file


def recorder_for(
    file: Path, name: str | None, out: Path, quiet: bool, verbose: bool
) -> SceneRecorder:
    """Return the recorder of a directed scene, which reports to standard error.

    Args:
        file: of the scene.
        name: of the directed scene, None for a default.
        out: folder that holds the scenes' folders.
        quiet: whether only errors are reported.
        verbose: whether details are reported.

    Raises:
        UsageError: the name is invalid.
    """
    name = f"{file.stem}{NAME_SUFFIX}" if name is None else name
    if not re.fullmatch(NAME_PATTERN, name):
        raise UsageError(f"--name {name!r} is no name; take letters, digits, _ and -")
    return SceneRecorder(name, out, Reporter() if quiet else LogReporter(sys.stderr, verbose))


def recorded_scene(scene: Scene, simulation: Simulation, end_now: bool) -> Scene:
    """Return a scene whose script also has the commands, at exact times.

    Args:
        scene: before it was directed.
        simulation: of it.
        end_now: whether it ends with the present frame.
    """
    clock = simulation.world.clock
    commands = [
        Instruction(at=float(clock.time_of(step)), who=who, do=do)
        for step, who, do in simulation.script.told
    ]
    changed = scene.model_copy(update={"script": (*scene.script, *commands)})
    if not end_now or simulation.finished:
        return changed
    frames = max(-(-simulation.step_number // clock.steps), 1)
    shorter: dict[str, object] = {"frames": frames, "duration": None}
    if scene.golden.frames:
        kept = tuple(n for n in scene.golden.frames if n <= frames)
        shorter["golden"] = scene.golden.model_copy(update={"frames": kept or None})
    return changed.model_copy(update=shorter)


def _take_with_key(simulation: Simulation, key: str) -> Take:
    """Return the take of a simulation, with the key of the recorded scene."""
    simulation.recorder.header = replace(simulation.recorder.header, key=key)
    return simulation.take()
