"""Build: how a dancer is made, from its words."""

from __future__ import annotations

from dataclasses import replace

from pipeline.simulation.people.proportions import ADULT, CHILD, Proportions
from pipeline.spec.dancer import Build, Dancer

BUILDS = {"torso": ADULT, "adult": ADULT, "child": CHILD}


def dancer_proportions(member: Dancer) -> Proportions:
    """Return how a dancer is made."""
    words = member.dancer
    if not isinstance(words, Build):
        return BUILDS[words]
    own = BUILDS[words.build]
    height = words.height or own.height
    # Who is taller of the same build weighs more by the square of it.
    mass = words.mass or own.mass * (height / own.height) ** 2
    return replace(own, height=height, mass=mass)


def is_child(member: Dancer) -> bool:
    """Tell whether a dancer is a child."""
    words = member.dancer
    return words == "child" or (isinstance(words, Build) and words.build == "child")
