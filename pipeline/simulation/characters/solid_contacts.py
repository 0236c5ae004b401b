"""Solid contacts: characters are moved out of solids of other rooms, and sense them.

Links are rows of balls, met by the planes of a convex solid and, beyond its faces, by its edges
and corners. A movable solid is pushed by what the character loses, so momentum is kept; out of
what then still overlaps it is driven slowly. Of a box, whose links are its edges, the corners of
the solid are moved out too.

Source: Horswill 2008, "Collision handling" and "Tactile sensing"; Ericson 2005, 5.1.5.
"""

from __future__ import annotations

from typing import NamedTuple

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID
from pipeline.simulation.characters.box_contacts import (
    Box,
    box_of,
    corner_mobility,
    corner_weights,
    damp_corners,
    move_corners,
    nearest_corner,
    nearest_on_box,
)
from pipeline.simulation.characters.broad_phase import bounds_overlap
from pipeline.simulation.characters.contact_response import (
    MIN_BOUNCE_SPEED,
    MIN_TOUCH_SPEED,
    SubStep,
    TouchLog,
    ball_count,
    damp_resting,
    friction_move,
    is_new_touch,
    link_overlaps,
    log_touch,
    move_between,
    move_node,
    place_between,
    sense_touch,
    support_factor,
)
from pipeline.simulation.characters.sleep_states import WAKE_SPEED, wake
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import (
    advance_solid,
    apply_impulse,
    mobility_at,
    signed_distance,
    velocity_at,
)
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.vectors import (
    Vector,
    dot,
    length,
    minus,
    plus,
    row,
    rows_of,
    times,
    triple,
    turned,
)

MAX_BALLS = 8  # along a link
ALLOWED_OVERLAP = 5e-4  # that movable solids keep [m]
DRIVE_FRACTION = 0.2  # of the overlap beyond it that they are driven out by in a sub-step
FIXED_WAKE_SPEED = 0.02  # of a fixed solid that wakes what is beside it [m/s]
MOVABLE_WAKE_SPEED = 0.12  # of a movable one, which trembles with what it lies on [m/s]
WAKE_OVERLAP = 2e-3  # of a moving fixed solid that wakes what it is in [m]
CREEP_SPEED = 0.05  # below which what lies on a character does not slide [m/s]


class Contact(NamedTuple):
    """A contact of a character with a solid.

    Attributes:
        place: in the world [m].
        depth: of the overlap [m].
        approach: by which the two came nearer in this sub-step [m].
        moved: motion past the solid in this sub-step [m].
        normal: towards the character.
        arm: from the origin of the solid to the contact [m].
    """

    place: Vector
    depth: float
    approach: float
    moved: Vector
    normal: Vector
    arm: Vector


@compiled
def find_solids(nodes: Records, owners: Records, solids: Solids, h: float) -> int:
    """Advance solids, and find the characters whose bounding boxes overlap theirs.

    Returns:
        The number of pairs in `solids.near`.
    """
    bodies, near, found = solids.bodies, solids.near, 0
    for s in range(len(bodies)):
        advance_solid(bodies[s], h)
    for c in range(len(owners)):
        for s in range(len(bodies)):
            if bodies[s].is_present and bounds_overlap(owners[c], bodies[s]):
                near[found, 0], near[found, 1] = c, s
                found += 1
                if owners[c].asleep and _max_speed(bodies[s]) > _wake_speed(bodies[s]):
                    wake(nodes, owners[c])
    return found


@compiled
def meet_solids(
    nodes: Records,
    links: Records,
    owners: Records,
    solids: Solids,
    count: int,
    sub_step: SubStep,
    reverse: bool,
    log: TouchLog,
) -> None:
    """Move characters out of the solids near them.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        solids: of other rooms.
        count: number of near pairs.
        sub_step: the sub-step.
        reverse: whether corners are visited from the last to the first: always in one order, what
            lies on a box would be pushed a little more at the first corners, and creep.
        log: of touches.
    """
    for k in range(count):
        c, s = solids.near[k, 0], solids.near[k, 1]
        owner, solid = owners[c], solids.bodies[s]
        if not owner.active and (not owner.asleep or _max_speed(solid) == 0.0):
            continue
        for n in range(owner.links[0], owner.links[0] + owner.links[1]):
            link = links[n]
            thickest = max(nodes[link.ends[0]].radius, nodes[link.ends[1]].radius)
            radius = max(link.radius, thickest)
            if link.radius == 0.0 or not link_overlaps(nodes, link, radius, solid):
                continue
            if link.ends[0] == link.ends[1]:
                _meet_ball(nodes, links, owner, solids, (n, s), 0.0, sub_step, log)
                continue
            parts = ball_count(link, MAX_BALLS)
            for i in range(parts + 1):
                _meet_ball(nodes, links, owner, solids, (n, s), i / parts, sub_step, log)
        if owner.edge_radius > 0.0:
            _meet_box(nodes, links, owner, solids, s, sub_step, reverse, log)


@inlined
def _max_speed(solid: Record) -> float:
    """Return the speed of the fastest place of a solid, at most [m/s]."""
    return length(triple(solid.v)) + length(triple(solid.w)) * solid.reach


@inlined
def _wake_speed(solid: Record) -> float:
    return FIXED_WAKE_SPEED if solid.inverse_mass == 0.0 else MOVABLE_WAKE_SPEED


@compiled
def _meet_ball(
    nodes: Records,
    links: Records,
    owner: Record,
    solids: Solids,
    pair: tuple[int, int],
    t: float,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a ball, at a fraction t along a link, out of a solid."""
    link, solid = links[pair[0]], solids.bodies[pair[1]]
    i, j = nodes[link.ends[0]], nodes[link.ends[1]]
    at = place_between(i.p, j.p, t)
    # At its ends a link is as thick as the nodes are, as on the ground.
    radius: float = i.radius if t == 0.0 else j.radius if t == 1.0 else link.radius
    gap, normal = signed_distance(solids, pair[1], at, radius)
    depth = radius - gap
    if depth <= 0.0:
        return
    place = minus(at, times(gap, normal))
    arm = minus(place, triple(solid.p))
    moved = minus(move_between(i, j, t), times(sub_step.h, velocity_at(solid, arm)))
    approach = -dot(moved, normal)
    if owner.asleep:
        _wake_by_solid(nodes, owner, solid, depth, approach / sub_step.h)
    owner.penetration = max(owner.penetration, depth)
    if _max_speed(solid) < FIXED_WAKE_SPEED:
        damp_resting(i, owner, approach / sub_step.h)
        damp_resting(j, owner, approach / sub_step.h)
    near, far = (i, i) if t == 0.0 else (i, j)
    own, against = i.mobility, mobility_at(solid, arm, normal)
    if t > 0.0:
        own = (1.0 - t) ** 2 * own + t * t * j.mobility
    kept = support_factor(near, far, normal[1], own, against)
    if kept * own + against == 0.0:
        return
    contact = Contact(place, depth, approach, moved, normal, arm)
    mobilities = own, kept, against
    move, part, back = _respond(
        link, owner, solids.bodies, pair, contact, mobilities, sub_step, log
    )
    move_node(i, kept * i.mobility * (1.0 - t if t > 0.0 else 1.0), move, part, back)
    if t > 0.0:
        move_node(j, kept * j.mobility * t, move, part, back)


@compiled
def _meet_box(
    nodes: Records,
    links: Records,
    owner: Record,
    solids: Solids,
    s: int,
    sub_step: SubStep,
    reverse: bool,
    log: TouchLog,
) -> None:
    """Move a box out of the corners of a solid, or out of a ball."""
    solid, box = solids.bodies[s], box_of(nodes, owner)
    R, p = rows_of(solid.R), triple(solid.p)
    if solid.radius > 0.0:
        at = plus(p, turned(R, triple(solid.middle)))
        _meet_corner(nodes, links, owner, solids.bodies, box, s, (at, solid.radius), sub_step, log)
        return
    first, number = solid.corners[0], solid.corners[1]
    for k in range(number):
        corner = first + (number - 1 - k if reverse else k)
        at = plus(p, turned(R, row(solids.corners, corner)))
        if _is_within_bounds(owner, at):
            _meet_corner(nodes, links, owner, solids.bodies, box, s, (at, 0.0), sub_step, log)


@inlined
def _is_within_bounds(owner: Record, at: Vector) -> bool:
    for k in range(3):
        if at[k] < owner.low[k] or at[k] > owner.high[k]:
            return False
    return True


@compiled
def _meet_corner(
    nodes: Records,
    links: Records,
    owner: Record,
    solids: Records,
    box: Box,
    s: int,
    ball: tuple[Vector, float],
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Move a box out of a ball of a solid, given by middle and radius, which may be 0."""
    solid = solids[s]
    place, outward, gap = nearest_on_box(box, ball[0])
    depth = ball[1] + owner.edge_radius - gap
    if depth <= 0.0:
        return
    normal = times(-1.0, outward)
    at = plus(ball[0], times(ball[1], normal))
    arm = minus(at, triple(solid.p))
    weights, first = corner_weights(place), owner.nodes[0]
    moved = times(-sub_step.h, velocity_at(solid, arm))
    for k in range(8):
        corner = nodes[first + k]
        moved = plus(moved, times(weights[k], minus(triple(corner.p), triple(corner.previous))))
    approach = -dot(moved, normal)
    if owner.asleep:
        _wake_by_solid(nodes, owner, solid, depth, approach / sub_step.h)
    owner.penetration = max(owner.penetration, depth)
    nearest = nodes[first + nearest_corner(weights)]
    own, against = corner_mobility(nodes, first, weights), mobility_at(solid, arm, normal)
    if _max_speed(solid) < FIXED_WAKE_SPEED:
        damp_corners(nodes, owner, weights, approach / sub_step.h)
    kept = support_factor(nearest, nearest, normal[1], own, against)
    if kept * own + against == 0.0:
        return
    pair, mobilities = (owner.links[0], s), (own, kept, against)
    contact = Contact(at, depth, approach, moved, normal, arm)
    link = links[pair[0]]
    moves = _respond(link, owner, solids, pair, contact, mobilities, sub_step, log)
    move_corners(nodes, first, weights, kept, moves)


@inlined
def _respond(
    link: Record,
    owner: Record,
    solids: Records,
    pair: tuple[int, int],
    contact: Contact,
    mobilities: tuple[float, float, float],
    sub_step: SubStep,
    log: TouchLog,
) -> tuple[Vector, Vector, Vector]:
    """Sense a contact, push the solid, and return the moves of the character for `move_node`.

    Args:
        link: of the character.
        owner: the character.
        solids: of other rooms.
        pair: numbers of the link and the solid.
        contact: of the two.
        mobilities: of the character's place [1/kg], the fraction of it that it keeps where the
            ground bears it, and that of the solid [1/kg].
        sub_step: the sub-step.
        log: of touches.
    """
    solid, h = solids[pair[1]], sub_step.h
    own, weight = mobilities[1] * mobilities[0], mobilities[1] * mobilities[0] + mobilities[2]
    is_supported = mobilities[1] != 1.0 or own == 0.0
    _touch_solid(link, solids, pair, contact, weight, sub_step, log)
    normal, approach = contact.normal, contact.approach
    stopped = min(contact.depth, max(approach, 0.0))
    parted = min(contact.depth - stopped, sub_step.slack)
    friction = 0.5 * (owner.friction + solid.friction)
    limit = friction * stopped
    is_creeping = dot(contact.moved, contact.moved) < (CREEP_SPEED * h) ** 2
    if solid.fall_acceleration > 0.0 and is_creeping:
        # It weighs on all its corners in every round, not on the first in the first alone.
        limit += friction * solid.fall_acceleration * h * h
    move = plus(times(stopped, normal), friction_move(contact.moved, normal, limit))
    move, part, back = times(1.0 / weight, move), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if own > 0.0:
        # A free character parts alone, which changes no velocity.
        part = times(parted / (weight if is_supported else own), normal)
    bounciness = max(owner.bounciness, solid.bounciness)
    if bounciness > 0.0 and approach > MIN_BOUNCE_SPEED * h:
        back = times((bounciness * approach + approach - stopped) / weight, normal)
    apply_impulse(solid, contact.arm, times(-1.0 / h, plus(move, back)), h)
    if is_supported:
        _drive_out(solid, contact, weight, sub_step)
    return move, part, back


@inlined
def _drive_out(solid: Record, contact: Contact, weight: float, sub_step: SubStep) -> None:
    """Drive a solid out of a character that cannot part from it, held or lying on the ground."""
    excess = contact.depth - max(contact.approach, 0.0) - ALLOWED_OVERLAP
    drive = min(DRIVE_FRACTION * excess, sub_step.slack)
    parting = max(-contact.approach, 0.0)
    if drive > parting:
        impulse = times((parting - drive) / (weight * sub_step.h), contact.normal)
        apply_impulse(solid, contact.arm, impulse, sub_step.h)


@inlined
def _wake_by_solid(
    nodes: Records, owner: Record, solid: Record, depth: float, speed: float
) -> None:
    """Wake a character that is struck, or that a fixed solid keeps moving into."""
    if speed > WAKE_SPEED or (depth > WAKE_OVERLAP and solid.inverse_mass == 0.0):
        wake(nodes, owner)


@inlined
def _touch_solid(
    link: Record,
    solids: Records,
    pair: tuple[int, int],
    contact: Contact,
    weight: float,
    sub_step: SubStep,
    log: TouchLog,
) -> None:
    """Let a link sense a solid, with the mobility of both [1/kg], and log the onset."""
    speed, number = max(contact.approach, 0.0) / sub_step.h, SOLID - pair[1]
    energy = 0.5 * speed * speed / weight
    if is_new_touch(link, SOLID - solids[pair[1]].thing) and speed > MIN_TOUCH_SPEED:
        where = contact.place, contact.normal
        log_touch(log, sub_step.moment, (pair[0], number), where, speed, energy)
    sense_touch(link, number, NOBODY, energy)
