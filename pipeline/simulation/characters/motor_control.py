"""Motor control: what people do with their nodes.

Targets are set once a step, and drive the nodes in its sub-steps, in which they go straight from
where they were to where they will be. On a deck, which moves from sub-step to sub-step, they are
set in each.

Feet that stand are locked on the ground, swinging feet are given the velocity along their line.
All other nodes are drawn to their targets by critically damped springs, slackened by blows;
gravity is taken off acting people, for a spring alone would let them sag.

Source: Horswill 2008, "Low-level character control", "Limb control" and "Node control" (by
velocity, by acceleration, and locked in place). Loops there are proportional, and the damping of
nodes keeps them from swinging; here they damp themselves, so that they hold at any rate of
sub-steps. Heads there turn at once. Guitton and Volle 1987 for how fast heads turn.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.biped_gait import advance_feet
from pipeline.simulation.characters.body_arrays import FREE, LOCKED, SOLID, CharacterArrays
from pipeline.simulation.characters.collision_avoidance import slide_feet, stop_before_solids
from pipeline.simulation.characters.crowd_avoidance import avoid_people
from pipeline.simulation.characters.dance_posture import hold_dance
from pipeline.simulation.characters.deck_motion import follow_deck, rides_deck
from pipeline.simulation.characters.gait_timing import (
    froude,
    leg_length,
    smoothstep,
    spring_step,
    wrap_angle,
)
from pipeline.simulation.characters.held_bar import follow_bars
from pipeline.simulation.characters.hurdles import notice_hurdles
from pipeline.simulation.characters.limb_posture import advance_stoop, hold_arms, hold_legs
from pipeline.simulation.characters.pelvis_motion import (
    BACKWARD_FROUDE,
    advance_sitting,
    faces_away,
    goal_velocity,
    halt,
    lead_pelvis,
)
from pipeline.simulation.characters.person_record import (
    ELBOW,
    FOOT,
    HAND,
    HEAD,
    NODE_COUNT,
    PELVIS,
    SITTING,
    STANCE,
    SWINGING,
)
from pipeline.simulation.characters.recovery import is_down, recover
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.trip import catch_feet
from pipeline.simulation.characters.trunk_posture import hold_trunk, stretch_chest, sway_in_place
from pipeline.simulation.dynamics.compiled import Record, Records, compiled, inlined
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import Grid
from pipeline.simulation.dynamics.vectors import (
    hypotenuse,
    minus,
    plus,
    row,
    set_triple,
    times,
    triple,
)

# Blows slacken muscles.
STUN_ENERGY = 0.5  # of a blow that leaves muscles quite slack, per kilogram of the body [J/kg]
STUN_THRESHOLD = 0.25  # fraction of it without effect
STUN_RECOVERY_RATE = 2.2  # [1/s]
IGNORED_KNOCK, FELLING_KNOCK = 0.5, 1.5  # speed of the pelvis against its led velocity [m/s]


@compiled
def update_stun(
    person: Record, nodes: Records, links: Records, owners: Records, h: float, dt: float
) -> None:
    """Stun muscles by blows and by knocks off balance, and let them recover for `dt` [s]."""
    person.stun *= max(1.0 - STUN_RECOVERY_RATE * dt, 0.0)
    pelvis = nodes[person.node + PELVIS]
    x = (pelvis.p[0] - pelvis.previous[0]) / h - person.velocity[0] - person.carry_velocity[0]
    z = (pelvis.p[2] - pelvis.previous[2]) / h - person.velocity[1] - person.carry_velocity[1]
    if person.sit_blend == 0.0 and not person.frozen:
        knock = (hypotenuse(x, z) - IGNORED_KNOCK) / (FELLING_KNOCK - IGNORED_KNOCK)
        person.stun = max(person.stun, min(knock, 1.0))
    owner = owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = links[link].touched_owner
        if (other >= 0 and other != person.owner) or links[link].touched <= SOLID:
            energy = max(links[link].energy, links[link].blow)
            blow = energy / (STUN_ENERGY * owner.mass)
            if blow > STUN_THRESHOLD:
                person.stun = max(person.stun, min(blow, 1.0))


# Gaze.
GAZE_RATE = 8.0  # [rad/s]
MAX_GAZE_YAW = math.radians(72.0)  # against the shoulders
MAX_WALKING_GAZE_YAW = math.radians(65.0)  # against the direction of walking
AVERTED_GAZE = math.radians(115.0)  # of one that is about to be pushed, from who pushes it
STRAIGHT_BACKWARD = math.radians(140.0)  # direction of walking from which either shoulder serves
WALKING_GAZE_FROUDE = 0.12  # speed from which that holds, in √(g l)
FEELING_GAZE_FROUDE = 0.05  # beyond that of one that feels its way back, likewise
MAX_HEAD_SPEED = math.radians(290.0)  # against the pelvis [rad/s]
CARRY_SPAN = math.radians(20.0)  # turn of the head that is left, from which the trunk carries it
MAX_GAZE_UP, MAX_GAZE_DOWN = math.radians(45.0), math.radians(50.0)


@compiled
def _way_yaw(person: Record) -> float:
    """Return where a person without a gaze target looks: where it goes or turns [rad].

    The head leads: it looks along the new way before the trunk has turned to it.
    """
    x, z = person.goal[0] - person.at[0], person.goal[1] - person.at[1]
    if person.has_facing:
        return person.facing
    if person.has_goal and hypotenuse(x, z) > person.stop_distance + 0.5 * leg_length(person):
        return math.atan2(-z, x)
    return person.heading + 0.25 * person.yaw_rate


@compiled
def _within_view_of_way(person: Record, aside: float) -> float:
    """Return a gaze yaw against the pelvis such that a person sees its way.

    The head turns to the way before the person sets out, and keeps to the present way until it has
    slowed down. A person walking backward looks over a shoulder, unless it only feels its way back
    before what it keeps facing. One that sees a push coming turns its face away from it. One that
    a deck carries sees where that goes.
    """
    goal = goal_velocity(person)
    velocity = (
        person.velocity[0] + person.carry_velocity[0],
        person.velocity[1] + person.carry_velocity[1],
    )
    if person.braces:
        source = math.atan2(person.push_way[1], -person.push_way[0])
        turned = wrap_angle(person.heading - source)
        return math.copysign(AVERTED_GAZE, turned) - turned
    if faces_away(person, goal) and not person.startled:
        return _within_view(person, aside, velocity, BACKWARD_FROUDE, FEELING_GAZE_FROUDE)
    aside = _within_view(person, aside, goal, 0.0, WALKING_GAZE_FROUDE)
    return _within_view(person, aside, velocity, 0.0, WALKING_GAZE_FROUDE)


@compiled
def _within_view(
    person: Record, aside: float, velocity: tuple[float, float], slowest: float, span: float
) -> float:
    """Return a gaze yaw against the pelvis that is nearer to the direction of a velocity.

    Only speeds above the slowest one matter, and fully from `span` above it, in √(g l).
    """
    way = wrap_angle(math.atan2(-velocity[1], velocity[0]) - person.heading)
    speed = froude(hypotenuse(velocity[0], velocity[1]), leg_length(person))
    walking = smoothstep(max(speed - slowest, 0.0) / span)
    gaze = wrap_angle(person.gaze[0] - person.heading)
    if person.startled and person.has_facing:
        # Over the shoulder that turns to the way.
        gaze = wrap_angle(person.facing - person.heading)
    if abs(way) > STRAIGHT_BACKWARD and way * gaze < 0.0:
        # Over the shoulder over which the person looks already.
        way -= math.copysign(2.0 * math.pi, way)
    nearest = min(max(aside, way - MAX_WALKING_GAZE_YAW), way + MAX_WALKING_GAZE_YAW)
    return aside + walking * (nearest - aside)


@compiled
def _see_push(person: Record, dt: float) -> None:
    """Let a person brace itself, hands free, for a push that it sees coming."""
    person.push_warning = max(person.push_warning - dt, 0.0)
    x, z = person.push_way[0], person.push_way[1]
    is_seen = math.cos(person.gaze[0]) * x - math.sin(person.gaze[0]) * z < 0.0
    is_coming = person.push_warning > 0.0 and (person.braces or is_seen)
    is_free = person.arm_mode[0] == SWINGING and person.arm_mode[1] == SWINGING
    can_turn = not person.frozen and person.posture != SITTING and not is_down(person)
    if person.has_braced and can_turn and not is_coming:
        # A person that has turned away faces the pusher again.
        person.has_braced = False
        if not person.has_goal and not person.has_facing:
            person.has_facing, person.facing = True, math.atan2(z, -x)
    person.braces = is_coming and is_free and can_turn
    person.has_braced |= person.braces
    person.seen_push_left = person.push_left if is_coming else math.inf


@compiled
def turn_head(person: Record, dt: float) -> None:
    """Turn the head for `dt` [s]."""
    yaw, pitch = _way_yaw(person), 0.0
    if person.has_look_target:
        x = person.look_at[0] - person.targets[HEAD, 0]
        y = person.look_at[1] - person.targets[HEAD, 1]
        z = person.look_at[2] - person.targets[HEAD, 2]
        if hypotenuse(x, z) > 1e-6:
            yaw = math.atan2(-z, x)
        pitch = math.atan2(y, hypotenuse(x, z))
    chest = person.heading + person.twist
    aside = wrap_angle(yaw - person.heading)
    # Beyond what neck and shoulders turn together: straight over the shoulder.
    aside = min(max(aside, -2.2), 2.2)
    limit = MAX_GAZE_YAW + abs(person.twist)
    aside = _within_view_of_way(person, min(max(aside, -limit), limit))
    pitch = min(max(pitch, -MAX_GAZE_DOWN), MAX_GAZE_UP)
    yaw_now, rate = wrap_angle(person.gaze[0] - person.heading), person.gaze_rate[0]
    # A trunk that turns to where the head turns carries it along.
    carried = (aside - yaw_now) * math.copysign(1.0, person.yaw_rate) / CARRY_SPAN
    yaw_now += min(max(carried, 0.0), 1.0) * person.yaw_rate * dt
    # A critically damped spring with a constant offset d settles at a speed of omega d / 2.
    farthest = 2.0 * MAX_HEAD_SPEED / GAZE_RATE
    aside = yaw_now + min(max(aside - yaw_now, -farthest), farthest)
    yaw_now, person.gaze_rate[0] = spring_step(yaw_now, rate, aside, GAZE_RATE, dt)
    chest_yaw = wrap_angle(chest - person.heading)
    person.gaze[0] = person.heading + min(
        max(yaw_now, chest_yaw - MAX_GAZE_YAW), chest_yaw + MAX_GAZE_YAW
    )
    person.gaze[1], person.gaze_rate[1] = spring_step(
        person.gaze[1], person.gaze_rate[1], pitch, GAZE_RATE, dt
    )


# Muscles.
TRUNK_RATE, LIMB_RATE = 30.0, 24.0  # of the springs [rad/s]
STUNNED_STRENGTH = 0.12  # fraction of these rates that a full stun leaves
MAX_PULL_DISTANCE = 0.08  # beyond which a muscle pulls no stronger [m]
CATCH_UP_SPEED = 1.5  # of a foot that was stopped on its way [m/s]
MAX_FOOT_SPEED = 15.0  # above which a target jumps and is no motion; runners reach 10 [m/s]
MAX_LOCK_OFFSET = 0.04  # from its target of a foot that locks on the ground [m]


@compiled
def muscle_rate(k: int) -> float:
    """Return the spring rate of a node of a person [rad/s]."""
    is_limb = k == ELBOW or k == ELBOW + 1 or k == HAND or k == HAND + 1 or k == HEAD
    return LIMB_RATE if is_limb else TRUNK_RATE


@inlined
def _limited(offset: float) -> float:
    """Return an offset [m], no farther than muscles pull stronger."""
    return min(max(offset, -MAX_PULL_DISTANCE), MAX_PULL_DISTANCE)


@compiled
def drive_nodes(person: Record, nodes: Records, part: float, span: float, h: float) -> None:
    """Act on all nodes of a person for a sub-step.

    Args:
        person: `PERSON` record.
        nodes: of all characters; changed.
        part: of the way of the targets that is gone at the end of the sub-step.
        span: time in which they go that way [s].
        h: the sub-step [s].
    """
    slackness = 1.0 - (1.0 - STUNNED_STRENGTH) * person.stun
    targets, before = person.targets, person.previous_targets
    for k in range(FOOT):
        node, omega = nodes[person.node + k], muscle_rate(k) * slackness
        p, previous, start = triple(node.p), triple(node.previous), row(before, k)
        way, pull = minus(row(targets, k), start), triple(node.acceleration)
        # All read before any is written, so that they are calculated together.
        v = (p[0] - previous[0]) / h, (p[1] - previous[1]) / h, (p[2] - previous[2]) / h
        wanted = way[0] / span, way[1] / span, way[2] / span
        offset = minus(plus(start, times(part, way)), p)
        offset = _limited(offset[0]), _limited(offset[1]), _limited(offset[2])
        gain = plus(times(omega, offset), times(2.0, minus(wanted, v)))
        pull = plus(pull, times(omega, gain))
        set_triple(node.acceleration, (pull[0], pull[1] + GRAVITY, pull[2]))
    for k in range(2):
        _drive_foot(person, nodes, k, part, span, h)


@compiled
def keep_targets(person: Record) -> None:
    """Let targets be where they were before, from then on."""
    for k in range(NODE_COUNT):
        for c in range(3):
            person.previous_targets[k, c] = person.targets[k, c]


@compiled
def _is_placed(person: Record, node: Record, k: int) -> bool:
    squared = 0.0
    for c in range(3):
        squared += (node.p[c] - person.ankles[k, c]) ** 2
    return squared < MAX_LOCK_OFFSET * MAX_LOCK_OFFSET


@compiled
def _drive_foot(person: Record, nodes: Records, k: int, part: float, span: float, h: float) -> None:
    """Lock a stance foot, and send a swinging foot along its line."""
    node, target = nodes[person.node + FOOT + k], person.targets[FOOT + k]
    before = person.previous_targets[FOOT + k]
    if person.foot_state[k] == STANCE and (node.lock == LOCKED or _is_placed(person, node, k)):
        if node.lock != LOCKED:
            # One that was held up on its way comes to its place without a jerk.
            node.lock = LOCKED
            for c in range(3):
                person.settling[k, c] += node.p[c] - person.ankles[k, c]
                person.ankles[k, c] = target[c] = before[c] = node.p[c]
        for c in range(3):
            node.lock_place[c] = before[c] + part * (target[c] - before[c])
        return
    node.lock = FREE
    squared = 0.0
    for c in range(3):
        squared += (target[c] - before[c]) ** 2
    moves = h / span if squared < (MAX_FOOT_SPEED * span) ** 2 else 0.0
    for c in range(3):
        step = moves * (target[c] - before[c])
        catch_up = before[c] + part * (target[c] - before[c]) - step - node.p[c]
        catch_up = min(max(catch_up, -CATCH_UP_SPEED * h), CATCH_UP_SPEED * h)
        node.previous[c] = node.p[c] - step - catch_up
    node.acceleration[1] += GRAVITY


@compiled
def control_people(
    arrays: CharacterArrays, persons: Records, ground: Grid, solids: Solids, h: float, dt: float
) -> None:
    """Set the targets of all people for a step of `dt` [s], whose sub-steps last `h` [s]."""
    if len(persons) == 0:
        return
    avoid_people(persons, arrays.owners, solids)
    notice_hurdles(arrays, persons, solids, dt)
    for i in range(len(persons)):
        person = persons[i]
        person.follows_closely = rides_deck(person)
        span = h if person.follows_closely else dt
        _set_targets(person, arrays, ground, solids, h, span)


@compiled
def drive_people(
    arrays: CharacterArrays,
    persons: Records,
    ground: Grid,
    solids: Solids,
    h: float,
    n: int,
    count: int,
) -> None:
    """Let all people act for the n-th of so many sub-steps `h` [s] of a step."""
    for i in range(len(persons)):
        person = persons[i]
        if person.follows_closely:
            if n > 0:
                _set_targets(person, arrays, ground, solids, h, h)
            drive_nodes(person, arrays.nodes, 1.0, h, h)
            keep_targets(person)
        else:
            drive_nodes(person, arrays.nodes, (n + 1) / count, count * h, h)
            if n == count - 1:
                keep_targets(person)


@compiled
def _set_targets(
    person: Record, arrays: CharacterArrays, ground: Grid, solids: Solids, h: float, dt: float
) -> None:
    """Set the targets of a person's nodes after `dt` [s]; sub-steps last `h` [s]."""
    nodes, links, _, _, _, grips, owners = arrays
    follow_deck(person, nodes, owners, solids, dt)
    update_stun(person, nodes, links, owners, h, dt)
    recover(person, nodes, dt)
    _see_push(person, dt)
    if person.frozen:
        halt(person)
        sway_in_place(person, dt)
    else:
        lead_pelvis(person, nodes, ground, h, dt)
        stop_before_solids(person, owners[person.owner].mass, solids, dt)
        slide_feet(person, nodes, dt)
        advance_feet(person, ground.frame, ground.vertices, dt)
        catch_feet(person, arrays, solids, h)
        advance_sitting(person, dt)
        turn_head(person, dt)
        advance_stoop(person, dt)
        follow_bars(person, nodes, grips)
        hold_trunk(person, nodes, dt)
        hold_legs(person, dt)
        hold_arms(person, dt)
        hold_dance(person, owners, dt)
    person.report_time += dt
    stretch_chest(person, links, owners)
