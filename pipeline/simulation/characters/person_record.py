"""Person record: the state of compiled control, one record for each acting person.

A person has sixteen consecutive nodes, in the order of `JOINTS`. Left is 0 and right is 1 wherever
there are two of something.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.dynamics.compiled import Records
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.people.guided_dance import GUIDED_FRAMES, GUIDED_JOINTS
from pipeline.simulation.people.proportions import JOINTS, Proportions
from pipeline.simulation.spatial import Array

PELVIS, SPINE, SHOULDERS, HEAD = (JOINTS.index(n) for n in ("pelvis", "spine", "shoulders", "head"))
SHOULDER, ELBOW, HAND = (JOINTS.index(f"{n}_l") for n in ("shoulder", "elbow", "hand"))
HIP, KNEE, FOOT = (JOINTS.index(f"{n}_l") for n in ("hip", "knee", "foot"))
NODE_COUNT = len(JOINTS)
"""Places of the joints behind a person's first node; of two the left one, the right one follows."""

STANCE, SWING = 0, 1
"""States of a foot."""

SWINGING, REACHING, PLACED, HUGGING = 0, 1, 2, 3
"""Modes of an arm: it swings along, is held out ahead, or has its hand at a place in the world;
in a hug with the elbow aside."""

STANDING, SITTING = 0, 1
"""Postures."""

HANG_SWING, HANG_BEND, HANG_OUTWARD = 0.02, np.radians(14.0), 0.13
"""Angles of hanging arms: ahead, in the elbow, outward [rad]."""

STANDING_DUTY = 0.72
"""Stance fraction of a cycle of the slowest walk."""

WALKING_FROUDE = 0.42
"""Speed of a usual walk, in √(g l)."""

MAX_ARM_STRETCH = 0.995
"""Longest reach of an arm, in the sum of its links."""

LENGTHS = (
    *("height", "thigh", "shin", "upper_arm", "forearm", "hips", "shoulders", "hip_height"),
    *("ankle", "belly", "chest", "neck", "foot", "ball"),
)
"""Lengths of a person [m]: `hips` and `shoulders` are half widths, `ball` is from ankle to ball."""

PERSON = np.dtype(
    [
        # Numbers of its owner, its first node, and its first grip: left hand, right hand, both.
        ("owner", "i8"),
        ("node", "i8"),
        ("grip", "i8"),
        *((name, "f8") for name in LENGTHS),
        # The led place of the pelvis, its velocity and acceleration: x and z [m], [m/s], [m/s²];
        # heading and its rate [rad], [rad/s].
        ("at", "f8", 2),
        ("velocity", "f8", 2),
        ("acceleration", "f8", 2),
        ("heading", "f8"),
        ("yaw_rate", "f8"),
        # Gait clock [cycles], stance fraction of a cycle, whether the clock runs, and the blend
        # from standing to walking, 0 to 1.
        ("phase", "f8"),
        ("duty", "f8"),
        ("stepping", "?"),
        ("walk_blend", "f8"),
        ("walk_blend_rate", "f8"),
        # Of each foot: STANCE or SWING; places of the ankle with the foot flat, at stance, lift-off
        # and landing, and yaws; height of the swing; pitch, toes up; the ankle now.
        ("foot_state", "i8", 2),
        ("stance_place", "f8", (2, 3)),
        ("liftoff_place", "f8", (2, 3)),
        ("landing_place", "f8", (2, 3)),
        ("yaw", "f8", 2),
        ("liftoff_yaw", "f8", 2),
        ("landing_yaw", "f8", 2),
        ("swing_height", "f8", 2),
        # Turn of each knee outward that makes room for the other one [rad].
        ("knee_parted", "f8", 2),
        # Height at which a swing ends, as far as it has come to heed it, and how much higher or
        # lower that is than the slope there explains [m]; what a foot that was caught in mid-swing
        # is still off its stance, and the rate of that [m], [m/s].
        ("swing_end", "f8", 2),
        ("step_rise", "f8", 2),
        ("settling", "f8", (2, 3)),
        ("settling_rate", "f8", (2, 3)),
        # By how much the gait is slowed by a high step, and quickened for a foot that is left
        # behind, as fractions.
        ("slowing", "f8"),
        ("hurry", "f8"),
        # Speed for which the stride rate was last calculated [m/s], and that rate [1/s].
        ("stride_speed", "f8"),
        ("stride_rate", "f8"),
        ("pitch", "f8", 2),
        ("liftoff_pitch", "f8", 2),
        ("ankles", "f8", (2, 3)),
        # Of each swinging foot at lift-off: heading of the pelvis, and x and z of the other foot,
        # around which it passes [rad], [m].
        ("liftoff_heading", "f8", 2),
        ("pivot", "f8", (2, 2)),
        # Time since the last report [s]; touchdowns of each foot since then, time and speed of the
        # last one [s], [m/s].
        ("report_time", "f8"),
        ("touchdowns", "i8", 2),
        ("touchdown_time", "f8", 2),
        ("touchdown_speed", "f8", 2),
        # Height of the ground it follows [m], [m/s].
        ("floor", "f8"),
        ("floor_rate", "f8"),
        # Lowering of the pelvis for a stance leg of limited length [m].
        ("pelvis_drop", "f8"),
        # Clock of weight shifts while standing [cycles], their blend, 0 to 1, and rate.
        ("shift_phase", "f8"),
        ("shift_blend", "f8"),
        ("shift_blend_rate", "f8"),
        # Lean of the trunk along x and z, as tangents; twist of the chest [rad].
        ("lean", "f8", 2),
        ("lean_rate", "f8", 2),
        ("twist", "f8"),
        ("twist_rate", "f8"),
        # Direction of the gaze: yaw in the world and pitch [rad], and rates.
        ("gaze", "f8", 2),
        ("gaze_rate", "f8", 2),
        # Blend from standing to sitting, 0 to 1; bow as a tangent and crouch as a fraction of the
        # legs, to reach low places, and rates; phase of the breath.
        ("sit_blend", "f8"),
        ("bow", "f8"),
        ("bow_rate", "f8"),
        ("crouch", "f8"),
        ("crouch_rate", "f8"),
        ("breath", "f8"),
        # Of each arm: blend from swinging to its hand place, 0 to 1, and that place in the frame
        # of the chest [m]; rates.
        ("hand_blend", "f8", 2),
        ("hand_blend_rate", "f8", 2),
        ("hand_place", "f8", (2, 3)),
        ("hand_velocity", "f8", (2, 3)),
        # Blend of each arm to an embrace, 0 to 1, and rate.
        ("embrace_blend", "f8", 2),
        ("embrace_blend_rate", "f8", 2),
        # Slackness of the muscles after a blow, 0 to 1.
        ("stun", "f8"),
        # Commands: whether to go to a goal, x and z [m], and the distance at which it is reached
        # [m]; walking speed [m/s]; velocity added to step aside [m/s].
        ("has_goal", "?"),
        ("goal", "f8", 2),
        ("stop_distance", "f8"),
        ("pace", "f8"),
        ("sidestep", "f8", 2),
        # Turn from the way to the goal towards a gap in a crowd [rad].
        ("detour", "f8"),
        # Whether walls are near that it passes, and how far ahead along its way the nearest is [m].
        ("has_passage", "?"),
        ("passage", "f8"),
        # Unit vector to the right of its way through an opening that others come through, 0 where
        # there is none; the middle of the opening [m]; how far it may go to the left of its lane,
        # ∞ where that does not matter [m]; and its way to where its lane leads through, less than 0
        # behind that [m].
        ("lane_right", "f8", 2),
        ("lane_middle", "f8", 2),
        ("lane_room", "f8"),
        ("way_to_lane", "f8"),
        # How much it squeezes through where it gets no further, 0 to 1.
        ("impatience", "f8"),
        # By how much others, rather than walls, change its velocity [m/s].
        ("held_up", "f8"),
        # Whether it is others, rather than things, who keep it from getting on.
        ("in_throng", "?"),
        # How far it makes up for time that others have cost it, 0 to 1 of the most haste.
        ("lateness", "f8"),
        # How far it keeps its arms to the body, where others pass close by, 0 to 1, and wants to.
        ("arms_in", "f8"),
        ("arms_wanted_in", "f8"),
        # Steps since it last looked at others, and the sidestep it then chose [m/s].
        ("looked", "i8"),
        ("wanted_sidestep", "f8", 2),
        # Whether it has left a place to make way, and that place, x and z [m].
        ("gave_way", "?"),
        ("post", "f8", 2),
        # The people it belongs to, as a number, or -1; how many of them walk together now, itself
        # included; its place from the left among them, from 0, now and in the next step, and from
        # the front where they walk one behind the other; their direction, the place in their middle
        # that is as far ahead as it is [m], half their width [m], and the pace of the slowest
        # [m/s]; room for them side by side, 1, or in single file, 0; how much the row is bent, 0
        # to 1.
        ("group", "i8"),
        ("group_size", "i8"),
        ("group_rank", "i8"),
        ("group_next", "i8"),
        ("group_file", "i8"),
        ("group_ahead", "f8", 2),
        ("group_row", "f8", 2),
        ("group_width", "f8"),
        ("group_pace", "f8"),
        ("group_room", "f8"),
        ("group_vee", "f8"),
        # Whether it comes along with a companion, rather than going somewhere by itself.
        ("comes_along", "?"),
        # Share of its patience for which it has waited for those who fall behind, 0 to 1.
        ("group_wait", "f8"),
        # Distance to others that it accepts where it goes, as beside those on a bench [m].
        ("neighbour_distance", "f8"),
        # Velocity added to keep off what it avoids [m/s]; the foot that kicks, -1 for none; the
        # place [m] and velocity [m/s] of that ankle, and its pitch, toes up [rad].
        ("evasion", "f8", 2),
        ("kick_foot", "i8"),
        ("kick_place", "f8", 3),
        ("kick_velocity", "f8", 3),
        ("kick_pitch", "f8"),
        # Owner for whom it does not step aside, or NOBODY; heading to stand in [rad]; whether it
        # starts back from pain.
        ("partner", "i8"),
        ("startled", "?"),
        # Level unit vector along which somebody is about to push it; time for which that is so
        # unless it is told again, 0 for nobody, and until the push [s]; whether it braces itself,
        # whether it has since it last faced nobody who pushes, and the time until a push that it
        # sees coming, infinite for none [s].
        ("push_way", "f8", 2),
        ("push_warning", "f8"),
        ("push_left", "f8"),
        ("braces", "?"),
        ("has_braced", "?"),
        ("seen_push_left", "f8"),
        ("has_facing", "?"),
        ("facing", "f8"),
        ("has_look_target", "?"),
        ("look_at", "f8", 3),
        ("arm_mode", "i8", 2),
        ("arm_target", "f8", (2, 3)),
        # Tangent of the lean ahead against what it pushes.
        ("brace", "f8"),
        # Descent of the shoulders to a small partner [m]; blend to leaning on it, 0 to 1, and rate.
        ("stoop_depth", "f8"),
        ("embrace_lean", "f8"),
        ("embrace_lean_rate", "f8"),
        # STANDING or SITTING; the seat: distance behind the feet and height of the pelvis [m], lean
        # back; whether to keep quite still.
        ("posture", "i8"),
        ("seat", "f8", 3),
        # Angle by which heels rise in sitting where the seat is high [rad].
        ("seat_heel_rise", "f8"),
        ("frozen", "?"),
        # Whether one that keeps still does so in fear, and sways on its feet all the same.
        ("fearful", "?"),
        # The deck that it may stand on: number of a merry-go-round, SOLID - s of a solid, or NOBODY
        # the one whose pose is known; whether a task asks for it. Middle of its top in the frame of
        # the solid, or above the hub [m]; its axes there, columns along, up and across; half
        # extents along and across, of a round one its radius twice [m].
        ("deck", "i8"),
        ("known_deck", "i8"),
        ("deck_wanted", "?"),
        # Whether it walks beside the deck, and sets no foot on it.
        ("beside_deck", "?"),
        ("deck_place", "f8", 3),
        ("deck_turn", "f8", (3, 3)),
        ("deck_half", "f8", 2),
        ("deck_is_round", "?"),
        # Middle of its top [m] and its axes in the world.
        ("deck_middle", "f8", 3),
        ("deck_axes", "f8", (3, 3)),
        # Of each foot, 1 if it stands on the deck, lifted off from it, or will land on it, else 0.
        ("stance_on_deck", "i8", 2),
        ("liftoff_on_deck", "i8", 2),
        ("landing_on_deck", "i8", 2),
        # Share of the weight that the deck bears, 0 to 1; velocity along x and z and turning rate
        # with which it carries the person [m/s], [rad/s].
        ("deck_share", "f8"),
        ("carry_velocity", "f8", 2),
        ("carry_turn", "f8"),
        # Whether a dance guides trunk and arms; blend to it, 0 to 1, and rate; time from one of its
        # poses to the next [s]; joints from the pelvis at the start and at the end of this step
        # [m], and rotations of arms and hands, in the frame of the heading.
        ("dances", "?"),
        ("dance_blend", "f8"),
        ("dance_blend_rate", "f8"),
        ("dance_step", "f8"),
        ("dance_start", "f8", (len(GUIDED_JOINTS), 3)),
        ("dance_end", "f8", (len(GUIDED_JOINTS), 3)),
        ("dance_arms", "f8", (len(GUIDED_FRAMES), 3, 3)),
        # The low thing that its feet come upon: number of a character, SOLID - s of a solid, or
        # NOBODY; x and z of its middle [m], cosine and sine of its long axis; half extents along
        # and across, height above the ground [m]; time for which it has been in view [s], and
        # whether it is seen. Of each foot, 1 if it lands behind the thing, -1 before it, 0 neither.
        ("hurdle", "i8"),
        ("hurdle_middle", "f8", 4),
        ("hurdle_half", "f8", 2),
        ("hurdle_rise", "f8"),
        ("hurdle_time", "f8"),
        ("hurdle_seen", "?"),
        ("hurdle_side", "i8", 2),
        # What its task is about, which is no hurdle: numbers of characters, SOLID - n of the thing
        # n of another room, or NOBODY; how often it has tripped.
        ("act_things", "i8", 2),
        ("trips", "i8"),
        # Time since it has fallen, 0 while it is up [s].
        ("down_time", "f8"),
        # Whether its targets are set in every sub-step.
        ("follows_closely", "?"),
        # Target places of the nodes [m], at the end of a step and at its start.
        ("targets", "f8", (NODE_COUNT, 3)),
        ("previous_targets", "f8", (NODE_COUNT, 3)),
    ],
    align=True,
)
"""A person."""


def persons_of(
    proportions: Sequence[Proportions],
    first_nodes: Sequence[int],
    at: Array,
    headings: Array,
    ground: Array,
) -> Records:
    """Return records of n standing people with hanging arms.

    Args:
        proportions: of each person.
        first_nodes: number of the first node of each.
        at: (n, 2) x and z of each [m].
        headings: (n,) positive turns about +Y [rad].
        ground: (n,) height of the ground [m].
    """
    persons = zero_records(len(proportions), PERSON)
    for i, (own, first) in enumerate(zip(proportions, first_nodes, strict=True)):
        person = persons[i]
        for name, fraction in _length_fractions(own).items():
            setattr(person, name, fraction * own.height)
        # They take turns.
        person.node, person.looked = first, i
        person.heading = headings[i]
        person.partner = person.kick_foot = person.deck = person.known_deck = -1
        person.hurdle = person.act_things[:] = person.group = -1
        person.group_size, person.group_room = 1, 1.0
        person.neighbour_distance = person.seen_push_left = np.inf
        person.at[:] = at[i]
        person.floor = ground[i]
        person.gaze[:] = headings[i], 0.0
        person.duty = STANDING_DUTY
        person.pace = WALKING_FROUDE * np.sqrt(9.81 * person.hip_height)
        nodes = standing_nodes(own, at[i], headings[i], ground[i])
        person.targets[:] = person.previous_targets[:] = nodes
        for k in range(2):
            for place in (person.stance_place, person.liftoff_place, person.landing_place):
                place[k] = nodes[FOOT + k]
            person.ankles[k] = nodes[FOOT + k]
            person.yaw[k] = person.landing_yaw[k] = person.liftoff_yaw[k] = headings[i]
    return persons


def standing_nodes(
    proportions: Proportions, at: NDArray[np.float64], heading: float, ground: float
) -> Array:
    """Return the nodes (16, 3) of a person standing at x and z [m]."""
    c, s = np.cos(heading), np.sin(heading)
    x, y, z = hanging_arms_pose(proportions).T
    return np.stack([at[0] + c * x + s * z, ground + y, at[1] - s * x + c * z], axis=1)


def hanging_arms_pose(proportions: Proportions) -> Array:
    """Return (16, 3) the rest pose with arms as they hang before they swing [m]."""
    rest = proportions.rest()
    upper, lower = (proportions.height * x for x in (proportions.upper_arm, proportions.forearm))
    for k, side in enumerate((-1.0, 1.0)):
        ahead = upper * np.sin(HANG_SWING) + lower * np.sin(HANG_SWING + HANG_BEND)
        down = upper * np.cos(HANG_SWING) + lower * np.cos(HANG_SWING + HANG_BEND)
        along = np.array([ahead, -down * np.cos(HANG_OUTWARD), side * down * np.sin(HANG_OUTWARD)])
        size = float(np.sqrt((along * along).sum()))
        along /= size
        size = min(size, MAX_ARM_STRETCH * (upper + lower))
        back = np.array([along[1], -along[0], 0.28 * side])
        back -= (back * along).sum() * along
        part = (upper**2 - lower**2 + size**2) / (2.0 * size)
        aside = np.sqrt(upper**2 - part**2) / np.sqrt((back * back).sum())
        rest[ELBOW + k] = rest[SHOULDER + k] + part * along + aside * back
        rest[HAND + k] = rest[SHOULDER + k] + size * along
    return rest


def _length_fractions(own: Proportions) -> dict[str, float]:
    return {
        "height": 1.0,
        "thigh": own.hip - own.knee,
        "shin": own.knee - own.ankle,
        "upper_arm": own.upper_arm,
        "forearm": own.forearm,
        "hips": own.hips,
        "shoulders": own.shoulders,
        "hip_height": own.hip,
        "ankle": own.ankle,
        "belly": own.spine - own.hip,
        "chest": own.shoulder - own.spine,
        "neck": own.head - own.shoulder,
        "foot": own.foot,
        "ball": 0.48 * own.foot,
    }
