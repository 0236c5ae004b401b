"""Kick task: walking round a thing, running up to it, and a swing of the foot through it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.grasp import mass_of
from pipeline.simulation.characters.person_controller import PersonController
from pipeline.simulation.characters.person_record import FOOT, HIP, STANCE, SWING
from pipeline.simulation.characters.person_tasks import (
    Task,
    place_text,
    take_route,
    walking_failure,
)
from pipeline.simulation.characters.task_progress import TaskProgress
from pipeline.simulation.characters.visibility_route import Route
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.members import MemberState
from pipeline.simulation.order_outcome import GripChange
from pipeline.simulation.people.proportions import SEGMENT_MASSES
from pipeline.simulation.spatial import Array

LEG_MASS = SEGMENT_MASSES["thigh"] + SEGMENT_MASSES["shin"] + SEGMENT_MASSES["foot"]
"""Mass of the leg that kicks, as a fraction of the body."""

RESTITUTION = 0.5  # of a foot and what it kicks
RUN_UP = 0.55  # length of the run-up, in heights
WALK_ROUND = 0.3  # clearance of a way round the thing, in heights
FOOT_LENGTH = 0.06  # from the ankle to the instep that meets the thing, in heights
STANCE_REACH = 0.16  # of the hip behind the place of the kick, in leg lengths
MISALIGNMENT = math.radians(25.0)  # of the run-up, beyond which it starts again
START_RANGE = 0.4  # of the place to kick from, within which the foot swings, in leg lengths
HIT_RANGE = 0.22  # of the foot from the surface that counts as a hit [m]
BUMP_SPEED = 0.5  # gained in a step by what the leg has met before its time [m/s]
BUMP_RANGE = 0.6  # of the foot from what it has met so, in leg lengths
KICK_LIFT = 0.14  # tangent of the elevation of a kick that rolls
STEEPEST_KICK = 0.6  # tangent of the elevation of a kick that flies
HIGHEST_KICK = 0.4  # of what is kicked above the ground, in leg lengths
BACKSWING_TIME, RECOVERY_TIME = 0.2, 0.16  # [s]
SLOWEST_FOOT, FASTEST_FOOT = 2.5, 12.0  # of the visible swing [m/s]
KICK_PATIENCE = 8.0  # of all [s]
BACK, FORWARD = (-0.45, 0.28), (0.45, 0.35)
"""Ends of the swing, ahead of the hip and of the impact, and above the ground, in leg lengths."""


@dataclass
class KickThing(Task):
    """Kick a thing of any room.

    Attributes:
        thing: its name.
        target: name of where to; None kicks it straight ahead.
        speed: of the foot where it meets the thing [m/s].
        direction: (2,) of the kick where there is no target.
        foot: number of the foot.
        time: since the start, and since the foot swings [s].
        swings: whether the foot swings.
        is_hit: whether it has met the thing.
        before: (3,) velocity of the thing a step before; None before the foot comes forward [m/s].
        is_over: whether the foot is back.
        route: around obstacles and the thing.
        progress: of the walk.
    """

    thing: str
    target: str | None
    speed: float
    direction: Array | None = None
    foot: int = 1
    time: float = 0.0
    is_behind: bool = False
    swings: bool = False
    is_hit: bool = False
    before: Array | None = None
    is_over: bool = False
    route: Route = field(default_factory=Route)
    progress: TaskProgress = field(default_factory=TaskProgress)
    path: tuple[Array, ...] = ()

    @property
    def members(self) -> tuple[str, ...]:
        """See `Task`."""
        return (self.thing,) if self.target is None else (self.thing, self.target)

    def advance(self, controller: PersonController, dt: float) -> bool:
        """See `Task`."""
        if self.is_over:
            return controller.is_standing
        thing = controller.view.state(self.thing)
        self.time += dt
        if self.swings:
            self._swing(controller, thing, dt)
            return False
        self._run_up(controller, thing, dt)
        if not self.failure and self.time > KICK_PATIENCE:
            self.stick(f"does not get behind it at {place_text(controller)}")
        return False

    def _run_up(self, controller: PersonController, thing: MemberState, dt: float) -> None:
        """Walk round the thing until it lies ahead, and run up to it."""
        person = controller.record
        middle, at = thing.centre[[0, 2]], np.array(person.at)
        leg, along = float(person.hip_height), self._aim(controller, thing)
        if thing.low[1] - person.floor > HIGHEST_KICK * leg:
            self.failure = (
                f"too high for a foot ({float(thing.low[1] - person.floor):.2f} m above the ground)"
            )
            return
        across = np.array([-along[1], along[0]])
        depth = 0.5 * float(np.ptp(_points(thing) @ np.array([along[0], 0.0, along[1]])))
        reach = depth + FOOT_LENGTH * person.height + STANCE_REACH * leg
        # The foot, not the middle, goes through the thing.
        side = 1.0 if self.foot == 1 else -1.0
        spot = middle - reach * along - side * person.hips * across
        offset = middle - at
        angle = abs(math.atan2(float(offset @ across), float(offset @ along)))
        if self.is_behind and angle > 2.0 * MISALIGNMENT:
            self.is_behind = False
        if not self.is_behind:
            start = spot - RUN_UP * person.height * along
            self._go(controller, start, (middle, WALK_ROUND * person.height + depth))
            left = math.dist(at, start)
            self.stick(walking_failure(controller, self.progress, left, dt))
            near = left < 0.25 or not person.has_goal
            ready = angle < MISALIGNMENT and math.dist(at, spot) < 1.5 * RUN_UP * person.height
            if near or ready:
                self.is_behind, self.route = True, Route()
            return
        left = float((spot - at) @ along)
        # On through the thing, so that the last step is not slowed down.
        goal = spot + 0.25 * leg * along
        controller.go(goal[0], goal[1], 0.0, controller.view.owner(self.thing))
        facing = math.atan2(-along[1], along[0])
        # Feet step aside on the way, so that the body is aimed as the kick is.
        person.has_facing, person.facing = True, facing
        turn = math.remainder(facing - float(person.heading), 2.0 * math.pi)
        self.stick(walking_failure(controller, self.progress, abs(left), dt))
        if left < START_RANGE * leg and abs(turn) < MISALIGNMENT:
            swinging = [k for k in range(2) if person.foot_state[k] == SWING]
            if len(swinging) < 2 and swinging in ([], [self.foot]):
                self._start_swing(controller, thing, along, spot)

    def _go(self, controller: PersonController, place: Array, circle: tuple[Array, float]) -> None:
        controller.go(place[0], place[1], 0.0, NOBODY)
        take_route(controller, self.route, place, circle)

    def _aim(self, controller: PersonController, thing: MemberState) -> Array:
        """Return the level unit vector (2,) of the kick."""
        if self.target is None and self.direction is not None:
            return self.direction
        if self.target is None:
            way = thing.centre[[0, 2]] - np.array(controller.record.at)
        else:
            target = controller.view.state(self.target)
            way = (target.centre - thing.centre)[[0, 2]]
            way = way + target.v[[0, 2]] * min(math.hypot(*way) / self.speed, 2.0)
        along: Array = way / max(math.hypot(way[0], way[1]), 1e-6)
        if self.target is None:
            self.direction = along
        return along

    def _start_swing(
        self, controller: PersonController, thing: MemberState, along: Array, spot: Array
    ) -> None:
        """Lift the foot, and plan its path."""
        person, k = controller.record, self.foot
        leg, floor = float(person.hip_height), float(person.floor)
        # The body goes on over the standing foot.
        beyond = spot + 0.2 * leg * along
        controller.go(beyond[0], beyond[1], 0.0, controller.view.owner(self.thing))
        person.has_facing, person.facing = True, math.atan2(-along[1], along[0])
        hip = np.array(person.targets[HIP + k])
        ahead = np.array([along[0], 0.0, along[1]])
        back = hip + BACK[0] * leg * ahead
        back[1] = floor + float(person.ankle) + BACK[1] * leg
        half = 0.5 * float(np.ptp(_points(thing) @ ahead))
        impact = thing.centre - (half + FOOT_LENGTH * person.height) * ahead
        highest = floor + HIGHEST_KICK * leg
        impact[1] = min(max(float(thing.centre[1]), floor + float(person.ankle)), highest)
        # The body goes on meanwhile.
        end = impact + FORWARD[0] * leg * ahead
        end[1] = floor + float(person.ankle) + FORWARD[1] * leg
        self.path = (np.array(person.ankles[k]), back, impact, end)
        person.kick_foot = k
        person.kick_place[:], person.kick_velocity[:] = self.path[0], 0.0
        person.kick_pitch = 0.0
        self.swings, self.time = True, 0.0

    def _swing(self, controller: PersonController, thing: MemberState, dt: float) -> None:
        """Lead the foot back, through the thing, and let it come down."""
        person, (start, back, impact, end) = controller.record, self.path
        speed = min(max(self.speed, SLOWEST_FOOT), FASTEST_FOOT)
        # It gains speed until it meets the thing, and loses it after.
        there = 2.0 * math.dist(back, impact) / speed
        on = 2.0 * math.dist(impact, end) / speed
        time = self.time - BACKSWING_TIME
        level = (end - back) * [1.0, 0.0, 1.0]
        level /= max(float(np.linalg.norm(level)), 1e-9)
        if time < 0.0:
            share = self.time / BACKSWING_TIME
            share = share * share * (3.0 - 2.0 * share)
            place, pitch = start + share * (back - start), -0.7 * share
        elif time < there:
            share = (time / there) ** 2
            place, pitch = _arc(back, impact, level, -1.0, 1.0 - share), -0.7 + 0.6 * share
        else:
            share = 1.0 - (1.0 - min((time - there) / on, 1.0)) ** 2
            place, pitch = _arc(end, impact, level, 1.0, share), -0.1
        person.kick_velocity[:], person.kick_pitch = (place - person.kick_place) / dt, pitch
        if not self.is_hit and time >= 0.0:
            # A toe or a knee meets what is wide or tall before the instep does.
            gain = 0.0 if self.before is None else float(np.linalg.norm(thing.v - self.before))
            self.before = thing.v
            if gain > BUMP_SPEED:
                self._hit(controller, thing, BUMP_RANGE * float(person.hip_height))
            elif time >= there:
                self._hit(controller, thing, HIT_RANGE)
        if time > there + on + RECOVERY_TIME:
            self.put_foot_down(controller)

    def _hit(self, controller: PersonController, thing: MemberState, reach: float) -> None:
        """Set the thing in motion if the foot is within a distance of it [m]."""
        view, person = controller.view, controller.record
        self.is_hit = True
        controller.stop()
        foot = view.p[int(person.node) + FOOT + self.foot]
        gap = float(np.linalg.norm(thing.nearest(foot) - foot))
        if gap > reach:
            self.stick(f"misses it by {gap:.2f} m at {place_text(controller)}")
            self.put_foot_down(controller)
            return
        v = self._launch(controller, thing)
        owner = view.owner(self.thing)
        if owner >= 0:
            view.set_velocity(owner, v)
        elif self.thing in view.body_masses:
            controller.kicked_bodies.append((self.thing, v))
        else:
            nodes = (f"{controller.name}.foot_{'lr'[self.foot]}",)
            controller.grip_changes.extend(
                [
                    GripChange(controller.name, nodes, self.thing, True),
                    GripChange(controller.name, nodes, self.thing, False, v),
                ]
            )

    def _launch(self, controller: PersonController, thing: MemberState) -> Array:
        """Return the velocity (3,) with which the thing leaves the foot [m/s]."""
        person = controller.record
        leg = LEG_MASS * float(controller.view.arrays.owners["mass"][person.owner])
        share = (1.0 + RESTITUTION) * leg / (leg + mass_of(controller, self.thing))
        speed = self.speed * min(share, 1.0)
        along, slope = self._aim(controller, thing), KICK_LIFT
        if self.target is not None:
            offset = controller.view.state(self.target).centre - thing.centre
            slope = _elevation(math.hypot(offset[0], offset[2]), float(offset[1]), speed)
        size = speed / math.hypot(1.0, slope)
        return np.array([size * along[0], size * slope, size * along[1]])

    def put_foot_down(self, controller: PersonController) -> None:
        """Let the gait swing the foot from where it is to below its hip."""
        person, k = controller.record, self.foot
        person.kick_foot = NOBODY
        person.foot_state[k] = SWING
        person.liftoff_place[k] = person.ankles[k]
        person.liftoff_yaw[k] = person.landing_yaw[k] = person.yaw[k]
        person.liftoff_pitch[k], person.liftoff_heading[k] = person.pitch[k], person.heading
        other = person.stance_place[1 - k]
        person.pivot[k] = other[0], other[2]
        person.swing_height[k] = 0.0
        side = 1.0 if k == 1 else -1.0
        x = person.at[0] + side * person.hips * math.sin(person.heading)
        z = person.at[1] + side * person.hips * math.cos(person.heading)
        height = controller.view.ground_height(x, z) + float(person.ankle)
        person.landing_place[k] = x, height, z
        person.swing_end[k] = height
        person.foot_state[1 - k] = STANCE
        person.stepping, person.phase = True, (1.0 - 0.5 * k) % 1.0
        person.has_goal = person.has_facing = False
        self.is_over, self.swings = True, False


def _arc(far: Array, impact: Array, level: Array, sense: float, share: float) -> Array:
    """Return the place (3,) of a foot on an arc that is level where it meets a thing.

    A quadratic Bezier curve; the foot passes from one arc to the other without a corner.

    Args:
        far: (3,) the other end of the arc [m].
        impact: (3,) where the foot meets the thing [m].
        level: (3,) unit vector along which it does.
        sense: 1 for the arc behind the impact, -1 for the one before it.
        share: of the way from the impact to the other end, in the parameter of the curve.
    """
    middle = impact + 0.5 * sense * math.dist(far, impact) * level
    near, between = (1.0 - share) ** 2, 2.0 * share * (1.0 - share)
    place: Array = near * impact + between * middle + share * share * far
    return place


def _points(state: MemberState) -> Array:
    return np.concatenate(state.solids) if state.solids else state.centre[None]


def _elevation(level: float, rise: float, speed: float) -> float:
    """Return the tangent of the flattest flight to a place, or of a kick that rolls there.

    Args:
        level: distance over the ground [m].
        rise: [m].
        speed: [m/s].
    """
    a = GRAVITY * level * level / (2.0 * speed * speed)
    root = level * level - 4.0 * a * (a + rise)
    if root < 0.0 or a == 0.0:
        return KICK_LIFT
    slope = (level - math.sqrt(root)) / (2.0 * a)
    return slope if slope < STEEPEST_KICK else KICK_LIFT
