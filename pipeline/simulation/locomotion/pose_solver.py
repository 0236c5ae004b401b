"""Pose solver: the poses of all nodes of a herd, for many moments at once.

Bodies follow their trajectories, feet their swings or footholds, and inverse kinematics joins the
two. Nothing of it feeds back into the walking, so dozens of moments are solved together, at a
fraction of the cost of single steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.clock import Clock
from pipeline.simulation.curves import ease, hinge
from pipeline.simulation.figures.figure_frames import FigureFrames
from pipeline.simulation.figures.goal_miss import GoalMiss
from pipeline.simulation.figures.tip_ik import TipSolution, solve_tips
from pipeline.simulation.locomotion.authored_poses import AuthoredPoses
from pipeline.simulation.locomotion.body_motion.damped_springs import BodySuspension
from pipeline.simulation.locomotion.body_motion.foot_roll import FootRoll, Steps
from pipeline.simulation.locomotion.body_motion.free_limb_motion import FreeLimbMotion
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion, LookTarget
from pipeline.simulation.locomotion.body_motion.idle_motion import FreeJoints
from pipeline.simulation.locomotion.body_motion.limb_avoidance import LimbAvoidance
from pipeline.simulation.locomotion.body_motion.pelvis_height import (
    SUPPORT_FRACTION,
    PelvisHeight,
    PlannedMotion,
)
from pipeline.simulation.locomotion.dancing.walker_dances import (
    DancingBody,
    move_arms,
    turn_trunks,
)
from pipeline.simulation.locomotion.foot_state import FootState, present_lowering
from pipeline.simulation.locomotion.gaits.moods import MotionStyle
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.inventory import NodeTable
from pipeline.simulation.locomotion.leaping.jump_handover import JumpHandover, JumpingBody
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory, RouteSet
from pipeline.simulation.locomotion.routes.route import Route
from pipeline.simulation.locomotion.routes.route_progress import ProgressSample
from pipeline.simulation.locomotion.swing.swing_depenetration import LegSolver
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    lowest_center_height,
    part_of_path,
    swing_positions,
)
from pipeline.simulation.spatial import Array, heading, turn, turn_inverse
from pipeline.simulation.take import TakeNote

# Distance between foot and foothold that is noted [m].
NOTED_MISS = 1e-4

# Greatest extension of a leg in the air, as a fraction of its length.
MAX_SWING_REACH = 1.01 * MAX_REACH

# Height above the ground at which feet pass that give way to their legs, in their radii.
CLEARANCE = 0.15

# Height of a foot that is held up, and how far it is drawn back, in leg lengths.
HELD_HEIGHT, HELD_BACK = 0.3, 0.12


@dataclass(frozen=True, slots=True, eq=False)
class HerdSnapshot:
    """The state of a herd at one step; see `RouteProgress` and `FootState`.

    Attributes:
        step: number of the step.
        progress: on the routes.
        stride_part, smoothed_fraction: (C,) distance of a cycle in strides, and speed fraction
            that bodies show.
        feet: (L,) where they are.
        style: (C,) of the motion.
        route_set: routes of the creatures.
        routes: along which they look.
        look_targets: by creature.
        aloft: jumping creatures.
        dances: dancing creatures.
    """

    step: int
    progress: ProgressSample
    stride_part: Array
    smoothed_fraction: Array
    feet: FootState
    style: MotionStyle
    route_set: RouteSet
    routes: Sequence[Route]
    look_targets: Mapping[int, LookTarget]
    aloft: Mapping[int, JumpingBody]
    dances: Mapping[int, DancingBody]


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of everything at n moments.

    Attributes:
        positions: (n, J, 3) of the nodes [m].
        rotations: (n, J, 3, 3).
        values: (n, K) of the channels.
        notes: about feet that miss their places.
    """

    positions: Array
    rotations: Array
    values: Array
    notes: list[TakeNote]


class PoseSolver:
    """Solves the poses of one herd."""

    def __init__(
        self,
        herd: Herd,
        trajectory: BodyTrajectory,
        free_joints: FreeJoints,
        table: NodeTable,
        authored: AuthoredPoses,
        clock: Clock,
    ) -> None:
        self.herd, self.trajectory, self.table = herd, trajectory, table
        self.free_joints, self.authored = free_joints, authored
        self.dt = clock.dt
        self.row_dt = clock.dt * clock.steps / clock.samples
        self.pelvis_height = PelvisHeight(herd, trajectory)
        self.suspension = BodySuspension(herd, self.row_dt)
        self.foot_roll = FootRoll(herd, trajectory.ground)
        self.free_limbs = FreeLimbMotion(herd, free_joints, trajectory.ground, self.row_dt)
        self.avoidance = LimbAvoidance(
            list(herd.figures),
            free_joints,
            authored.surroundings,
            herd.body_height,
            self.row_dt,
        )
        self._last_free = np.zeros(len(free_joints.owner))

    def solve(self, moments: Sequence[HerdSnapshot]) -> Poses:
        """Return the poses at `moments`, throughout which all keep their routes."""
        herd, n = self.herd, len(moments)
        times = np.array([moment.step for moment in moments]) * self.dt
        samples = zip(*(moment.progress for moment in moments), strict=True)
        progress = ProgressSample(*(np.stack(arrays) for arrays in samples))
        distance, phase, speed_fraction = progress
        smoothed = np.stack([moment.smoothed_fraction for moment in moments])
        style = MotionStyle.stacked([moment.style for moment in moments])
        feet = FootState.stacked([moment.feet for moment in moments])
        s = _swing_fractions(herd, phase, feet)
        R_WB, p_WB = self._planned_bodies(distance, phase, smoothed, style)
        planned = R_WB.copy(), p_WB[..., 1].copy()
        part = np.stack([moment.stride_part for moment in moments])
        motion = PlannedMotion(progress, part, smoothed, style.body_pitch, *planned)
        p_WB[..., 1] -= total_lowering(herd, feet, phase, s)
        tall = self._pace_values("body_height", phase)
        jumps = JumpHandover(herd, [moment.aloft for moment in moments])
        jumps.bodies(R_WB, p_WB)
        self.suspension.apply(R_WB, p_WB)
        dances = [moment.dances for moment in moments]
        turn_trunks(dances, R_WB, p_WB)
        around = self._pose_authored_bodies(times, distance, tall, R_WB, p_WB)
        tips = self._tips(feet, s, tall, motion, times, R_WB, p_WB)
        jumps.bodies(R_WB, p_WB)
        tips = jumps.feet(tips)
        goals = turn_inverse(R_WB[:, herd.owner], tips - p_WB[:, herd.owner])
        bodies = R_WB, p_WB
        steps = Steps(feet, s, jumps.walking_weights())
        directions = self.foot_roll.directions(tips, bodies, jumps.limp, steps)
        legs = self._solve_legs(goals, directions, R_WB, p_WB, jumps)
        # A foot in the air has no foothold to miss: its leg follows it as far as it can.
        residual = np.where(jumps.down & ~feet.swinging, legs.residual, 0.0)
        routes, targets = [m.routes for m in moments], [m.look_targets for m in moments]
        q_free = self.free_limbs.values(
            BodyMotion(
                times,
                distance,
                phase,
                speed_fraction,
                self._pace_values("running", phase),
                style,
                routes,
                targets,
                R_WB,
                p_WB,
            )
        )
        stride, cycle = (self._pace_values(name, phase) for name in ("stride", "cycle"))
        speed = stride / cycle * speed_fraction
        v_WB = speed[..., None] * R_WB[..., 0]
        q_free = self.avoidance.apply(times, q_free, R_WB, p_WB, v_WB)
        q_free = self._frozen(q_free, jumps.limp)
        move_arms(dances, q_free)
        X_free = self.free_joints.tree.pose(q_free)
        misses = self.authored.move_joints(around, (legs.q, legs.X_BJ), (q_free, X_free))
        X_BN = self.table.poses(legs.X_BJ.reshape(n, -1, 4, 4), X_free)
        R_own = R_WB[:, self.table.owner]
        jumps.speeds(speed)
        q_legs = legs.q[:, herd.legs.is_joint]
        return Poses(
            positions=p_WB[:, self.table.owner] + turn(R_own, X_BN[..., :3, 3]),
            rotations=R_own @ X_BN[..., :3, :3],
            values=np.concatenate([np.mod(phase, 1.0), speed, q_legs, q_free], axis=1),
            notes=self._notes([moment.step for moment in moments], residual, misses),
        )

    # --- bodies ---------------------------------------------------------------------

    def _planned_bodies(
        self, distance: Array, phase: Array, smoothed: Array, style: MotionStyle
    ) -> tuple[Array, Array]:
        """Return R_WB (n, C, 3, 3) and p_WB (n, C, 3) of the trajectories [m]."""
        n, count = distance.shape
        state = (values.ravel() for values in (distance, phase, smoothed, style.body_pitch))
        R, p = self.trajectory.pose(np.tile(np.arange(count), n), *state)
        return R.reshape(n, -1, 3, 3), p.reshape(n, -1, 3)

    def _pace_values(self, name: str, phase: Array) -> Array:
        """Return the pace parameter `name` (n, C) at phases (n, C)."""
        creature = np.tile(np.arange(phase.shape[1]), len(phase))
        return self.trajectory.paces.value(name, creature, phase.ravel()).reshape(phase.shape)

    def _pose_authored_bodies(
        self, times: Array, distance: Array, tall: Array, R_WB: Array, p_WB: Array
    ) -> dict[int, FigureFrames]:
        """Move bodies to their authored poses; return the surroundings of their creatures."""
        if not self.authored.postures:
            return {}
        creature = np.tile(np.arange(distance.shape[1]), len(distance))
        headings = self.trajectory.on_route(creature, distance.ravel())[1].reshape(distance.shape)
        grounds = {}
        for c in self.authored.postures:
            p_WG = p_WB[:, c].copy()
            p_WG[:, 1] -= tall[:, c]
            grounds[c] = heading(headings[:, c]), p_WG
        self.authored.move_bodies(times, headings, R_WB, p_WB)
        return {
            c: FigureFrames(times, self.row_dt, R_WB[:, c], p_WB[:, c], *ground)
            for c, ground in grounds.items()
        }

    # --- legs -----------------------------------------------------------------------

    def _tips(
        self,
        feet: FootState,
        s: Array,
        tall: Array,
        motion: PlannedMotion,
        times: Array,
        R_WB: Array,
        p_WB: Array,
    ) -> Array:
        """Return the tips (n, L, 3), and raise and lower the bodies for them [m].

        Args:
            feet: at n moments.
            s: (n, L) fractions of the swings.
            tall: (n, C) heights of the bodies above the ground [m].
            motion: planned for the bodies.
            times: (n,) since the start [s].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies; positions are changed [m].
        """
        ends = feet.start.reshape(-1, 3), feet.end.reshape(-1, 3)
        bend = None if feet.bend is None else feet.bend.reshape(-1, *feet.bend.shape[2:])
        tips = swing_positions(*ends, feet.swing_height.ravel(), s.ravel(), bend).reshape(
            feet.start.shape
        )
        free = self.authored.free_fraction(times)
        if feet.held_up.any():
            up = _between(feet.held_up, s)
            free = free * (1.0 - up)
            tips = tips + up[..., None] * (self._held_tips(tall, R_WB, p_WB) - tips)
        airborne = ease(np.clip(np.minimum(s, 1.0 - s) / SUPPORT_FRACTION, 0.0, 1.0))
        support = free * (1.0 - airborne), free
        self.pelvis_height.correct(R_WB, p_WB, tips, support, motion, feet)
        return self._within_reach(tips, R_WB, p_WB, airborne, feet.swinging)

    def _within_reach(
        self,
        tips: Array,
        R_WB: Array,
        p_WB: Array,
        airborne: Array,
        swinging: NDArray[np.bool_],
    ) -> Array:
        """Return tips (n, L, 3) of feet in the air so that no leg stretches or folds too far [m].

        Args:
            tips: (n, L, 3) [m].
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies [m].
            airborne: (n, L) how far feet give way to bodies, 0 to 1.
            swinging: (n, L) feet in the air.
        """
        herd = self.herd
        from_hip = tips - (p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], herd.hips))
        far = np.sqrt((from_hip * from_hip).sum(axis=-1))
        width = 0.01 * herd.legs.lengths
        beyond = hinge(far - MAX_SWING_REACH * herd.legs.lengths, width)
        beyond = np.where(swinging, beyond, 0.0)
        part = np.minimum(airborne / SUPPORT_FRACTION, 1.0)
        beyond -= part * hinge(self.pelvis_height.shortest - far, width)
        shorter = beyond / np.maximum(far, 1e-9)
        result: Array = tips - shorter[..., None] * from_hip
        moved = beyond != 0.0
        if moved.any():
            # Feet must not be pressed into the ground, nor pushed aside into a slope.
            (x, y, z), foot_radii = (
                result[moved].T,
                np.broadcast_to(herd.foot_radius, moved.shape)[moved],
            )
            least = lowest_center_height(self.trajectory.ground, x, z, foot_radii)
            # Steps of the ground may lie between the places that this looks at.
            least += np.minimum(np.abs(beyond[moved]), CLEARANCE * foot_radii)
            result[moved, 1] = np.maximum(y, least)
        return result

    def _held_tips(self, tall: Array, R_WB: Array, p_WB: Array) -> Array:
        """Return the tips (n, L, 3) of feet that are held up [m]."""
        herd = self.herd
        x, z = herd.rest.T
        height = HELD_HEIGHT * herd.legs.lengths - tall[:, herd.owner]
        back = np.broadcast_to(x - HELD_BACK * herd.legs.lengths, height.shape)
        held = np.stack([back, height, np.broadcast_to(z, height.shape)], axis=-1)
        return p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], held)

    def _solve_legs(
        self,
        goals: Array,
        directions: Array | None,
        R_WB: Array,
        p_WB: Array,
        jumps: JumpHandover,
    ) -> TipSolution:
        """Return the legs at goals (n, L, 3) relative to their bodies; see `LegSolver`."""
        herd = self.herd
        if jumps.down.all():
            return solve_tips(herd.legs, herd.chains, goals, directions)
        shortest = self.pelvis_height.shortest
        reaching = LegSolver(herd, self.trajectory.ground, shortest, directions)
        limp = jumps.limp[:, herd.owner]
        return reaching.solve(goals, R_WB, p_WB, jumps.down, limp)

    # --- joints and channels ----------------------------------------------------------

    def _frozen(self, q: Array, limp: NDArray[np.bool_]) -> Array:
        """Return values of free joints (n, M) that stay as they were on fallen creatures."""
        for row in np.flatnonzero(limp.any(axis=1)).tolist():
            before = q[row - 1] if row else self._last_free
            fallen = limp[row, self.free_joints.owner]
            q[row, fallen] = before[fallen]
        self._last_free = q[-1].copy()
        return q

    def _notes(
        self,
        steps: Sequence[int],
        residual: Array,
        misses: Sequence[tuple[int, GoalMiss]],
    ) -> list[TakeNote]:
        """Return notes about feet (n, L) that miss their footholds [m], and about other limbs."""
        herd, notes = self.herd, list[TakeNote]()
        for row, leg in np.argwhere(residual > NOTED_MISS):
            name = f"{herd.names[herd.owner[leg]]}.{herd.leg_names[leg]}"
            text = f"misses its foothold by {1000.0 * float(residual[row, leg]):.2g} mm"
            notes.append(TakeNote("clamped", steps[row], name, text))
        for c, miss in misses:
            part = f"{herd.names[c]}.{miss.limb}"
            notes.append(TakeNote("missed_key", steps[miss.row], part, miss.text))
        return notes


def _swing_fractions(herd: Herd, phase: Array, feet: FootState) -> Array:
    """Return the part of its path that each foot has done (n, L); 1 where it stands."""
    s = (phase[:, herd.owner] - feet.lift_phase) / feet.swing_length
    s = part_of_path(np.minimum(np.maximum(s, 0.0), 1.0), feet.swing_length)
    return np.where(feet.swinging, s, 1.0)


def _between(values: Array, s: Array) -> Array:
    """Return values (n, L) that go from values[:, 0] to values[:, 1] within each swing."""
    before, after = values[:, 0], values[:, 1]
    return before + ease(s) * (after - before)


def total_lowering(herd: Herd, feet: FootState, phase: Array, s: Array) -> Array:
    """Return how far the bodies are lowered (n, C) for their feet's footholds [m].

    The norm of order 4 is never less than the greatest and has no corner where another one becomes
    that.

    Args:
        herd: the creatures.
        feet: (n, L) where they are.
        phase: (n, C) of the bodies.
        s: (n, L) fractions of the swings.
    """
    wanted = present_lowering(feet, phase[:, herd.owner], s) ** 4
    sums = np.zeros((len(s), len(herd.names)))
    for owners, legs in herd.legs_by_rank:
        sums[:, owners] += wanted[:, legs]
    return np.sqrt(np.sqrt(sums))
