"""Verlet step: a step of all characters, as one call of machine code.

Source: Horswill 2008, "Dynamics simulation" and "Friction, drag and damping".
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import LOCKED, RESTING, CharacterArrays, IntArray
from pipeline.simulation.characters.box_contacts import meet_box, separate_boxes
from pipeline.simulation.characters.broad_phase import (
    Workspace,
    find_link_pairs,
    find_near_characters,
    find_own_pairs,
    update_bounds,
)
from pipeline.simulation.characters.constraint_projection import (
    close_grips,
    finish_constraints,
    finish_grips,
    project_constraints,
    project_grips,
)
from pipeline.simulation.characters.contact_response import (
    PARTING_SPEED,
    SubStep,
    TouchLog,
    begin_touches,
)
from pipeline.simulation.characters.limb_limits import begin_recovery
from pipeline.simulation.characters.link_contacts import may_touch, separate_links
from pipeline.simulation.characters.motor_control import control_people, drive_people
from pipeline.simulation.characters.sleep_states import update_sleep, wake_near
from pipeline.simulation.characters.solid_contacts import find_solids, meet_solids
from pipeline.simulation.characters.terrain_contacts import separate_from_ground
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, entry, inlined
from pipeline.simulation.dynamics.terrain_grid import Grid
from pipeline.simulation.spatial import Array


@compiled
def _move_characters(
    arrays: CharacterArrays, measured: Array, travel: Array, gravity: float, h: float
) -> None:
    """Move all nodes by a sub-step, one character after the other, and update its bounds.

    So its nodes are read from memory only once.
    """
    rates = 0.0, 1.0, 0.0, 0.0
    for c in range(len(arrays.owners)):
        owner = arrays.owners[c]
        rates = _move_character(arrays.nodes, arrays.links, owner, rates, gravity, h)
        travel[c] += update_bounds(arrays.nodes, owner, measured)


@inlined
def _move_character(
    nodes: Records,
    links: Records,
    owner: Record,
    rates: tuple[float, float, float, float],
    gravity: float,
    h: float,
) -> tuple[float, float, float, float]:
    """Damp the links of a character and move its nodes by a sub-step.

    Args:
        nodes: of all characters.
        links: of all characters.
        owner: the character.
        rates: of damping and the part of a motion that is kept with it, and the same of links and
            the part that is lost; those of the character before, for most are alike.
        gravity: [m/s²].
        h: the sub-step [s].

    Returns:
        The rates of this character.
    """
    rate, kept, link_rate, lost = rates
    link_rate, lost = damp_links(nodes, links, owner, link_rate, lost, h)
    rate, kept = integrate(nodes, owner, rate, kept, gravity, h)
    return rate, kept, link_rate, lost


@inlined
def integrate(
    nodes: Records, owner: Record, rate: float, kept: float, gravity: float, h: float
) -> tuple[float, float]:
    """Move the nodes of a character by a sub-step; return its damping and what is kept with it.

    p(t + h) = (2 - d) p(t) - (1 - d) p(t - h) + a h², where d = 1 - exp(-c h): the paper's factor
    is one a sixtieth of a second, a rate c [1/s] holds for any step.

    Args:
        nodes: of all characters.
        owner: the character.
        rate: of damping of the node before [1/s].
        kept: part of a motion that is kept with it.
        gravity: [m/s²].
        h: the sub-step [s].
    """
    for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        node = nodes[i]
        # Most nodes have the rate of the one before.
        own_rate = node.air_damping + max(node.ground_damping, node.contact_damping)
        if own_rate != rate:
            rate, kept = own_rate, math.exp(-own_rate * h)
        _integrate_node(node, gravity, h, kept)
    return rate, kept


@inlined
def _integrate_node(node: Record, gravity: float, h: float, kept: float) -> None:
    p, previous, acceleration = node.p, node.previous, node.acceleration
    for k in range(3):
        node.contact_push[k] = 0.0
    if node.lock == LOCKED:
        for k in range(3):
            p[k] = previous[k] = node.lock_place[k]
            acceleration[k] = 0.0
        node.mobility = 0.0
        return
    if node.lock == RESTING or node.inverse_mass == 0.0:
        for k in range(3):
            previous[k] = p[k]
            acceleration[k] = 0.0
        node.mobility = 0.0
        return
    node.mobility = node.inverse_mass
    for k in range(3):
        moved = p[k] - previous[k]
        previous[k] = p[k]
        p[k] += kept * moved + acceleration[k] * h * h
        acceleration[k] = 0.0
    p[1] -= gravity * h * h
    node.ground_damping = node.contact_damping = 0.0


@inlined
def damp_links(
    nodes: Records, links: Records, owner: Record, rate: float, lost: float, h: float
) -> tuple[float, float]:
    """Damp the ends of links against one another, a crude model of muscles and tendons.

    Both take on part of their difference, weighted so that momentum is kept.

    Args:
        nodes: of all characters; changed.
        links: of all characters.
        owner: whose links are damped.
        rate: of damping of the link before [1/s].
        lost: part of a difference that is lost with it.
        h: the sub-step [s].

    Returns:
        Rate and part of its last link.
    """
    for n in range(owner.links[0], owner.links[0] + owner.links[1]):
        link = links[n]
        if link.damping == 0.0:
            continue
        if link.damping != rate:
            rate, lost = link.damping, 1.0 - math.exp(-link.damping * h)
        one, other = nodes[link.ends[0]], nodes[link.ends[1]]
        if one.mobility + other.mobility == 0.0:
            continue
        part = lost / (one.mobility + other.mobility)
        for k in range(3):
            slip = part * ((one.p[k] - one.previous[k]) - (other.p[k] - other.previous[k]))
            one.previous[k] += one.mobility * slip
            other.previous[k] -= other.mobility * slip
    return rate, lost


ROUNDS = 2  # of constraints and contacts in a sub-step, before constraints have the last word
EXTRA_ROUNDS = 4  # for characters in deep contacts
DEEP_CONTACT = 0.003  # [m]
PAIN_DECAY = 0.5  # [1/s]


@entry
def advance(
    arrays: CharacterArrays,
    persons: Records,
    grid: Grid,
    level: bool,
    workspace: Workspace,
    log: TouchLog,
    gravity: float,
    dt: float,
    count: int,
) -> None:
    """Advance all characters by a step of `dt` [s] in `count` sub-steps.

    Args:
        arrays: all characters; changed.
        persons: `PERSON` records of acting people; changed.
        grid: the terrain.
        level: whether the terrain is a level plane.
        workspace: buffers, and the solids of other rooms; changed.
        log: of touches in this step; overwritten.
        gravity: [m/s²].
        dt: the step [s].
        count: number of sub-steps.
    """
    h = dt / count
    log.filled[0] = 0
    # They feel the blows of the step before.
    control_people(arrays, persons, grid, workspace.solids, h, dt)
    begin_touches(arrays.links, dt)
    for n in range(count):
        drive_people(arrays, persons, grid, workspace.solids, h, n, count)
        _sub_step(arrays, grid, level, workspace, log, gravity, h, n / count)
    _update_pain(arrays.links, arrays.owners, dt)
    update_sleep(arrays.nodes, arrays.links, arrays.limbs, arrays.owners, arrays.grips, h, dt)


@compiled
def _sub_step(
    arrays: CharacterArrays,
    grid: Grid,
    level: bool,
    workspace: Workspace,
    log: TouchLog,
    gravity: float,
    h: float,
    moment: float,
) -> None:
    nodes, links, middles, limbs, own_pairs, grips, owners = arrays
    _move_characters(arrays, workspace.measured, workspace.travel, gravity, h)
    close_grips(nodes, grips, h)
    begin_recovery(limbs, h)
    near = workspace.near[: find_near_characters(owners, workspace.order, workspace.near)]
    wake_near(nodes, owners, near)
    solid_count = find_solids(nodes, owners, workspace.solids, h)
    _activate_awake(owners)
    pairs, known = workspace.pairs, (workspace.travel, workspace.due, workspace.is_near)
    found = find_own_pairs(nodes, links, owners, own_pairs, *known, pairs)
    pairs = pairs[: find_link_pairs(nodes, links, owners, near, pairs, found)]
    for n in range(ROUNDS + EXTRA_ROUNDS):
        if n > 0 and not _activate(owners, n >= ROUNDS) and solid_count == 0:
            break
        # Old overlap is resolved at a constant speed, however many rounds there are.
        slack = PARTING_SPEED * h / ROUNDS if n < ROUNDS else 0.0
        sub_step = SubStep(h, slack, moment)
        for c in range(len(owners)):
            if owners[c].active:
                project_constraints(nodes, links, middles, limbs, owners[c])
        project_grips(nodes, owners, grips)
        _separate_pairs(nodes, links, owners, pairs, sub_step, log)
        _meet_boxes(nodes, links, owners, near, sub_step, log)
        if solid_count > 0:
            solids, reverse = workspace.solids, n % 2 == 1
            meet_solids(nodes, links, owners, solids, solid_count, sub_step, reverse, log)
        for c in range(len(owners)):
            if owners[c].active:
                separate_from_ground(nodes, links, owners[c], grid, level, sub_step, log)
    _unsettle_touching(owners)
    for c in range(len(owners)):
        if not owners[c].asleep:
            finish_constraints(nodes, links, middles, limbs, owners[c])
    finish_grips(nodes, links, middles, limbs, owners, grips)


@compiled
def _separate_pairs(
    nodes: Records,
    links: Records,
    owners: Records,
    pairs: IntArray,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    for n in range(len(pairs)):
        if owners[pairs[n, 2]].active or owners[pairs[n, 3]].active:
            pair = pairs[n, 0], pairs[n, 1]
            if may_touch(nodes, links[pair[0]], links[pair[1]]):
                separate_links(nodes, links, owners, pair, sub_step, log)


@inlined
def _activate_awake(owners: Records) -> None:
    """Activate characters that are awake; none is settled yet."""
    for c in range(len(owners)):
        owners[c].active, owners[c].settled = not owners[c].asleep, False
        owners[c].penetration = 0.0


@compiled
def _activate(owners: Records, only_deep: bool) -> bool:
    """Activate characters that are awake and unsettled, or only those in deep contacts.

    Returns:
        Whether there are any.
    """
    _unsettle_touching(owners)
    found = False
    for c in range(len(owners)):
        owner = owners[c]
        is_deep = owner.penetration > DEEP_CONTACT
        owner.active = not (owner.asleep or owner.settled) and (not only_deep or is_deep)
        owner.penetration, found = 0.0, found or owner.active
    return found


@inlined
def _unsettle_touching(owners: Records) -> None:
    """Let characters that something has moved be no longer settled."""
    for c in range(len(owners)):
        owners[c].settled = owners[c].settled and owners[c].penetration == 0.0


@compiled
def _meet_boxes(
    nodes: Records,
    links: Records,
    owners: Records,
    near: IntArray,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if not one.active and not other.active:
            continue
        if one.edge_radius > 0.0 and other.edge_radius > 0.0:
            separate_boxes(nodes, one, other, sub_step.slack)
        if other.edge_radius > 0.0:
            meet_box(nodes, links, one, other, sub_step, log)
        if one.edge_radius > 0.0:
            meet_box(nodes, links, other, one, sub_step, log)


@compiled
def _update_pain(links: Records, owners: Records, dt: float) -> None:
    for c in range(len(owners)):
        owner = owners[c]
        owner.pain *= math.exp(-PAIN_DECAY * dt)
        for n in range(owner.links[0], owner.links[0] + owner.links[1]):
            borne = owner.pain_threshold * links[n].toughness
            if links[n].energy > borne:
                owner.pain += links[n].energy / borne - 1.0
