"""Keeping: what a directed scene leaves: one that goes the same way by itself, and its take."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path

from audio.atomic_file import write_if_changed
from audio.errors import AudioError
from pipeline.errors import StoreError, UsageError
from pipeline.production.run import production
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs, opened
from pipeline.production.run.progress import LogReporter, Reporter
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene, dump, load_scene
from pipeline.spec.model_base import NAME_PATTERN
from pipeline.spec.script import Instruction

ENDING = "_directed"
"""Ends the name of a directed scene, unless it is given another."""


@dataclass(frozen=True, slots=True)
class Kept:
    """What was written.

    Attributes:
        scene: its file.
        take: its folder.
        digest: of the take.
        frames: of the film.
    """

    scene: Path
    take: Path
    digest: str
    frames: int


@dataclass(frozen=True, slots=True)
class Place:
    """Where it is kept.

    Attributes:
        name: of the directed scene.
        out: folder that holds the scenes' folders.
        reporter: where it is said.
    """

    name: str
    out: Path
    reporter: Reporter

    @property
    def outputs(self) -> Outputs:
        """The files of the directed scene."""
        return Outputs(self.out / self.name, self.name)

    def check(self) -> None:
        """Make sure that it can be written to, before there is anything to lose.

        Raises:
            StoreError: if it cannot.
        """
        with opened(self.outputs):
            pass

    def keep(self, scene: Scene, simulation: Simulation, now: bool) -> Kept:
        """Write the scene as it was directed, and its take.

        Args:
            scene: as it was before.
            simulation: of it, at its end unless it ends `now`. What the film's length decides
                at its end, such as a breath that is cut off, is then worked out by simulating
                the shorter scene anew.
            now: whether the film ends with the frame at which the simulation is.

        Raises:
            PronkError: if something cannot be written.
        """
        file = self.write(scene, simulation, now)
        order = Order(load_scene(file), self.name, self.out)
        if now and not simulation.finished:
            outputs, take = production.simulate_only(order, self.reporter)
        else:
            take = _take(simulation, production.take_key(order.scene))
            outputs = production.store_only(order, take, self.reporter)
        return Kept(file, outputs.take, take.digest, take.header.frames)

    def write(self, scene: Scene, simulation: Simulation, now: bool) -> Path:
        """Write the scene as it was directed; return its file."""
        file = self.outputs.folder / f"{self.name}.yaml"
        text = dump(directed(scene, simulation, now), in_full=False)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            write_if_changed(file, f"# As it was directed.\n{text}".encode())
        except (AudioError, OSError) as error:
            raise StoreError(f"{file}: could not be written ({error})") from error
        return file


def place_of(file: Path, name: str | None, out: Path, quiet: bool, verbose: bool) -> Place:
    """Return where a scene is kept when it has been directed.

    Args:
        file: of the scene.
        name: of the directed scene, None for one like that of its file.
        out: folder that holds the scenes' folders.
        quiet: whether nothing is said but errors.
        verbose: whether more is said. Standard output is for messages alone.

    Raises:
        UsageError: nothing can be called so.
    """
    name = f"{file.stem}{ENDING}" if name is None else name
    if not re.fullmatch(NAME_PATTERN, name):
        raise UsageError(f"--name {name!r} is no name; take letters, digits, _ and -")
    return Place(name, out, Reporter() if quiet else LogReporter(sys.stderr, verbose))


def directed(scene: Scene, simulation: Simulation, now: bool) -> Scene:
    """Return a scene whose script holds what it was told from outside, too, at exact times.

    Args:
        scene: as it was before.
        simulation: of it.
        now: whether it ends with the frame at which the simulation is.
    """
    clock = simulation.world.clock
    told = [
        Instruction(at=float(clock.time_of(step)), who=who, do=do)
        for step, who, do in simulation.script.told
    ]
    changed = scene.model_copy(update={"script": (*scene.script, *told)})
    if not now or simulation.finished:
        return changed
    frames = max(-(-simulation.step_number // clock.steps), 1)
    shorter: dict[str, object] = {"frames": frames, "duration": None}
    if scene.golden.frames:
        kept = tuple(n for n in scene.golden.frames if n <= frames)
        shorter["golden"] = scene.golden.model_copy(update={"frames": kept or None})
    return changed.model_copy(update=shorter)


def _take(simulation: Simulation, key: str) -> Take:
    """Return the take of a simulation, under the key of the scene that it has become."""
    simulation.recorder.header = replace(simulation.recorder.header, key=key)
    return simulation.take()
