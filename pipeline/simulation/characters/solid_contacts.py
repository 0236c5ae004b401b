"""Solid contacts."""

from __future__ import annotations

from typing import NamedTuple

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID
from pipeline.simulation.characters.box_contacts import (
    Box,
    box_of,
    heaviest,
    nearest_of_box,
    weights_of,
)
from pipeline.simulation.characters.broad_phase import MARGIN
from pipeline.simulation.characters.contact_response import (
    ABOVE,
    LEAST_BOUNCE,
    PAUSE,
    TouchLog,
    borne,
    log_touch,
    move_node,
    rub,
    rubbed,
)
from pipeline.simulation.characters.sleep_states import WAKE_SPEED, wake
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import gap_of, gives, go_on, shove, velocity_at
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

APART = 0.08
"""Distance of the balls along a link, about [m]."""

PARTS = 8
"""Of them along a link."""

ALLOWED, DRIVEN = 5e-4, 0.2
"""Depth that is left as it is of what gives way [m], and the part of more of it that it is
driven out by in a sub-step."""

STIRS, TREMBLES = 0.02, 0.12
"""Speed of a solid that wakes whom it is beside [m/s]; and of one that lies on them and trembles
with them."""

DEEP = 2e-3
"""Depth at which one that moves at all wakes whom it is in [m]."""

CREEPS = 0.05
"""Speed below which what lies on somebody does not slide [m/s]."""


class SubStep(NamedTuple):
    """How a sub-step is gone through.

    Attributes:
        h: its length [s].
        slack: how far what was in one another may part [m].
        moment: of the step that has gone.
    """

    h: float
    slack: float
    moment: float


@compiled
def find_solids(nodes: Records, owners: Records, solids: Solids, h: float) -> int:
    """Let solids go on, and find characters whose boxes overlap theirs.

    Returns:
        How many pairs there are.
    """
    bodies, near, found = solids.bodies, solids.near, 0
    for s in range(len(bodies)):
        go_on(bodies[s], h)
    for c in range(len(owners)):
        for s in range(len(bodies)):
            if bodies[s].is_present and _overlap(owners[c], bodies[s]):
                near[found, 0], near[found, 1] = c, s
                found += 1
                if owners[c].asleep and _speed(bodies[s]) > _stirs(bodies[s]):
                    wake(nodes, owners[c])
    return found


@compiled
def meet_solids(
    nodes: Records,
    links: Records,
    owners: Records,
    solids: Solids,
    count: int,
    pace: SubStep,
    back: bool,
    log: TouchLog,
) -> None:
    """Move characters out of the solids that they are near.

    Args:
        nodes: of all characters.
        links: of all characters.
        owners: all characters.
        solids: of other rooms.
        count: of pairs that are near.
        pace: of the sub-step.
        back: whether corners are gone through from the last to the first: always in one order,
            what lies on a box would be pushed a little more at the first of them, and creep.
        log: of what touched.
    """
    for k in range(count):
        c, s = solids.near[k, 0], solids.near[k, 1]
        owner, solid = owners[c], solids.bodies[s]
        if not owner.active and (not owner.asleep or _speed(solid) == 0.0):
            continue
        for n in range(owner.links[0], owner.links[0] + owner.links[1]):
            link = links[n]
            if link.radius == 0.0 or not _may_touch(nodes, link, solid):
                continue
            if link.ends[0] == link.ends[1]:
                _meet(nodes, links, owner, solids, (n, s), 0.0, pace, log)
                continue
            parts = min(int(link.length_limits[0] / APART) + 1, PARTS)
            for i in range(parts + 1):
                _meet(nodes, links, owner, solids, (n, s), i / parts, pace, log)
        if owner.edge_radius > 0.0:
            _meet_box(nodes, links, owner, solids, s, pace, back, log)


@inlined
def _speed(solid: Record) -> float:
    """Return how fast the fastest place of a solid may be [m/s]."""
    speed: float = length(triple(solid.v)) + length(triple(solid.w)) * solid.reach
    return speed


@inlined
def _stirs(solid: Record) -> float:
    """Return how fast a solid is that wakes whom it is beside [m/s]."""
    return STIRS if solid.inverse_mass == 0.0 else TREMBLES


@inlined
def _overlap(owner: Record, solid: Record) -> bool:
    for k in range(3):
        if owner.low[k] > solid.high[k] + MARGIN or solid.low[k] > owner.high[k] + MARGIN:
            return False
    return True


@inlined
def _may_touch(nodes: Records, link: Record, solid: Record) -> bool:
    one, other = nodes[link.ends[0]], nodes[link.ends[1]]
    p, q, radius = one.p, other.p, max(link.radius, max(one.radius, other.radius))
    for k in range(3):
        if min(p[k], q[k]) - radius > solid.high[k] or max(p[k], q[k]) + radius < solid.low[k]:
            return False
    return True


@compiled
def _meet(
    nodes: Records,
    links: Records,
    owner: Record,
    solids: Solids,
    pair: tuple[int, int],
    t: float,
    pace: SubStep,
    log: TouchLog,
) -> None:
    """Move a ball, at a place from 0 to 1 on a link, out of a solid."""
    link, solid = links[pair[0]], solids.bodies[pair[1]]
    i, j = nodes[link.ends[0]], nodes[link.ends[1]]
    at = plus(times(1.0 - t, triple(i.p)), times(t, triple(j.p)))
    # At its ends a link is as thick as the nodes are, as on the ground.
    radius: float = i.radius if t == 0.0 else j.radius if t == 1.0 else link.radius
    gap, normal = gap_of(solids, pair[1], at, radius)
    depth = radius - gap
    if depth <= 0.0:
        return
    place = minus(at, times(gap, normal))
    arm = minus(place, triple(solid.p))
    went = plus(
        times(1.0 - t, minus(triple(i.p), triple(i.previous))),
        times(t, minus(triple(j.p), triple(j.previous))),
    )
    went = minus(went, times(pace.h, velocity_at(solid, arm)))
    nearer = -dot(went, normal)
    if owner.asleep:
        _stir(nodes, owner, solid, depth, nearer / pace.h)
    owner.penetration = max(owner.penetration, depth)
    if _speed(solid) < STIRS:
        rub(i, owner, nearer / pace.h)
        rub(j, owner, nearer / pace.h)
    near, far = (i, i) if t == 0.0 else (i, j)
    own, against = i.mobility, gives(solid, arm, normal)
    if t > 0.0:
        own = (1.0 - t) ** 2 * own + t * t * j.mobility
    light = borne(near, far, normal[1], own, against)
    own *= light
    weight = own + against
    if weight == 0.0:
        return
    hard = max(nearer, 0.0) / pace.h, weight
    _feel(link, solids.bodies, pair, (place, normal), hard, pace.moment, log)
    firm = own if light == 1.0 else 0.0
    moved = _apart(owner, solid, (depth, nearer), went, normal, (own, firm, weight), pace)
    move, part, back = moved
    move_node(i, light * i.mobility * (1.0 - t if t > 0.0 else 1.0), move, part, back)
    if t > 0.0:
        move_node(j, light * j.mobility * t, move, part, back)
    shove(solid, arm, times(-1.0 / pace.h, plus(move, back)), pace.h)
    if firm == 0.0:
        _drive(solid, arm, normal, (depth, nearer), weight, pace)


@compiled
def _meet_box(
    nodes: Records,
    links: Records,
    owner: Record,
    solids: Solids,
    s: int,
    pace: SubStep,
    back: bool,
    log: TouchLog,
) -> None:
    """Move a box out of the corners of a solid, or out of a ball."""
    solid, box = solids.bodies[s], box_of(nodes, owner)
    R, p = rows_of(solid.R), triple(solid.p)
    if solid.radius > 0.0:
        at = plus(p, turned(R, triple(solid.middle)))
        _meet_corner(nodes, links, owner, solids.bodies, box, s, (at, solid.radius), pace, log)
        return
    first, number = solid.corners[0], solid.corners[1]
    for k in range(number):
        corner = first + (number - 1 - k if back else k)
        at = plus(p, turned(R, row(solids.corners, corner)))
        if _is_in(owner, at):
            _meet_corner(nodes, links, owner, solids.bodies, box, s, (at, 0.0), pace, log)


@inlined
def _is_in(owner: Record, at: Vector) -> bool:
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
    pace: SubStep,
    log: TouchLog,
) -> None:
    """Move a box out of a ball of a solid, whose radius may be 0."""
    solid = solids[s]
    place, outward, gap = nearest_of_box(box, ball[0])
    depth = ball[1] + owner.edge_radius - gap
    if depth <= 0.0:
        return
    # From here on as above: the normal points to whom is moved.
    normal = times(-1.0, outward)
    at = plus(ball[0], times(ball[1], normal))
    arm = minus(at, triple(solid.p))
    weights, first = weights_of(place), owner.nodes[0]
    went = times(-pace.h, velocity_at(solid, arm))
    for k in range(8):
        corner = nodes[first + k]
        went = plus(went, times(weights[k], minus(triple(corner.p), triple(corner.previous))))
    nearer = -dot(went, normal)
    if owner.asleep:
        _stir(nodes, owner, solid, depth, nearer / pace.h)
    owner.penetration = max(owner.penetration, depth)
    most = nodes[first + heaviest(weights)]
    own, against = 0.0, gives(solid, arm, normal)
    for k in range(8):
        own += weights[k] ** 2 * nodes[first + k].mobility
        if weights[k] > 0.1 and _speed(solid) < STIRS:
            rub(nodes[first + k], owner, nearer / pace.h)
    light = borne(most, most, normal[1], own, against)
    own *= light
    weight = own + against
    if weight == 0.0:
        return
    n = owner.links[0]
    hard = max(nearer, 0.0) / pace.h, weight
    _feel(links[n], solids, (n, s), (at, normal), hard, pace.moment, log)
    firm = own if light == 1.0 else 0.0
    moved = _apart(owner, solid, (depth, nearer), went, normal, (own, firm, weight), pace)
    move, part, back = moved
    for k in range(8):
        corner = nodes[first + k]
        move_node(corner, light * corner.mobility * weights[k], move, part, back)
    shove(solid, arm, times(-1.0 / pace.h, plus(move, back)), pace.h)
    if firm == 0.0:
        _drive(solid, arm, normal, (depth, nearer), weight, pace)


@inlined
def _apart(
    owner: Record,
    solid: Record,
    into: tuple[float, float],
    went: Vector,
    normal: Vector,
    weights: tuple[float, float, float],
    pace: SubStep,
) -> tuple[Vector, Vector, Vector]:
    """Return by what two are moved apart, in shares of the inverse masses [kg m].

    Args:
        owner: who is moved.
        solid: out of what.
        into: how deep it is, and how much nearer it came in this sub-step [m].
        went: how far it went past the solid in this sub-step [m].
        normal: towards who is moved.
        weights: inverse masses of the place that is moved, of it if it can part, and of both
            [1/kg].
        pace: of the sub-step.

    Returns:
        What changes its velocity, what does not, and what changes the velocity alone.
    """
    own, firm, weight = weights
    stopped = min(into[0], max(into[1], 0.0))
    parted = min(into[0] - stopped, pace.slack)
    friction = 0.5 * (owner.friction + solid.friction)
    most = friction * stopped
    if solid.fall_acceleration > 0.0 and dot(went, went) < (CREEPS * pace.h) ** 2:
        # It weighs on all its corners in every round, not on the first in the first alone.
        most += friction * solid.fall_acceleration * pace.h * pace.h
    move = plus(times(stopped, normal), rubbed(went, normal, most))
    part, back = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if own > 0.0:
        # What can part does so alone, which changes nobody's velocity.
        part = times(parted / (weight if firm == 0.0 else firm), normal)
    bounciness = max(owner.bounciness, solid.bounciness)
    if bounciness > 0.0 and into[1] > LEAST_BOUNCE * pace.h:
        back = times((bounciness * into[1] + into[1] - stopped) / weight, normal)
    return times(1.0 / weight, move), part, back


@inlined
def _drive(
    solid: Record,
    arm: Vector,
    normal: Vector,
    into: tuple[float, float],
    weight: float,
    pace: SubStep,
) -> None:
    """Drive a solid out of what cannot part from it, being held or lying on the ground."""
    deeper = min(DRIVEN * (into[0] - max(into[1], 0.0) - ALLOWED), pace.slack)
    parts = max(-into[1], 0.0)
    if deeper > parts:
        shove(solid, arm, times((parts - deeper) / (weight * pace.h), normal), pace.h)


@inlined
def _stir(nodes: Records, owner: Record, solid: Record, depth: float, speed: float) -> None:
    """Wake somebody who is struck, or into whom something goes on."""
    if speed > WAKE_SPEED or (depth > DEEP and solid.inverse_mass == 0.0):
        wake(nodes, owner)


@inlined
def _is_part(solids: Records, touched: int, s: int) -> bool:
    """Tell whether what a link touches is a part of the same thing as a solid."""
    same: bool = touched <= SOLID and solids[SOLID - touched].thing == solids[s].thing
    return same


@inlined
def _feel(
    link: Record,
    solids: Records,
    pair: tuple[int, int],
    where: tuple[Vector, Vector],
    hard: tuple[float, float],
    moment: float,
    log: TouchLog,
) -> None:
    """Let a link know of a solid that it meets at a speed [m/s], of both inverse masses [1/kg]."""
    speed, weight = hard
    energy, which = 0.5 * speed * speed / weight, SOLID - pair[1]
    if (link.age[0] > PAUSE or not _is_part(solids, link.touched, pair[1])) and speed > ABOVE:
        log_touch(log, moment, (pair[0], which), where[0], where[1], (speed, energy))
    if link.age[0] > 0.0 or energy > link.energy:
        link.touched, link.touched_owner = which, NOBODY
    link.energy = max(link.energy, energy)
    link.age[0] = 0.0
