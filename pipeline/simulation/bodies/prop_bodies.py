"""Prop bodies: mass and shape of props that hands can take or that fall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.simulation.bodies.body_model import build_body, model_of_matter
from pipeline.simulation.bodies.prop_shapes import prop_solid
from pipeline.simulation.dynamics.hull import hull_of
from pipeline.simulation.dynamics.mass import mass_of_solid
from pipeline.simulation.dynamics.mujoco_bodies import Collider
from pipeline.simulation.dynamics.rigid_body import BodyModel
from pipeline.simulation.spatial import Array
from pipeline.spec.body import Box, Matter, Sphere
from pipeline.spec.prop import BallShape, BoxShape, Prop, Shape


def collider_of_prop(member: Prop) -> tuple[Collider, Array]:
    """Returns a prop's mass and shape, and its centre of mass (3,) from its middle [m]."""
    force = member.force
    matter = Matter() if force is None else Matter(density=force.density)
    model, centre = _model(member.prop, matter)
    if force is not None and force.mass is not None:
        own = model.mass
        inertia = own.inertia * (force.mass / own.mass)
        model = replace(model, mass=replace(own, mass=force.mass, inertia=inertia))
    half = 0.5 * np.array(member.prop.size) if isinstance(member.prop, BoxShape) else None
    return Collider(model, half), centre


def _model(shape: Shape, matter: Matter) -> tuple[BodyModel, Array]:
    """Returns the model of a shape of some matter, and its centre of mass (3,) [m]."""
    if isinstance(shape, BallShape):
        ball = Sphere(shape="sphere", radius=shape.radius, density=matter.density)
        return build_body(ball, ""), np.zeros(3)
    if isinstance(shape, BoxShape):
        return build_body(Box(shape="box", size=shape.size, density=matter.density), ""), np.zeros(
            3
        )
    solid = prop_solid(shape)
    own = mass_of_solid(solid.vertices, solid.faces, matter.density)
    hull = hull_of(solid.vertices)
    hull = replace(hull, vertices=hull.vertices - own.centre)
    return model_of_matter(matter, own, hull, 0.0), own.centre
