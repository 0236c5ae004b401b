"""Stepping: a step of all characters, as one call of machine code."""

from __future__ import annotations

import math

from pipeline.simulation.characters.control import steer
from pipeline.simulation.characters.events import Log
from pipeline.simulation.characters.floor import stand
from pipeline.simulation.characters.layout import Crowd
from pipeline.simulation.characters.neighbours import Room, enclose, find_near, find_pairs
from pipeline.simulation.characters.projecting import finish, hold, project
from pipeline.simulation.characters.touching import grow_old, meet
from pipeline.simulation.characters.verlet import damp, integrate
from pipeline.simulation.dynamics.compiled import Records, compiled, entry
from pipeline.simulation.dynamics.grid import Grid

ROUNDS = 2
"""Times that links and touches are gone through in a sub-step, before links have the last word."""

PAIN_ENDS = 0.5
"""How fast pain decays [1/s]."""


@entry
def advance(
    crowd: Crowd,
    persons: Records,
    grid: Grid,
    level: bool,
    room: Room,
    log: Log,
    gravity: float,
    dt: float,
    count: int,
) -> None:
    """Go on by a step of `dt` [s] in `count` sub-steps.

    Args:
        crowd: all characters; changed.
        persons: `control.PERSON` of those who act; changed.
        grid: the terrain.
        level: whether it is a level plane.
        room: to work in.
        log: of what touches; begun anew.
        gravity: [m/s²].
        dt: the step [s].
        count: of sub-steps.
    """
    h = dt / count
    log.count[0] = 0
    crowd.energy[:] = 0.0
    for n in range(count):
        steer(crowd, persons, grid, h)
        _sub_step(crowd, grid, level, room, log, gravity, h, n / count)
    _feel(crowd, dt)


@compiled
def _sub_step(
    crowd: Crowd,
    grid: Grid,
    level: bool,
    room: Room,
    log: Log,
    gravity: float,
    h: float,
    moment: float,
) -> None:
    damp(crowd, h)
    integrate(crowd, gravity, h)
    grow_old(crowd, log, h)
    enclose(crowd)
    pairs = find_pairs(crowd, room, find_near(crowd, room))
    for _ in range(ROUNDS):
        for c in range(len(crowd.owners)):
            project(crowd, crowd.owners[c])
        hold(crowd)
        for c in range(len(crowd.owners)):
            owner = crowd.owners[c]
            for n in range(owner.pairs[0], owner.pairs[0] + owner.pairs[1]):
                meet(crowd, crowd.pairs[n, 0], crowd.pairs[n, 1], h, moment, log)
        for n in range(pairs):
            meet(crowd, room.pairs[n, 0], room.pairs[n, 1], h, moment, log)
        for c in range(len(crowd.owners)):
            stand(crowd, crowd.owners[c], grid, level, h, moment, log)
    for c in range(len(crowd.owners)):
        finish(crowd, crowd.owners[c])


@compiled
def _feel(crowd: Crowd, dt: float) -> None:
    """Let touches that are hard enough hurt, and pain decay."""
    for c in range(len(crowd.owners)):
        owner = crowd.owners[c]
        owner.pain *= math.exp(-PAIN_ENDS * dt)
        for n in range(owner.links[0], owner.links[0] + owner.links[1]):
            if crowd.energy[n] > owner.threshold:
                owner.pain += crowd.energy[n] / owner.threshold - 1.0
