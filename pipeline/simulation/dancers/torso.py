"""Torso: eight rigid links and twenty degrees of freedom on static legs.

The frame is that of `Proportions.rest`: X forward, Y up, Z to the right, standing at the
origin. Angles are those of anatomy: flexion raises an arm forward, abduction away from the
body, rotation turns it inward, pronation turns the palm down when the arm is out.

Source: Matarić, Zordan and Mason 1998, section 3; Winter 2009 for masses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.simulation.dynamics.linkage import (
    Capsule,
    CollisionGroup,
    Disc,
    Hinge,
    Link,
    Linkage,
    Spot,
)
from pipeline.simulation.people.proportions import ADULT, CHILD, JOINTS, SEGMENT_MASSES, Proportions
from pipeline.simulation.spatial import Array
from pipeline.spec.dancer import Build, Dancer, Gains

HANDS = ("r", "l")
"""Sides, in the order in which hands are numbered."""

ARM = ("shoulder_flexion", "shoulder_abduction", "shoulder_rotation", "elbow_flexion")
"""Joints of an arm that a force on its hand moves."""

WRIST = ("wrist_pronation", "wrist_flexion", "wrist_deviation")

AXES = {
    "waist_rotation": (0.0, 1.0, 0.0),
    "waist_flexion": (0.0, 0.0, -1.0),
    "waist_bend": (1.0, 0.0, 0.0),
    "neck_rotation": (0.0, 1.0, 0.0),
    "neck_flexion": (0.0, 0.0, -1.0),
    "neck_bend": (1.0, 0.0, 0.0),
    "shoulder_flexion": (0.0, 0.0, 1.0),
    "shoulder_abduction": (-1.0, 0.0, 0.0),
    "shoulder_rotation": (0.0, 1.0, 0.0),
    "elbow_flexion": (0.0, 0.0, 1.0),
    "wrist_pronation": (0.0, 1.0, 0.0),
    "wrist_flexion": (-1.0, 0.0, 0.0),
    "wrist_deviation": (0.0, 0.0, 1.0),
}
"""Axis of each joint at rest; on the left those along X and Y point the other way."""

LIMITS = {
    "waist_rotation": (-40, 40),
    "waist_flexion": (-15, 45),
    "waist_bend": (-25, 25),
    "neck_rotation": (-75, 75),
    "neck_flexion": (-45, 50),
    "neck_bend": (-35, 35),
    "shoulder_flexion": (-60, 185),
    "shoulder_abduction": (-60, 160),
    "shoulder_rotation": (-100, 115),
    "elbow_flexion": (0, 150),
    "wrist_pronation": (-95, 95),
    "wrist_flexion": (-70, 75),
    "wrist_deviation": (-30, 30),
}
"""Least and greatest angle [degrees]."""

GAINS = {
    "waist": (1600.0, 150.0, 300.0),
    "neck": (160.0, 7.0, 60.0),
    "shoulder": (260.0, 20.0, 90.0),
    "elbow": (130.0, 6.5, 60.0),
    "wrist": (14.0, 0.6, 15.0),
}
"""Stiffness [N m/rad], damping [N m s/rad] and strength [N m] of a grown-up's servos, chosen by
hand and the same all the time."""

FIELD_GAIN, FIELD_FORCE_LIMIT = 230.0, 320.0
"""Gain c of the fields [N s/m], and their greatest force along an axis [N], of a grown-up."""

PALM = 0.45
"""Where on a hand one touches, from the wrist to the fingertips."""

HAND_RADIUS = 0.013
"""Of a hand's solid, as a part of the height."""

REFERENCE_MASS = 68.0
"""Mass that the gains are chosen for [kg]."""


@dataclass(frozen=True, eq=False)
class Torso:
    """The linkage of a dancer, and where in it things are.

    Attributes:
        proportions: of the dancer.
        linkage: that is simulated.
        names: of its joints, in their order.
    """

    proportions: Proportions
    linkage: Linkage

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the twenty joints, in their order."""
        return tuple(hinge.name for hinge in self.linkage.hinges)

    def arm(self, side: str) -> slice:
        """Returns the places of an arm's joints, shoulder and elbow, among all."""
        first = self.names.index(f"shoulder_{side}_flexion")
        return slice(first, first + len(ARM))

    def wrist(self, side: str) -> slice:
        """Returns the places of a wrist's joints among all."""
        first = self.names.index(f"wrist_{side}_pronation")
        return slice(first, first + len(WRIST))

    def spot(self, name: str) -> int:
        """Returns the number of a spot."""
        return [spot.name for spot in self.linkage.spots].index(name)


def sided(joint: str, side: str) -> str:
    """Returns the name of a joint of one side: wrist_flexion of r is wrist_r_flexion."""
    stem, what = joint.split("_")
    return f"{stem}_{side}_{what}"


def torso_of(
    proportions: Proportions,
    spots: tuple[Spot, ...] = (),
    discs: tuple[Disc, ...] = (),
    compensated: bool = True,
) -> Torso:
    """Returns the torso of a person.

    Args:
        proportions: of the person.
        spots: places beside the palms whose way matters, their links as in `LINKS`.
        discs: that stand about it.
        compensated: whether the arms' weight is.
    """
    links = _links(proportions, compensated)
    numbers = {link.name: i for i, link in enumerate(links)}
    rest, hand = _rest(proportions), proportions.hand * proportions.height
    palms = tuple(
        Spot(f"palm_{side}", numbers[f"hand_{side}"], rest[f"hand_{side}"] - [0, PALM * hand, 0])
        for side in HANDS
    )
    apart = tuple(
        (f"{one}_{side}", f"{other}_{side}")
        for side in HANDS
        for one, other in (("upper_arm", "hand"), ("upper_arm", "forearm"), ("forearm", "hand"))
    )
    scale = proportions.mass / REFERENCE_MASS
    linkage = Linkage(
        links,
        tuple(sorted((*palms, *spots), key=lambda spot: spot.link)),
        tuple(palm.name for palm in palms),
        FIELD_GAIN * scale,
        FIELD_FORCE_LIMIT * scale,
        apart,
        discs,
    )
    return Torso(proportions, linkage)


LINKS = (
    *("pelvis", "chest", "head"),
    *("upper_arm_r", "forearm_r", "hand_r", "upper_arm_l", "forearm_l", "hand_l"),
)
"""Names of the links, in their order: the first stands still."""


def _rest(proportions: Proportions) -> dict[str, Array]:
    return dict(zip(JOINTS, proportions.rest(), strict=True))


def _links(who: Proportions, compensated: bool) -> tuple[Link, ...]:
    rest, h = _rest(who), who.height
    # The trunk's mass is spread over its height; what is below the waist stands still.
    chest = SEGMENT_MASSES["trunk"] * (who.shoulder - who.spine) / (who.shoulder - who.hip)
    links = [
        Link("pelvis", -1, rest["pelvis"], 1.0, (), _pelvis(who)),
        Link("chest", 0, rest["spine"], who.mass * chest, _hinges("waist", who), _chest(who)),
        Link(
            "head",
            1,
            rest["shoulders"],
            who.mass * SEGMENT_MASSES["head"],
            _hinges("neck", who),
            (_capsule("head", (0.004, 0.918), (0.004, 0.948), 0.05, h, "trunk"),),
        ),
    ]
    for side in HANDS:
        links += _arm(who, rest, side, len(links), compensated)
    return tuple(links)


def _arm(
    who: Proportions, rest: dict[str, Array], side: str, first: int, compensated: bool
) -> list[Link]:
    h, hand = who.height, who.hand * who.height
    shoulder, elbow, wrist = (rest[f"{what}_{side}"] for what in ("shoulder", "elbow", "hand"))
    along = np.array([0.0, -hand, 0.0])
    fingers = np.stack([wrist + 0.12 * along, wrist + 0.85 * along])
    kinds = (
        ("upper_arm", shoulder, np.stack([shoulder, elbow]), 0.026, "trunk", "shoulder"),
        ("forearm", elbow, np.stack([elbow, wrist]), 0.021, "limb", "elbow"),
        ("hand", wrist, fingers, HAND_RADIUS, "limb", "wrist"),
    )
    links, meets = list[Link](), dict[str, CollisionGroup](limb="limb", trunk="trunk")
    for k, (name, place, ends, radius, kind, hinges) in enumerate(kinds):
        solid = Capsule(f"{name}_{side}", ends, radius * h, meets[kind])
        mass = who.mass * SEGMENT_MASSES[name]
        parent = 1 if k == 0 else first + k - 1
        own = _hinges(hinges, who, side)
        links.append(Link(f"{name}_{side}", parent, place, mass, own, (solid,), compensated))
    return links


def _hinges(stem: str, who: Proportions, side: str = "") -> tuple[Hinge, ...]:
    # Torques go with mass times height, inertia with mass times height squared.
    scale = who.mass / REFERENCE_MASS
    stiffness, damping, strength = (value * scale for value in GAINS[stem])
    found = list[Hinge]()
    for joint in AXES:
        if joint.startswith(f"{stem}_"):
            axis = np.array(AXES[joint])
            if side == "l":
                axis = axis * [-1.0, -1.0, 1.0]
            lower, upper = (math.radians(angle) for angle in LIMITS[joint])
            name = sided(joint, side) if side else joint
            found.append(Hinge(name, axis, lower, upper, stiffness, damping, strength))
    return tuple(found)


def _capsule(
    name: str,
    one: tuple[float, float],
    other: tuple[float, float],
    radius: float,
    h: float,
    meets: CollisionGroup,
) -> Capsule:
    """Returns a capsule in the middle plane, given as forward and up in heights."""
    ends = np.array([[*one, 0.0], [*other, 0.0]])
    return Capsule(name, ends * h, radius * h, meets)


def _across(name: str, up: float, half: float, radius: float, h: float) -> Capsule:
    """Returns a capsule across the body, given in heights."""
    ends = np.array([[0.0, up, -half], [0.0, up, half]])
    return Capsule(name, ends * h, radius * h, "trunk")


def _chest(who: Proportions) -> tuple[Capsule, ...]:
    h, yoke = who.height, who.shoulder
    middle = 0.5 * (who.spine + who.shoulder)
    return (
        _across("belly", who.spine + 0.02, 0.030, 0.058, h),
        _across("ribs", middle, 0.032, 0.061, h),
        _across("breast", yoke - 0.043, 0.040, 0.059, h),
        _across("yoke", yoke - 0.006, who.shoulders - 0.02, 0.030, h),
        _capsule("neck", (0.0, yoke), (0.004, yoke + 0.06), 0.031, h, "trunk"),
    )


def _pelvis(who: Proportions) -> tuple[Capsule, ...]:
    h, rest = who.height, _rest(who)
    thighs = [
        Capsule(
            f"thigh_{side}",
            np.stack([rest[f"hip_{side}"], rest[f"knee_{side}"]]),
            0.045 * h,
            "trunk",
        )
        for side in HANDS
    ]
    return (_across("pelvis", who.hip + 0.015, 0.038, 0.060, h), *thighs)


def with_gains(torso: Torso, gains: Gains) -> Torso:
    """Returns a torso whose servos and fields have the author's gain factors."""
    if gains == Gains():
        return torso
    links = tuple(
        replace(
            link,
            hinges=tuple(
                replace(
                    hinge,
                    stiffness=hinge.stiffness * gains.stiffness,
                    damping=hinge.damping * gains.damping,
                )
                for hinge in link.hinges
            ),
        )
        for link in torso.linkage.links
    )
    linkage = replace(torso.linkage, links=links, drag=torso.linkage.drag * gains.drag)
    return replace(torso, linkage=linkage)


BUILDS = {"torso": ADULT, "adult": ADULT, "child": CHILD}


def dancer_proportions(member: Dancer) -> Proportions:
    """Returns the proportions of a dancer."""
    dancer = member.dancer
    if not isinstance(dancer, Build):
        return BUILDS[dancer]
    build = BUILDS[dancer.build]
    height = dancer.height or build.height
    # At the same build, mass grows with the square of height (body mass index).
    mass = dancer.mass or build.mass * (height / build.height) ** 2
    return replace(build, height=height, mass=mass)


def is_child(member: Dancer) -> bool:
    """Returns whether a dancer has the build of a child."""
    dancer = member.dancer
    return dancer == "child" or (isinstance(dancer, Build) and dancer.build == "child")
