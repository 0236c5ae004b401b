"""Limits and preferred values of joints, by kind of appendage and as the author overrides them.

An insect is created flat, fully extended. The preferred value of a joint so near its full
extension is altered, so that a limb at rest is bent and away from the singularity (Sims 1987, 5.2
and 6.3.1). A mammal's limbs keep the bends that they were drawn with, and those drawn straight are
bent a little. Positive pitch raises a limb or swings it forward; an inner joint of a leg bends one
way only, as a knee does.
"""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import Problem, SceneError
from pipeline.simulation.figures.network import ARM, FEELER, HEAD, HORN, LEG, TAIL, WING
from pipeline.simulation.spatial import Array
from pipeline.spec.figure import JointSettings

LEG_RISE_DEG = 24.0
"""Elevation of the first link of an insect's leg at rest."""

LEG_FALL_DEG = (-54.0, -72.0)
"""Elevations of the second and the last link of an insect's leg at rest: over the knee and
steeply down."""

STRAIGHT_LIMIT_DEG = 8.0
"""A joint drawn with a smaller bend counts as straight."""

REST_BEND_DEG, COLUMN_BEND_DEG = {LEG: -22.0, ARM: 26.0}, -18.0
"""Rest bend of limbs drawn straight, and of legs with straight knees, as those of people: knees
bend backward, elbows forward."""

LEVEL, SOLE_AHEAD = 0.6, 0.5
"""Sine of the slope up to which a foot stands on its sole, and the part of the sole that lies
before its hip at rest, so that the weight is over its middle."""

HIP_PITCH_DEG = 125.0
"""How far a mammal's hip or shoulder swings forward and back, as a person's thigh that comes up to
the belly. A folded leg needs it where its foot is far ahead or behind: a hip at its limit would
turn aside instead, all at once."""

MAX_BEND_DEG = {LEG: 160.0, ARM: 150.0}
"""Greatest bend of knees and elbows from straight: calf on thigh, forearm on upper arm."""

NECK_PITCH_DEG = (-50.0, 85.0, 50.0)
"""Lowest, highest and rest elevation of the neck of a mammal whose body is level."""

NOD_DEG = (-115.0, 30.0, -68.0)
"""Limits and rest of the bend between that neck and the last link of its head."""

HORN_RISE_DEG, HORN_TILT_DEG = 60.0, 40.0
"""Rest pitch of a horn that was drawn to the side, and how much more of one drawn backward."""

HORN_PITCH_DEG, HORN_YAW_DEG = (-30.0, 150.0), 60.0
"""How far a horn that stands tilts along the way it was drawn, and to either side of that."""

SHOULDER_ROLL_DEG = (-35.0, 150.0, 6.0)
"""A mammal's shoulder inward, outward, and at rest, clear of the body."""

WRIST_DEG = (-60.0, 70.0, 8.0)
"""A wrist back, forward, and at rest; unlike an elbow it bends both ways."""


FOOT_LENGTH = 0.35
"""Length up to which the last link of a leg is a foot, in that of the leg."""

ANKLE_BACK_DEG = 55.0
"""How far an ankle bends past the straight."""

FOOT_ITERATIONS = 8
"""Of the ankle at rest, which moves the foot by little beside its own turn."""


@dataclass(frozen=True, slots=True)
class JointRange:
    """Limits and values of one joint; zero is as created [rad].

    Attributes:
        lower, upper: limits.
        preferred: value at rest.
        extended: value at which its links are straightest.
    """

    lower: float
    upper: float
    preferred: float
    extended: float = 0.0


def range_in_degrees(
    lower: float, upper: float, preferred: float, extended: float = 0.0
) -> JointRange:
    """Return a range given in degrees."""
    return JointRange(*(math.radians(angle) for angle in (lower, upper, preferred, extended)))


ROOT_RANGES = {
    HEAD: (
        range_in_degrees(-60, 60, 0),
        range_in_degrees(-50, 50, -8),
        range_in_degrees(-40, 40, 0),
    ),
    TAIL: (
        range_in_degrees(-60, 60, 0),
        range_in_degrees(-40, 70, 6),
        range_in_degrees(-40, 40, 0),
    ),
    FEELER: (
        range_in_degrees(-40, 40, 0),
        range_in_degrees(-30, 80, 34),
        range_in_degrees(-40, 40, 0),
    ),
    HORN: (
        range_in_degrees(-90, 90, 0),
        range_in_degrees(-120, 160, 60),
        range_in_degrees(-90, 90, 0),
    ),
    WING: (
        range_in_degrees(-60, 60, 0),
        range_in_degrees(-80, 85, 16),
        range_in_degrees(-60, 60, 0),
    ),
    ARM: (
        range_in_degrees(-80, 80, 0),
        range_in_degrees(-80, 80, 32),
        range_in_degrees(-60, 60, 0),
    ),
}
"""Yaw, pitch and roll at the root of appendages other than legs."""

BEND_RANGES = {
    HEAD: range_in_degrees(-50, 50, 0),
    TAIL: range_in_degrees(-60, 60, 4),
    FEELER: range_in_degrees(-70, 40, -24),
    HORN: range_in_degrees(-60, 60, 0),
    WING: range_in_degrees(-120, 40, -14),
    ARM: range_in_degrees(-150, 0, -20),
}
"""Inner joints of appendages other than legs."""


SHOULDER_RANGES = {"pitch": range_in_degrees(-60, 170, 4), "yaw": range_in_degrees(-80, 80, 0)}
"""A mammal's shoulder: back and forward, and about the arm. As a person's, whose arms reach
farther than most (American Academy of Orthopaedic Surgeons 1965)."""


def insect_joint_ranges(kind: str, links: int) -> list[dict[str, JointRange]]:
    """Return the joints at each node of an insect's appendage but its tip, in order.

    Args:
        kind: leg, arm, head, tail, feeler, horn or wing.
        links: number of links of the appendage.
    """
    if kind != LEG:
        return _root_and_bends(kind, links)
    elevations = insect_leg_elevations(links)
    base = {
        "yaw": range_in_degrees(-75, 75, 0),
        "pitch": range_in_degrees(-85, 88, elevations[0]),
        "roll": range_in_degrees(-55, 55, 0),
    }
    bends = (after - before for before, after in itertools.pairwise(elevations))
    return [base] + [{"bend": range_in_degrees(-165, 0, bend)} for bend in bends]


def _root_and_bends(kind: str, links: int) -> list[dict[str, JointRange]]:
    yaw, pitch, roll = ROOT_RANGES[kind]
    bends = [{"bend": BEND_RANGES[kind]} for _ in range(links - 1)]
    return [{"yaw": yaw, "pitch": pitch, "roll": roll}, *bends]


def insect_leg_elevations(links: int) -> list[float]:
    """Return the link elevations of an insect's leg at rest, from hip to foot [degrees].

    A leg of one link leans outward.
    """
    if links == 1:
        return [-50.0]
    if links == 2:
        return [LEG_RISE_DEG, LEG_FALL_DEG[1]]
    second, last = LEG_FALL_DEG
    step = (last - second) / (links - 2)
    return [LEG_RISE_DEG] + [second + step * i for i in range(links - 1)]


def raised_neck(ranges: list[dict[str, JointRange]]) -> list[dict[str, JointRange]]:
    """Return the joints of a mammal's neck, held up, with its head nodding.

    A neck has two links or more; a head of one link stays as it is.
    """
    if len(ranges) < 2:
        return ranges
    lower, upper, rest = NECK_PITCH_DEG
    base = {**ranges[0], "pitch": range_in_degrees(lower, upper, rest)}
    lower, upper, rest = NOD_DEG
    return [base, *ranges[1:-1], {"bend": range_in_degrees(lower, upper, rest)}]


def mammal_joint_ranges(
    kind: str, side: str, steps: Array, splay: float = 0.0
) -> list[dict[str, JointRange]]:
    """Return the joints at each node of a mammal's appendage but its tip, in order.

    Args:
        kind: leg, arm, head, tail, feeler, horn or wing.
        side: l, m or r.
        steps: (n, 3) its links in the creation frame, from base to tip [m].
        splay: how far to the side a leg's foot stands, because its base is on the midline [m].
    """
    if kind == HORN:
        return _standing_twig(steps)
    if kind not in REST_BEND_DEG:
        return _root_and_bends(kind, len(steps))
    # In the plane in which the limb swings: forward, and down.
    angles = np.unwrap(np.arctan2(steps[:, 0], -steps[:, 1]))
    bends = np.degrees(np.diff(angles)).tolist()
    is_column = kind == LEG and len(bends) > 0 and abs(bends[0]) < STRAIGHT_LIMIT_DEG
    rest = COLUMN_BEND_DEG if is_column else REST_BEND_DEG[kind]
    inner = [_inner_range(kind, bend, rest) for bend in bends]
    if kind == ARM:
        base = {
            "pitch": SHOULDER_RANGES["pitch"],
            "roll": _shoulder_roll(side),
            "yaw": SHOULDER_RANGES["yaw"],
        }
        if len(inner) > 1:
            inner[-1] = _wrist_range(math.degrees(inner[-1].extended))
    else:
        if len(inner) > 1 and is_foot(float(np.linalg.norm(steps[-1])), steps):
            inner[-1] = _ankle_range(inner[-1])
            if any(knee.preferred for knee in inner[:-1]):
                inner[-1] = _with_foot_as_drawn(steps, angles, inner)
        # The foot of a leg drawn back over its own hip cannot come under it.
        under = math.degrees(_hip_pitch(steps, angles, inner))
        most = HIP_PITCH_DEG
        base = {"pitch": range_in_degrees(-most, most, min(max(under, -most), most))}
        roll = _splay_deg(side, splay, steps) if splay else 0.0
        base |= {"roll": range_in_degrees(-40, 40, roll), "yaw": range_in_degrees(-45, 45, 0)}
    return [base, *({"bend": stance} for stance in inner)]


def _splay_deg(side: str, splay: float, steps: Array) -> float:
    """Return the roll of a hip whose foot stands `splay` [m] to the side, positive on the left."""
    length = float(np.linalg.norm(steps, axis=-1).sum())
    return {"l": 1.0, "r": -1.0}.get(side, 0.0) * math.degrees(math.asin(min(splay / length, 0.5)))


def _standing_twig(steps: Array) -> list[dict[str, JointRange]]:
    """Return the joints of a horn, which stands on its head wherever it was drawn to.

    It pitches before it yaws: upright it would lie along the axis of a yaw that came first, and
    could not be turned aside.
    """
    root, *bends = _root_and_bends(HORN, len(steps))
    ahead = float(steps[0, 0] / max(np.linalg.norm(steps[0]), 1e-12))
    pitch = range_in_degrees(*HORN_PITCH_DEG, HORN_RISE_DEG - HORN_TILT_DEG * ahead)
    yaw = range_in_degrees(-HORN_YAW_DEG, HORN_YAW_DEG, 0)
    return [{"pitch": pitch, "yaw": yaw, "roll": root["roll"]}, *bends]


def _shoulder_roll(side: str) -> JointRange:
    """Return the roll of a shoulder, positive towards the left."""
    inward, outward, rest = SHOULDER_ROLL_DEG
    if side == "l":
        return range_in_degrees(inward, outward, rest)
    if side == "r":
        return range_in_degrees(-outward, -inward, -rest)
    return range_in_degrees(inward, -inward, 0.0)


def _wrist_range(straight: float) -> JointRange:
    """Return the range of a wrist whose hand continues the forearm at `straight` [degrees]."""
    back, forward, rest = WRIST_DEG
    if abs(straight) >= STRAIGHT_LIMIT_DEG:
        rest = -straight
    # The drawn bend is always within the limits.
    lower, upper = min(straight + back, 0.0), max(straight + forward, 0.0)
    return range_in_degrees(lower, upper, straight + rest, straight)


def is_foot(length: float, steps: Array) -> bool:
    """Return whether a last link of that length is the foot of a leg with links (n, 3) [m]."""
    return length < FOOT_LENGTH * float(np.linalg.norm(steps, axis=-1).sum())


def _has_sole(steps: Array) -> bool:
    """Return whether a leg with links (n, 3) after its hip stands on its sole [m]."""
    foot = float(np.linalg.norm(steps[-1]))
    return len(steps) > 2 and is_foot(foot, steps) and abs(float(steps[-1, 1])) < LEVEL * foot


def _ankle_range(knee: JointRange) -> JointRange:
    """Return the range of an ankle or fetlock, which unlike a knee bends both ways."""
    beyond = math.copysign(math.radians(ANKLE_BACK_DEG), knee.extended - knee.preferred)
    far = knee.extended + beyond
    return replace(knee, lower=min(knee.lower, far), upper=max(knee.upper, far))


def _with_foot_as_drawn(steps: Array, angles: Array, inner: Sequence[JointRange]) -> JointRange:
    """Return the range of an ankle whose foot stands as it was drawn under a straight leg.

    The knee of a leg that was drawn straight rests bent, and would tilt the foot.
    """
    ankle, (ahead, up) = inner[-1], steps[:-1, :2].sum(axis=0).tolist()
    wanted = float(angles[-1]) - math.atan2(ahead, -up)
    for _ in range(FOOT_ITERATIONS):
        bends = [*inner[:-1], ankle]
        turned = float(angles[-1]) + sum(stance.preferred for stance in bends)
        tilt = turned + _hip_pitch(steps, angles, bends) - wanted
        rest = min(max(ankle.preferred - tilt, ankle.lower), ankle.upper)
        ankle = replace(ankle, preferred=rest)
    return ankle


def _hip_pitch(steps: Array, angles: Array, inner: Sequence[JointRange]) -> float:
    """Return the pitch of a hip that brings the resting foot under it [rad].

    Of a foot that stands on its sole, its middle.
    """
    turned = angles + np.cumsum([0.0, *(stance.preferred for stance in inner)])
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    across, along = lengths * np.sin(turned), lengths * np.cos(turned)
    pitch = -math.atan2(float(across.sum()), float(along.sum()))
    if _has_sole(steps) and abs(math.cos(float(turned[-1]) + pitch)) < LEVEL:
        across[-1], along[-1] = SOLE_AHEAD * across[-1], SOLE_AHEAD * along[-1]
        pitch = -math.atan2(float(across.sum()), float(along.sum()))
    return pitch


def _inner_range(kind: str, bend: float, straight_rest: float) -> JointRange:
    """Return the range of an inner joint drawn with `bend`.

    Args:
        kind: of the limb.
        bend: [degrees].
        straight_rest: bend at rest of one drawn straight [degrees].
    """
    rest = straight_rest if abs(bend) < STRAIGHT_LIMIT_DEG else 0.0
    way = math.copysign(1.0, rest or bend)
    # The drawn bend is always within the limits.
    far = -bend + way * max(MAX_BEND_DEG[kind], abs(bend))
    return range_in_degrees(min(-bend, far), max(-bend, far), rest, -bend)


@dataclass(frozen=True, eq=False)
class AdjustedJoints:
    """Ranges of all joints, and which of them slide."""

    ranges: list[JointRange]
    prismatic: NDArray[np.bool_]


def apply_joint_overrides(
    overrides: Mapping[str, Mapping[str, JointSettings]],
    names: Sequence[str],
    ranges: Sequence[JointRange],
    scale: float,
) -> AdjustedJoints:
    """Return joint ranges with an author's overrides applied.

    Args:
        overrides: by limb and joint.
        names: of the joints, "limb.joint".
        ranges: by style.
        scale: factor from the drawing to the world, for sliding joints.

    Raises:
        SceneError: an override names no joint, or a joint rests outside its limits.
    """
    by_name = {
        f"{limb}.{joint}": w for limb, joints in overrides.items() for joint, w in joints.items()
    }
    problems = [
        Problem(f"joints.{name}", f"the figure has no such joint{_name_hint(name, names)}")
        for name in by_name
        if name not in names
    ]
    result = [
        _override(by_name[name], stance, scale) if name in by_name else stance
        for name, stance in zip(names, ranges, strict=True)
    ]
    problems += [
        Problem(f"joints.{name}", "rests outside its limits")
        for name, stance in zip(names, result, strict=True)
        if not stance.lower <= stance.preferred <= stance.upper
    ]
    if problems:
        raise SceneError(problems)
    slides = [name in by_name and by_name[name].slide is not None for name in names]
    return AdjustedJoints(result, np.array(slides, dtype=bool))


def _override(config: JointSettings, joint_range: JointRange, scale: float) -> JointRange:
    if config.slide is not None:
        lower, upper = (scale * value for value in config.slide)
        # As drawn, if nothing else is said: a leg that rests drawn in cannot shorten for its steps.
        rest = min(max(0.0, lower), upper) if config.rest is None else scale * config.rest
        return JointRange(lower, upper, rest, upper)
    if config.limits_deg is not None:
        lower, upper = (math.radians(value) for value in config.limits_deg)
        rest = min(max(joint_range.preferred, lower), upper)
        joint_range = replace(joint_range, lower=lower, upper=upper, preferred=rest)
    if config.rest_deg is not None:
        joint_range = replace(joint_range, preferred=math.radians(config.rest_deg))
    return joint_range


def _name_hint(name: str, names: Sequence[str]) -> str:
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.0)
    return f", did you mean '{close[0]}'?" if close else ": it has no joints"
