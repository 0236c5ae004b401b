"""Gait plot: planned and actual contacts of all feet over time, one panel per creature.

Planned stances are phases of the gait, recorded in the take. Actual ones are measured in its
poses: touches to a fraction of a step, liftings to a row.

Source: Sims 1987, figure 9.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import drawsvg
import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UsageError
from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.plot_colors import FAINT, INK, limb_colors
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.time_axis import Axis, draw_frames, draw_seconds
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.take_stage import take_of
from pipeline.simulation.mechanism import Leg
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.stance_detection import foot_path, ground_below, resting_rows
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from pipeline.spec.creature import Creature
from pipeline.spec.script import ChangeGait
from pipeline.spec.walk import Manner

TOP, GAP = 92, 24
"""Above the first panel, and between panels [pixels]."""

NAMES, HEAD, FOOT = 92, 62, 44
"""Beside the bars, above and below them within a panel [pixels]."""

ROW, BAR = 30, 10
"""Height of a leg's row and of one of its two bars [pixels]."""

MIN_FLIGHT = 1e-6
"""Shortest gap between planned stances that counts as a flight [cycles]."""

MAX_TOUCH_ROWS = 2.0
"""Rows by which the poses can show a rest later than its touch."""


@dataclass(frozen=True, eq=False)
class LegStances:
    """Stances of one foot.

    Attributes:
        name: of the leg.
        planned, actual: (n, 2) starts and ends [s].
    """

    name: str
    planned: Array
    actual: Array


@dataclass(frozen=True, eq=False)
class CreatureStances:
    """Stances of one creature.

    Attributes:
        name: of the creature.
        gait: names of its gaits, in their order.
        colors: of its legs.
        legs: their stances.
        flights: (n, 2) starts and ends of planned flights [s].
    """

    name: str
    gait: str
    colors: Sequence[str]
    legs: tuple[LegStances, ...]
    flights: Array


def plot_gait(order: Order, reporter: Reporter) -> tuple[Path, Path]:
    """Write the gait plot of a scene into its folder as SVG and PNG.

    Raises:
        PronkError: no creature walks on legs, or something cannot be made.
    """
    walkers = walkers_of(order.scene)
    with working(order, reporter) as run:
        take = take_of(run)
        rate = float(take.header.rate)
        creatures = [creature_stances(order.scene, name, take) for name in walkers]
        title = take.header.title or order.name
        svg = gait_svg(title, creatures, take.header.frames / rate, rate)
        return write_plot(run, "gait", svg)


def walkers_of(scene: Scene) -> list[str]:
    """Return the creatures of a scene that walk on legs, all on one ground.

    Raises:
        UsageError: there are none.
        PronkError: the scene cannot start.
    """
    legged = {leg.performer for leg in Simulation(scene).legs()}
    members = [member for _, member in scene.creatures if member.name in legged]
    walkers: dict[float | None, list[str]] = {_level(member): [] for member in members}
    for member in members:
        if member.walk is not None:
            walkers[_level(member)].append(member.name)
    for names in walkers.values():
        if names:
            return names
    raise UsageError(
        "nobody in this scene walks on legs, so there is no gait to plot; "
        "give a creature with legs `walk: {}`"
    )


def _level(member: Creature) -> float | None:
    """Return the height of the level ground of a creature that rides, None on the terrain."""
    if member.parent is None:
        return None
    return member.at[1] if len(member.at) == 3 else 0.0


def creature_stances(scene: Scene, name: str, take: Take) -> CreatureStances:
    """Return the planned and the actual stances of a creature that walks."""
    member = next(member for _, member in scene.creatures if member.name == name)
    legs = [leg for leg in take.legs if leg.performer == name]
    times = np.arange(len(take.positions)) / float(take.header.rate * take.header.samples)
    names = [channel.name for channel in take.channels]
    phase = np.unwrap(take.values[:, names.index(f"{name}.gait_phase")], period=1.0)
    planned = [_seconds(np.reshape(leg.stances, (-1, 2)), phase, times) for leg in legs]
    changes = [
        entry.do
        for _, entry in scene.instructions
        if entry.who == name and isinstance(entry.do, ChangeGait)
    ]
    return CreatureStances(
        name,
        " → ".join(_gait_name(manner) for manner in [member.walk, *changes]),
        limb_colors([("leg", leg.side) for leg in legs]),
        tuple(
            LegStances(leg.name, planned[i], _actual(take, leg, _level(member), times))
            for i, leg in enumerate(legs)
        ),
        _seconds(_flights(legs), phase, times),
    )


def _gait_name(manner: Manner | None) -> str:
    gait = manner.gait if manner is not None else ""
    return gait if isinstance(gait, str) else "a gait written out"


def _flights(legs: Sequence[Leg]) -> Array:
    """Return the phases (n, 2) between which no foot is planned to be down."""
    spans = np.concatenate([np.zeros((0, 2)), *(np.reshape(leg.stances, (-1, 2)) for leg in legs)])
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    ends = np.maximum.accumulate(spans[:, 1]) if len(spans) else spans[:, 1]
    gaps = np.stack([ends[:-1], spans[1:, 0]], axis=-1)
    return gaps[gaps[:, 1] > gaps[:, 0] + MIN_FLIGHT]


def _seconds(phases: Array, phase: Array, times: Array) -> Array:
    """Return when (n, 2) the course `phase` (K,) lies between `phases` (n, 2) [s]."""
    spans = np.clip(phases, phase[0], phase[-1])
    spans = spans[spans[:, 1] > spans[:, 0]]
    moments = np.interp(spans, phase, times)
    # A creature that has halted keeps its phase, so its last stance lasts to the end.
    moments[spans[:, 1] >= phase[-1], 1] = times[-1]
    return moments


def _actual(take: Take, leg: Leg, level: float | None, times: Array) -> Array:
    """Return when (n, 2) a foot rested on the ground [s]."""
    path = foot_path(take, leg)
    ground = ground_below(take, path) if level is None else np.full(len(path), level)
    result = times[_runs(resting_rows(take, leg, path, ground))]
    row = float(times[1] - times[0])
    for contact in take.contacts:
        if contact.part == f"{leg.performer}.{leg.name}" and contact.kind == "touch":
            header = take.header
            moment = float((contact.step + contact.fraction) / (header.rate * header.steps))
            own = np.flatnonzero(np.abs(result[:, 0] - moment) < MAX_TOUCH_ROWS * row)
            result[own, 0] = moment
    return result


def _runs(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the first and the last row (n, 2) of every run of rows.

    Args:
        flags: (K - 1,) whether a row and the next belong together.
    """
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    return np.stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)], axis=-1)


def gait_svg(title: str, creatures: Sequence[CreatureStances], duration: float, rate: float) -> str:
    """Return the plot as SVG.

    Args:
        title: of the scene.
        creatures: that walk.
        duration: of the film [s].
        rate: frames per second.
    """
    axis = Axis.fitted(MARGIN + NAMES, duration, rate)
    width = axis.length + NAMES + 2 * MARGIN + 24
    heights = [HEAD + ROW * len(creature.legs) + FOOT for creature in creatures]
    canvas = Canvas.page(width, TOP + sum(heights) + GAP * len(heights), title)
    legend = "feet on the ground: as planned by the gait (pale, above), as they were (full, below)"
    canvas.text(legend, (MARGIN, 74), 15, FAINT)
    y = float(TOP)
    for creature, height in zip(creatures, heights, strict=True):
        _draw_creature(canvas, Panel(MARGIN, y, width - 2 * MARGIN, height), creature, axis)
        y += height + GAP
    return canvas.svg


def _draw_creature(canvas: Canvas, panel: Panel, creature: CreatureStances, axis: Axis) -> None:
    canvas.panel(panel)
    canvas.text(creature.name, (panel.x + 16, panel.y + 26), 17, INK, bold=True)
    canvas.text(creature.gait, (axis.x, panel.y + 26), 15, FAINT)
    top = panel.y + HEAD
    bottom = top + ROW * len(creature.legs)
    for x, width in _boxes(creature.flights, axis):
        canvas.draw(drawsvg.Rectangle(x, top, width, bottom - top, fill="#ffffff"))
    draw_seconds(canvas, axis, top, bottom)
    draw_frames(canvas, axis, top)
    for i, (leg, color) in enumerate(zip(creature.legs, creature.colors, strict=True)):
        y = top + ROW * i
        canvas.text(leg.name, (panel.x + 16, y + 20), 14, INK, bold=True)
        for spans, down, opacity in ((leg.planned, 4.0, 0.45), (leg.actual, 4.0 + BAR + 1.0, 1.0)):
            for x, width in _boxes(spans, axis):
                style = {"fill": color, "fill_opacity": opacity}
                canvas.draw(drawsvg.Rectangle(x, y + down, width, BAR, **style))


def _boxes(spans: Array, axis: Axis) -> Iterator[tuple[float, float]]:
    """Yield left edge and width of intervals, cut off at the end of the film [pixels]."""
    for start, end in spans.tolist():
        last = min(end, axis.duration)
        if last > start:
            yield axis.at(start), axis.scale * (last - start)
