"""Gait bars: when feet were to be down, and when they were.

What was planned is told by the gait's phases; what came of it is measured in the poses
of the take alone: where the tip of a leg rests on the ground. Touches are known to a
fraction of a step, liftings to a row of the take.

Source: Sims 1987, figure 9.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UsageError
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.gaits.gait import PHASE_TOLERANCE
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.walking import Walkers
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, matrix, turn
from pipeline.simulation.take import Take
from pipeline.simulation.terrain import Ground
from pipeline.spec import Scene
from pipeline.spec.script import ChangeGait
from pipeline.spec.walk import Manner

STILL = 0.004
"""Speed below which a tip rests, in leg lengths a second."""

NEAR = 0.03
"""How far above the ground a resting tip may be, in leg lengths."""


@dataclass(frozen=True, eq=False)
class LegBars:
    """When one foot is down.

    Attributes:
        name: of the leg.
        planned, actual: (n, 2) begins and ends [s].
    """

    name: str
    planned: Array
    actual: Array


@dataclass(frozen=True, eq=False)
class CreatureBars:
    """When the feet of one creature are down.

    Attributes:
        name: of the creature.
        gait: its name, or what stands for it.
        figure: for the colors of its legs.
        legs: of the creature.
        flights: (n, 2) begins and ends of flights, as planned [s].
    """

    name: str
    gait: str
    figure: Figure
    legs: tuple[LegBars, ...]
    flights: Array


def walkers_of(scene: Scene) -> Walkers:
    """Return the creatures of a scene that walk on legs; at its end if a script directs them.

    Raises:
        UsageError: nobody does.
        PronkError: the scene cannot begin.
    """
    simulation = Simulation(scene)
    for troupe in simulation.troupes:
        if isinstance(troupe, Walkers) and troupe.herd.walks.any():
            while scene.script and not simulation.finished:
                simulation.step()
            return troupe
    raise UsageError(
        "nobody in this scene walks on legs, so there is no gait to plot; "
        "give a creature with legs `walk: {}`"
    )


def bars_of(scene: Scene, walkers: Walkers, take: Take) -> Iterator[CreatureBars]:
    """Give the bars of every creature that walks.

    Args:
        scene: what was asked for.
        walkers: its creatures.
        take: what became of it.
    """
    herd, ground = walkers.herd, walkers.world.ground
    words = {member.name: member.walk for _, member in scene.creatures}
    times = np.arange(len(take.positions)) / float(take.header.rate * take.header.samples)
    for c in np.flatnonzero(herd.walks):
        name, legs = herd.names[c], np.flatnonzero(herd.owner == c)
        course = _course(take, name)
        stances = [walkers.going.paces.stances(int(leg), course[0], course[-1]) for leg in legs]
        yield CreatureBars(
            name,
            " → ".join(_called(words) for words in [words[name], *_told(scene, name)]),
            herd.figures[c],
            tuple(
                LegBars(
                    herd.leg_names[leg],
                    _planned(stances[i], course, times),
                    _actual(take, herd, ground, int(leg), times),
                )
                for i, leg in enumerate(legs)
            ),
            _planned(_gaps(stances, course), course, times),
        )


def _told(scene: Scene, name: str) -> list[Manner]:
    """Return the gaits that the script tells a creature to go over into, as they are written."""
    return [one.do for one in scene.script if one.who == name and isinstance(one.do, ChangeGait)]


def _called(walk: Manner | None) -> str:
    gait = walk.gait if walk is not None else ""
    return gait if isinstance(gait, str) else "a gait written out"


def _course(take: Take, name: str) -> Array:
    """Return the phase of a creature's gait in every row, whole cycles counted."""
    names = [channel.name for channel in take.channels]
    return np.unwrap(take.values[:, names.index(f"{name}.gait_phase")], period=1.0)


def _gaps(stances: Sequence[Array], course: Array) -> Array:
    """Return between which phases (n, 2) no foot is to be down."""
    spans = np.concatenate([np.zeros((0, 2)), *stances])
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    ends = np.maximum.accumulate(spans[:, 1]) if len(spans) else spans[:, 1]
    gaps = np.stack([ends[:-1], spans[1:, 0]], axis=-1)
    return gaps[gaps[:, 1] > gaps[:, 0] + PHASE_TOLERANCE]


def _planned(phases: Array, course: Array, times: Array) -> Array:
    """Return when (n, 2) the phase is between `phases` (n, 2) [s]."""
    spans = np.clip(phases, course[0], course[-1])
    spans = spans[spans[:, 1] > spans[:, 0]]
    moments = np.interp(spans, course, times)
    # Who has halted keeps its phase: what was going on then goes on to the end.
    moments[spans[:, 1] >= course[-1], 1] = times[-1]
    return moments


def _actual(take: Take, herd: Herd, ground: Ground, leg: int, times: Array) -> Array:
    """Return when (n, 2) the tip of a leg rested on the ground [s]."""
    owner = herd.names[herd.owner[leg]]
    row = float(times[1] - times[0])
    spans = _runs(rests(tips_of(take, herd, leg), herd, ground, leg, row))
    result = times[spans]
    touches = [
        float((contact.step + contact.fraction) / (take.header.rate * take.header.steps))
        for contact in take.contacts
        if contact.part == f"{owner}.{herd.leg_names[leg]}" and contact.kind == "touch"
    ]
    for moment in touches:
        # A foot touches less than two rows before it is seen to rest.
        own = np.flatnonzero(np.abs(result[:, 0] - moment) < 2.0 * row)
        result[own, 0] = moment
    return result


def rests(tip: Array, herd: Herd, ground: Ground, leg: int, row: float) -> NDArray[np.bool_]:
    """Tell whether a foot rested on the ground between each row and the next (K - 1,).

    Args:
        tip: (K, 3) places of its tip [m].
        herd: the creatures.
        ground: that it rests on.
        leg: which.
        row: time between two rows [s].
    """
    length = float(herd.legs.lengths[leg])
    still = np.linalg.norm(np.diff(tip, axis=0), axis=-1) < STILL * length * row
    above = tip[:, 1] - ground.height(tip[:, 0], tip[:, 2]) - float(herd.sole[leg])
    result: NDArray[np.bool_] = still & (above[1:] < NEAR * length)
    return result


def tips_of(take: Take, herd: Herd, leg: int) -> Array:
    """Return where the tip of a leg is in every row (K, 3) [m]."""
    owner = int(herd.owner[leg])
    skeleton = herd.figures[owner].skeleton
    which = int(np.count_nonzero(herd.owner[:leg] == owner))
    link = skeleton.legs[which].links[-1]
    first = [node.performer for node in take.nodes].index(herd.names[owner])
    start, end = skeleton.links[link].ends
    R = matrix(take.rotations[:, first + link])
    return take.positions[:, first + link] + turn(R, end - start)


def _runs(flags: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the first and the last row (n, 2) of every run of rows that belong together.

    Args:
        flags: (K - 1,) whether a row and the next belong together.
    """
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8))
    return np.stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)], axis=-1)
