"""Torso of a dancer: eight rigid links with twenty degrees of freedom on a pelvis that stands.

The frame is the frame of `Proportions.rest`: X forward, Y up, Z to the right, with the person at
the origin. Angles follow anatomy: flexion raises an arm forward, abduction raises it sideways,
rotation turns it inward, pronation turns the palm of an outstretched arm down.

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
    Site,
)
from pipeline.simulation.people.joint_limits import HINGE_LIMITS
from pipeline.simulation.people.proportions import (
    ADULT,
    BUILDS,
    JOINTS,
    PALM_FRACTION,
    SEGMENT_MASSES,
    Proportions,
)
from pipeline.simulation.spatial import Array
from pipeline.spec.dancer import Build, Dancer, Gains

HANDS = ("r", "l")
"""Sides, in the order of the hands' numbers."""

ARM = ("shoulder_flexion", "shoulder_abduction", "shoulder_rotation", "elbow_flexion")
"""Joints of an arm that a force on the hand moves."""

WRIST = ("wrist_pronation", "wrist_flexion", "wrist_deviation")

JOINT_AXES = {
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
"""Axis of each joint at rest; the X and Y components are negated on the left side."""

GAINS = {
    "waist": (1600.0, 150.0, 300.0),
    "neck": (160.0, 7.0, 60.0),
    "shoulder": (260.0, 20.0, 90.0),
    "elbow": (130.0, 6.5, 60.0),
    "wrist": (14.0, 0.6, 15.0),
}
"""Stiffness [N m/rad], damping [N m s/rad] and strength [N m] of an adult's servos; constant gains,
tuned by hand."""

FIELD_GAIN = 230.0
"""Gain c of an adult's force fields [N s/m]."""

FIELD_FORCE_LIMIT = 320.0
"""Largest force of an adult's force fields along each axis [N]."""

HAND_RADIUS = 0.013
"""Radius of the solid of a hand, per body height."""

REFERENCE_MASS = 68.0
"""Body mass for which the gains are tuned [kg]."""


@dataclass(frozen=True, eq=False)
class Torso:
    """Linkage of a dancer, with lookups of its joints and sites.

    Attributes:
        proportions: proportions of the dancer.
        linkage: simulated linkage.
    """

    proportions: Proportions
    linkage: Linkage

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the twenty joints, in order."""
        return tuple(hinge.name for hinge in self.linkage.hinges)

    def arm(self, side: str) -> slice:
        """Returns the slice of the shoulder and elbow joints of an arm."""
        first = self.names.index(f"shoulder_{side}_flexion")
        return slice(first, first + len(ARM))

    def wrist(self, side: str) -> slice:
        """Returns the slice of the joints of a wrist."""
        first = self.names.index(f"wrist_{side}_pronation")
        return slice(first, first + len(WRIST))

    def site(self, name: str) -> int:
        """Returns the number of a site."""
        return [site.name for site in self.linkage.sites].index(name)


def joint_name(joint: str, side: str) -> str:
    """Returns the name of a joint with its side: wrist_flexion and r give wrist_r_flexion."""
    stem, motion = joint.split("_")
    return f"{stem}_{side}_{motion}"


def build_torso(
    proportions: Proportions,
    sites: tuple[Site, ...] = (),
    discs: tuple[Disc, ...] = (),
    compensated: bool = True,
) -> Torso:
    """Returns the torso of a person.

    Args:
        proportions: proportions of the person.
        sites: tracked points in addition to the palms, with links as in `LINKS`.
        discs: static drums around the torso.
        compensated: whether gravity of the arms is compensated.
    """
    links = _links(proportions, compensated)
    numbers = {link.name: i for i, link in enumerate(links)}
    rest, hand = _rest(proportions), proportions.hand * proportions.height
    palms = tuple(
        Site(
            f"palm_{side}",
            numbers[f"hand_{side}"],
            rest[f"hand_{side}"] - [0, PALM_FRACTION * hand, 0],
        )
        for side in HANDS
    )
    excluded_pairs = tuple(
        (f"{first}_{side}", f"{second}_{side}")
        for side in HANDS
        for first, second in (("upper_arm", "hand"), ("upper_arm", "forearm"), ("forearm", "hand"))
    )
    scale = proportions.mass / REFERENCE_MASS
    linkage = Linkage(
        links,
        tuple(sorted((*palms, *sites), key=lambda site: site.link)),
        tuple(palm.name for palm in palms),
        FIELD_GAIN * scale,
        FIELD_FORCE_LIMIT * scale,
        excluded_pairs,
        discs,
    )
    return Torso(proportions, linkage)


LINKS = (
    *("pelvis", "chest", "head"),
    *("upper_arm_r", "forearm_r", "hand_r", "upper_arm_l", "forearm_l", "hand_l"),
)
"""Names of the links, in order; the first is static."""


def _rest(proportions: Proportions) -> dict[str, Array]:
    return dict(zip(JOINTS, proportions.rest(), strict=True))


def _links(person: Proportions, compensated: bool) -> tuple[Link, ...]:
    rest, h = _rest(person), person.height
    # The trunk's mass is uniform over its height; the part below the waist is static.
    chest = (
        SEGMENT_MASSES["trunk"] * (person.shoulder - person.spine) / (person.shoulder - person.hip)
    )
    links = [
        Link("pelvis", -1, rest["pelvis"], 1.0, (), _pelvis(person)),
        Link(
            "chest", 0, rest["spine"], person.mass * chest, _hinges("waist", person), _chest(person)
        ),
        Link(
            "head",
            1,
            rest["shoulders"],
            person.mass * SEGMENT_MASSES["head"],
            _hinges("neck", person),
            (_capsule("head", (0.004, 0.918), (0.004, 0.948), 0.05, h, "trunk"),),
        ),
    ]
    for side in HANDS:
        links += _arm(person, rest, side, len(links), compensated)
    return tuple(links)


def _arm(
    person: Proportions, rest: dict[str, Array], side: str, first: int, compensated: bool
) -> list[Link]:
    h, hand = person.height, person.hand * person.height
    shoulder, elbow, wrist = (rest[f"{joint}_{side}"] for joint in ("shoulder", "elbow", "hand"))
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
        mass = person.mass * SEGMENT_MASSES[name]
        parent = 1 if k == 0 else first + k - 1
        own = _hinges(hinges, person, side)
        links.append(Link(f"{name}_{side}", parent, place, mass, own, (solid,), compensated))
    return links


def _hinges(stem: str, person: Proportions, side: str = "") -> tuple[Hinge, ...]:
    # Gains scale with body mass.
    scale = person.mass / REFERENCE_MASS
    stiffness, damping, strength = (value * scale for value in GAINS[stem])
    result = list[Hinge]()
    for joint in JOINT_AXES:
        if joint.startswith(f"{stem}_"):
            axis = np.array(JOINT_AXES[joint])
            if side == "l":
                axis = axis * [-1.0, -1.0, 1.0]
            lower, upper = (math.radians(angle) for angle in HINGE_LIMITS[joint])
            name = joint_name(joint, side) if side else joint
            result.append(Hinge(name, axis, lower, upper, stiffness, damping, strength))
    return tuple(result)


def _capsule(
    name: str,
    first: tuple[float, float],
    second: tuple[float, float],
    radius: float,
    h: float,
    meets: CollisionGroup,
) -> Capsule:
    """Returns a capsule in the sagittal plane; ends (forward, up) and radius per body height."""
    ends = np.array([[*first, 0.0], [*second, 0.0]])
    return Capsule(name, ends * h, radius * h, meets)


def _lateral_capsule(name: str, up: float, half: float, radius: float, h: float) -> Capsule:
    """Returns a capsule from left to right; dimensions per body height."""
    ends = np.array([[0.0, up, -half], [0.0, up, half]])
    return Capsule(name, ends * h, radius * h, "trunk")


def _chest(person: Proportions) -> tuple[Capsule, ...]:
    h, yoke = person.height, person.shoulder
    middle = 0.5 * (person.spine + person.shoulder)
    return (
        _lateral_capsule("belly", person.spine + 0.02, 0.030, 0.058, h),
        _lateral_capsule("ribs", middle, 0.032, 0.061, h),
        _lateral_capsule("breast", yoke - 0.043, 0.040, 0.059, h),
        _lateral_capsule("yoke", yoke - 0.006, person.shoulders - 0.02, 0.030, h),
        _capsule("neck", (0.0, yoke), (0.004, yoke + 0.06), 0.031, h, "trunk"),
    )


def _pelvis(person: Proportions) -> tuple[Capsule, ...]:
    h, rest = person.height, _rest(person)
    thighs = [
        Capsule(
            f"thigh_{side}",
            np.stack([rest[f"hip_{side}"], rest[f"knee_{side}"]]),
            0.045 * h,
            "trunk",
        )
        for side in HANDS
    ]
    return (_lateral_capsule("pelvis", person.hip + 0.015, 0.038, 0.060, h), *thighs)


def with_gains(torso: Torso, gains: Gains) -> Torso:
    """Returns a torso with scaled gains of its servos and fields."""
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


def dancer_proportions(member: Dancer) -> Proportions:
    """Returns the proportions of a dancer."""
    dancer = member.dancer
    if not isinstance(dancer, Build):
        return ADULT if dancer == "torso" else BUILDS[dancer]
    build = BUILDS[dancer.build]
    height = dancer.height or build.height
    # A constant body mass index.
    mass = dancer.mass or build.mass * (height / build.height) ** 2
    return replace(build, height=height, mass=mass)
