"""Body frames: the fifteen frames that a person's meshes follow, from its sixteen joints.

A frame is named after its part of the body and starts at the joint before it. At rest
(`Proportions.rest`) no frame is turned: X forward, Y up, Z to the right. Joints leave the twist of
a limb open: a bent knee or elbow defines it, with its hinge along Z; a straight limb has the
least twist; between the two the one blends into the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.simulation.people.joint_limits import LIMP_ANKLE_PITCH, MAX_ANKLE_PITCH, MAX_NOD
from pipeline.simulation.people.proportions import (
    BACK_DEPTH,
    JOINTS,
    PALM_FRACTION,
    TRUNK_BREADTH,
    Proportions,
)
from pipeline.simulation.spatial import UP, Array, cross, normalized, turn, turn_inverse

FRAMES = (
    "pelvis",
    "chest",
    "head",
    "upper_arm_l",
    "upper_arm_r",
    "forearm_l",
    "forearm_r",
    "hand_l",
    "hand_r",
    "thigh_l",
    "thigh_r",
    "shin_l",
    "shin_r",
    "foot_l",
    "foot_r",
)
"""Names of the frames, in the order of their numbers."""

PARENTS = (-1, 0, 1, 1, 1, 3, 4, 5, 6, 0, 0, 9, 10, 11, 12)
"""Parent frames, -1 for none."""

ORIGINS = tuple(name for name in JOINTS if name != "head")
"""The joint at which each frame starts; that of the head is the neck, "shoulders"."""

HINGE_BEND = np.sin(np.radians(25.0))  # sine of the bend from which the hinge alone counts
LEAST_TWIST_WEIGHT = 0.5  # of the least twist of a straight limb, as the sine of a bend
HAND_RISE = 0.2  # of fingers that lie on a back, as a tangent
MAX_WRIST_BEND = np.radians(60.0)  # of a hand against its forearm
FOREARM_TWIST = 0.5  # share of the twist of a hand against its hinge that the forearm takes
LYING, NEAR = 0.03, 0.10
"""Distances of a palm from a trunk up to which it lies on it, and turns to it, in heights."""

ARM_SPREAD = normalized(np.array([1.0, -0.6, 0.7]))
LEG_SPREAD = normalized(np.array([1.0, -1.0, 0.15]))
"""Middle directions of right limbs. The least twist starts there, so that the one direction
without one lies behind the back."""

_DOWN, _Z = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def frame_origins(proportions: Proportions) -> Array:
    """Return (15, 3) the origins of the frames at rest [m]."""
    return proportions.rest()[[JOINTS.index(name) for name in ORIGINS]]


def frames_from_joints(
    joints: Array, gaze: Array | None = None, soles: Array | None = None
) -> tuple[Array, Array]:
    """Return the frames of persons from their joints.

    Args:
        joints: (..., 16, 3) in the order of `JOINTS` [m].
        gaze: (..., 3) direction of the gaze; ahead of the chest if left out.
        soles: (..., 2, 3) direction above the left and the right foot, such as the normal of the
            ground; up in the world if left out.

    Returns:
        The rotations (..., 15, 3, 3) and the origins (..., 15, 3) [m] in the order of `FRAMES`.
    """
    p = {name: joints[..., k, :] for k, name in enumerate(JOINTS)}
    R: dict[str, Array] = {}
    R["pelvis"] = _trunk_frames(p["hip_r"] - p["hip_l"], p["spine"] - p["pelvis"], upright=False)
    R["chest"] = _trunk_frames(
        p["shoulder_r"] - p["shoulder_l"], p["shoulders"] - p["spine"], upright=True
    )
    ahead = R["chest"][..., 0] if gaze is None else gaze
    R["head"] = _head_frames(p["head"] - p["shoulders"], ahead, R["chest"], nods=gaze is not None)
    for k, side in enumerate("lr"):
        mirror = np.array([1.0, 1.0, 1.0 if side == "r" else -1.0])
        arm = (p[f"shoulder_{side}"], p[f"elbow_{side}"], p[f"hand_{side}"])
        R[f"upper_arm_{side}"], R[f"forearm_{side}"] = _limb_frames(
            R["chest"], *arm, 1.0, ARM_SPREAD * mirror
        )
        R[f"hand_{side}"] = R[f"forearm_{side}"]
        leg = (p[f"hip_{side}"], p[f"knee_{side}"], p[f"foot_{side}"])
        R[f"thigh_{side}"], R[f"shin_{side}"] = _limb_frames(
            R["pelvis"], *leg, -1.0, LEG_SPREAD * mirror
        )
        sole = UP if soles is None else soles[..., k, :]
        R[f"foot_{side}"] = _foot_frames(R[f"shin_{side}"], sole)
    rotations = np.stack([R[name] for name in FRAMES], axis=-3)
    return rotations, joints[..., [JOINTS.index(name) for name in ORIGINS], :]


class Trunks(NamedTuple):
    """The trunks of n people, around which arms lie.

    Attributes:
        spines: (n, 3, 3) joints: pelvis, spine and shoulders [m].
        chests: (n, 3, 3) frames.
        heights: (n,) of the people [m].
    """

    spines: Array
    chests: Array
    heights: Array

    def surface(self, places: Array) -> tuple[Array, Array]:
        """Return the normals (n, 2, 3) and distances (n, 2) of places (n, 2, 3) from trunks [m].

        A trunk is an oval around its spine.
        """
        pelvis, spine, shoulders = (self.spines[:, None, k] for k in range(3))
        along = normalized(shoulders - pelvis)
        is_low = _dot(places - spine, along) < 0.0
        axis = normalized(np.where(is_low[..., None], spine - pelvis, shoulders - spine))
        ahead = self.chests[:, None, :, 0]
        ahead = normalized(ahead - _dot(ahead, axis)[..., None] * axis)
        right, offset = cross(ahead, axis), places - spine
        depth, breadth = (part * self.heights[:, None] for part in (BACK_DEPTH, TRUNK_BREADTH))
        x, z = _dot(offset, ahead), _dot(offset, right)
        normal = (x / depth**2)[..., None] * ahead + (z / breadth**2)[..., None] * right
        size = np.hypot(x / depth, z / breadth)
        distance = np.hypot(x, z) * (1.0 - 1.0 / np.maximum(size, 1e-3))
        return normalized(normal + 1e-9 * ahead), distance


def hands_on_trunks(
    forearms: Array, wrists: Array, lengths: Array, trunks: Trunks, share: Array
) -> tuple[Array, Array]:
    """Return the frames (n, 2, 3, 3) of forearms and of hands whose palms lie on trunks.

    Fingers go on around the trunk. Hands that are away from it continue their forearms.

    Args:
        forearms: (n, 2, 3, 3) of the left and the right one, turned by their hinges.
        wrists: (n, 2, 3) [m].
        lengths: (n,) of the hands [m].
        trunks: around which they lie.
        share: (n, 2) of an embrace, 0 to 1.
    """
    side = np.array([[-1.0], [1.0]])
    straight = -forearms[..., 1]
    fingers = straight
    for _ in range(3):
        palms = wrists + (PALM_FRACTION * lengths)[:, None, None] * fingers
        normals, distances = trunks.surface(palms)
        around = side * cross(np.broadcast_to(UP, normals.shape), normals)
        risen = around + HAND_RISE * UP + 0.5 * straight[..., 1:2] * UP
        flat = normalized(risen - _dot(risen, normals)[..., None] * normals)
        fingers = _bent_at_most(straight, flat, MAX_WRIST_BEND)
    outward = normalized(normals - _dot(normals, fingers)[..., None] * fingers)
    away = distances / trunks.heights[:, None]
    share = share * (1.0 - _smoothstep((away - LYING) / (NEAR - LYING)))
    lying = _hanging_frames(fingers, side * outward)
    # Without the bend of the wrist, the hand turns its forearm.
    unbent = np.stack([_swing_rotated(fingers, straight, lying[..., k]) for k in range(3)], axis=-1)
    return (
        _mixed_frames(forearms, unbent, FOREARM_TWIST * share),
        _mixed_frames(forearms, lying, share),
    )


def _bent_at_most(straight: Array, bent: Array, most: float) -> Array:
    """Return directions (..., 3) towards `bent`, at most an angle [rad] from `straight`."""
    aside = bent - _dot(bent, straight)[..., None] * straight
    angle = np.arctan2(np.sqrt(_dot(aside, aside)), _dot(bent, straight))
    kept = np.minimum(angle, most)[..., None]
    return np.cos(kept) * straight + np.sin(kept) * normalized(aside + 1e-12)


def _mixed_frames(own: Array, other: Array, share: Array) -> Array:
    """Return the frames (..., 3, 3) between two, with the share (...) of the other."""
    mixed = own + share[..., None, None] * (other - own)
    y = normalized(mixed[..., 1])
    x = normalized(cross(y, mixed[..., 2]))
    return np.stack([x, y, cross(x, y)], axis=-1)


def guided_arms(own: Array, guide: Array, share: Array) -> Array:
    """Return the frames (..., 6, 3, 3) of arms and hands with the twist that a guide gives them.

    Bones keep their directions, and hands follow the forearms as those of the guide do.

    Args:
        own: (..., 6, 3, 3) of upper arms, forearms and hands, the left one of each first.
        guide: (..., 6, 3, 3) likewise.
        share: (...) of the guide, 0 to 1.
    """
    turned = np.stack(
        [
            np.stack(
                [
                    _swing_rotated(
                        guide[..., bone, :, 1], own[..., bone, :, 1], guide[..., k, :, c]
                    )
                    for c in range(3)
                ],
                axis=-1,
            )
            for k, bone in enumerate((0, 1, 2, 3, 2, 3))
        ],
        axis=-3,
    )
    return _mixed_frames(own, turned, share[..., None])


def _trunk_frames(right: Array, up: Array, upright: bool) -> Array:
    """Return the frames (..., 3, 3) of a trunk along `up` if it is upright, else `right`."""
    if upright:
        y = normalized(up)
        x = normalized(cross(y, right))
        z = cross(x, y)
    else:
        z = normalized(right)
        x = normalized(cross(up, z))
        y = cross(z, x)
    return np.stack([x, y, z], axis=-1)


def _head_frames(neck: Array, gaze: Array, chest: Array, nods: bool) -> Array:
    """Return the frames of heads (..., 3, 3): turned about the neck, then nodding to the gaze."""
    y = normalized(neck)
    along = normalized(gaze)
    rise = _dot(along, y)
    # A gaze along the neck turns no head.
    z = normalized(cross(along - rise[..., None] * y + 1e-3 * chest[..., 0], y))
    x = cross(y, z)
    if not nods:
        return np.stack([x, y, z], axis=-1)
    angle = np.clip(np.arcsin(np.clip(rise, -1.0, 1.0)), -MAX_NOD, MAX_NOD)
    return _pitched(np.stack([x, y, z], axis=-1), angle)


def _limb_frames(
    parent: Array, root: Array, middle: Array, tip: Array, way: float, spread: Array
) -> tuple[Array, Array]:
    """Return the frames (..., 3, 3) of both links of a limb.

    Args:
        parent: (..., 3, 3) of the trunk.
        root: (..., 3) first joint [m].
        middle: (..., 3) elbow or knee [m].
        tip: (..., 3) last joint [m].
        way: 1 for a limb that bends forward, -1 back.
        spread: (3,) middle direction of the limb in the frame of the trunk.
    """
    upper, lower = normalized(middle - root), normalized(tip - middle)
    hinge = way * cross(upper, lower)
    bend = np.sqrt(_dot(hinge, hinge))
    weight = LEAST_TWIST_WEIGHT * (1.0 - _smoothstep(bend / HINGE_BEND))
    straight_hinge = turn(parent, _least_twist_hinge(turn_inverse(parent, upper), spread))
    hinge = hinge + weight[..., None] * straight_hinge
    return _hanging_frames(upper, hinge), _hanging_frames(lower, hinge)


def _least_twist_hinge(along: Array, spread: Array) -> Array:
    """Return the hinge (..., 3) of straight limbs along directions (..., 3).

    It is turned by the smallest rotation from `spread`, and from hanging to that likewise.
    """
    return _swing_rotated(spread, along, _swing_rotated(_DOWN, spread, _Z))


def _swing_rotated(a: Array, b: Array, v: Array) -> Array:
    """Return `v` turned by the smallest rotation that takes `a` to `b`, all (..., 3).

    `a` and `b` are unit vectors. With c = a · b and w = a × b it is
    v + w × v + w × (w × v) / (1 + c).
    """
    a, b, v = np.broadcast_arrays(a, b, v)
    w = cross(a, b)
    turned = cross(w, v)
    again: Array = cross(w, turned) / np.maximum(1.0 + _dot(a, b), 1e-9)[..., None]
    return v + turned + again


def _hanging_frames(along: Array, hinge: Array) -> Array:
    """Return frames (..., 3, 3) that hang along a direction, with Z nearest to the hinge."""
    y = -along
    x = normalized(cross(y, hinge))
    return np.stack([x, y, cross(x, y)], axis=-1)


def _foot_frames(shin: Array, sole: Array) -> Array:
    """Return the frames of feet (..., 3, 3), pitched about the ankle so that the sole lies flat.

    Where it would turn too far, as in lying, the ankle lets go.
    """
    up = turn_inverse(shin, np.broadcast_to(sole, shin.shape[:-1]))
    angle = np.arctan2(-up[..., 0], up[..., 1])
    limited = np.minimum(np.abs(angle), MAX_ANKLE_PITCH)
    kept = np.clip(
        (LIMP_ANKLE_PITCH - np.abs(angle)) / (LIMP_ANKLE_PITCH - MAX_ANKLE_PITCH), 0.0, 1.0
    )
    return _pitched(shin, np.sign(angle) * limited * kept)


def _pitched(R: Array, angle: Array) -> Array:
    """Return frames turned by an angle (...,) about their own Z."""
    x, y, z = R[..., 0], R[..., 1], R[..., 2]
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)


def _smoothstep(s: Array) -> Array:
    s = np.clip(s, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def _dot(a: Array, b: Array) -> Array:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
