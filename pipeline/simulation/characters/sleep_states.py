"""Sleep states: characters that lie still are left where they are, and wake when something comes.

Relaxation leaves a tremor of some millimetres that should not be seen, and costs time. A
character that touches something and has been in one place for a while sleeps: it is infinitely
heavy to gentle touches, and wakes as soon as something strikes it, moves beside it, or holds it.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import FREE, RESTING, IntArray
from pipeline.simulation.characters.limb_limits import joint_excess
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined

WATCH_INTERVAL = 0.25  # at which movement is measured [s]
STILL_DISTANCE = 0.006  # moved in an interval by what rests [m]
STILL_DISTANCE_GAIN = 0.002  # more for each interval without much movement [m]
MAX_STILL_DISTANCE = 0.05  # much movement [m]
RECENT_TOUCH = 0.1  # age of a touch that supports [s]
WAKE_SPEED = 0.3  # of an approach that wakes [m/s]
TIRED_COUNT = 8  # still intervals after which a tremor wakes nobody, or piles would never rest
DEEP_OVERLAP = 0.004  # overlap that is given time to resolve [m]
WEDGED_COUNT = 40  # still intervals after which it is not
JOINT_EXCESS = 1e-6  # of a joint beyond its limit that is given the same time, in upper lengths
UNTANGLE_TIME = 2.0  # for which overlapping links of one character are parted: where its joints
# hold them together they would be thrown back for ever [s]


@compiled
def update_sleep(
    nodes: Records,
    links: Records,
    limbs: Records,
    owners: Records,
    grips: IntArray,
    h: float,
    dt: float,
) -> None:
    """Let still characters sleep, and wake those that are held; once a step."""
    for c in range(len(owners)):
        owner = owners[c]
        if not owner.asleep:
            owner.speed = _fastest_move(nodes, owner) / h
            # Acting people bring their arms out of themselves.
            change = dt if owner.self_penetrating and not owner.acts else -dt
            owner.tangled_time = min(max(owner.tangled_time + change, 0.0), UNTANGLE_TIME)
            owner.self_penetrating = False
            owner.watch_time += dt
            if owner.watch_time >= WATCH_INTERVAL and not owner.acts:
                _watch_movement(nodes, links, limbs, owner)
    for n in range(len(grips)):
        if grips[n, 0] >= 0 and grips[n, 1] >= 0:
            for k in range(2):
                wake(nodes, owners[nodes[grips[n, k]].owner])


@inlined
def wake_struck(nodes: Records, one: Record, other: Record) -> None:
    """Wake characters that strike one another, unless the other one has only trembled for long.

    A character pushed by an acting one does not fall asleep meanwhile.
    """
    if (one.asleep or other.acts) and other.still_count < TIRED_COUNT:
        wake(nodes, one)
    if (other.asleep or one.acts) and one.still_count < TIRED_COUNT:
        wake(nodes, other)


@inlined
def wake_touching(nodes: Records, one: Record, other: Record, depth: float, speed: float) -> None:
    """Wake two touching characters by their approach speed [m/s], or by a deep overlap [m].

    One that has long lain deep in a sleeping one wakes it, for both to make room; one that fell
    asleep in spite of it does not wake the other again.
    """
    if speed > WAKE_SPEED:
        wake_struck(nodes, one, other)
    if depth <= DEEP_OVERLAP:
        return
    if (
        one.asleep
        and one.still_count < WEDGED_COUNT
        and not other.asleep
        and other.still_count >= TIRED_COUNT
    ):
        wake(nodes, one)
    elif (
        other.asleep
        and other.still_count < WEDGED_COUNT
        and not one.asleep
        and one.still_count >= TIRED_COUNT
    ):
        wake(nodes, other)


@inlined
def wake_near(nodes: Records, owners: Records, near: IntArray) -> None:
    """Wake characters beside which another one moves."""
    for n in range(len(near)):
        one, other = owners[near[n, 0]], owners[near[n, 1]]
        if one.asleep and not other.asleep and other.speed > WAKE_SPEED:
            wake_struck(nodes, one, other)
        elif other.asleep and not one.asleep and one.speed > WAKE_SPEED:
            wake_struck(nodes, one, other)


@compiled
def wake(nodes: Records, owner: Record) -> None:
    """Wake a character."""
    owner.watch_time, owner.still_count = 0.0, 0
    if not owner.asleep:
        return
    owner.asleep = False
    for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        node = nodes[i]
        if node.lock == RESTING:
            node.lock, node.mobility = FREE, node.inverse_mass
        for k in range(3):
            node.anchor[k] = node.p[k]


@inlined
def _fastest_move(nodes: Records, owner: Record) -> float:
    """Return the distance moved by the fastest node in the last sub-step [m]."""
    fastest = 0.0
    for i in range(owner.nodes[0], owner.nodes[0] + owner.nodes[1]):
        node, squared = nodes[i], 0.0
        for k in range(3):
            squared += (node.p[k] - node.previous[k]) ** 2
        fastest = max(fastest, squared)
    return math.sqrt(fastest)


@inlined
def _keeps_limits(nodes: Records, limbs: Records, owner: Record) -> bool:
    """Tell whether all joints of a character point where they may."""
    for n in range(owner.limbs[0], owner.limbs[0] + owner.limbs[1]):
        if joint_excess(nodes, limbs[n]) > JOINT_EXCESS:
            return False
    return True


@inlined
def _watch_movement(nodes: Records, links: Records, limbs: Records, owner: Record) -> None:
    owner.watch_time = 0.0
    first, end = owner.nodes[0], owner.nodes[0] + owner.nodes[1]
    farthest, is_supported = 0.0, False
    for i in range(first, end):
        node, squared = nodes[i], 0.0
        is_supported = is_supported or node.inverse_mass == 0.0
        for k in range(3):
            squared += (node.p[k] - node.anchor[k]) ** 2
            node.anchor[k] = node.p[k]
        farthest = max(farthest, squared)
    for n in range(owner.links[0], owner.links[0] + owner.links[1]):
        is_supported = is_supported or min(links[n].age[0], links[n].age[1]) < RECENT_TOUCH
    moved = math.sqrt(farthest)
    owner.still_count = owner.still_count + 1 if moved < MAX_STILL_DISTANCE else 0
    if not is_supported or moved > min(
        STILL_DISTANCE + STILL_DISTANCE_GAIN * owner.still_count, MAX_STILL_DISTANCE
    ):
        return
    is_settled = owner.penetration <= DEEP_OVERLAP and _keeps_limits(nodes, limbs, owner)
    if not is_settled and owner.still_count < WEDGED_COUNT:
        return
    owner.asleep, owner.speed = True, 0.0
    for i in range(first, end):
        if nodes[i].lock == FREE:
            nodes[i].lock = RESTING
