"""Pelvis height: raises and lowers bodies so that no leg is folded or stretched too far.

This covers what no plan foresaw: a body rises where a leg would fold too far, and sinks where one
would be overstretched. A body in flight is caught at touchdown: a foot in the air that reaches
ahead does not pull it down, because it comes down by itself; it is lowered by as much as the leg is
stretched at touchdown, from a while before to a while after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.curves import ease, hinge
from pipeline.simulation.locomotion.foot_placement.leg_reachability import shortest_reaches
from pipeline.simulation.locomotion.foot_state import FootState
from pipeline.simulation.locomotion.gaits.stride_limits import MAX_REACH
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.routes.body_trajectory import BodyTrajectory
from pipeline.simulation.locomotion.routes.route_progress import ProgressSample
from pipeline.simulation.spatial import Array, turn

# Stretch or fold over which the correction sets in, in leg lengths.
ROUNDING = 0.02

# Part of a swing, at either end, in which bodies begin to give way to a foot; in between the foot
# gives way to them. Bodies in flight are low for a touchdown as long before and after it.
SUPPORT_FRACTION = 0.25

# Hip-to-foot distance at a contact, in leg lengths, from which on a leg may be stretched too far.
NEARLY_STRETCHED = 0.85


@dataclass(frozen=True, eq=False)
class PlannedMotion:
    """The planned motion of bodies at n moments; see `BodyTrajectory.pose`.

    Attributes:
        progress: (n, C) on the routes.
        stride_part: (n, C) distance of a cycle, in strides.
        smoothed_fraction: (n, C) speed fraction that bodies show.
        style_pitch: (n, C) of the motion style [rad].
        R_WB, height: (n, C, 3, 3) and (n, C), of the trajectory [m].
    """

    progress: ProgressSample
    stride_part: Array
    smoothed_fraction: Array
    style_pitch: Array
    R_WB: Array
    height: Array


class PelvisHeight:
    """Corrects the heights of the bodies of a herd.

    Attributes:
        shortest: (L,) least hip-to-foot distances [m].
    """

    def __init__(self, herd: Herd, trajectory: BodyTrajectory) -> None:
        self.herd, self.trajectory = herd, trajectory
        self.shortest = shortest_reaches(herd)

    def correct(
        self,
        R_WB: Array,
        p_WB: Array,
        tips: Array,
        support: tuple[Array, Array],
        motion: PlannedMotion,
        feet: FootState,
    ) -> None:
        """Raise and lower bodies as their legs need it.

        Args:
            R_WB: (n, C, 3, 3) and
            p_WB: (n, C, 3), poses of the bodies; positions are changed [m].
            tips: (n, L, 3) of the legs [m].
            support: (n, L) how far feet count as standing, 0 to 1, and how far they would if they
                were down.
            motion: of the bodies.
            feet: (n, L) where they are.
        """
        herd, (standing, free) = self.herd, support
        lengths = herd.legs.lengths
        hips = p_WB[:, herd.owner] + turn(R_WB[:, herd.owner], herd.hips)
        raised = _greatest(herd, standing * self._overfold(hips, tips))
        p_WB[..., 1] += raised
        hips[..., 1] += raised[:, herd.owner]
        # A foot in the air stretches its leg no more than when it lifted, or comes down.
        stretch = np.where(feet.swinging, 0.0, standing * _overstretch(hips, tips, lengths))
        turned = np.swapaxes(motion.R_WB, -1, -2) @ R_WB
        lowered = np.maximum(motion.height - p_WB[..., 1], 0.0)
        down_at = feet.lift_phase + feet.swing_length
        lift_at = np.where(feet.swinging, feet.lift_phase, feet.next_lift)
        lift = np.where(feet.swinging[..., None], feet.start, feet.end)
        lowering = np.where(feet.swinging, feet.lowering[:, 0], feet.lowering[:, 1])
        for contact in ((lift_at, lift, lowering), (down_at, feet.end, feet.lowering[:, 1])):
            near = self._stretched_at(contact[:2], hips, motion, feet)
            if near.any():
                catch = self._catch(near, motion, contact, (turned, lowered), feet.swing_length)
                stretch[near] = np.maximum(stretch[near], free[near] * catch)
        p_WB[..., 1] -= _greatest(herd, stretch)

    def _stretched_at(
        self, contact: tuple[Array, Array], hips: Array, motion: PlannedMotion, feet: FootState
    ) -> NDArray[np.bool_]:
        """Return which legs (n, L) may be stretched too far at a contact that is near.

        Args:
            contact: phases (n, L) and places (n, L, 3) of the contacts [m].
            hips: (n, L, 3) [m].
            motion: of the bodies.
            feet: (n, L) where they are.
        """
        herd, (at, place) = self.herd, contact
        away = at - motion.progress.phase[:, herd.owner]
        near: NDArray[np.bool_] = np.abs(away) < SUPPORT_FRACTION * feet.swing_length
        row, leg = np.nonzero(near)
        c = herd.owner[leg]
        ahead = away[near] * herd.stride[c] * motion.stride_part[row, c]
        from_hip = place[near] - hips[near] - ahead[:, None] * motion.R_WB[row, c, :, 0]
        far = np.sqrt((from_hip * from_hip).sum(axis=-1))
        near[near] = far > NEARLY_STRETCHED * herd.legs.lengths[leg]
        return near

    def _overfold(self, hips: Array, tips: Array) -> Array:
        """Return how much too low hips (n, L, 3) are for tips (n, L, 3) [m]."""
        across = ((tips - hips)[..., [0, 2]] ** 2).sum(axis=-1) / self.shortest**2
        # Less towards the rim, so that nothing jumps where a foot comes under the hip.
        below = np.maximum(1.0 - across, 0.0) ** 2
        least = tips[..., 1] + self.shortest * np.sqrt(below)
        return below * hinge(least - hips[..., 1], ROUNDING * self.herd.legs.lengths)

    def _catch(
        self,
        near: NDArray[np.bool_],
        motion: PlannedMotion,
        contact: tuple[Array, Array, Array],
        moved: tuple[Array, Array],
        swing_length: Array,
    ) -> Array:
        """Return by how much bodies must be lowered around contacts (N,) [m].

        Args:
            near: (n, L) legs near their contact, N in all.
            motion: of the bodies, which continues to the contact.
            contact: phases (n, L), places (n, L, 3) and lowering (n, L) of the contacts [m].
            moved: how bodies are turned from their trajectories (n, C, 3, 3), and how far they are
                below them (n, C) [m].
            swing_length: (n, L) in cycles.
        """
        herd, trajectory, (turned, lowered) = self.herd, self.trajectory, moved
        row, leg = np.nonzero(near)
        c = herd.owner[leg]
        at, place, lowering = (values[near] for values in contact)
        here = motion.progress.phase[row, c]
        stride = trajectory.paces.value("stride", c, here)
        ahead = (at - here) * stride * motion.stride_part[row, c]
        R_WB, p_WB = trajectory.pose(
            c,
            motion.progress.distance[row, c] + ahead,
            at,
            motion.smoothed_fraction[row, c],
            motion.style_pitch[row, c],
        )
        hips = p_WB + turn(R_WB @ turned[row, c], herd.hips[leg])
        hips[:, 1] -= np.maximum(lowered[row, c], lowering)
        stretch = _overstretch(hips, place, herd.legs.lengths[leg])
        apart = np.abs(here - at) / (SUPPORT_FRACTION * swing_length[near])
        return stretch * (1.0 - ease(apart))


def _overstretch(hips: Array, tips: Array, lengths: Array) -> Array:
    """Return how much too high hips (..., 3) are for tips (..., 3) of legs this long [m]."""
    across = ((tips - hips)[..., [0, 2]] ** 2).sum(axis=-1)
    highest = tips[..., 1] + np.sqrt(np.maximum((MAX_REACH * lengths) ** 2 - across, 0.0))
    return hinge(hips[..., 1] - highest, ROUNDING * lengths)


def _greatest(herd: Herd, values: Array) -> Array:
    """Return the greatest (n, C) of the values (n, L) of each creature's legs."""
    result = np.zeros((len(values), len(herd.names)))
    for owners, legs in herd.legs_by_rank:
        result[:, owners] = np.maximum(result[:, owners], values[:, legs])
    return result
