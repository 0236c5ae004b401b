"""Prop paths: position and rotation of one prop over time, by keyframes, velocity or force.

Source: Sims 1987, 3.1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from pipeline.simulation.bodies.integrated_attitude import SpunAttitude, TorquedAttitude
from pipeline.simulation.bodies.integrated_motion import (
    IntegratedMotion,
    PiecewisePolynomial,
)
from pipeline.simulation.bodies.prop_shapes import prop_depth, prop_solid
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties, mass_of_solid
from pipeline.simulation.figures.surroundings import MovingSolid
from pipeline.simulation.keyframe_track import CyclicTrack, Key, Track, rotation_from_angles
from pipeline.simulation.spatial import Array
from pipeline.simulation.troupe import World
from pipeline.spec.keyframes import Keyframe
from pipeline.spec.prop import ForceKey, ForceMotion, Prop, Shape, VelocityKey

ZERO_VECTOR = (0.0, 0.0, 0.0)


class PropPath(Protocol):
    """Pose of one prop relative to its parent or the world; queried at ascending times."""

    def at(self, times: Array) -> tuple[Array, Array]:
        """Returns positions (m, 3) [m] and rotations (m, 3, 3) at `times` (m,) [s]."""


@dataclass(frozen=True, eq=False)
class KeyframePath:
    """Motion along keyframes.

    Attributes:
        position: (3,) [m] over time.
        angles: (3,) [rad] over time, see `rotation_from_angles`.
    """

    position: Track | CyclicTrack
    angles: Track | CyclicTrack

    @classmethod
    def of(cls, member: Prop, start: Array, angles: Array) -> Self:
        """Returns the path along keyframes; values without keys stay as they start."""
        position = _track(member.keyframes, "position")
        looks = _track(member.keyframes, "rotation_deg")
        return cls(
            _constant_track(start) if position is None else _repeated(member, position),
            _constant_track(angles) if looks is None else _repeated(member, _in_radians(looks)),
        )

    def at(self, times: Array) -> tuple[Array, Array]:
        """See `PropPath`."""
        return self.position(times), rotation_from_angles(self.angles(times))


class VelocityPath:
    """Motion by given velocity."""

    def __init__(self, linear: Track, spin: Track, start: Array, R: Array) -> None:
        self.places = IntegratedMotion.by_velocity(PiecewisePolynomial.of(linear), start)
        self.attitude = SpunAttitude(PiecewisePolynomial.of(spin), R)

    def at(self, times: Array) -> tuple[Array, Array]:
        """See `PropPath`."""
        return self.places.at(times)[0], self.attitude.at(times)


class ForcePath:
    """Motion by given force and torque."""

    def __init__(
        self, config: ForceMotion, mass: MassProperties, start: Array, angles: Array
    ) -> None:
        keys, weight = config.keys, np.array([0.0, GRAVITY if config.gravity else 0.0, 0.0])
        force = _track(keys, "force") or _constant_track(np.array(config.force or ZERO_VECTOR))
        torque = _track(keys, "torque") or _constant_track(np.array(config.torque or ZERO_VECTOR))
        pull = Track(force.times, force.values / mass.mass - weight, force.eases)
        velocity = np.array(config.velocity)
        drag = config.drag / mass.mass
        self.places = IntegratedMotion.by_acceleration(
            PiecewisePolynomial.of(pull), start, velocity, drag
        )
        spin = np.radians(np.array(config.spin_deg))
        R = rotation_from_angles(angles)
        self.attitude = TorquedAttitude(
            PiecewisePolynomial.of(torque), mass, R, spin, config.turning_drag
        )

    def at(self, times: Array) -> tuple[Array, Array]:
        """See `PropPath`."""
        return self.places.at(times)[0], self.attitude.at(times)


def path_of_prop(member: Prop, world: World) -> PropPath:
    """Returns the path of a prop until hands take it or it falls."""
    return prop_path(member, _start(member, world))


def is_guided(member: Prop) -> bool:
    """Return whether a prop stands, or moves by its keyframes alone, and keeps its size."""
    moved = member.velocity, member.spin_deg, member.force, member.falls, member.parent
    scaled = any(key.scale is not None for key in member.keyframes)
    return all(way is None for way in moved) and not member.held and not scaled


def guided_solid(member: Prop, world: World) -> MovingSolid:
    """Return the solid of a prop that `is_guided`."""
    corners = prop_solid(member.prop).vertices
    return MovingSolid.of(member.name, corners, path_of_prop(member, world).at)


def _start(member: Prop, world: World) -> Array:
    """Returns the initial position of a prop without keyframes (3,) [m]."""
    if len(member.at) == 3:
        return np.array(member.at)
    x, z = member.at
    floor = 0.0
    if member.parent is None:
        floor = float(world.ground.height(np.array(x), np.array(z))) + prop_depth(member.prop)
    return np.array([x, floor, z])


def prop_path(member: Prop, start: Array) -> PropPath:
    """Returns the path of a prop that begins at `start` (3,) [m]."""
    # The heading adds to the second angle, the last rotation about the vertical.
    angles = np.radians(np.array(member.rotation_deg))
    angles[1] += math.radians(member.heading_deg)
    if member.force is not None:
        return ForcePath(member.force, prop_mass(member.prop, member.force), start, angles)
    if member.velocity is None and member.spin_deg is None:
        return KeyframePath.of(member, start, angles)
    keys, alone = velocity_keys(member)
    linear = _track(keys, "linear") or _constant_track(np.array(alone))
    spin = _track(keys, "spin_deg") or _constant_track(np.array(member.spin_deg or ZERO_VECTOR))
    return VelocityPath(linear, _in_radians(spin), start, rotation_from_angles(angles))


def velocity_keys(member: Prop) -> tuple[Sequence[VelocityKey], tuple[float, float, float]]:
    """Returns the velocity keys of a prop, and its constant velocity without keys."""
    keys = tuple(key for key in member.velocity or () if isinstance(key, VelocityKey))
    numbers = [float(v) for v in member.velocity or () if not isinstance(v, VelocityKey)]
    x, y, z = numbers or ZERO_VECTOR
    return keys, (x, y, z)


def prop_scale(member: Prop) -> Track | CyclicTrack | None:
    """Returns the scale of a prop over time, None for a constant size."""
    track = _track(member.keyframes, "scale", "factors")
    return None if track is None else _repeated(member, track)


def _repeated(member: Prop, track: Track) -> Track | CyclicTrack:
    if not member.repeat:
        return track
    first, last = member.keyframes[0].at, member.keyframes[-1].at
    return CyclicTrack.of(track, first, last - first)


def prop_mass(shape: Shape, config: ForceMotion) -> MassProperties:
    """Returns the mass properties of a prop, by its shape."""
    solid = prop_solid(shape)
    own = mass_of_solid(solid.vertices, solid.faces, config.density)
    factor = 1.0 if config.mass is None else config.mass / own.mass
    return MassProperties(own.mass * factor, np.zeros(3), own.inertia * factor)


def _track(
    keys: Sequence[Keyframe | VelocityKey | ForceKey], word: str, values: str = ""
) -> Track | None:
    """Returns the track of the keys that set an attribute, None if none does."""
    said = [key for key in keys if getattr(key, word) is not None]
    if not said:
        return None
    row: list[Key] = [(key.at, getattr(key, values or word), key.ease) for key in said]
    given = [
        getattr(key.tangent, word, None) if isinstance(key, Keyframe) else None for key in said
    ]
    return Track.of(row, given)


def _constant_track(value: Array) -> Track:
    return Track.of([(0.0, tuple(value), "linear")])


def _in_radians(track: Track) -> Track:
    given = None if track.tangents is None else np.radians(track.tangents)
    return Track(track.times, np.radians(track.values), track.eases, given)
