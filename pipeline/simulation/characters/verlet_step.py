"""Verlet step."""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import LOCKED, RESTING, CharacterArrays, IntArray
from pipeline.simulation.characters.box_contacts import meet_box, part
from pipeline.simulation.characters.broad_phase import Workspace, enclose, find_near, find_pairs
from pipeline.simulation.characters.constraint_projection import (
    close_grips,
    finish_constraints,
    finish_grips,
    project_constraints,
    project_grips,
)
from pipeline.simulation.characters.contact_response import PARTING, TouchLog, grow_old
from pipeline.simulation.characters.link_contacts import are_near, meet
from pipeline.simulation.characters.motor_control import control_people
from pipeline.simulation.characters.sleep_states import update_sleep, wake_near
from pipeline.simulation.characters.solid_contacts import SubStep, find_solids, meet_solids
from pipeline.simulation.characters.terrain_contacts import stand
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry, inlined
from pipeline.simulation.dynamics.terrain_grid import Grid


@inlined
def integrate(nodes: Records, gravity: float, h: float) -> None:
    """Move all nodes on by a sub-step.

    p(t + h) = (2 - d) p(t) - (1 - d) p(t - h) + a h², where d = 1 - exp(-c h): the paper's
    factor is one a sixtieth of a second, a rate c [1/s] holds for any step.

    Args:
        nodes: of all characters.
        gravity: [m/s²].
        h: the sub-step [s].
    """
    for i in range(len(nodes)):
        _move(nodes[i], gravity, h)


@inlined
def _move(node: Record, gravity: float, h: float) -> None:
    p, before, pull = node.p, node.previous, node.acceleration
    for k in range(3):
        node.contact_push[k] = 0.0
    if node.lock == LOCKED:
        for k in range(3):
            p[k] = before[k] = node.lock_place[k]
            pull[k] = 0.0
        node.mobility = 0.0
        return
    if node.lock == RESTING or node.inverse_mass == 0.0:
        for k in range(3):
            before[k] = p[k]
            pull[k] = 0.0
        node.mobility = 0.0
        return
    node.mobility = node.inverse_mass
    keeps = math.exp(-(node.air_damping + max(node.ground_damping, node.contact_damping)) * h)
    for k in range(3):
        went = p[k] - before[k]
        before[k] = p[k]
        p[k] += keeps * went + pull[k] * h * h
        pull[k] = 0.0
    p[1] -= gravity * h * h
    node.ground_damping = node.contact_damping = 0.0


@inlined
def damp(nodes: Records, links: Records, h: float) -> None:
    """Damp the ends of links against one another, a crude model of muscles and tendons.

    Both take on part of their difference, weighted so that no momentum is made.
    """
    for n in range(len(links)):
        link = links[n]
        if link.damping == 0.0:
            continue
        one, other = nodes[link.ends[0]], nodes[link.ends[1]]
        if one.mobility + other.mobility == 0.0:
            continue
        part = (1.0 - math.exp(-link.damping * h)) / (one.mobility + other.mobility)
        for k in range(3):
            slip = part * ((one.p[k] - one.previous[k]) - (other.p[k] - other.previous[k]))
            one.previous[k] += one.mobility * slip
            other.previous[k] -= other.mobility * slip


ROUNDS = 2
"""Times that links and touches are gone through in a sub-step, before links have the last word."""

MORE, DEEP = 4, 0.003
"""Times that those are gone through again in whom, or who, lies something so deep [m]."""

PAIN_ENDS = 0.5
"""How fast pain decays [1/s]."""


@entry
def advance(
    arrays: CharacterArrays,
    persons: Records,
    grid: Grid,
    level: bool,
    room: Workspace,
    log: TouchLog,
    gravity: float,
    dt: float,
    count: int,
) -> None:
    """Go on by a step of `dt` [s] in `count` sub-steps.

    Args:
        arrays: all characters; changed.
        persons: `control.PERSON` of those who act; changed.
        grid: the terrain.
        level: whether it is a level plane.
        room: to work in, and the solids of other rooms; these are changed.
        log: of what touches; begun anew.
        gravity: [m/s²].
        dt: the step [s].
        count: of sub-steps.
    """
    h = dt / count
    log.filled[0] = 0
    _forget(arrays.links)
    for n in range(count):
        control_people(arrays, persons, grid, room.solids, h)
        _sub_step(arrays, grid, level, room, log, gravity, h, n / count)
    _feel(arrays.links, arrays.owners, dt)
    update_sleep(arrays.nodes, arrays.links, arrays.owners, arrays.grips, h, dt)


@compiled
def _sub_step(
    arrays: CharacterArrays,
    grid: Grid,
    level: bool,
    room: Workspace,
    log: TouchLog,
    gravity: float,
    h: float,
    moment: float,
) -> None:
    nodes, links, middles, limbs, own, grips, owners = arrays
    damp(nodes, links, h)
    integrate(nodes, gravity, h)
    close_grips(nodes, grips, h)
    grow_old(links, h)
    enclose(nodes, owners)
    near = room.near[: find_near(owners, room.order, room.near)]
    wake_near(nodes, owners, near)
    solid = find_solids(nodes, owners, room.solids, h)
    _choose(owners, False)
    pairs = room.pairs[: find_pairs(nodes, links, owners, own, near, room.pairs)]
    for n in range(ROUNDS + MORE):
        if n > 0:
            _choose(owners, n >= ROUNDS)
        # What was in one another parts at its pace, however often it is gone through.
        slack = PARTING * h / ROUNDS if n < ROUNDS else 0.0
        for c in range(len(owners)):
            if owners[c].active:
                project_constraints(nodes, links, middles, limbs, owners[c])
        project_grips(nodes, grips)
        _meet_all(nodes, links, owners, pairs, h, slack, moment, log)
        _meet_boxes(nodes, links, owners, near, h, slack, moment, log)
        if solid > 0:
            pace = SubStep(h, slack, moment)
            meet_solids(nodes, links, owners, room.solids, solid, pace, n % 2 == 1, log)
        for c in range(len(owners)):
            if owners[c].active:
                stand(nodes, links, owners[c], grid, level, h, slack, moment, log)
    for c in range(len(owners)):
        if not owners[c].asleep:
            finish_constraints(nodes, links, middles, limbs, owners[c])
    finish_grips(nodes, links, middles, limbs, owners, grips)


@compiled
def _meet_all(
    nodes: Records,
    links: Records,
    owners: Records,
    pairs: IntArray,
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    for n in range(len(pairs)):
        a, b = links[pairs[n, 0]], links[pairs[n, 1]]
        if (owners[a.owner].active or owners[b.owner].active) and are_near(nodes, a, b):
            meet(nodes, links, owners, (pairs[n, 0], pairs[n, 1]), h, slack, moment, log)


@compiled
def _choose(owners: Records, again: bool) -> None:
    """Choose who is gone through: who is awake; or again, in whom something lies deep."""
    for c in range(len(owners)):
        owner = owners[c]
        owner.active = not owner.asleep and (not again or owner.penetration > DEEP)
        owner.penetration = 0.0


@compiled
def _meet_boxes(
    nodes: Records,
    links: Records,
    owners: Records,
    near: IntArray,
    h: float,
    slack: float,
    moment: float,
    log: TouchLog,
) -> None:
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if not one.active and not other.active:
            continue
        if one.edge_radius > 0.0 and other.edge_radius > 0.0:
            part(nodes, one, other, slack)
        if other.edge_radius > 0.0:
            meet_box(nodes, links, one, other, h, slack, moment, log)
        if one.edge_radius > 0.0:
            meet_box(nodes, links, other, one, h, slack, moment, log)


@compiled
def _forget(links: Records) -> None:
    """Forget how hard touches of the last step were."""
    for n in range(len(links)):
        links[n].energy = 0.0


@compiled
def _feel(links: Records, owners: Records, dt: float) -> None:
    """Let touches that are hard enough hurt, and pain decay."""
    for c in range(len(owners)):
        owner = owners[c]
        owner.pain *= math.exp(-PAIN_ENDS * dt)
        for n in range(owner.links[0], owner.links[0] + owner.links[1]):
            if links[n].energy > owner.pain_threshold:
                owner.pain += links[n].energy / owner.pain_threshold - 1.0
