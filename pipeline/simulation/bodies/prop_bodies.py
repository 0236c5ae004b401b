"""Prop bodies: mass and shape of props that hands can take or that fall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.bodies.body_model import model_of_matter
from pipeline.simulation.bodies.prop_shapes import prop_solid
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.spatial import Array
from pipeline.spec.body import Matter
from pipeline.spec.prop import BallShape, BoxShape, Prop


def collider_of_prop(member: Prop) -> tuple[Collider, Array]:
    """Returns a prop's mass and shape, and its centre of mass (3,) from its middle [m]."""
    shape, force = member.prop, member.force
    matter = Matter() if force is None else Matter(density=force.density)
    solid = prop_solid(shape)
    own = mass_of_solid(solid.vertices, solid.faces, matter.density)
    if force is not None and force.mass is not None:
        factor = force.mass / own.mass
        own = MassProperties(force.mass, own.centre, own.inertia * factor)
    if isinstance(shape, BallShape):
        return Collider(model_of_matter(matter, own, None, shape.radius), None), own.centre
    hull = hull_of(solid.vertices)
    hull = replace(hull, vertices=hull.vertices - own.centre)
    half = 0.5 * np.array(shape.size) if isinstance(shape, BoxShape) else None
    return Collider(model_of_matter(matter, own, hull, 0.0), half), own.centre
