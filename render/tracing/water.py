"""Water for Dr.Jit: where rays meet it, what it reflects, and what light arrives below it.

The surface is no mesh: rays are intersected with the level, then corrected for the height of
the waves, and the waves bend the normal. Only rays from the camera are bent by it. All other
rays and shadow rays pass it straight, dimmed by reflection and by what the water absorbs on the
way; the light patterns on the ground come from the curvature of the surface above.

Source: J. Tessendorf, Simulating Ocean Water, 2001; D. Zimmermann and A. Bunse, and M. Guardado,
Rendering Water Caustics, GPU Gems, 2004, for light patterns from the surface above a point;
C. Bruneton et al., Real-time Realistic Ocean Lighting, 2010, for waves below a pixel's width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from render.lights.lattice_noise import noise2
from render.tracing.foam import Foam
from render.water import REFRACTIVE_INDEX, WaterSurface

_DEFOCUS_DEPTH = 1.6
"""Depth from which light patterns grow no sharper [m]: rays of the sun's disc and of many
wavelets mix."""

_SUNK = 0.6
"""Fall of the fog's light with depth, relative to the extinction along a ray."""

_WET_SHARE = 0.52
"""Brightness of wet ground relative to dry ground."""

_WET_HEIGHT, _WET_RAGGED = 0.07, 0.02
"""Height to which water soaks the ground of a shore, and by how much more or less in places [m]."""

_LEAST_ROUGHNESS = 6e-4
"""Mean squared slope of the waves that are too short to be in the sum."""

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0

SPREAD_LOOKS = 4
"""Normals that are sampled of the waves below a pixel's width, in each pass."""

_SHAFT_STEPS, _SHAFT_REACH, _SHAFT_WIDTH, _SHAFT_DEPTH = 9, 11.0, 0.8, 4.0
"""Number of places along a ray at which shafts of light are looked at, how far the last is, how
wide shafts are, and the depth at which 1/e of them is left [m]."""

_SHAFT_DARK, _SHAFT_MEAN = 0.42, 0.5
"""Light between shafts relative to the mean, and the root of the mean square of their pattern."""

_OPAQUE = 12.0
"""Optical depth from which water lets nothing more be seen."""

FAR = 1e4
"""Distance that stands for no surface [m]."""

KEY_LIGHT_FROM = 2000.0
"""Distance from which an emitter with a place is the key light [m]."""


@dataclass
class Interface:
    """The surface where rays meet it, with the two directions in which light goes on.

    Attributes:
        p: places, `mi.Point3f` [m].
        normal: towards the side that the rays come from.
        unbent: normal of the waves that are seen one by one, upwards.
        roughness: mean squared slope of waves below a pixel's width.
        reflectance: share of light that is reflected.
        reflected: direction, unit vector.
        refracted: direction, unit vector.
        is_above: whether the rays come from above.
    """

    p: Any
    normal: Any
    unbent: Any
    roughness: Any
    reflectance: Any
    reflected: Any
    refracted: Any
    is_above: Any


@dataclass
class Water:
    """The water of a scene at one moment, opaque to recordings.

    Attributes:
        waves: amplitude [m], wave vector [rad/m] and length [m] of each; constant.
        level: mean height of the surface [m].
        phases: of the waves.
        extinction: by colour [1/m].
        glow: radiance of endless water at the surface.
        foam: on the surface.
        pixel: width of a pixel at a distance of 1 m [m].
        mean_focus: mean of the light pattern at some depths, by which it is divided.
        shafts: unit vector under water towards the key light whose shafts a camera below the
            surface sees; None without any.
    """

    waves: tuple[tuple[float, float, float, float], ...]
    level: mi.Float
    phases: list[mi.Float]
    extinction: mi.Color3f
    glow: mi.Color3f
    foam: Foam
    pixel: mi.Float
    mean_focus: tuple[float, ...]
    shafts: mi.Vector3f | None = None

    @staticmethod
    def of(surface: WaterSurface, downwelling: Any, time: float = 0.0) -> Water:
        """Return the water of a surface.

        Args:
            surface: of a shot.
            downwelling: (3,) irradiance of level ground by sun and sky.
            time: of the film [s].
        """
        waves = tuple((w.amplitude, *w.k, w.length) for w in surface.waves)
        glow = np.asarray(surface.albedo) * np.asarray(downwelling) / np.pi
        made = Water(
            waves,
            mi.Float(surface.level),
            [],
            mi.Color3f(list(surface.extinction)),
            mi.Color3f(glow.tolist()),
            Foam.of(surface, downwelling),
            mi.Float(1e-3),
            _mean_focus(waves),
        )
        dr.make_opaque(made.level, made.extinction, made.glow, made.pixel)
        made.set_time(surface, time)
        return made

    def set_time(self, surface: WaterSurface, time: float) -> None:
        """Move the waves to a time of the film [s]."""
        self.phases = [dr.opaque(mi.Float, wave.phase_at(time)) for wave in surface.waves]
        self.foam.set_time(time, self.phases[-1] if self.phases else None)

    def set_pixel_width(self, fov_deg: float, height: int) -> None:
        """Set how fine waves are seen: in a field of view this high, of so many pixels."""
        width = 2.0 * math.tan(math.radians(fov_deg) / 2.0) / height
        self.pixel = dr.opaque(mi.Float, width)

    def crossing(self, ray: Any) -> Any:
        """Return the distance at which rays meet the surface, infinity where they do not."""
        rise = dr.select(dr.abs(ray.d.y) < 1e-6, 1e-6, ray.d.y)
        t = (self.level - ray.o.y) / rise
        if self.waves:
            # A flat ray would slide along the crests; its normal alone shows the waves.
            calm = dr.square(dr.clip(4.0 * dr.abs(ray.d.y), 0.0, 1.0))
            for _ in range(2):
                near = dr.clip(t, 0.0, 60.0)
                height = calm * self._height(ray.o.x + near * ray.d.x, ray.o.z + near * ray.d.z)
                t = (self.level + height - ray.o.y) / rise
        return dr.select((t > 1e-4) & (dr.abs(ray.d.y) >= 1e-6), t, dr.inf)

    def is_below(self, p: Any) -> Any:
        """Return whether places are under water."""
        return p.y < self.level

    def interface(self, ray: Any, t: Any) -> Interface:
        """Return the surface at the distances where rays meet it."""
        p = ray.o + t * ray.d
        slope_x, slope_z, lost = self._slopes(p, ray.d, self.pixel * t)
        is_above = ray.d.y < 0.0
        # Of waves that are too far to be seen one by one, those that face the camera are seen.
        flat = 1.0 - dr.minimum(dr.abs(ray.d.y), 1.0)
        facing = 0.55 * dr.sqrt(lost) * flat
        up = dr.normalize(
            mi.Vector3f(-slope_x - facing * ray.d.x, 1.0, -slope_z - facing * ray.d.z)
        )
        unbent = dr.normalize(mi.Vector3f(-slope_x, 1.0, -slope_z))
        normal = dr.select(is_above, up, -up)
        cosine = -dr.dot(ray.d, normal)
        # A wave that faces away is hidden by the one before it.
        normal = dr.normalize(normal - ray.d * dr.maximum(0.02 - cosine, 0.0))
        cosine = dr.clip(-dr.dot(ray.d, normal), 0.005, 1.0)
        signed = dr.select(is_above, cosine, -cosine)
        share, cosine_t, _, eta = _fresnel(signed)
        reflected = ray.d + 2.0 * cosine * normal
        side = dr.select(is_above, mi.Float(1.0), mi.Float(-1.0))
        reflected = mi.Vector3f(
            reflected.x, side * dr.maximum(dr.abs(reflected.y), 1e-3), reflected.z
        )
        refracted = eta * ray.d + (eta * cosine - dr.abs(cosine_t)) * normal
        refracted = mi.Vector3f(
            refracted.x, -side * dr.maximum(dr.abs(refracted.y), 1e-3), refracted.z
        )
        ways = dr.normalize(reflected), dr.normalize(refracted)
        return Interface(p, normal, unbent, lost, share, *ways, is_above)

    def mirrored(self, interface: Interface, ray: Any, radiance: Any, k: Any, passes: int) -> Any:
        """Return the mean light that waves below a pixel's width mirror from the sky.

        The slopes are Gaussian (Beckmann's distribution). Normals are sampled in proportion to the
        area that the ray sees of them, and weighted by their reflectance, so that grazing rays see
        the waves that face them. The mean is relative to the reflectance of the interface. All
        pixels use the same samples, which leaves no noise between neighbours.

        Args:
            interface: where rays meet the surface.
            ray: that meet it.
            radiance: returns the light of the sky from directions.
            k: number of the pass.
            passes: of the frame, which share the directions.

        Source: Bruneton et al. 2010, section 5; Heitz and d'Eon 2014 (visible normals).
        """
        slopes = mi.MicrofacetDistribution(
            mi.MicrofacetType.Beckmann, dr.sqrt(interface.roughness), sample_visible=True
        )
        frame = mi.Frame3f(interface.unbent)
        seen_from = frame.to_local(-ray.d)
        # Waves that face away are hidden by those before them, of which the flattest are seen.
        seen_from.z = dr.maximum(seen_from.z, 0.005)
        seen_from = dr.normalize(seen_from)
        total: Any = mi.Color3f(0.0)
        whole: Any = mi.Float(0.0)
        for look in range(SPREAD_LOOKS):
            # A lattice of rank one, even in both coordinates whatever the number of passes.
            place = look + (mi.Float(k) + 0.5) / passes
            u = mi.Point2f(place / SPREAD_LOOKS, dr.fma(place, _GOLDEN, 0.5))
            u.y -= dr.floor(u.y)
            normal = frame.to_world(mi.Vector3f(slopes.sample(seen_from, u)[0]))
            cosine = -dr.dot(ray.d, normal)
            way = ray.d + 2.0 * cosine * normal
            # What would be thrown down is thrown up by the next wave.
            way.y = dr.maximum(dr.abs(way.y), 1e-3)
            thrown, *_ = _fresnel(dr.maximum(cosine, 0.005))
            total += thrown * radiance(dr.normalize(way))
            whole += thrown
        return total / whole

    def transmittance(self, distance: Any) -> Any:
        """Return the share of light that is left after distances under water [m]."""
        # A little is left, by which the denoiser can divide.
        return dr.exp(-dr.minimum(self.extinction * dr.minimum(distance, FAR), _OPAQUE))

    def scattered(self, origin: Any, direction: Any, distance: Any) -> Any:
        """Return the light that water sends along rays below the surface, `mi.Color3f`.

        The light in the water falls off with the depth, slower than along a ray because it comes
        from many sides.
        """
        depth = dr.maximum(self.level - origin.y, 0.0)
        along = 1.0 - _SUNK * direction.y
        filled = 1.0 - dr.exp(-self.extinction * along * dr.minimum(distance, FAR))
        light = self.glow * dr.exp(-_SUNK * self.extinction * depth) * filled / along
        if self.shafts is not None:
            light *= self._shaft_share(self.shafts, origin, direction, distance)
        return light

    def show_shafts(self, to_light: Any) -> None:
        """Let a camera below the surface see shafts of a key light in this direction in air."""
        x, y, z = (float(part) / REFRACTIVE_INDEX for part in to_light)
        flat = x * x + z * z
        parts = (x, math.sqrt(1.0 - flat) if y > 0.0 else 1.0, z)
        self.shafts = mi.Vector3f(*(dr.opaque(mi.Float, part) for part in parts))

    def _shaft_share(self, light: Any, origin: Any, direction: Any, distance: Any) -> Any:
        """Return the light in shafts along rays, relative to the mean.

        Waves gather light into bundles that lean as the refracted key light does; a ray that goes
        along them stays in one, others meet many.
        """
        total, whole = mi.Float(0.0), mi.Float(1e-6)
        drift = 0.12 * self.phases[-1] if self.phases else mi.Float(0.0)
        for k in range(_SHAFT_STEPS):
            at = _SHAFT_REACH * ((k + 0.5) / _SHAFT_STEPS) ** 1.5
            p = origin + at * direction
            up = (self.level - p.y) / light.y
            x, z = (p.x + up * light.x) / _SHAFT_WIDTH, (p.z + up * light.z) / _SHAFT_WIDTH
            bundle = noise2(x + drift, z, 83) * (0.4 + noise2(3.1 * x, 3.1 * z + drift, 84))
            deep = dr.exp(-dr.maximum(self.level - p.y, 0.0) / _SHAFT_DEPTH)
            weight = dr.select(at < distance, 1.0, 0.0) * (k + 0.5) ** 0.5 * deep
            total = dr.fma(weight, dr.square(bundle / _SHAFT_MEAN), total)
            whole += weight
        return _SHAFT_DARK + (1.0 - _SHAFT_DARK) * total / whole

    def along(self, origin: Any, direction: Any, distance: Any) -> Any:
        """Return the share of light that passes straight segments, partly under water."""
        start = origin.y - self.level
        length = dr.minimum(distance, FAR)
        end = start + length * direction.y
        wet = dr.maximum(-dr.minimum(start, end), 0.0) - dr.maximum(-dr.maximum(start, end), 0.0)
        steep = dr.maximum(dr.abs(direction.y), 1e-4)
        is_wet = (start < 0.0) & (end < 0.0)
        under = dr.select(is_wet, length, dr.minimum(wet / steep, length))
        passed = self.transmittance(under)
        crosses = (start < 0.0) != (end < 0.0)
        lost, *_ = _fresnel(dr.maximum(dr.abs(direction.y), 0.02))
        return dr.select(crosses, passed * (1.0 - lost), passed)

    def reaching(self, p: Any, sample: Any) -> Any:
        """Return the share of an emitter's light that reaches places, with its pattern.

        Args:
            p: lit places.
            sample: of the emitter, `mi.DirectionSample3f`.
        """
        depth = self.level - p.y
        is_outside = (sample.d.y * sample.dist > depth) & (depth > 0.0)
        cosine = dr.maximum(sample.d.y, 0.02)
        lost, inside, _, _ = _fresnel(cosine)
        inside = dr.maximum(dr.abs(inside), 0.3)
        passed = self.transmittance(dr.maximum(depth, 0.0) / inside) * (1.0 - lost)
        if self.waves:
            # The light enters where the bent ray meets the surface.
            shift = dr.maximum(depth, 0.0) / (inside * REFRACTIVE_INDEX)
            passed *= self._focus(p.x + shift * sample.d.x, p.z + shift * sample.d.z, depth)
        both_under = (depth > 0.0) & ~is_outside
        passed = dr.select(both_under, self.transmittance(sample.dist), passed)
        return dr.select(depth > 0.0, passed, self.along(p, sample.d, sample.dist))

    def wetness(self, p: Any, normal: Any) -> Any:
        """Return the brightness of surfaces relative to dry ones: wet ground is darker."""
        height = p.y - self.level
        if self.waves:
            height -= 0.5 * self._height(p.x, p.z)
        # Incommensurable waves, never seen to repeat.
        height += _WET_RAGGED * dr.sin(23.0 * p.x + 1.7 * dr.sin(17.0 * p.z)) * dr.sin(19.0 * p.z)
        wet = 1.0 - dr.clip(height / _WET_HEIGHT, 0.0, 1.0)
        # Sides of stones, too, but nothing that hangs over the water.
        wet = wet * wet * (3.0 - 2.0 * wet) * dr.clip(2.0 * normal.y + 1.0, 0.0, 1.0)
        return 1.0 - (1.0 - _WET_SHARE) * wet

    def glitter(self, interface: Interface, ray: Any, sample: Any, arriving: Any) -> Any:
        """Return the light of an emitter sample that waves too short to be seen reflect."""
        half = dr.normalize(sample.d - ray.d)
        rise = dr.maximum(dr.abs(half.y), 0.05)
        n = interface.normal
        tilt = dr.maximum(dr.abs(n.y), 0.05)
        off = dr.square(half.x / rise - n.x / tilt) + dr.square(half.z / rise - n.z / tilt)
        spread = interface.roughness + _LEAST_ROUGHNESS
        density = dr.exp(-off / spread) / (dr.pi * spread) / (rise * rise * rise * rise)
        share, *_ = _fresnel(dr.maximum(dr.dot(half, sample.d), 0.02))
        facing = dr.maximum(-dr.dot(ray.d, n), 0.12)
        is_seen = interface.is_above & (sample.d.y > 0.0)
        return dr.select(is_seen, arriving * share * density / (4.0 * facing), 0.0)

    def _height(self, x: Any, z: Any) -> Any:
        height = mi.Float(0.0)
        for (amplitude, kx, kz, _), phase in zip(self.waves, self.phases, strict=True):
            height += amplitude * dr.sin(dr.fma(kx, x, dr.fma(kz, z, phase)))
        return height

    def _slopes(self, p: Any, d: Any, width: Any) -> tuple[Any, Any, Any]:
        """Return the slopes along x and z, and the mean square of those not seen one by one.

        Args:
            p: places on the surface [m].
            d: directions from which they are seen.
            width: of a pixel there, across the direction [m].
        """
        # A pixel covers more of the water along the view the flatter that is.
        flat = dr.rsqrt(dr.maximum(dr.square(d.x) + dr.square(d.z), 1e-6))
        view_x, view_z = d.x * flat, d.z * flat
        drawn_out = dr.square(dr.rcp(dr.maximum(dr.abs(d.y), 2e-3))) - 1.0
        slope_x, slope_z, lost = mi.Float(0.0), mi.Float(0.0), mi.Float(0.0)
        for (amplitude, kx, kz, length), phase in zip(self.waves, self.phases, strict=True):
            along = dr.square((kx * view_x + kz * view_z) * (length / (2.0 * math.pi)))
            covered = width * dr.sqrt(1.0 + along * drawn_out)
            seen = dr.clip(2.0 - 4.0 * covered / length, 0.0, 1.0)
            rise = amplitude * dr.cos(dr.fma(kx, p.x, dr.fma(kz, p.z, phase))) * seen
            slope_x, slope_z = dr.fma(kx, rise, slope_x), dr.fma(kz, rise, slope_z)
            steepness = 0.5 * amplitude**2 * (kx**2 + kz**2)
            lost += steepness * (1.0 - seen * seen)
        return slope_x, slope_z, lost

    def _focus(self, x: Any, z: Any, depth: Any) -> Any:
        """Return how far the surface gathers or spreads light at a depth below its places."""
        xx, xz, zz = mi.Float(0.0), mi.Float(0.0), mi.Float(0.0)
        # Crests that are not quite straight: sines alone would draw a lattice.
        bent_x, bent_z = x, z
        for reach, k, turn in _BENDS:
            bent_x += reach * dr.sin(k * (math.cos(turn) * z + math.sin(turn) * x) + turn)
            bent_z += reach * dr.sin(k * (math.cos(turn) * x - math.sin(turn) * z) + 2.0 * turn)
        x, z = bent_x, bent_z
        for (amplitude, kx, kz, length), phase in zip(self.waves, self.phases, strict=True):
            bend = -amplitude * _focusing(length) * dr.sin(dr.fma(kx, x, dr.fma(kz, z, phase)))
            xx, xz, zz = (
                dr.fma(kx * kx, bend, xx),
                dr.fma(kx * kz, bend, xz),
                dr.fma(kz * kz, bend, zz),
            )
        reach = _FOCUS_PER_DEPTH * dr.clip(depth, 0.0, _DEFOCUS_DEPTH)
        area = (1.0 + reach * xx) * (1.0 + reach * zz) - dr.square(reach * xz)
        found = 1.0 / dr.maximum(dr.abs(area), _SHARPEST)
        return found / self._mean(depth)

    def _mean(self, depth: Any) -> Any:
        place = dr.clip(depth / _DEFOCUS_DEPTH, 0.0, 1.0) * (len(self.mean_focus) - 1)
        mean = mi.Float(self.mean_focus[0])
        for i in range(len(self.mean_focus) - 1):
            step = self.mean_focus[i + 1] - self.mean_focus[i]
            mean += step * dr.clip(place - i, 0.0, 1.0)
        return mean


_FOCUS_PER_DEPTH = 1.0 - 1.0 / REFRACTIVE_INDEX
"""Shift of light along the ground, for each metre of depth and unit of slope."""

_BENDS = ((0.26, 1.3, 0.6), (0.11, 3.7, 2.3), (0.045, 9.1, 4.1))
"""Swirls that bend the crests of a light pattern: reach [m], wave number [rad/m], turn [rad]."""

_FOCUSING, _FOCUSING_LENGTH = 2.0, 0.6
"""Greatest factor on the curvature of waves, and the length below which it falls [m]."""

_SHARPEST = 0.22
"""Smallest area that light of a unit of the surface is gathered on."""


def _focusing(length: float) -> float:
    """Return the share of a wave's curvature that gathers light.

    Light from many sides blurs what ripples gather; without that the two shortest waves would
    draw the whole pattern.
    """
    return _FOCUSING * length / (length + _FOCUSING_LENGTH)


def _fresnel(cosine: Any) -> Any:
    """Return `mi.fresnel` of water; a negative cosine is that of a ray from below."""
    index: Any = REFRACTIVE_INDEX
    return mi.fresnel(cosine, index)


def _mean_focus(waves: tuple[tuple[float, float, float, float], ...]) -> tuple[float, ...]:
    """Return the mean of the light pattern at some depths, so that it can be divided out."""
    if not waves:
        return (1.0,)
    rng = np.random.default_rng(5)
    phases = rng.uniform(0.0, 2.0 * np.pi, (4096, len(waves)))
    amplitude, kx, kz, length = np.array(waves).T
    bend = -amplitude * np.array([_focusing(one) for one in length]) * np.sin(phases)
    xx, xz, zz = bend @ (kx * kx), bend @ (kx * kz), bend @ (kz * kz)
    means = []
    for depth in np.linspace(0.0, _DEFOCUS_DEPTH, 9):
        reach = _FOCUS_PER_DEPTH * depth
        area = (1.0 + reach * xx) * (1.0 + reach * zz) - (reach * xz) ** 2
        means.append(float((1.0 / np.maximum(np.abs(area), _SHARPEST)).mean()))
    return tuple(means)
