"""The wavefront tracer: all paths of a picture advance together, one bounce at a time.

It solves what Mitsuba's `path` solves, with the same scene, lights and surfaces, and differs
in how the work is laid out, which decides the speed on a CPU:

- Only paths that still go on are worked on. Outdoors four of five rays that leave a surface
  end in the sky; a loop inside one kernel drags the others along in half-empty vectors.
- Samples are stratified pass by pass (`draws`), so that rays that lie beside each other in
  memory, those of a small square of the picture, go into the same part of the sphere.
- A pass is traced in Python once and then played back, until something moves.
- What lamps do for the surfaces that are seen, and these surfaces' colours, is sharp and cheap;
  what comes from the sky and from surface to surface is soft and dear. So the first has samples
  of its own, the *looks*, several for each path of the second, and the two are handed on apart;
  for a preview the second is a picture half as wide and half as high.

Sums are added up pass after pass and pixel by pixel, never by threads that meet, so that the
same seed gives the same bits.

Source: Laine, Karras, Aila, Megakernels Considered Harmful, 2013, for wavefronts; Veach,
Robust Monte Carlo Methods for Light Transport Simulation, 1997, ch. 9, for the weights of
rays to lights and rays along the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from render.config.film import RAYS_PER_PATH
from render.exposure import GLEAM, Exposure
from render.strata import grid
from render.tracing.raster import Raster, Sums
from render.tracing.stratification import ALONG, ON_LAMP, Chance, Draws, line, pair
from render.tracing.tracer import Plate, Tracer

RECORDINGS = 8
"""Most recordings that are kept of one stage of the work."""


@dataclass
class Paths:
    """Paths under way, one a lane.

    Attributes:
        lane: place in the sums.
        pixel: number of the pixel, row by row.
        begin: where its last segment begins [m].
        toward: unit vector along that.
        hit: what that meets.
        weight: share of what comes that reaches the eye.
        pdf: density with which its direction was drawn [1/sr]; 0 where there was no choice.
    """

    lane: mi.UInt32
    pixel: mi.UInt32
    begin: mi.Point3f
    toward: mi.Vector3f
    hit: mi.PreliminaryIntersection3f
    weight: mi.Color3f
    pdf: mi.Float

    @property
    def ray(self) -> Any:
        """The last segment as a ray."""
        return mi.Ray3f(self.begin, self.toward)

    def met(self) -> Any:
        """Return the surface at its end."""
        return self.hit.compute_surface_interaction(self.ray)


class Wavefront(Tracer):
    """Traces one scene.

    Args:
        scene: of Mitsuba; see `tracer.refusal` for what it must not have.
        size: width and height of the picture [pixels].
        depth: longest path, in segments.
        half: whether soft light is traced at half the size, one look in each pixel beside it.

    Attributes:
        looks: for each path.
        sharp: the picture of direct light.
        soft: that of indirect light.
    """

    def __init__(
        self, scene: Any, size: tuple[int, int], depth: int, *, half: bool = False
    ) -> None:
        self._scene, self._depth = scene, depth
        self.looks = 1 if half else RAYS_PER_PATH
        self.sharp = Raster(size)
        self.soft = Raster((size[0] // 2, size[1] // 2)) if half else self.sharp
        sky = scene.environment()
        self._sky_is_asked = sky is not None and sky.sampling_weight() > 0.0
        self._of = 0
        # Each scene has recordings of its own, which go when it goes.
        self._looked = _played(_looked)
        self._begun = _played(_begun)
        self._shaded = _played(_shaded)
        self._shining = _played(_shining)
        self._ended = _played(_ended)

    def plate(self) -> Plate:
        """Return a plate on which nothing has fallen yet."""
        return _Plate(self)

    def moved(self) -> None:
        """Forget what was recorded before the scene was changed.

        Played back, it would go on with some of what was there before: Dr.Jit 1.5 finds the
        buffers of a scene again that it replaced itself, but not always Embree's.
        """
        for stage in (self._looked, self._begun, self._shaded, self._shining, self._ended):
            stage.clear()

    def spread(self, passes: int) -> None:
        """Take note of how many passes the samples of a picture are spread over."""
        if passes != self._of:
            # Numbers of Python's in what is drawn by are not asked for by what plays back.
            self.moved()
            self._of = passes

    def look(self, sensor: Any, pixels: Any, chance: Chance, sums: Sums) -> Sums:
        """Return the sums of direct light and colour with one look through every pixel."""
        ray = _ray(sensor, pixels, self.sharp.size, chance.draws(0))
        further: Sums = self._looked(
            self._scene, pixels, ray, self._depth > 1, sums, chance.draws(1)
        )
        return further

    def follow(self, sensor: Any, pixels: Any, chance: Chance, sums: Sums) -> Sums:
        """Return the sums of indirect light and dye with one path from every pixel."""
        if self._depth == 1:
            return sums
        count = dr.width(pixels)
        # Held in full, although all are equal, so that later steps have the kernel of the first.
        fresh = dr.opaque(mi.Color3f, 1.0, count), dr.opaque(mi.Float, 0.0, count)
        ray = _ray(sensor, pixels, self.soft.size, chance.draws(0))
        paths = self._begun(self._scene, pixels, ray, fresh)
        for step in range(1, self._depth):
            going = mi.UInt32(dr.compress(paths.hit.is_valid()))
            if dr.width(going) == 0:
                return sums
            paths = dr.gather(Paths, paths, going)
            first = dr.opaque(mi.Bool, step == 1)
            draws = chance.draws(step)
            paths, *further = self._shaded(
                self._scene, paths, sums, draws, first, self._sky_is_asked
            )
            sums = further[0], further[1]
        shining = mi.UInt32(dr.compress(self._shining(paths)))
        if dr.width(shining):
            paths = dr.gather(Paths, paths, shining)
            sums = self._ended(self._scene, paths, sums[0]), sums[1]
        return sums


class _Plate(Plate):
    """Looks and paths, added up apart and part by part of the picture.

    Args:
        tracer: what fills it.
    """

    def __init__(self, tracer: Wavefront) -> None:
        self._tracer = tracer
        self._sharp, self._soft = tracer.sharp.sums(), tracer.soft.sums()
        self._passes = 0

    def expose(self, sensor: Any, seed: int, passes: range, of: int) -> None:
        """Add what the sensor sees now."""
        tracer = self._tracer
        tracer.spread(of)
        looks = range(tracer.looks * passes.start, tracer.looks * passes.stop)
        cells = grid(tracer.looks * of), grid(of)
        for i, pixels in enumerate(tracer.sharp.parts):
            for k in looks:
                chance = Chance(seed + 1, k, cells[0])
                self._sharp[i] = tracer.look(sensor, pixels, chance, self._sharp[i])
        for i, pixels in enumerate(tracer.soft.parts):
            for k in passes:
                chance = Chance(seed, k, cells[1])
                self._soft[i] = tracer.follow(sensor, pixels, chance, self._soft[i])
        self._passes += len(passes)

    def exposure(self) -> Exposure:
        """Return the mean of all passes."""
        tracer = self._tracer
        direct, color = tracer.sharp.pictures(self._sharp, tracer.looks * self._passes)
        indirect, dye = tracer.soft.pictures(self._soft, self._passes)
        return Exposure(direct, color, indirect, dye)


def _played(stage: Callable[..., Any]) -> Any:
    """Return a stage of the work that is recorded once and then played back.

    Few paths may be as many as something else by chance, which takes a recording of its own.
    """
    return dr.freeze(stage, limit=RECORDINGS, warn_after=1 << 30)


def _looked(
    scene: Any, pixels: Any, ray: Any, lamps: bool, sums: tuple[Any, Any], draws: Draws
) -> tuple[Any, Any]:
    """Add what is seen through every pixel, as lamps light it, and its colours."""
    si = scene.ray_intersect(ray, mi.RayFlags.All, coherent=True)
    emitter = si.emitter(scene)
    light = emitter.eval(si, emitter != None)  # noqa: E711  (compared lane by lane)
    lamp, arriving = scene.sample_emitter_direction(
        si, pair(pixels, draws, ON_LAMP), False, si.is_valid()
    )

    def answer(surface: Any, si: Any, toward: Any) -> Any:
        # Asked for together, so that textures are read once.
        return *surface.eval_pdf(mi.BSDFContext(), si, toward), surface.eval_diffuse_reflectance(si)

    value, density, color = dr.dispatch(si.bsdf(), answer, si, si.to_local(lamp.d))
    if lamps:
        light += _reached(scene, si, lamp, density, value * arriving, si.is_valid(), coherent=True)
    return sums[0] + light, sums[1] + dr.select(si.is_valid(), color + GLEAM, 0.0)


def _begun(scene: Any, pixels: Any, ray: Any, fresh: tuple[Any, Any]) -> Paths:
    """Begin a path in every pixel."""
    lanes = dr.arange(mi.UInt32, dr.width(pixels))
    hit = scene.ray_intersect_preliminary(ray, coherent=True)
    return Paths(lanes, pixels, ray.o, ray.d, hit, *fresh)


def _ray(sensor: Any, pixels: Any, size: tuple[int, int], draws: Draws) -> Any:
    """Return a ray through every pixel. This is not recorded: not every lens can be."""
    place, lens = pair(pixels, draws, ON_LAMP), pair(pixels, draws, ALONG)
    column, row = pixels % size[0], pixels // size[0]
    film = mi.Point2f((mi.Float(column) + place.x) / size[0], (mi.Float(row) + place.y) / size[1])
    ray, _ = sensor.sample_ray(0.0, 0.5, film, lens)
    return mi.Ray3f(ray.o, ray.d)


def _shaded(
    scene: Any,
    paths: Paths,
    sums: tuple[Any, Any],
    draws: Draws,
    first: Any,
    sky_is_asked: bool,
) -> tuple[Paths, Any, Any]:
    """Light the surfaces that were met and send the paths on; return them and the sums.

    What lamps do for the first surface is found by looks, and is left out here.
    """
    si = paths.met()
    lamp, arriving = scene.sample_emitter_direction(si, pair(paths.pixel, draws, ON_LAMP), False)

    def answer(surface: Any, si: Any, toward: Any, u: Any, v: Any) -> Any:
        color = surface.eval_diffuse_reflectance(si)
        return *surface.eval_pdf_sample(mi.BSDFContext(), si, toward, u, v), color

    value, density, going, share, color = dr.dispatch(
        si.bsdf(),
        answer,
        si,
        si.to_local(lamp.d),
        line(paths.pixel, draws),
        pair(paths.pixel, draws, ALONG),
    )
    light = _reached(scene, si, lamp, density, paths.weight * value * arriving, ~first)
    light += dr.select(first, 0.0, _finite(paths.weight * _glow(scene, si, paths)))
    weight = _finite(paths.weight * share)
    free = mi.has_flag(going.sampled_type, mi.BSDFFlags.Delta)
    further = si.spawn_ray(si.to_world(going.wo))
    onward = Paths(
        paths.lane,
        paths.pixel,
        further.o,
        further.d,
        scene.ray_intersect_preliminary(mi.Ray3f(further.o, further.d)),
        mi.Color3f(weight),
        mi.Float(dr.select(free, 0.0, going.pdf)),
    )
    # What carries nothing ends here.
    onward.hit.t = dr.select(dr.max(weight) > 0.0, onward.hit.t, dr.inf)
    light += dr.select(
        onward.hit.is_valid(), 0.0, onward.weight * _sky(scene, onward, si, sky_is_asked)
    )
    dye = dr.select(first, color + GLEAM, 0.0)
    return onward, _added(sums[0], paths, _finite(light)), _added(sums[1], paths, dye)


def _reached(
    scene: Any,
    si: Any,
    lamp: Any,
    density: Any,
    light: Any,
    asked: Any,
    *,
    coherent: bool = False,
) -> Any:
    """Return the light of a lamp, weighted against rays along the surface, if nothing hides it."""
    light = _finite(light * dr.select(lamp.delta, 1.0, lamp.pdf / (lamp.pdf + density)))
    asked = asked & (lamp.pdf > 0.0) & (dr.max(light) > 0.0)
    hidden = scene.ray_test(si.spawn_ray_to(lamp.p), coherent, asked)
    return dr.select(asked & ~hidden, light, 0.0)


def _sky(scene: Any, paths: Paths, before: Any, is_asked: bool) -> Any:
    """Return the light of the sky that rays along the surface meet."""
    sky = scene.environment()
    if sky is None:
        return mi.Color3f(0.0)
    nothing = dr.zeros(mi.SurfaceInteraction3f)
    nothing.wi = -paths.toward
    light = sky.eval(nothing)
    if not is_asked:
        return light
    seen = dr.zeros(mi.DirectionSample3f, dr.width(paths.lane))
    seen.d, seen.emitter = paths.toward, mi.EmitterPtr(sky)
    return _weighed(paths, scene.pdf_emitter_direction(before, seen)) * light


def _weighed(paths: Paths, density: Any) -> Any:
    """Return the weight of a ray along the surface against one sent to the light it meets."""
    return _finite(dr.select(paths.pdf > 0.0, paths.pdf / (paths.pdf + density), 1.0))


def _finite(values: Any) -> Any:
    """Return values without those of directions that could not be drawn."""
    return dr.select(dr.isfinite(values), values, 0.0)


def _shining(paths: Paths) -> Any:
    """Return which paths meet a surface that gives off light."""
    return paths.hit.is_valid() & paths.hit.shape.is_emitter()


def _ended(scene: Any, paths: Paths, light: Any) -> Any:
    """Return the sums with the light of the surfaces at which paths end."""
    si = paths.met()
    return _added(light, paths, _finite(paths.weight * _glow(scene, si, paths)))


def _added(sums: Any, paths: Paths, more: Any) -> Any:
    """Return `sums` with something more for the lane of each path; no two share one."""
    dr.scatter(sums, dr.gather(mi.Color3f, sums, paths.lane) + more, paths.lane)
    return sums


def _glow(scene: Any, si: Any, paths: Paths) -> Any:
    """Return the light that the surfaces met give off, weighted against rays sent to lights."""
    emitter = si.emitter(scene)
    glows = emitter != None  # noqa: E711  (compared lane by lane)
    seen = dr.zeros(mi.DirectionSample3f, dr.width(paths.lane))
    seen.p, seen.n, seen.uv, seen.d, seen.dist = si.p, si.n, si.uv, paths.toward, si.t
    seen.emitter = emitter
    before = dr.zeros(mi.Interaction3f, dr.width(paths.lane))
    before.p = paths.begin
    density = scene.pdf_emitter_direction(before, seen, glows)
    return _weighed(paths, density) * emitter.eval(si, glows)
