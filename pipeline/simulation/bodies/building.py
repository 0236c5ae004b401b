"""Building: the words of a body -> its mass, its hull and its matter, and what is seen of it.

Source: Sims 1987, 7.1.1.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.simulation.bodies.bevelled import bevelled
from pipeline.simulation.bodies.pips import MATERIAL, pips
from pipeline.simulation.bodies.polyhedra import hull_of_words
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.dynamics.rigid import Build
from pipeline.simulation.figures.solids import Solid, ball_solid
from pipeline.simulation.take import Mesh
from pipeline.spec.body import Sphere


def build_of(words: Any, path: str) -> Build:
    """Return a body as it is built.

    Args:
        words: of the body.
        path: where they stand in the scene.

    Raises:
        SceneError: its shape is no solid.
    """
    if isinstance(words, Sphere):
        mass = words.density * 4.0 / 3.0 * math.pi * words.radius**3
        moment = 0.4 * mass * words.radius**2
        own, hull, radius = (
            MassProperties(mass, np.zeros(3), moment * np.eye(3)),
            None,
            words.radius,
        )
    else:
        hull = hull_of_words(words, path)
        own, radius = mass_of_solid(hull.vertices, hull.faces, words.density), 0.0
        hull = replace(hull, vertices=hull.vertices - own.centre)
    if words.inertia == "scalar":
        own = _isotropic(own)
    return Build(
        mass=own,
        hull=hull,
        radius=radius,
        bounciness=words.bounciness,
        friction=words.friction,
        rolling=words.rolling if words.friction > 0.0 else 0.0,
        soft=words.soft,
    )


def _isotropic(mass: MassProperties) -> MassProperties:
    """Return mass properties with the mean moment of inertia about every axis.

    Source: Sims 1987, 7.1.1: "approximated to be a constant, independent of the axis". A
    moment that is taken anew for each torque's axis, as in (7.10), gives a body more energy
    than it was given.
    """
    return replace(mass, inertia=np.trace(mass.inertia) / 3.0 * np.eye(3))


def seen_of(words: Any, build: Build, material: str) -> list[tuple[str, Solid, str]]:
    """Return what is seen of a body: names after its own, solids and materials."""
    if build.hull is None:
        return [("", ball_solid(np.zeros(3), build.radius), material)]
    seen = [("", bevelled(build.hull), material)]
    if words.shape == "die":
        seen.append((".pips", pips(words.size), MATERIAL))
    return seen


def mesh_of(solid: Solid, node: int) -> Mesh:
    """Return the mesh of a solid that follows one node."""
    count = len(solid.vertices)
    return Mesh(
        solid.vertices.astype(np.float32),
        solid.faces,
        np.full((count, 2), node, dtype=np.int32),
        np.tile(np.array([1.0, 0.0], dtype=np.float32), (count, 1)),
    )
