"""Phases: how each begins, and what its events change.

Flight ends when all feet touch, or when the body has sunk a little since the first one did:
over a ditch some never do. A landing ends at rest above the crouch, a push with the velocity
of the next jump or when a foot no longer reaches the ground.

Source: Sims 1987, 11.1 to 11.3.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.locomotion.pronking import spin
from pipeline.simulation.locomotion.pronking.aiming import aim, held_out, leant, leaves
from pipeline.simulation.locomotion.pronking.attitude import FREE, NONE, Steering, rate_for
from pipeline.simulation.locomotion.pronking.course import Course
from pipeline.simulation.locomotion.pronking.forces import drive
from pipeline.simulation.locomotion.pronking.happening import Happening
from pipeline.simulation.locomotion.pronking.pronker import HOLDS, Pronker
from pipeline.simulation.locomotion.pronking.spin import Quaternion, Vector
from pipeline.simulation.locomotion.pronking.state import State, level
from pipeline.simulation.locomotion.pronking.swing import Swing
from pipeline.simulation.locomotion.pronking.watching import body_gap
from pipeline.simulation.locomotion.swings.sole import lowest
from pipeline.simulation.spatial import Array, quaternion
from pipeline.simulation.terrain import Ground

FALLING = np.array([0.0, -GRAVITY, 0.0])

SINKS, EASY = 0.42, 0.7
"""How long a creature with legs of one metre takes to crouch [s], and with which part of its
weight it sinks at most."""

BAND = 0.3
"""How far from above its feet a body may be when a landing ends, in leg lengths."""

ROOM = 0.03
"""Way of a landing at least, in leg lengths."""

TUCK = 0.3
"""How high feet are drawn up in the middle of a flight, in leg lengths."""

TRAIL = 0.35
"""Speed with which feet trail behind after a lift-off, in that of the body."""

RESTRETCHES = 0.15
"""How long a leg that came off the ground takes to be ready again [s]."""

WALL = 0.06
"""How high a foot would have to be lifted at once where it meets a wall, in leg lengths."""

LOWER = 0.03
"""Steps in which who cannot stand upright stands lower, in leg lengths."""

SITS = 0.2
"""Speed from which a body that comes down on its folded legs is heard [m/s]."""

Events = list[Happening]


def first_state(of: Pronker, ground: Ground, above: float | None) -> State:
    """Return how it begins: standing, or with its feet `above` the ground [m], to fall."""
    if above is None:
        state = _stood(of, ground)
        if body_gap(of, ground, state.now(of)) >= 0.0 and not gives_way(of, state):
            return state
    # Where it cannot stand it comes down from as low as there is room for it.
    return _held_up(of, ground, above or 0.0)


def _stood(of: Pronker, ground: Ground) -> State:
    """Return it standing, on what legs come to the ground."""
    state = _put(of, ground)
    R = np.array(spin.rows(state.turning[0]))
    x, z = (float(c) for c in of.start)
    feet = of.rest @ R.T + [x, 0.0, z]
    feet[:, 1] = lowest(ground, feet[:, 0], feet[:, 2], of.soles)
    floor = float((feet[:, 1] - of.soles).mean())
    origin = np.array([x, _standing(of, R, feet, floor + of.stand, x, z), z])
    # Legs that stand on a slope may come to limits of their joints before they are long.
    while of.legs.misses((feet - origin) @ R).any() and origin[1] - floor > of.crouch:
        origin[1] -= LOWER * of.leg
    # On rough ground some legs may have nothing to stand on: they hang.
    hangs = of.rest - [0.0, min(of.stand, 0.8 * of.leg), 0.0]
    state.phase, state.until = "standing", of.words.start
    state.p, state.tips = origin + R @ of.mass.centre, feet
    state.down, state.swing = ~of.legs.misses((feet - origin) @ R), Swing.still(hangs)
    state.floor = _floor(of, state)
    return state


def _held_up(of: Pronker, ground: Ground, above: float) -> State:
    """Return it with its feet so high above the ground, or as low as its body is out of it."""
    state = _put(of, ground)
    R = np.array(spin.rows(state.turning[0]))
    feet = held_out(of, R, np.zeros(3), 1.0, stops=False)
    base = float(ground.height(of.start[0], of.start[1]))
    state.p[1] += base + above - float((feet[:, 1] - of.soles).min())
    state.swing, state.a = Swing.still(feet), FALLING
    now = state.now(of)
    tips = now.points(feet)
    deep = float((lowest(ground, tips[:, 0], tips[:, 2], of.soles) - tips[:, 1]).max())
    state.p[1] += max(deep, -body_gap(of, ground, now), 0.0)
    return state


def _put(of: Pronker, ground: Ground) -> State:
    """Return it where it begins, its body at height 0."""
    q = leant(of, ground, float(of.start[0]), float(of.start[1]), of.heading)
    n, R = len(of.hips), np.array(spin.rows(q))
    return State(
        phase="flight",
        time=0.0,
        p=np.array([of.start[0], 0.0, of.start[1]]) + R @ of.mass.centre,
        v=np.zeros(3),
        turning=(q, NONE),
        tips=np.zeros((n, 3)),
        down=np.zeros(n, dtype=bool),
        released=np.zeros(n, dtype=bool),
        swing=Swing.still(np.zeros((n, 3))),
        facing=of.heading + (0.0 if of.words.land_at else math.radians(of.words.turn_deg)),
        going=of.heading + math.radians(of.words.direction_deg),
        course=Course(of.jump),
    )


def taken_over(of: Pronker, R: Array, origin: Array, tips: Array, time: float) -> State:
    """Return the state of one that stands, and has come there by other ways than jumps.

    Args:
        of: who.
        R: (3, 3) and
        origin: (3,) of its body [m].
        tips: (n, 3) its feet, which are on the ground [m].
        time: since the start of the film [s].
    """
    a, b, c, d = quaternion(R[None])[0].tolist()
    angle = math.atan2(-R[2, 0], R[0, 0])
    own = (tips - origin) @ R
    state = State(
        phase="standing",
        time=time,
        p=origin + R @ of.mass.centre,
        v=np.zeros(3),
        turning=((a, b, c, d), NONE),
        tips=tips.copy(),
        down=~of.legs.misses(own),
        released=np.zeros(len(tips), dtype=bool),
        swing=Swing.still(own),
        facing=angle,
        going=angle,
        course=Course(of.jump, onward=False),
    )
    state.floor = _floor(of, state)
    return state


def crouched(of: Pronker, state: State) -> State:
    """Return the state of one that stands as it will be at the begin of a push."""
    low = min(state.floor + of.crouch, level(of, state.p))
    return replace(state, p=np.array([state.p[0], low + of.mass.centre[1], state.p[2]]))


def end_of_phase(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Go over from a phase whose time has come to the next."""
    match state.phase:
        case "standing":
            _crouch(of, ground, state, events)
        case "crouching":
            begin_landing(of, ground, state, events)
        case "landing":
            state.v = np.array([state.v[0], 0.0, state.v[2]])
            _landed(of, ground, state, events)
        case "pushing":
            take_off(of, ground, state, events)
        case "rising":
            _straighten(state)
        case "straightening":
            _stand(state)
            wake(of, state)
        case _:
            pass


# --- flight ---------------------------------------------------------------------


def trip(of: Pronker, state: State, legs: NDArray[np.int64], tips: Array, events: Events) -> None:
    """Let feet (n, 3) that go with the body meet a wall."""
    v = np.broadcast_to(state.v, tips.shape)
    _trip(of, state, legs, tips, v, events)


def touch(
    of: Pronker,
    ground: Ground,
    state: State,
    legs: NDArray[np.int64],
    met: NDArray[np.bool_],
    events: Events,
) -> None:
    """Put feet down where they are: these are their footholds until the next lift-off.

    Args:
        of: whose feet.
        ground: that they come to.
        state: in flight or landing.
        legs: whose feet they are.
        met: (n,) which came to it just now; the others were lifted over it.
        events: to be added to.
    """
    now, own = state.now(of), state.swing.tips(state.time)
    tips = now.points(own)
    moves = now.R @ ((own - state.swing.tips(state.time - 1e-5)) / 1e-5).T
    v = state.v + np.cross(state.turning[1], tips - state.p) + moves.T
    if not state.down.any():
        state.first = float(state.p[1])
    caught, floors = list[int](), lowest(ground, tips[:, 0], tips[:, 2], of.soles)
    for leg in legs.tolist():
        (x, y, z), least = tips[leg].tolist(), float(floors[leg])
        if met[leg] and least - y > WALL * of.leg:
            caught.append(leg)
        else:
            y = max(least, y)
        state.tips[leg], state.down[leg] = (x, y, z), True
        place, normal = np.array([x, y - of.soles[leg], z]), ground.normal(x, z)
        speed = max(-float(normal @ v[leg]), 0.0)
        energy = 0.5 * of.mass.mass / len(of.hips) * speed * speed
        events.append(Happening("touch", state.time, leg, place, normal, speed, energy))
        if not bool(ground.steppable(x, z)):
            text = f"a foot landed in a forbidden zone, at ({x:.2f}, {z:.2f})"
            events.append(Happening("misplaced", state.time, leg, place, normal, 0.0, 0.0, text))
    if caught:
        _trip(of, state, np.array(caught), tips, v, events)


def _trip(
    of: Pronker, state: State, legs: NDArray[np.int64], tips: Array, v: Array, events: Events
) -> None:
    """Catch feet on a wall: what stops the legs pulls at the body.

    Source: Sims 1987, 9.4.
    """
    pull = -of.leg_mass[legs, None] * v[legs] * [1.0, 0.0, 1.0]
    state.v = state.v + pull.sum(axis=0) / of.mass.mass
    R = np.array(spin.rows(state.turning[0]))
    inverse = R @ np.array(of.inertia.inverse) @ R.T
    twist = np.cross(tips[legs] - state.p, pull).sum(axis=0)
    x, y, z = (state.turning[1] + inverse @ twist).tolist()
    state.turning = state.turning[0], (x, y, z)
    up = np.array([0.0, 1.0, 0.0])
    for leg in legs.tolist():
        text = "a foot caught on a wall"
        events.append(Happening("tripped", state.time, leg, tips[leg], up, 0.0, 0.0, text))


def take_off(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Leave the ground with all feet."""
    now = state.now(of)
    down = state.down.copy()
    tips = np.where(down[:, None], state.tips, now.points(state.swing.tips(state.time)))
    start = (tips - now.origin) @ now.R
    speed = float(np.linalg.norm(state.v))
    for leg in np.flatnonzero(down).tolist():
        place = tips[leg] - [0.0, of.soles[leg], 0.0]
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * float(of.leg_mass[leg]) * speed * speed
        events.append(Happening("lift", state.time, leg, place, normal, speed, energy))
    time = max(state.flight, 0.1)
    leap = state.course.leap
    folds = leap is not None and leap.folds
    state.swing = drawn_up(of, start, state.ends, state.time, time, now.R.T @ state.v, folds)
    state.lift = state.p.copy(), state.v.copy()
    state.phase, state.a, state.until, state.steering = "flight", FALLING, math.inf, FREE
    state.down[:] = state.released[:] = False
    state.jumps += 1
    state.first, state.hits, state.saturated = math.inf, 0, False
    state.course.took_off()
    if leap is not None:
        state.facing = leap.facing
    elif not of.words.land_at:
        state.facing += math.radians(of.words.turn_deg)
        state.going += math.radians(of.words.turn_deg)


def drawn_up(
    of: Pronker, start: Array, ends: Array, begin: float, time: float, v: Array, folds: bool
) -> Swing:
    """Return the ways of feet that leave the ground and are held out for the landing.

    Args:
        of: whose feet.
        start: (n, 3) where they leave it, and
        ends: (n, 3) where they are held, in the frame of the body [m].
        begin: when it leaves the ground [s].
        time: how long the flight takes [s].
        v: (3,) velocity of the body, in its frame [m/s].
        folds: whether they are drawn up as far as legs fold.
    """
    n = len(start)
    middle = 0.5 * (start + ends)
    low, room = np.maximum(start[:, 1], ends[:, 1]), of.hips[:, 1] - 1.15 * of.folds
    top = room if folds else np.minimum(low + TUCK * of.leg * min(1.0, time / 0.5), room)
    middle[:, 1] = np.maximum(top, low)
    trail = np.tile([-TRAIL * v[0], 0.0, -TRAIL * v[2]], (n, 1))
    return Swing(np.full(n, begin), np.full(n, 0.97 * time), start, middle, ends, trail)


# --- landing ----------------------------------------------------------------------


def begin_landing(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Let the legs that touch absorb the fall."""
    state.phase = "landing"
    state.floor = _floor(of, state)
    here = level(of, state.p) - state.floor
    state.goal = min(of.crouch, here - ROOM * of.leg)
    go_on_landing(of, ground, state, events)


def go_on_landing(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Share the landing anew among the legs that touch."""
    if state.v[1] >= -1e-9:
        _landed(of, ground, state, events)
        return
    rise = min(state.goal - (level(of, state.p) - state.floor), -1e-3 * of.leg)
    time = 2.0 * rise / float(state.v[1])
    x, z = _carried(of, state, time)
    one = drive(of.mass.mass, _most(of, state), _plain(state.v), (x, 0.0, z), rise)
    _say_if(one.saturated, state, events)
    state.a, state.until = np.array(one.acceleration), state.time + one.time
    x, _, z = state.tips[state.down].mean(axis=0).tolist()
    q = leant(of, ground, x, z, state.now(of).heading)
    state.steering = _steering(of, state, one.force, q, NONE, time)


def _carried(of: Pronker, state: State, time: float) -> tuple[float, float]:
    """Return the horizontal velocity wanted at the end of a landing [m/s].

    It stays what it is, unless the body would get too far from above its feet.
    """
    v = state.v[[0, 2]]
    if not leaves(of, state):
        return 0.0, 0.0
    now = state.now(of)
    own = state.down
    offset = (now.points(of.rest) - state.tips)[own][:, [0, 2]].mean(axis=0)
    after = offset + time * v
    far = float(np.hypot(*after))
    most = BAND * of.leg
    if far <= most:
        return float(v[0]), float(v[1])
    wanted = after * (most / far)
    # With a constant acceleration the way is the mean of both velocities times the time.
    end = 2.0 * (wanted - offset) / time - v
    # Who is thrown far aside is not to be thrown back harder.
    k = min(1.0, float(np.hypot(*v)) / max(float(np.hypot(*end)), 1e-9))
    return k * float(end[0]), k * float(end[1])


def bottomed(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """End a landing at once: the body lies on the ground."""
    state.v = np.array([state.v[0], max(float(state.v[1]), 0.0), state.v[2]])
    _landed(of, ground, state, events)


def sat_down(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Let the body come down on legs that fold no farther, as hard as on the ground."""
    speed = -float(state.v[1])
    if speed > SITS:
        place = state.tips[state.down].mean(axis=0)
        normal = ground.normal(place[0], place[2])
        energy = 0.5 * of.mass.mass * speed * speed
        events.append(Happening("body", state.time, -1, place, normal, speed, energy))
    bottomed(of, ground, state, events)


def overstretched(
    of: Pronker, ground: Ground, state: State, legs: NDArray[np.bool_], events: Events
) -> None:
    """Lift feet that no longer reach the ground; in a push, with them all others."""
    if state.phase == "pushing":
        take_off(of, ground, state, events)
        return
    now = state.now(of)
    own = (
        np.where(state.down[:, None], state.tips, now.points(state.swing.tips(state.time)))
        - now.origin
    ) @ now.R
    which = np.asarray(legs, dtype=bool) & state.down
    state.swing = state.swing.again(which, state.time, own, RESTRETCHES)
    state.down[which], state.released[which] = False, True
    if state.down.any():
        if state.phase == "landing":
            go_on_landing(of, ground, state, events)
    else:
        state.phase, state.a, state.until, state.steering = "flight", FALLING, math.inf, FREE
        state.first = math.inf
        state.released[:] = False


def _landed(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    if leaves(of, state):
        begin_push(of, ground, state, events)
    else:
        _rise(of, ground, state)


# --- pushing -----------------------------------------------------------------------


def begin_push(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Push off for the next jump."""
    state.phase = "pushing"
    if state.v[1] < 0.0:
        state.v = np.array([state.v[0], 0.0, state.v[2]])
    for text in state.course.choose(of, state, ground):
        up = np.array([0.0, 1.0, 0.0])
        events.append(Happening("stopped", state.time, -1, state.p, up, 0.0, 0.0, text))
    if not leaves(of, state):
        _rise(of, ground, state)
        return
    one, good = aim(of, state, ground)
    if not good:
        text = "no landing outside of forbidden zones; it jumps where it is"
        place = np.array([one.spot[0], 0.0, one.spot[1]])
        up = np.array([0.0, 1.0, 0.0])
        events.append(Happening("stopped", state.time, -1, place, up, 0.0, 0.0, text))
    push = drive(of.mass.mass, _most(of, state), _plain(state.v), _plain(one.velocity), one.rise)
    _say_if(push.saturated, state, events)
    if push.acceleration[1] <= 0.0:
        text = f"{int(state.down.sum())} legs on the ground cannot lift it"
        events.append(Happening("stopped", state.time, -1, state.p, np.zeros(3), 0.0, 0.0, text))
        _stand(state)
        return
    state.a, state.until = np.array(push.acceleration), state.time + push.time
    state.flight, state.ends = one.flight, one.ends
    q, time = state.turning[0], min(push.time, 1.0)
    goal, rate = rate_for(q, one.attitude, of.inertia, time, one.flight)
    state.steering = _steering(of, state, push.force, goal, rate, time)


def _crouch(of: Pronker, ground: Ground, state: State, events: Events) -> None:
    """Sink for half of the way into the first crouch; the landing ends the other half."""
    if not leaves(of, state):
        state.until = math.inf
        return
    way = max(level(of, state.p) - state.floor - of.crouch, 0.5 * ROOM * of.leg)
    time = max(SINKS * math.sqrt(of.leg), math.sqrt(4.0 * way / (EASY * GRAVITY)))
    state.phase, state.a = "crouching", np.array([0.0, -4.0 * way / time**2, 0.0])
    state.until = state.time + 0.5 * time
    force = 0.0, of.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    state.steering = _steering(of, state, force, state.turning[0], NONE, time)


def _rise(of: Pronker, ground: Ground, state: State) -> None:
    """Rise from the last crouch, half of the way ever faster."""
    state.v = np.zeros(3)
    now = state.now(of)
    x, _, z = now.origin.tolist()
    height = _standing(of, now.R, state.tips[state.down], state.floor + of.stand, x, z, state.down)
    way = max(height - level(of, state.p), 1e-3 * of.leg)
    # Weak legs rise slowly; those that cannot rise at all give way.
    lift = max(_most(of, state) / of.mass.mass - GRAVITY, 1e-3)
    time = max(1.4 * SINKS * math.sqrt(of.leg), math.sqrt(4.0 * way / min(EASY * GRAVITY, lift)))
    state.phase, state.a = "rising", np.array([0.0, 4.0 * way / time**2, 0.0])
    state.until = state.time + 0.5 * time
    force = 0.0, of.mass.mass * (float(state.a[1]) + GRAVITY), 0.0
    q = leant(of, ground, x, z, now.heading)
    state.steering = _steering(of, state, force, q, NONE, 0.5 * time)


def _straighten(state: State) -> None:
    time = float(state.v[1] / state.a[1])
    state.phase, state.a = "straightening", -state.a
    state.until = state.time + time


def _stand(state: State) -> None:
    state.phase, state.until = "standing", math.inf
    state.v, state.a = np.zeros(3), np.zeros(3)
    state.turning, state.steering = (state.turning[0], NONE), FREE


def gives_way(of: Pronker, state: State) -> bool:
    """Tell whether it stands, or sinks and rises slowly, on fewer legs than can carry it."""
    if state.phase not in ("standing", "crouching", "rising", "straightening"):
        return False
    force = of.mass.mass * float(state.a[1] + GRAVITY)
    return force > _most(of, state) * (1.0 + 1e-9)


def wake(of: Pronker, state: State) -> None:
    """Let who stands begin to crouch if it is to jump again."""
    if state.phase == "standing" and leaves(of, state):
        state.until = min(state.until, max(state.time, of.words.start))


def let_go(state: State, feet: Array) -> None:
    """Fall as one rigid body, feet (n, 3) where they are in its frame [m]."""
    state.phase, state.until, state.steering = "fallen", math.inf, FREE
    state.down[:] = False
    state.swing = Swing.still(feet)


def _standing(
    of: Pronker,
    R: Array,
    feet: Array,
    height: float,
    x: float,
    z: float,
    down: NDArray[np.bool_] | None = None,
) -> float:
    """Return the height of a body at which all feet (n, 3) that are down reach the ground [m]."""
    own = slice(None) if down is None else down
    hips = of.hips[own] @ R.T + [x, 0.0, z]
    across = ((hips - feet)[:, [0, 2]] ** 2).sum(axis=-1)
    room = np.sqrt(np.maximum((HOLDS * 0.995 * of.lengths[own]) ** 2 - across, 0.0))
    return min(height, float((feet[:, 1] + room - hips[:, 1]).min()))


def _floor(of: Pronker, state: State) -> float:
    """Return the mean height of the footholds, of the ground without them [m]."""
    if not state.down.any():
        return 0.0
    return float((state.tips[:, 1] - of.soles)[state.down].mean())


def _most(of: Pronker, state: State) -> float:
    return of.most * int(state.down.sum())


def _steering(
    of: Pronker, state: State, force: Vector, goal: Quaternion, rate: Vector, time: float
) -> Steering:
    x, y, z = (of.hips[state.down].mean(axis=0) - of.mass.centre).tolist()
    end = state.time + (time if math.isfinite(time) else 0.3)
    return Steering(force, (x, y, z), goal, rate, end, of.balance, of.twist)


def _say_if(saturated: bool, state: State, events: Events) -> None:
    if saturated and not state.saturated:
        state.saturated = True
        text = "its legs give all they have, which is less than it takes"
        up = np.array([0.0, 1.0, 0.0])
        events.append(Happening("saturated", state.time, -1, state.p, up, 0.0, 0.0, text))


def _plain(v: Array) -> Vector:
    x, y, z = v.tolist()
    return x, y, z
