"""Bouncing: bodies that fall, strike a terrain, roll, and come to rest.

Every body goes through a step at its own pace, for none meets another: flights and
sub-steps end where a body strikes the ground, which is looked for on its path, so heights
do not depend on the grid of steps. What has lain still for a while sleeps.

Source: Sims 1987, ch. 12.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.leaning import HELD, Forces, holds, leant, paid
from pipeline.simulation.dynamics.meeting import Contacts, Meeting, none
from pipeline.simulation.dynamics.path import Path, in_world
from pipeline.simulation.dynamics.rigid import FREE, Bodies, State, dot, turned
from pipeline.simulation.dynamics.striking import REST, strike
from pipeline.simulation.dynamics.tumbling import MOST_TURN, Tumble
from pipeline.simulation.spatial import Array, matrix
from pipeline.simulation.terrain import Ground

LONGEST = 1.0 / 240.0
"""Longest sub-step near the ground [s]."""

FREE_LONGEST = 1.0 / 24.0
"""Longest sub-step of a flight that meets nothing [s]."""

TRAVEL = 0.5
"""Way of any point in a sub-step near the ground, in the depth of the body: none passes
through what is higher than that."""

DEEP = 1e-7
"""Depth at which a body in flight has struck, in sizes; an impact is located to half of it."""

DEEP_HELD = 2e-5
"""The same of new contacts of a body that the ground holds already."""

SLACK = 0.02
"""Gap up to which contacts are told, in sizes of the largest body."""

LOCATING = 60
"""Most times that a path is cut to find an impact."""

MOST_ROUNDS = 400
"""Sub-steps of one step; what needs more is stuck, and loses the rest of its step."""

QUIET, QUIET_TIME = 0.01, 0.4
"""Speed of any point [m/s] below which a body is quiet, and how long until it sleeps [s]."""

PROPPED, PROPPED_TIME = 3, 1.5
"""Contacts that let a body lie safely; one with fewer sleeps after this time [s]."""

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Impact:
    """A body has struck the ground.

    Attributes:
        body: its number.
        time: from the begin of the step [s].
        place: (3,) [m].
        normal: (3,) of the ground.
        speed: of approach along the normal [m/s].
        energy: of what came at this speed [J].
    """

    body: int
    time: float
    place: tuple[float, float, float]
    normal: tuple[float, float, float]
    speed: float
    energy: float


class Bouncing:
    """N bodies over a terrain.

    Attributes:
        bodies: what stays of them.
        state: how they are.
        awake: (N,) which are not asleep.
    """

    def __init__(self, bodies: Bodies, state: State, ground: Ground) -> None:
        self.bodies = bodies
        self.state = state
        count = len(bodies.mass)
        self.meeting = Meeting(
            ground, bool((bodies.radius > 0.0).any()), bool((bodies.radius == 0.0).any())
        )
        self.awake = np.ones(count, dtype=bool)
        self._quiet = np.zeros(count)
        self._held = np.zeros(count, dtype=np.int64)
        # A soft contact pushes for a while, and leaves the body sunk in what gave way.
        self._pushed = np.zeros(count)
        self._push_v, self._push_w = np.zeros((count, 3)), np.zeros((count, 3))
        self._sunk = np.zeros(count)
        width = self.meeting.width
        self._forces = Forces(np.zeros((count, width, 3)), np.zeros((count, width, 3)))
        self._contacts = none(count, self.meeting.width)
        self.look()

    def look(self) -> None:
        """Take in that bodies were put elsewhere."""
        self._look(np.arange(len(self.awake)))

    def depths(self) -> Array:
        """Return how deep each body is in the ground (N,), negative above it [m]."""
        slack = float(self.bodies.size.max())
        return -self.meeting.contacts(self.bodies, self.state.p, self.state.q, slack).least

    def drop(self, which: Numbers) -> None:
        """Take bodies out of the world: they no longer move."""
        self.awake[which] = False
        self.state.v[which] = self.state.w[which] = 0.0

    def advance(self, dt: float) -> list[Impact]:
        """Go on by `dt` [s]; return what has struck the ground."""
        impacts = list[Impact]()
        left = np.where(self.awake, dt, 0.0)
        self._quiet[self.awake] += dt
        for _ in range(MOST_ROUNDS):
            rows = np.flatnonzero(left > 1e-12)
            if not len(rows):
                break
            impacts += self._strike(rows, dt - left[rows])
            left[rows] -= self._go(rows, left[rows])
        self._fall_asleep()
        return sorted(impacts, key=lambda one: (one.time, one.body))

    def _strike(self, rows: Numbers, time: Array) -> list[Impact]:
        """Let bodies that touch the ground and approach it bounce."""
        contacts = self._contacts.some(rows)
        able = np.flatnonzero(
            (contacts.least <= HELD * self.bodies.size[rows]) & (self._pushed[rows] == 0.0)
        )
        rows, time = rows[able], time[able]
        if not len(rows):
            return []
        state = self.state.some(rows)
        struck = strike(self.bodies.some(rows), state, contacts.some(able))
        # Only what bounces is pushed for a while; what rests is held.
        soft = (self.bodies.soft[rows] > 0.0) & (struck.speed >= REST)
        self._push(rows[soft], state.some(np.flatnonzero(soft)), struck.v[soft], struck.w[soft])
        hard = ~soft
        self.state.v[rows[hard]], self.state.w[rows[hard]] = struck.v[hard], struck.w[hard]
        place = state.p + struck.place
        return [
            Impact(
                int(rows[i]),
                float(time[i]),
                tuple(place[i].tolist()),
                tuple(struck.normal[i].tolist()),
                float(struck.speed[i]),
                float(struck.energy[i]),
            )
            for i in np.flatnonzero(struck.speed >= REST)
        ]

    def _push(self, rows: Numbers, state: State, v: Array, w: Array) -> None:
        """Begin to push bodies by forces that change their velocities to v and w in time.

        Source: Sims 1987, (12.11) and (12.19): the force makes up for gravity as well.
        """
        soft = self.bodies.soft[rows]
        self._pushed[rows] = soft
        R = matrix(state.q)
        self._push_v[rows] = (v - state.v) / soft[:, None]
        self._push_w[rows] = turned(R, w - state.w) / soft[:, None]

    def _go(self, rows: Numbers, left: Array) -> Array:
        """Take bodies on by one sub-step, or to where they strike; return how long (B,) [s]."""
        bodies, state = self.bodies.some(rows), self.state.some(rows)
        contacts = self._contacts.some(rows)
        h = self._sub_step(bodies, state, left, self._pushed[rows])
        pushed = self._pushed[rows] > 0.0
        acts = holds(bodies, state, contacts, h) & ~pushed[:, None]
        held = acts.any(axis=1)
        self._held[rows] = acts.sum(axis=1)
        path = self._path(rows, bodies, state, contacts, acts, pushed, h)
        deep = np.where(held, DEEP_HELD, DEEP) * bodies.size
        # What lies deeper from the begin may stay so, but not go deeper.
        limit = np.minimum(-deep, np.minimum(contacts.least, 0.0) - deep)
        limit[pushed] = -np.inf
        h, end, found = self._located(rows, bodies, path, h, limit, deep)
        at = np.flatnonzero(held)
        if len(at):
            end.put(at, paid(bodies.some(at), state.some(at), end.some(at)))
        self.state.put(rows, end)
        self._contacts.put(rows, found)
        self._after(rows, h, pushed)
        return h

    def _sub_step(self, bodies: Bodies, state: State, left: Array, pushed: Array) -> Array:
        """Return how long a sub-step may be (B,) [s]."""
        rate = np.sqrt(dot(state.w, state.w))
        speed = np.sqrt(dot(state.v, state.v)) + rate * bodies.reach
        h = np.minimum(left, FREE_LONGEST)
        # While it turns the rate may grow, by what the moments of inertia allow.
        h = np.minimum(h, MOST_TURN / np.maximum(rate, 1e-9))
        lowest = state.p[:, 1] - bodies.reach - h * (speed + h * -FREE[1])
        near = lowest <= self.meeting.top
        travel = TRAVEL * bodies.thin / np.maximum(speed, 1e-9)
        h = np.where(near, np.minimum(np.minimum(h, LONGEST), travel), h)
        return np.where(pushed > 0.0, np.minimum(h, pushed), h)

    def _path(
        self,
        rows: Numbers,
        bodies: Bodies,
        state: State,
        contacts: Contacts,
        acts: NDArray[np.bool_],
        pushed: NDArray[np.bool_],
        h: Array,
    ) -> Path:
        tumble = Tumble.of(state.q, state.w, bodies.inertia, bodies.inverse)
        turn = in_world(state)
        a = np.tile(FREE, (len(rows), 1))
        rate = np.zeros_like(a)
        a[pushed], rate[pushed] = self._push_v[rows[pushed]], self._push_w[rows[pushed]]
        held = acts.any(axis=1)
        some = np.flatnonzero(held)
        if len(some):
            own = state.some(some)
            q, w = tumble.some(some).at(h[some])
            free_w = turned(matrix(q), w)
            who = rows[some]
            before = Forces(self._forces.force[who], self._forces.lever[who])
            v, after, forces = leant(
                bodies.some(some), own, contacts.some(some), acts[some], free_w, h[some], before
            )
            self._forces.force[who], self._forces.lever[who] = forces.force, forces.lever
            a[some] = (v - own.v) / h[some, None]
            rate[some] = (after - turn[some]) / h[some, None]
        return Path(state, a, tumble, held | pushed, turn, rate)

    def _located(
        self, rows: Numbers, bodies: Bodies, path: Path, h: Array, limit: Array, deep: Array
    ) -> tuple[Array, State, Contacts]:
        """Cut paths where bodies get below their limits; return lengths, ends and contacts.

        By false position, the end that stays having its weight halved (Illinois).
        """
        end = path.at(h)
        found = self._contacts_at(rows, bodies, end)
        strikes = np.flatnonzero(found.least < limit)
        aim = limit[strikes] + 0.5 * deep[strikes]
        low, high = np.zeros(len(strikes)), h[strikes].copy()
        f_high = found.least[strikes] - aim
        # A contact that is just leaving is as near as nothing: it must not draw the search.
        f_low = np.maximum(self._contacts.least[rows[strikes]] - aim, -f_high)
        f_low = np.minimum(f_low, -1e3 * f_high)
        h = h.copy()
        for i in range(LOCATING):
            if not len(strikes):
                break
            cut = high - f_high * (high - low) / (f_high - f_low)
            cut = np.where(i % 4 == 3, 0.5 * (low + high), cut)
            own = path.some(strikes).at(cut)
            there = self._contacts_at(rows[strikes], bodies.some(strikes), own)
            f = there.least - aim
            end.put(strikes, own)
            found.put(strikes, there)
            h[strikes] = cut
            below = f < 0.0
            f_low, f_high = (
                np.where(below, 0.5 * f_low, f),
                np.where(below, f, 0.5 * f_high),
            )
            low, high = np.where(below, low, cut), np.where(below, cut, high)
            still = np.abs(f) > 0.45 * deep[strikes]
            strikes, aim = strikes[still], aim[still]
            low, high, f_low, f_high = low[still], high[still], f_low[still], f_high[still]
        return h, end, found

    def _contacts_at(self, rows: Numbers, bodies: Bodies, state: State) -> Contacts:
        slack = SLACK * float(self.bodies.size.max())
        found = self.meeting.contacts(bodies, state.p, state.q, slack)
        found.gap[:] += self._sunk[rows, None]
        return found

    def _look(self, rows: Numbers) -> None:
        bodies, state = self.bodies.some(rows), self.state.some(rows)
        self._contacts.put(rows, self._contacts_at(rows, bodies, state))

    def _after(self, rows: Numbers, h: Array, pushed: NDArray[np.bool_]) -> None:
        """Keep account of pushes, of dents, and of how long bodies have been quiet."""
        self._pushed[rows] = np.where(pushed, np.maximum(self._pushed[rows] - h, 0.0), 0.0)
        self._pushed[rows[self._pushed[rows] < 1e-9]] = 0.0
        dented = rows[(self._sunk[rows] > 0.0) | pushed]
        if len(dented):
            depth = self._sunk[dented] - self._contacts.least[dented]
            grows = self._pushed[dented] > 0.0
            most = np.where(grows | pushed[np.isin(rows, dented)], np.inf, self._sunk[dented])
            self._sunk[dented] = np.clip(depth, 0.0, most)
            self._look(dented)
        state = self.state.some(rows)
        speed = np.sqrt(dot(state.v, state.v))
        speed += np.sqrt(dot(state.w, state.w)) * self.bodies.reach[rows]
        self._quiet[rows[(speed > QUIET) | (self._held[rows] == 0)]] = 0.0

    def _fall_asleep(self) -> None:
        """Let bodies sleep that have long been quiet."""
        propped = (self._held >= PROPPED) | (self.bodies.radius > 0.0)
        long = np.where(propped, QUIET_TIME, PROPPED_TIME)
        sleeps = self.awake & (self._quiet >= long)
        self.awake[sleeps] = False
        self.state.v[sleeps] = self.state.w[sleeps] = 0.0
