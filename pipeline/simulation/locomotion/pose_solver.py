"""Posing: from what a herd does to where all its parts are, for many moments at once.

Bodies follow their path, feet their swings or their footholds, and inverse kinematics
joins the two. None of it feeds back into the walking, so it is worked out for dozens of
moments together, which costs a fraction of doing it step by step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.curves import ease, hinge
from pipeline.simulation.figures.figure_posture import FigureFrames, GoalMiss
from pipeline.simulation.figures.rest_ik import RestSolution, solve_near_rest
from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.body_motion.free_limb_motion import FreeLimbMotion
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion, LookTarget
from pipeline.simulation.locomotion.body_motion.give import BodySuspension
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.body_motion.pelvis_height import (
    Going,
    Touches,
    Yielding,
)
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.gaits.spread import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import NodeTable
from pipeline.simulation.locomotion.leaping.jump_handover import JumpHandover, JumpingBody
from pipeline.simulation.locomotion.pronking.swing_depenetration import LegSolver
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory, Ways
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    lowest_center_height,
    swing_positions,
)
from pipeline.simulation.spatial import Array, turn, unturn
from pipeline.simulation.take import Note

SLIP = 1e-4
"""Distance between foot and foothold that is worth a note [m]."""

YIELDS = 0.25
"""Part of a swing, at either end, in which bodies come to give way to a foot; in between the
foot gives way."""

REINED = 1.01 * MAX_REACH
"""How far a leg stretches at most in the air, as a part of its length."""

TUCKED, BACK = 0.3, 0.12
"""How high a foot is held up, and how far back, as parts of its leg."""


@dataclass(frozen=True, slots=True, eq=False)
class HerdSnapshot:
    """The state of a herd at one step; see `Walkers` for its parts, and `BodyMotion`."""

    step: int
    gone: Array
    drive: Array
    vigour: Array
    start: Array
    end: Array
    height: Array
    lifted: Array
    span: Array
    swinging: NDArray[np.bool_]
    stoop: Array
    tuck: Array
    bearing: MotionStyle
    ways: Ways
    routes: Sequence[Route]
    looks: Mapping[int, LookTarget]
    bend: Array | None = None
    aloft: Mapping[int, JumpingBody] = field(default_factory=dict)


ALONE = ("step", "bearing", "ways", "routes", "looks", "bend", "aloft")
ARRAYS = tuple(name for name in HerdSnapshot.__slots__ if name not in ALONE)
"""What of a moment is arrays, to be stacked."""


@dataclass(frozen=True, eq=False)
class Poses:
    """Where everything is at n moments.

    Attributes:
        positions: (n, J, 3) of the nodes [m].
        rotations: (n, J, 3, 3).
        values: (n, K) of the channels.
        notes: feet that do not come to their places.
    """

    positions: Array
    rotations: Array
    values: Array
    notes: list[Note]


class PoseSolver:
    """Works out the poses of one herd."""

    def __init__(
        self,
        herd: Herd,
        path: BodyTrajectory,
        idlers: FreeJoints,
        table: NodeTable,
        postures: AuthoredPoses,
        clock: Clock,
    ) -> None:
        self.herd = herd
        self.path = path
        self.idlers = idlers
        self.table = table
        self.postures = postures
        self.dt = clock.dt
        self.row_dt = clock.dt * clock.steps / clock.samples
        self.yielding = Yielding(herd, path)
        self.give = BodySuspension(herd, self.row_dt)
        self.carriage = FreeLimbMotion(herd, idlers, path.ground, self.row_dt)
        self._last = np.zeros(len(idlers.owner))

    def poses(self, moments: Sequence[HerdSnapshot]) -> Poses:
        """Return where everything is at `moments`, throughout which all have the same ways."""
        herd, n = self.herd, len(moments)
        steps = np.array([moment.step for moment in moments])
        gone, drive, vigour, start, end, height, lifted, span, swinging, stoop, tuck = (
            np.stack([getattr(moment, name) for moment in moments]) for name in ARRAYS
        )
        way, phase = gone[:, 0], gone[:, 1]
        s = _swung(herd, phase, lifted, span, swinging)
        ends = start.reshape(-1, 3), end.reshape(-1, 3)
        tips = swing_positions(*ends, height.ravel(), s.ravel(), _bends(moments)).reshape(
            start.shape
        )
        creature = np.tile(np.arange(len(herd.names)), n)
        bearing = MotionStyle.stacked([moment.bearing for moment in moments])
        R, p = self.path.pose(
            creature, way.ravel(), phase.ravel(), vigour.ravel(), bearing.body_pitch.ravel()
        )
        R_WB, p_WB = R.reshape(n, -1, 3, 3), p.reshape(n, -1, 3)
        planned = p_WB[..., 1].copy()
        p_WB[..., 1] -= _stooped(herd, stoop, s)
        tall = self.path.paces.value("body_height", creature, phase.ravel()).reshape(phase.shape)
        carried = JumpHandover(herd, [moment.aloft for moment in moments])
        carried.bodies(R_WB, p_WB)
        self.give.apply(R_WB, p_WB)
        around = self._posed_bodies(steps * self.dt, way, tall, R_WB, p_WB)
        free = self.postures.free(steps * self.dt)
        if tuck.any():
            up = _between(tuck, s)
            free = free * (1.0 - up)
            tips = tips + up[..., None] * (self._tucked(tall, R_WB, p_WB) - tips)
        aloft = ease(np.clip(np.minimum(s, 1.0 - s) / YIELDS, 0.0, 1.0))
        grip = free * (1.0 - aloft)
        going = Going(way, phase, drive, vigour, bearing.body_pitch.reshape(n, -1), planned)
        touches = Touches(lifted + span, YIELDS * span, end, stoop[:, 1], swinging)
        self.yielding.give_way(R_WB, p_WB, tips, (grip, free), going, touches)
        tips = self._reined(tips, R_WB, p_WB, aloft, swinging)
        carried.bodies(R_WB, p_WB)
        tips = carried.feet(tips)
        goals = unturn(R_WB[:, herd.owner], tips - p_WB[:, herd.owner])
        solution = self._settled(goals, R_WB, p_WB, carried)
        residual = np.where(carried.down, solution.residual, 0.0)
        routes, looks = [m.routes for m in moments], [m.looks for m in moments]
        q_idle = self.carriage.values(
            BodyMotion(steps * self.dt, way, phase, drive, bearing, routes, looks, R_WB, p_WB)
        )
        q_legs, X_legs = solution.q, solution.X_BJ
        self.postures.keep_feet(goals, q_legs, residual)
        q_idle = self._held(q_idle, carried.limp)
        X_idle = self.idlers.tree.pose(q_idle)
        misses = self.postures.move_joints(around, (q_legs, X_legs), (q_idle, X_idle))
        X_BN = self.table.poses(X_legs.reshape(n, -1, 4, 4), X_idle)
        R_own = R_WB[:, self.table.owner]
        speed = self._speeds(creature, phase) * drive
        carried.speeds(speed)
        return Poses(
            positions=p_WB[:, self.table.owner] + turn(R_own, X_BN[..., :3, 3]),
            rotations=R_own @ X_BN[..., :3, :3],
            values=np.concatenate(
                [np.mod(phase, 1.0), speed, q_legs[:, herd.legs.is_joint], q_idle], axis=1
            ),
            notes=[
                *(self._slipped(steps, residual, *at) for at in np.argwhere(residual > SLIP)),
                *(self._missed(steps, c, miss) for c, miss in misses),
            ],
        )

    def _settled(
        self, goals: Array, R_WB: Array, p_WB: Array, carried: JumpHandover
    ) -> RestSolution:
        """Return legs at goals (n, L, 3) relative to their bodies; see `LegSolver`."""
        herd = self.herd
        if carried.down.all():
            return solve_near_rest(herd.legs, herd.chains, goals)
        reaching = LegSolver(herd, self.path.ground, self.yielding.folds)
        limp = carried.limp[:, herd.owner]
        return reaching.solve(goals, R_WB, p_WB, carried.down, limp)

    def _held(self, q: Array, limp: NDArray[np.bool_]) -> Array:
        """Return joint values (n, M) that stay what they were on those who have fallen."""
        for row in np.flatnonzero(limp.any(axis=1)).tolist():
            before, fallen = q[row - 1] if row else self._last, limp[row, self.idlers.owner]
            q[row, fallen] = before[fallen]
        self._last = q[-1].copy()
        return q

    def _reined(
        self,
        tips: Array,
        R_WB: Array,
        p_WB: Array,
        aloft: Array,
        swinging: NDArray[np.bool_],
    ) -> Array:
        """Return tips (n, L, 3) of feet in the air so that no leg stretches or folds too far [m].

        Args:
            tips: (n, L, 3) where they would be [m].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies [m].
            aloft: (n, L) how far feet give way to bodies, 0 to 1.
            swinging: (n, L) which are in the air.
        """
        herd = self.herd
        way = tips - (p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], herd.hips))
        far = np.sqrt((way * way).sum(axis=-1))
        width = 0.01 * herd.legs.lengths
        beyond = np.where(swinging, hinge(far - REINED * herd.legs.lengths, width), 0.0)
        beyond -= np.minimum(aloft / YIELDS, 1.0) * hinge(self.yielding.folds - far, width)
        shorter = beyond / np.maximum(far, 1e-9)
        result: Array = tips - shorter[..., None] * way
        down = result[..., 1] < tips[..., 1]
        if down.any():
            # What a folded leg wants away from its hip must not be pressed into the ground.
            (x, y, z), soles = result[down].T, np.broadcast_to(herd.sole, down.shape)[down]
            least = lowest_center_height(self.path.ground, x, z, soles)
            result[down, 1] = np.maximum(y, np.minimum(least, tips[down, 1]))
        return result

    def _tucked(self, tall: Array, R_WB: Array, p_WB: Array) -> Array:
        """Return where tips (n, L, 3) are held up [m]."""
        herd = self.herd
        x, z = herd.rest.T
        height = TUCKED * herd.legs.lengths - tall[:, herd.owner]
        back = np.broadcast_to(x - BACK * herd.legs.lengths, height.shape)
        held = np.stack([back, height, np.broadcast_to(z, height.shape)], axis=-1)
        return p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], held)

    def _speeds(self, creature: NDArray[np.int64], phase: Array) -> Array:
        """Return how fast creatures go at full drive (n, C) [m/s]."""
        paces, at = self.path.paces, phase.ravel()
        speeds = paces.value("stride", creature, at) / paces.value("cycle", creature, at)
        return speeds.reshape(phase.shape)

    def _posed_bodies(
        self, times: Array, way: Array, tall: Array, R_WB: Array, p_WB: Array
    ) -> dict[int, FigureFrames]:
        """Put bodies where they are asked to be; return what that is relative to."""
        if not self.postures.of:
            return {}
        creature = np.tile(np.arange(way.shape[1]), len(way))
        turned = self.path.on_route(creature, way.ravel())[1].reshape(way.shape)
        grounds = {
            c: self.postures.ground(turned[:, c], p_WB[:, c], tall[:, c]) for c in self.postures.of
        }
        self.postures.move_bodies(times, turned, R_WB, p_WB)
        return {
            c: FigureFrames(times, self.row_dt, R_WB[:, c], p_WB[:, c], *ground)
            for c, ground in grounds.items()
        }

    def _missed(self, steps: NDArray[np.int64], c: int, miss: GoalMiss) -> Note:
        text = f"{100.0 * miss.gap:.2g} % of its length from what it is asked for"
        return Note("clamped", int(steps[miss.row]), f"{self.herd.names[c]}.{miss.limb}", text)

    def _slipped(self, steps: NDArray[np.int64], residual: Array, row: int, leg: int) -> Note:
        name = f"{self.herd.names[self.herd.owner[leg]]}.{self.herd.leg_names[leg]}"
        gap = float(residual[row, leg]) * 1000.0
        return Note("clamped", int(steps[row]), name, f"{gap:.2g} mm from its foothold")


def _bends(moments: Sequence[HerdSnapshot]) -> Array | None:
    """Return the bends of all swings of all moments, one after the other, if there are any."""
    bends = [moment.bend for moment in moments if moment.bend is not None]
    return np.concatenate(bends) if bends else None


def _swung(
    herd: Herd, phase: Array, lifted: Array, span: Array, swinging: NDArray[np.bool_]
) -> Array:
    """Return the part of its swing that each foot has done (n, L); 1 where it stands."""
    s = (phase[:, herd.owner] - lifted) / span
    return np.where(swinging, np.minimum(np.maximum(s, 0.0), 1.0), 1.0)


def _between(values: Array, s: Array) -> Array:
    """Return values (n, L) that go from values[:, 0] to values[:, 1] within each swing."""
    before, after = values[:, 0], values[:, 1]
    return before + ease(s) * (after - before)


def _stooped(herd: Herd, stoop: Array, s: Array) -> Array:
    """Return how far the bodies are lowered (n, C) for their feet's footholds [m].

    It comes and goes within the swings before and after; the norm of order 4 is never
    less than the greatest and changes smoothly where another becomes the greatest.
    """
    wanted = _between(stoop, s) ** 4
    sums = np.zeros((len(s), len(herd.names)))
    for owners, legs in herd.tiers:
        sums[:, owners] += wanted[:, legs]
    result: Array = np.sqrt(np.sqrt(sums))
    return result
