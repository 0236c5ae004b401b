"""Scene check: what can be known of a scene without rendering it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pipeline.errors import Problem
from pipeline.production.camera.parent_nodes import camera_parents, focus_nodes
from pipeline.production.reports.figure_size import FigureSize, metres
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.notes import clock_of, foreseen_notes, refuse_notes, take_notes
from pipeline.production.run.outdoors_summary import scatter_text, sun_text
from pipeline.production.run.picture_notes import shooting_notes
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.shots.title_timing import require_titles
from pipeline.simulation.figure_analysis import Figure, build_figure, check_figure
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.cast import Member
from pipeline.spec.creature import Creature

PROGRESS_FRAMES = 8
"""Frames after which the simulation reports its progress."""


def check_scene(
    scene: Scene,
    reporter: Reporter | None = None,
    name: str = "scene",
    simulated: bool = False,
    strict: bool = False,
) -> str:
    """Build the scene's world with its cast in place and return a summary in one line.

    Args:
        scene: to be checked.
        reporter: of progress and notes.
        name: of the scene, in reports.
        simulated: whether to simulate the film as well, which may take minutes.
        strict: whether notes are an error.

    Raises:
        NotesRefused: there are notes, and the check is strict.
        PronkError: a figure is wrong, a performer cannot start its part, the film has no encoder
            here, a title does not fit, or the simulation fails.
    """
    reporter = reporter or Reporter()
    require_encoders(scene)
    require_titles(scene)
    with compile_progress(reporter):
        simulation = Simulation(scene)
    names = NodeNames.joined(simulation.recorder.nodes, simulation.aliases)
    camera_parents(scene, names)
    focus_nodes(scene, names)
    notes, tally = notes_after_end(scene), None
    if simulated:
        take = _take_of(simulation, scene.n_frames, reporter)
        # What the renderer needs of a take can be wrong too.
        shooting = ShotBuilder(scene, take)
        notes += take_notes(take, clock_of(scene)) + shooting_notes(scene, shooting)
        tally = shooting.scattered
    else:
        notes += foreseen_notes(simulation.foreseen_notes(), clock_of(scene))
    if strict:
        refuse_notes(notes)
    if notes:
        reporter.notes(name, notes, None)
    outdoors = (sun_text(scene.light), scatter_text(scene, tally))
    told = [_summary(scene, simulation), *filter(None, outdoors)]
    return "; ".join(told) + ("" if simulated else _unchecked_poses(scene))


def _take_of(simulation: Simulation, frames: int, reporter: Reporter) -> Take:
    """Take all steps of a simulation and return its take."""
    clock = simulation.world.clock
    with (
        stage(reporter, "simulate", frames, "s", float(1 / clock.rate)) as current,
        compile_progress(reporter, current),
    ):
        while not simulation.finished:
            simulation.step()
            if simulation.step_number % (PROGRESS_FRAMES * clock.steps) == 0:
                current.advance(simulation.step_number // clock.steps)
        take = simulation.take()
        current.done, current.result = frames, counted(frames)
    return take


def _summary(scene: Scene, simulation: Simulation) -> str:
    ground = simulation.world.ground
    width, height = scene.film.resolved().size
    length = f"{scene.n_frames} frames at {scene.fps} a second, {width}x{height}"
    used = {member.figure for _, member in scene.creatures}
    sizes = {
        name: FigureSize.of(build_figure(name, figure, 1.0))
        for name, figure in scene.figures.items()
        if name in used
    }
    cast = ", ".join(f"{member.name} ({_kind_text(member, sizes)})" for member in scene.cast)
    return f"right: {length}; {cast}; {100 * ground.forbidden.mean():.0f}% of the ground forbidden"


def _unchecked_poses(scene: Scene) -> str:
    """Return whose pose keys depend on where they walk to, and are found by simulation alone."""
    names = [
        f"'{member.name}'"
        for _, member in scene.creatures
        if member.pose and (member.walk is not None or member.pronk is not None)
    ]
    if not names:
        return ""
    return f"; --simulate also checks the pose keys of {', '.join(names)} on the way"


def _kind_text(member: Member, sizes: Mapping[str, FigureSize]) -> str:
    """Return the kind of a member; of a creature, also its length and height."""
    if not isinstance(member, Creature):
        return member.kind_name
    size, scale = sizes[member.figure], member.scale
    extent = f"{metres(scale * size.length)} m long, {metres(scale * size.height)} m high"
    return f"{member.figure}, {extent}"


@dataclass(frozen=True, slots=True)
class FigureRemark:
    """A remark on a figure.

    Attributes:
        problem: the remark at its place.
        is_fault: whether it is likely a mistake.
    """

    problem: Problem
    is_fault: bool


def figure_remarks(scene: Scene) -> Iterator[FigureRemark]:
    """Yield remarks on the figures of a scene's creatures."""
    for name in dict.fromkeys(member.figure for _, member in scene.creatures):
        yield from remarks_on(scene, build_figure(name, scene.figures[name], 1.0))


def remarks_on(scene: Scene, figure: Figure) -> Iterator[FigureRemark]:
    """Yield remarks on one figure of a scene."""
    for remark in check_figure(figure):
        path = f"figures.{figure.name}.{figure.drawing.path_of(remark.node)}"
        problem = scene.source_map.with_location(Problem(path, remark.text))
        yield FigureRemark(problem, remark.is_fault)
