"""Body frames."""

from __future__ import annotations

import numpy as np

from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import UP, Array, cross, normalized, turn, unturn

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
"""Their names, in the order of their numbers."""

PARENTS = (-1, 0, 1, 1, 1, 3, 4, 5, 6, 0, 0, 9, 10, 11, 12)
"""The frame that each hangs on, -1 for none."""

ORIGINS = (
    "pelvis",
    "spine",
    "shoulders",
    "shoulder_l",
    "shoulder_r",
    "elbow_l",
    "elbow_r",
    "hand_l",
    "hand_r",
    "hip_l",
    "hip_r",
    "knee_l",
    "knee_r",
    "foot_l",
    "foot_r",
)
"""The joint at which each begins."""

STRAIGHT = np.sin(np.radians(25.0))
"""Sine of the bend from which on the hinge alone says how a limb is turned."""

GUIDED = 0.5
"""How much a straight limb is held to the turn of least effort, as the sine of a bend."""

NOD = np.radians(50.0)
"""How far a head looks up or down against its neck, at most."""

CLASP = 1.3
"""How far hands bend inward that lie around somebody, as a tangent across straight forearms."""

LEVEL, LIMP = np.radians(45.0), np.radians(110.0)
"""How far an ankle turns to put a sole down, and at which angle it no longer tries."""

ARM_SPREAD = normalized(np.array([1.0, -0.6, 0.7]))

LEG_SPREAD = normalized(np.array([1.0, -1.0, 0.15]))
"""Where a right limb points in the middle of where it may point: the turn of least effort is from
there, so that the one direction for which there is none lies behind the back."""

_DOWN, _Z = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def frame_origins(proportions: Proportions) -> Array:
    """Return (15, 3) where the frames begin at rest [m]."""
    return proportions.rest()[[JOINTS.index(name) for name in ORIGINS]]


def frames_of(
    joints: Array, gaze: Array | None = None, soles: Array | None = None
) -> tuple[Array, Array]:
    """Return the frames of persons whose sixteen places are known.

    Args:
        joints: (..., 16, 3) in the order of `JOINTS` [m].
        gaze: (..., 3) where the face looks, a direction; straight on from the chest if left out.
        soles: (..., 2, 3) what is up for the left and the right foot, such as the normal of the
            ground under it; up in the world if left out.

    Returns:
        The rotations (..., 15, 3, 3) and the origins (..., 15, 3) [m] in the order of `FRAMES`.
    """
    p = {name: joints[..., k, :] for k, name in enumerate(JOINTS)}
    R: dict[str, Array] = {}
    R["pelvis"] = _facing(p["hip_r"] - p["hip_l"], p["spine"] - p["pelvis"], upright=False)
    R["chest"] = _facing(
        p["shoulder_r"] - p["shoulder_l"], p["shoulders"] - p["spine"], upright=True
    )
    ahead = R["chest"][..., 0] if gaze is None else gaze
    R["head"] = _head(p["head"] - p["shoulders"], ahead, R["chest"], nods=gaze is not None)
    for k, side in enumerate("lr"):
        mirror = np.array([1.0, 1.0, 1.0 if side == "r" else -1.0])
        arm = (p[f"shoulder_{side}"], p[f"elbow_{side}"], p[f"hand_{side}"])
        R[f"upper_arm_{side}"], R[f"forearm_{side}"] = _limb(
            R["chest"], *arm, 1.0, ARM_SPREAD * mirror
        )
        R[f"hand_{side}"] = R[f"forearm_{side}"]
        leg = (p[f"hip_{side}"], p[f"knee_{side}"], p[f"foot_{side}"])
        R[f"thigh_{side}"], R[f"shin_{side}"] = _limb(R["pelvis"], *leg, -1.0, LEG_SPREAD * mirror)
        sole = UP if soles is None else soles[..., k, :]
        R[f"foot_{side}"] = _foot(R[f"shin_{side}"], sole)
    rotations = np.stack([R[name] for name in FRAMES], axis=-3)
    return rotations, joints[..., [JOINTS.index(name) for name in ORIGINS], :]


def closed(forearms: Array, chest: Array, share: Array) -> Array:
    """Return the frames (..., 2, 3, 3) of hands that lie around somebody.

    Args:
        forearms: (..., 2, 3, 3) frames of the left and the right one, which hands go on straight.
        chest: (..., 3, 3) frame of the chest.
        share: (..., 2) how much they bend inward, 0 to 1.
    """
    along = -forearms[..., 1]
    inward = chest[..., None, :, 2] * np.array([[1.0], [-1.0]])
    bent = normalized(along + CLASP * share[..., None] * inward)
    return np.stack([_swung(along, bent, forearms[..., k]) for k in range(3)], axis=-1)


def _facing(right: Array, up: Array, upright: bool) -> Array:
    """Return the frames (..., 3, 3) of a trunk; what it is true to is `up` or `right`."""
    if upright:
        y = normalized(up)
        x = normalized(cross(y, right))
        z = cross(x, y)
    else:
        z = normalized(right)
        x = normalized(cross(up, z))
        y = cross(z, x)
    return np.stack([x, y, z], axis=-1)


def _head(neck: Array, gaze: Array, chest: Array, nods: bool) -> Array:
    """Return the frames of heads (..., 3, 3): turned about the neck, then nodding to the gaze."""
    y = normalized(neck)
    along = normalized(gaze)
    rise = _dot(along, y)
    # A gaze along the neck turns no head.
    level = along - rise[..., None] * y + 1e-3 * chest[..., 0]
    z = normalized(cross(level, y))
    x = cross(y, z)
    if not nods:
        return np.stack([x, y, z], axis=-1)
    angle = np.clip(np.arcsin(np.clip(rise, -1.0, 1.0)), -NOD, NOD)
    return _pitched(np.stack([x, y, z], axis=-1), angle)


def _limb(
    parent: Array, root: Array, middle: Array, tip: Array, way: float, spread: Array
) -> tuple[Array, Array]:
    """Return the frames (..., 3, 3) of both links of a limb.

    Args:
        parent: (..., 3, 3) what it hangs on.
        root: (..., 3) its first joint [m].
        middle: (..., 3) elbow or knee [m].
        tip: (..., 3) its last [m].
        way: 1 if it bends forward, -1 if it bends back.
        spread: (3,) the middle of where it may point, in the frame of what it hangs on.
    """
    upper, lower = normalized(middle - root), normalized(tip - middle)
    hinge = way * cross(upper, lower)
    bend = np.sqrt(_dot(hinge, hinge))
    guided = GUIDED * (1.0 - _smooth(bend / STRAIGHT))
    least = turn(parent, _least_turned(unturn(parent, upper), spread))
    hinge = hinge + guided[..., None] * least
    return _hanging(upper, hinge), _hanging(lower, hinge)


def _least_turned(along: Array, spread: Array) -> Array:
    """Return where the hinge (..., 3) of straight limbs is that point `along` (..., 3).

    By the smallest rotation from `spread`, to which the limb came from hanging in the same way.
    """
    return _swung(spread, along, _swung(_DOWN, spread, _Z))


def _swung(a: Array, b: Array, v: Array) -> Array:
    """Return `v` turned by the smallest rotation that takes `a` to `b`, all (..., 3).

    `a` and `b` have length one. With c = a · b and w = a × b it is
    v + w × v + w × (w × v) / (1 + c).
    """
    a, b, v = np.broadcast_arrays(a, b, v)
    w = cross(a, b)
    turned = cross(w, v)
    again: Array = cross(w, turned) / np.maximum(1.0 + _dot(a, b), 1e-9)[..., None]
    return v + turned + again


def _hanging(along: Array, hinge: Array) -> Array:
    """Return frames (..., 3, 3) that hang `along`, their Z as near the hinge as can be."""
    y = -along
    x = normalized(cross(y, hinge))
    return np.stack([x, y, cross(x, y)], axis=-1)


def _foot(shin: Array, sole: Array) -> Array:
    """Return the frames of feet (..., 3, 3): pitched about the ankle so that the sole lies flat.

    Where it would have to turn too far, as of one who lies, the ankle lets go.
    """
    up = unturn(shin, np.broadcast_to(sole, shin.shape[:-1]))
    angle = np.arctan2(-up[..., 0], up[..., 1])
    least = np.minimum(np.abs(angle), LEVEL)
    left = np.clip((LIMP - np.abs(angle)) / (LIMP - LEVEL), 0.0, 1.0)
    return _pitched(shin, np.sign(angle) * least * left)


def _pitched(R: Array, angle: Array) -> Array:
    """Return frames turned by `angle` (...,) about their own Z."""
    x, y, z = R[..., 0], R[..., 1], R[..., 2]
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)


def _smooth(s: Array) -> Array:
    s = np.clip(s, 0.0, 1.0)
    result: Array = s * s * (3.0 - 2.0 * s)
    return result


def _dot(a: Array, b: Array) -> Array:
    result: Array = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return result
