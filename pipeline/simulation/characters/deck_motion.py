"""Deck motion: moving surfaces that people stand on, and how these carry them.

A deck is the flat top of a merry-go-round, or of a solid of another room such as a cart, a raft or
the board of a seesaw. A person knows one deck at a time, the nearest; `support_at` is the one place
that says what a foot finds below it, terrain or deck. What stands on a deck is carried by its rigid
motion from sub-step to sub-step: feet wholly, the led place and the heading by the share of the
weight that the deck bears. A person's own velocity is that against what carries it, so that one who
steps off keeps the velocity that it had over the ground.
"""

from __future__ import annotations

import math

from pipeline.simulation.characters.body_arrays import NOBODY, SOLID
from pipeline.simulation.characters.gait_timing import leg_length, wrap_angle
from pipeline.simulation.characters.person_record import NODE_COUNT, STANCE
from pipeline.simulation.characters.playthings import SPOKES
from pipeline.simulation.characters.solid_arrays import Solids
from pipeline.simulation.characters.solid_kinematics import apply_impulse
from pipeline.simulation.dynamics.compiled import Record, Records, compiled
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.terrain_grid import surface_at
from pipeline.simulation.dynamics.vectors import (
    Rows,
    Vector,
    hypotenuse,
    inverse_turned,
    minus,
    plus,
    put,
    row,
    rows_of,
    set_triple,
    triple,
    turned,
)
from pipeline.simulation.spatial import Array

HIGHEST_STEP = 0.6  # up to a deck, in leg lengths
STEEPEST_DECK = 0.7  # least cosine of the angle of its normal to the vertical
INSIDE_MARGIN, OUTSIDE_MARGIN = 0.5, 0.45  # of ankles from the edge of a deck, in foot lengths
NARROW_DECK = 0.8  # of the half extent of a deck, beyond which its margin does not go
LEAST_SHARE = 1e-3  # of the weight on a deck that the deck carries along
WEIGHT_RATE = 9.0  # at which weight goes to a foot on the other surface [1/s]


@compiled
def support_at(
    person: Record, frame: Record, vertices: Array, x: float, z: float
) -> tuple[float, Vector, bool]:
    """Return height and normal of what bears a foot at a position, and whether that is a deck.

    Args:
        person: `PERSON` record.
        frame: of the terrain grid.
        vertices: of the terrain grid.
        x: of the position [m].
        z: of the position [m].
    """
    height, normal = surface_at(frame, vertices, x, z)
    if person.deck != NOBODY and person.known_deck == person.deck and not person.beside_deck:
        top, inside, _ = _deck_at(person, x, z)
        is_low = top - person.floor < HIGHEST_STEP * leg_length(person)
        if inside > 0.0 and top > height and is_low:
            axes = person.deck_axes
            return top, (axes[0, 1], axes[1, 1], axes[2, 1]), True
    return height, normal, False


@compiled
def clear_of_edge(person: Record, x: float, z: float) -> tuple[float, float]:
    """Return the place nearest to a foothold at which a foot stands wholly on a deck or beside it.

    A person that walks beside a deck never steps onto it, however near.

    Args:
        person: `PERSON` record.
        x: of the foothold [m].
        z: of the foothold [m].
    """
    if person.deck == NOBODY or person.known_deck != person.deck:
        return x, z
    top, inside, outward = _deck_at(person, x, z)
    if person.beside_deck and inside > -OUTSIDE_MARGIN * person.foot:
        move = OUTSIDE_MARGIN * person.foot + inside
        return x + move * outward[0], z + move * outward[2]
    narrow = NARROW_DECK * min(person.deck_half[0], person.deck_half[1])
    within = min(INSIDE_MARGIN * person.foot, narrow)
    beyond = OUTSIDE_MARGIN * person.foot
    if not -beyond < inside < within or top - person.floor > HIGHEST_STEP * leg_length(person):
        return x, z
    move = beyond + inside if inside < 0.5 * (within - beyond) else inside - within
    return x + move * outward[0], z + move * outward[2]


@compiled
def _deck_at(person: Record, x: float, z: float) -> tuple[float, float, Vector]:
    """Return height, distance inside the edge, and the direction to the edge of a deck there.

    The distance is negative outside [m].
    """
    axes, middle = rows_of(person.deck_axes), triple(person.deck_middle)
    up = (axes[0][1], axes[1][1], axes[2][1])
    if up[1] < STEEPEST_DECK:
        return middle[1], -1e9, (1.0, 0.0, 0.0)
    y = middle[1] - (up[0] * (x - middle[0]) + up[2] * (z - middle[2])) / up[1]
    local = inverse_turned(axes, minus((x, y, z), middle))
    half = person.deck_half
    if person.deck_is_round:
        size = max(hypotenuse(local[0], local[2]), 1e-9)
        return y, half[0] - size, turned(axes, (local[0] / size, 0.0, local[2] / size))
    along, across = half[0] - abs(local[0]), half[1] - abs(local[2])
    if along < across:
        return y, along, turned(axes, (math.copysign(1.0, local[0]), 0.0, 0.0))
    return y, across, turned(axes, (0.0, 0.0, math.copysign(1.0, local[2])))


@compiled
def rides_deck(person: Record) -> bool:
    """Tell whether a deck carries a person, or will when a foot comes down."""
    if person.deck == NOBODY:
        return False
    feet = 0
    for k in range(2):
        feet += person.stance_on_deck[k] + person.liftoff_on_deck[k] + person.landing_on_deck[k]
    return bool(feet > 0 or person.deck_share > LEAST_SHARE)


@compiled
def follow_deck(person: Record, nodes: Records, owners: Records, solids: Solids, h: float) -> None:
    """Carry a person along with its deck, which has moved for `h` [s]."""
    person.carry_velocity[0] = person.carry_velocity[1] = person.carry_turn = 0.0
    if person.deck == NOBODY:
        person.known_deck, person.deck_share = NOBODY, 0.0
        return
    old, old_middle = rows_of(person.deck_axes), triple(person.deck_middle)
    new, middle = _deck_pose(person, nodes, owners, solids)
    for k in range(3):
        put(person.deck_axes, k, new[k])
    set_triple(person.deck_middle, middle)
    if person.known_deck != person.deck:
        person.known_deck = person.deck
        return
    _press_down(person, owners[person.owner].mass, solids, h)
    motion = (old, old_middle, new, middle)
    yaw = math.atan2(-new[2][0], new[0][0]) - math.atan2(-old[2][0], old[0][0])
    yaw = wrap_angle(yaw)
    _carry_feet(person, motion, yaw)
    _carry_body(person, motion, yaw, h)


@compiled
def _deck_pose(
    person: Record, nodes: Records, owners: Records, solids: Solids
) -> tuple[Rows, Vector]:
    """Return the axes of a deck as rows, whose columns are along, up and across, and its middle."""
    place = triple(person.deck_place)
    if person.deck < 0:
        solid = solids.bodies[SOLID - person.deck]
        R, own = rows_of(solid.R), rows_of(person.deck_turn)
        columns = (
            turned(R, (own[0][0], own[1][0], own[2][0])),
            turned(R, (own[0][1], own[1][1], own[2][1])),
            turned(R, (own[0][2], own[1][2], own[2][2])),
        )
        axes = (
            (columns[0][0], columns[1][0], columns[2][0]),
            (columns[0][1], columns[1][1], columns[2][1]),
            (columns[0][2], columns[1][2], columns[2][2]),
        )
        return axes, plus(triple(solid.p), turned(R, place))
    first = owners[person.deck].nodes[0]
    centre = triple(nodes[first].p)
    x = z = 0.0
    for k in range(SPOKES):
        # The mean of all spokes, each turned back by its own angle: pushes bend the rim.
        angle = 2.0 * math.pi * k / SPOKES
        c, s = math.cos(angle), math.sin(angle)
        u, v = nodes[first + 2 + k].p[0] - centre[0], nodes[first + 2 + k].p[2] - centre[2]
        x, z = x + c * u - s * v, z + s * u + c * v
    size = max(hypotenuse(x, z), 1e-9)
    c, s = x / size, z / size
    return ((c, 0.0, -s), (0.0, 1.0, 0.0), (s, 0.0, c)), plus(centre, place)


@compiled
def _press_down(person: Record, mass: float, solids: Solids, h: float) -> None:
    """Let the weight of a person act where its feet stand on a solid that gives way."""
    if person.deck >= 0:
        return
    solid = solids.bodies[SOLID - person.deck]
    for k in range(2):
        if person.foot_state[k] == STANCE and person.stance_on_deck[k] == 1:
            other_stands = person.foot_state[1 - k] == STANCE
            weight = mass * GRAVITY * (0.5 if other_stands else 1.0)
            arm = minus(row(person.stance_place, k), triple(solid.p))
            apply_impulse(solid, arm, (0.0, -weight * h, 0.0), h)


Motion = tuple[Rows, Vector, Rows, Vector]
"""Axes and middle of a deck one sub-step ago and now."""


@compiled
def _carried(motion: Motion, p: Vector) -> Vector:
    """Return where the motion of a deck takes a place."""
    old, old_middle, new, middle = motion
    return plus(middle, turned(new, inverse_turned(old, minus(p, old_middle))))


@compiled
def _carry_feet(person: Record, motion: Motion, yaw: float) -> None:
    """Carry what the feet stand on, have left and will stand on."""
    for k in range(2):
        if person.stance_on_deck[k] and person.foot_state[k] == STANCE:
            put(person.stance_place, k, _carried(motion, row(person.stance_place, k)))
            put(person.ankles, k, _carried(motion, row(person.ankles, k)))
            person.yaw[k] = wrap_angle(person.yaw[k] + yaw)
        if person.liftoff_on_deck[k]:
            put(person.liftoff_place, k, _carried(motion, row(person.liftoff_place, k)))
            person.liftoff_yaw[k] = wrap_angle(person.liftoff_yaw[k] + yaw)
            person.liftoff_heading[k] = wrap_angle(person.liftoff_heading[k] + yaw)
        if person.landing_on_deck[k]:
            put(person.landing_place, k, _carried(motion, row(person.landing_place, k)))
            person.landing_yaw[k] = wrap_angle(person.landing_yaw[k] + yaw)
        if person.stance_on_deck[1 - k]:
            pivot = (person.pivot[k, 0], person.floor, person.pivot[k, 1])
            pivot = _carried(motion, pivot)
            person.pivot[k, 0], person.pivot[k, 1] = pivot[0], pivot[2]


@compiled
def _weight_on_deck(person: Record) -> float:
    """Return the share of the weight that stands on the deck."""
    standing = on_deck = 0.0
    for k in range(2):
        if person.foot_state[k] == STANCE:
            standing += 1.0
            on_deck += person.stance_on_deck[k]
    return on_deck / standing if standing > 0.0 else person.deck_share


@compiled
def _carry_body(person: Record, motion: Motion, yaw: float, h: float) -> None:
    """Carry the led place, the heading and what is directed in the world along with the deck."""
    here = (person.at[0], person.floor, person.at[1])
    moved = minus(_carried(motion, here), here)
    gained = (_weight_on_deck(person) - person.deck_share) * (1.0 - math.exp(-WEIGHT_RATE * h))
    person.deck_share += gained
    share = person.deck_share
    # What the deck comes to carry is no longer the person's own velocity.
    person.velocity[0] -= gained * moved[0] / h
    person.velocity[1] -= gained * moved[2] / h
    person.yaw_rate -= gained * yaw / h
    person.at[0] += share * moved[0]
    person.at[1] += share * moved[2]
    person.floor += share * moved[1]
    person.seat[1] += share * moved[1]
    person.carry_velocity[0], person.carry_velocity[1] = share * moved[0] / h, share * moved[2] / h
    turn = share * yaw
    person.carry_turn = turn / h
    person.heading = wrap_angle(person.heading + turn)
    person.facing = wrap_angle(person.facing + turn)
    person.gaze[0] += turn
    c, s = math.cos(turn), math.sin(turn)
    _turn_level(person.velocity, c, s)
    _turn_level(person.acceleration, c, s)
    _turn_level(person.lean, c, s)
    _turn_level(person.lean_rate, c, s)
    if person.frozen:
        for k in range(NODE_COUNT):
            place = row(person.targets, k)
            step = minus(_carried(motion, place), place)
            for i in range(3):
                person.targets[k, i] += share * step[i]


@compiled
def _turn_level(values: Array, c: float, s: float) -> None:
    """Turn a level vector, x and z, about +Y by an angle with this cosine and sine."""
    x, z = values[0], values[1]
    values[0], values[1] = c * x + s * z, c * z - s * x
