"""Motor control: what people do with their nodes before each sub-step.

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
from pipeline.simulation.characters.deck_motion import follow_deck
from pipeline.simulation.characters.gait_timing import (
    froude,
    leg_length,
    smoothstep,
    spring_step,
    wrap_angle,
)
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
    STANCE,
)
from pipeline.simulation.characters.recovery import recover
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.trip import catch_feet
from pipeline.simulation.characters.trunk_posture import hold_trunk, stretch_chest, sway_in_place
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import Grid

# Blows slacken muscles.
STUN_ENERGY = 0.5  # of a blow that leaves muscles quite slack, per kilogram of the body [J/kg]
STUN_THRESHOLD = 0.25  # fraction of it without effect
STUN_RECOVERY_RATE = 2.2  # [1/s]
IGNORED_KNOCK, FELLING_KNOCK = 0.5, 1.5  # speed of the pelvis against its led velocity [m/s]


@compiled
def update_stun(person: Record, nodes: Records, links: Records, owners: Records, dt: float) -> None:
    """Stun muscles by blows and by knocks off balance, and let them recover."""
    person.stun *= max(1.0 - STUN_RECOVERY_RATE * dt, 0.0)
    pelvis = nodes[person.node + PELVIS]
    x = (pelvis.p[0] - pelvis.previous[0]) / dt - person.velocity[0] - person.carry_velocity[0]
    z = (pelvis.p[2] - pelvis.previous[2]) / dt - person.velocity[1] - person.carry_velocity[1]
    if person.sit_blend == 0.0 and not person.frozen:
        knock = (math.hypot(x, z) - IGNORED_KNOCK) / (FELLING_KNOCK - IGNORED_KNOCK)
        person.stun = max(person.stun, min(knock, 1.0))
    owner = owners[person.owner]
    first, count = owner.links[0], owner.links[1]
    for link in range(first, first + count):
        other = links[link].touched_owner
        if (other >= 0 and other != person.owner) or links[link].touched <= SOLID:
            blow = links[link].energy / (STUN_ENERGY * owner.mass)
            if blow > STUN_THRESHOLD:
                person.stun = max(person.stun, min(blow, 1.0))


# Gaze.
GAZE_RATE = 8.0  # [rad/s]
MAX_GAZE_YAW = math.radians(72.0)  # against the shoulders
MAX_WALKING_GAZE_YAW = math.radians(65.0)  # against the direction of walking
STRAIGHT_BACKWARD = math.radians(140.0)  # direction of walking from which either shoulder serves
WALKING_GAZE_FROUDE = 0.12  # speed from which that holds, in √(g l)
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
    if person.has_goal and math.hypot(x, z) > person.stop_distance + 0.5 * leg_length(person):
        return math.atan2(-z, x)
    return person.heading + 0.25 * person.yaw_rate


@compiled
def _within_view_of_way(person: Record, aside: float) -> float:
    """Return a gaze yaw against the pelvis such that a person sees its way.

    The head turns to the way before the person sets out, and keeps to the present way until it has
    slowed down. A person walking backward looks over a shoulder, unless it only feels its way back
    before what it keeps facing.
    """
    goal, velocity = goal_velocity(person), (person.velocity[0], person.velocity[1])
    if faces_away(person, goal) and not person.startled:
        return _within_view(person, aside, velocity, BACKWARD_FROUDE)
    aside = _within_view(person, aside, goal, 0.0)
    return _within_view(person, aside, velocity, 0.0)


@compiled
def _within_view(
    person: Record, aside: float, velocity: tuple[float, float], slowest: float
) -> float:
    """Return a gaze yaw against the pelvis that is nearer to the direction of a velocity.

    Only speeds above the slowest one matter, in √(g l).
    """
    way = wrap_angle(math.atan2(-velocity[1], velocity[0]) - person.heading)
    speed = froude(math.hypot(velocity[0], velocity[1]), leg_length(person))
    walking = smoothstep(max(speed - slowest, 0.0) / WALKING_GAZE_FROUDE)
    gaze = wrap_angle(person.gaze[0] - person.heading)
    if abs(way) > STRAIGHT_BACKWARD and way * gaze < 0.0:
        # Over the shoulder over which the person looks already.
        way -= math.copysign(2.0 * math.pi, way)
    nearest = min(max(aside, way - MAX_WALKING_GAZE_YAW), way + MAX_WALKING_GAZE_YAW)
    return aside + walking * (nearest - aside)


@compiled
def turn_head(person: Record, dt: float) -> None:
    """Turn the head by one sub-step."""
    yaw, pitch = _way_yaw(person), 0.0
    if person.has_look_target:
        x = person.look_at[0] - person.targets[HEAD, 0]
        y = person.look_at[1] - person.targets[HEAD, 1]
        z = person.look_at[2] - person.targets[HEAD, 2]
        if math.hypot(x, z) > 1e-6:
            yaw = math.atan2(-z, x)
        pitch = math.atan2(y, math.hypot(x, z))
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


@compiled
def drive_nodes(person: Record, nodes: Records, dt: float) -> None:
    """Act on all nodes of a person for a sub-step."""
    for k in range(NODE_COUNT):
        node = nodes[person.node + k]
        if k >= FOOT:
            _drive_foot(person, nodes, k - FOOT, dt)
        else:
            omega = muscle_rate(k) * (1.0 - (1.0 - STUNNED_STRENGTH) * person.stun)
            for c in range(3):
                v = (node.p[c] - node.previous[c]) / dt
                target_velocity = (person.targets[k, c] - person.previous_targets[k, c]) / dt
                offset = min(
                    max(person.targets[k, c] - node.p[c], -MAX_PULL_DISTANCE), MAX_PULL_DISTANCE
                )
                node.acceleration[c] += omega * (omega * offset + 2.0 * (target_velocity - v))
            node.acceleration[1] += GRAVITY
        for c in range(3):
            person.previous_targets[k, c] = person.targets[k, c]


@compiled
def _is_placed(person: Record, node: Record, k: int) -> bool:
    squared = 0.0
    for c in range(3):
        squared += (node.p[c] - person.ankles[k, c]) ** 2
    return squared < MAX_LOCK_OFFSET * MAX_LOCK_OFFSET


@compiled
def _drive_foot(person: Record, nodes: Records, k: int, dt: float) -> None:
    """Lock a stance foot, and send a swinging foot along its line."""
    node = nodes[person.node + FOOT + k]
    if person.foot_state[k] == STANCE and (node.lock == LOCKED or _is_placed(person, node, k)):
        if node.lock != LOCKED:
            # One that was held up on its way comes to its place without a jerk.
            node.lock = LOCKED
            for c in range(3):
                person.settling[k, c] += node.p[c] - person.ankles[k, c]
                person.ankles[k, c] = node.p[c]
        for c in range(3):
            node.lock_place[c] = person.ankles[k, c]
        return
    node.lock = FREE
    squared = 0.0
    for c in range(3):
        squared += (person.targets[FOOT + k, c] - person.previous_targets[FOOT + k, c]) ** 2
    moves = 1.0 if squared < (MAX_FOOT_SPEED * dt) ** 2 else 0.0
    for c in range(3):
        step = moves * (person.targets[FOOT + k, c] - person.previous_targets[FOOT + k, c])
        catch_up = person.targets[FOOT + k, c] - step - node.p[c]
        catch_up = min(max(catch_up, -CATCH_UP_SPEED * dt), CATCH_UP_SPEED * dt)
        node.previous[c] = node.p[c] - step - catch_up
    node.acceleration[1] += GRAVITY


@compiled
def control_people(
    arrays: CharacterArrays, persons: Records, ground: Grid, solids: Solids, h: float, count: int
) -> None:
    """Let all people act for a sub-step of `h` [s], one of a number in a step."""
    nodes, links, _, _, _, _, owners = arrays
    if len(persons) > 0 and persons[0].report_time == 0.0:
        avoid_people(persons, owners, solids)
        notice_hurdles(arrays, persons, solids, count * h)
    for i in range(len(persons)):
        person = persons[i]
        follow_deck(person, nodes, owners, solids, h)
        update_stun(person, nodes, links, owners, h)
        recover(person, nodes, h)
        if person.frozen:
            halt(person)
            sway_in_place(person, h)
        else:
            lead_pelvis(person, nodes, ground, h)
            stop_before_solids(person, owners[person.owner].mass, solids, h)
            slide_feet(person, nodes, h)
            advance_feet(person, ground.frame, ground.vertices, h)
            catch_feet(person, arrays, solids, h)
            advance_sitting(person, h)
            turn_head(person, h)
            advance_stoop(person, h)
            hold_trunk(person, nodes, h)
            hold_legs(person)
            hold_arms(person, h)
            hold_dance(person, owners, h)
        person.report_time += h
        stretch_chest(person, links, owners)
        drive_nodes(person, nodes, h)
