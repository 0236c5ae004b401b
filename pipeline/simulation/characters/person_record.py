"""Person record."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.records import zeros
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array

PELVIS, SPINE, SHOULDERS, HEAD = (JOINTS.index(n) for n in ("pelvis", "spine", "shoulders", "head"))

SHOULDER, ELBOW, HAND = (JOINTS.index(f"{n}_l") for n in ("shoulder", "elbow", "hand"))

HIP, KNEE, FOOT = (JOINTS.index(f"{n}_l") for n in ("hip", "knee", "foot"))
"""The left of two; the right one follows."""

COUNT = len(JOINTS)

STANCE, SWING = 0, 1
"""What a foot does."""

SWINGING, REACHING, PLACED, HUGGING = 0, 1, 2, 3
"""What an arm does: it swings along, is held out ahead, has its hand put somewhere in the world,
or that around somebody, with the elbow aside."""

STANDING, SITTING = 0, 1

AT_EASE, OUT = (0.02, np.radians(14.0)), 0.13
"""Of arms that hang: how far they swing ahead and bend [rad]; how far outward [rad]."""

LONGEST_ARM = 0.995
"""Of an arm, in the sum of its links."""

_SIZES = ("height", "thigh", "shin", "upper_arm", "forearm", "hips", "shoulders", "hip_height")

_MORE = ("ankle", "belly", "chest", "neck", "foot", "ball")

PERSON = np.dtype(
    [
        # Its number among the owners, its first node, and its first grip: left hand, right hand,
        # and both hands together.
        ("owner", "i8"),
        ("node", "i8"),
        ("grip", "i8"),
        # Lengths [m]: halves of hips and shoulders, of the leg's joints, of the trunk from
        # pelvis over spine to shoulders and head, of the foot, and from ankle to its ball.
        *((name, "f8") for name in (*_SIZES, *_MORE)),
        # Where its pelvis is led over the ground, how fast, and by what it is pushed there:
        # x and z [m], [m/s], [m/s²]; heading and how fast it turns [rad], [rad/s].
        ("at", "f8", 2),
        ("going", "f8", 2),
        ("gaining", "f8", 2),
        ("heading", "f8"),
        ("turning", "f8"),
        # The clock of the gait [cycles], whether it goes, and how much of a walk it is, 0 to 1.
        ("phase", "f8"),
        ("stepping", "?"),
        ("walking", "f8"),
        ("walking_rate", "f8"),
        # Of each foot: what it does, the ankle's place when flat on the ground and its yaw, both
        # where it stands or stood and where it will; height of its arch; pitch, toes up; how
        # long it has stood [cycles].
        ("doing", "i8", 2),
        ("stood", "f8", (2, 3)),
        ("left", "f8", (2, 3)),
        ("land", "f8", (2, 3)),
        ("yaw", "f8", 2),
        ("yaw_left", "f8", 2),
        ("yaw_land", "f8", 2),
        ("arch", "f8", 2),
        ("pitch", "f8", 2),
        ("pitch_left", "f8", 2),
        ("ankles", "f8", (2, 3)),
        # Of each that swings: where the pelvis looked when it left the ground, and where the other
        # foot was to stand, x and z, round which it goes [rad], [m].
        ("way_left", "f8", 2),
        ("pivot", "f8", (2, 2)),
        # Since it was last asked [s]; how often feet came down since then, the last time of each,
        # and with what speed [m/s].
        ("since", "f8"),
        ("landed", "i8", 2),
        ("landed_at", "f8", 2),
        ("landing", "f8", 2),
        # Ground that it goes by [m], [m/s]; lean of the trunk, along x and z; twist of the chest.
        ("floor", "f8"),
        ("floor_rate", "f8"),
        # How much lower the pelvis is than it would be, for a leg that stands is no longer [m].
        ("short", "f8"),
        ("lean", "f8", 2),
        ("lean_rate", "f8", 2),
        ("twist", "f8"),
        ("twist_rate", "f8"),
        # Where it looks: yaw in the world and pitch [rad], and their rates.
        ("gaze", "f8", 2),
        ("gaze_rate", "f8", 2),
        # How far it sits, 0 to 1; how far it bows, as a tangent, and crouches, as a part of its
        # legs, to reach what is low, and their rates.
        ("seated", "f8"),
        ("bow", "f8"),
        ("bow_rate", "f8"),
        ("crouch", "f8"),
        ("crouch_rate", "f8"),
        ("breath", "f8"),
        # Of each arm: how much its hand is where it is told to be, 0 to 1, and where that is in
        # the frame of the chest [m]; rates of both.
        ("told", "f8", 2),
        ("told_rate", "f8", 2),
        ("hand", "f8", (2, 3)),
        ("hand_rate", "f8", (2, 3)),
        # How far the arm goes round somebody, 0 to 1, and the rate.
        ("wraps", "f8", 2),
        ("wraps_rate", "f8", 2),
        # How much its muscles are slack after a blow, 0 to 1.
        ("dazed", "f8"),
        # Commands: a place to go to, whether it got there in this step, how near
        # is there [m]; the speed of its walk [m/s]; a
        # velocity that is added, from steering; a heading to stand in.
        ("goes", "?"),
        ("arrived", "?"),
        ("goal", "f8", 2),
        ("near", "f8"),
        ("pace", "f8"),
        ("aside", "f8", 2),
        # Whom it does not step aside for, by owner, -1 for nobody.
        ("partner", "i8"),
        ("faces", "?"),
        ("facing", "f8"),
        ("looks", "?"),
        ("look_at", "f8", 3),
        ("arm", "i8", 2),
        ("arm_at", "f8", (2, 3)),
        # How far its shoulders are to come down to somebody [m]; how much it leans on them, 0 to
        # 1, and the rate.
        ("down", "f8"),
        ("leans", "f8"),
        ("leans_rate", "f8"),
        ("posture", "i8"),
        ("seat", "f8", 3),
        ("frozen", "?"),
        # What control asks of its nodes: where they should be [m], and where
        # they should have been a sub-step ago.
        ("wanted", "f8", (COUNT, 3)),
        ("before", "f8", (COUNT, 3)),
    ],
    align=True,
)
"""A person."""


def persons_of(
    proportions: Sequence[Proportions],
    firsts: Sequence[int],
    at: Array,
    headings: Array,
    ground: Array,
) -> Records:
    """Return persons who stand at ease.

    Args:
        proportions: of each of n.
        firsts: number of the first node of each.
        at: (n, 2) x and z where each stands [m].
        headings: (n,) where each looks, positive turns about +Y [rad].
        ground: (n,) height of the ground there [m].
    """
    persons = zeros(len(proportions), PERSON)
    for i, (who, first) in enumerate(zip(proportions, firsts, strict=True)):
        _measure(persons[i], who)
        persons[i].node = first
        persons[i].heading = headings[i]
        persons[i].partner = -1
        persons[i].at[:] = at[i]
        persons[i].floor = ground[i]
        persons[i].gaze[:] = headings[i], 0.0
        persons[i].pace = 0.42 * np.sqrt(9.81 * persons[i].hip_height)
        nodes = standing(who, at[i], headings[i], ground[i])
        persons[i].wanted[:] = persons[i].before[:] = nodes
        for k in range(2):
            persons[i].stood[k] = persons[i].left[k] = persons[i].land[k] = nodes[FOOT + k]
            persons[i].ankles[k] = nodes[FOOT + k]
            persons[i].yaw[k] = persons[i].yaw_land[k] = persons[i].yaw_left[k] = headings[i]
    return persons


def standing(
    proportions: Proportions, at: NDArray[np.float64], heading: float, ground: float
) -> Array:
    """Return (16, 3) the nodes of one who stands at a place (x, z) [m]."""
    rest = at_ease(proportions)
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = rest.T
    return np.stack([at[0] + c * x + s * z, ground + y, at[1] - s * x + c * z], axis=1)


def at_ease(proportions: Proportions) -> Array:
    """Return (16, 3) the rest pose with arms that hang as they do before they swing [m]."""
    rest = proportions.rest()
    upper, lower = (proportions.height * x for x in (proportions.upper_arm, proportions.forearm))
    swing, bend = AT_EASE
    for k, side in enumerate((-1.0, 1.0)):
        ahead = upper * np.sin(swing) + lower * np.sin(swing + bend)
        down = upper * np.cos(swing) + lower * np.cos(swing + bend)
        along = np.array([ahead, -down * np.cos(OUT), side * down * np.sin(OUT)])
        size = float(np.sqrt((along * along).sum()))
        along /= size
        size = min(size, LONGEST_ARM * (upper + lower))
        back = np.array([along[1], -along[0], 0.28 * side])
        back -= (back * along).sum() * along
        part = (upper**2 - lower**2 + size**2) / (2.0 * size)
        aside = np.sqrt(upper**2 - part**2) / np.sqrt((back * back).sum())
        rest[ELBOW + k] = rest[SHOULDER + k] + part * along + aside * back
        rest[HAND + k] = rest[SHOULDER + k] + size * along
    return rest


def _measure(person: np.record, who: Proportions) -> None:
    """Write down lengths [m]."""
    fractions = {
        "height": 1.0,
        "thigh": who.hip - who.knee,
        "shin": who.knee - who.ankle,
        "upper_arm": who.upper_arm,
        "forearm": who.forearm,
        "hips": who.hips,
        "shoulders": who.shoulders,
        "hip_height": who.hip,
        "ankle": who.ankle,
        "belly": who.spine - who.hip,
        "chest": who.shoulder - who.spine,
        "neck": who.head - who.shoulder,
        "foot": who.foot,
        "ball": 0.48 * who.foot,
    }
    for name, fraction in fractions.items():
        setattr(person, name, fraction * who.height)
