"""Wavefront path tracer: all paths of an image advance together, one bounce at a time.

It solves what Mitsuba's `path` solves, with the same scene, lights and surfaces, and differs in
how the work is laid out, which decides the speed on a CPU:

- Only live paths are traced. Outdoors four of five rays that leave a surface end in the sky; a
  loop inside one kernel drags them along in half-empty vectors.
- Samples are stratified pass by pass (`stratification`), so that rays that are adjacent in
  memory, those of a small square of pixels, go to the same part of the sphere.
- A pass is traced in Python once and then replayed, until the scene changes.
- Direct light on visible surfaces, and their albedo, are sharp and cheap; sky light and indirect
  light are soft and expensive. So direct light has several samples for each path, and both are
  returned apart; for a preview, indirect light is an image half as wide and high. Paths start
  where one of the samples of their pixel met a surface (`path_starts`).
- Haze lies between the camera and what it sees; reflections and light on its way do without.
- Clouds dim the key light wherever it arrives.
- Water is a surface of its own (`water`): rays from the camera go on from it in two directions,
  and all other rays pass it straight.

Sums are added up pass after pass and pixel by pixel, never by concurrent threads, so that the
same seed gives the same bits.

Source: Laine, Karras, Aila, Megakernels Considered Harmful, 2013, for wavefronts; Veach,
Robust Monte Carlo Methods for Light Transport Simulation, 1997, ch. 9, for multiple importance
sampling of emitters and BSDFs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from render.config.film import RAYS_PER_PATH
from render.frame import ALBEDO_BIAS, LightLayers
from render.surfaces.bsdf_plugins import eval_pdf_sample_albedo
from render.tracing.camera_rays import CameraView
from render.tracing.cloud_shade import CloudShade, dimmed
from render.tracing.direct_light import finite, passed_air, surface_light, unoccluded
from render.tracing.emitter_choice import emitter_sample, has_one_lamp
from render.tracing.haze import Air
from render.tracing.path_starts import PathStarts, StartLanes
from render.tracing.scene_pair import ScenePair, emitters_of
from render.tracing.sky_relief import SkyRelief, sky_share
from render.tracing.stratification import (
    BSDF_PAIR,
    EMITTER_PAIR,
    PassStrata,
    StepStrata,
    sample_1d,
    sample_2d,
    stratum_grid,
)
from render.tracing.tracer import Accumulator, PixelLanes, Sums, Tracer
from render.tracing.water import Water
from render.tracing.water_light import add_water, beyond_water

MAX_RECORDINGS = 8
"""Recordings that are kept of one stage."""

CERTAIN_THROUGHPUT, LEAST_CHANCE = 0.2, 0.3
"""Throughput from which on a path of a preview goes on for certain, and its least chance below."""


@dataclass
class Paths:
    """Live paths, one to a lane.

    Attributes:
        lane: index in the sums.
        pixel: number of the pixel, row by row.
        origin: of the last segment [m].
        direction: of the last segment, unit vector.
        hit: intersection of the last segment.
        weight: throughput.
        pdf: density of the sampled direction [1/sr]; 0 for a delta distribution.
    """

    lane: mi.UInt32
    pixel: mi.UInt32
    origin: mi.Point3f
    direction: mi.Vector3f
    hit: mi.PreliminaryIntersection3f
    weight: mi.Color3f
    pdf: mi.Float

    def interaction(self) -> Any:
        """Return the surface interaction at the end of the last segment."""
        return self.hit.compute_surface_interaction(mi.Ray3f(self.origin, self.direction))


class Wavefront(Tracer):
    """Traces one scene.

    Args:
        scene: of Mitsuba, or a `ScenePair`; see `mitsuba_scene.wavefront_limitation` for what is
            not supported.
        size: width and height of the frame [pixels].
        depth: longest path, in segments.
        half: whether indirect light is traced at half the size, with one direct sample per pixel.
        air: haze before the camera, None without any.
        water: of the scene, None without any.
        relief: of surfaces in the light of the sky, None to do without.

    Attributes:
        shade: of clouds on the key light, None without any; it may change with the scene.
        direct_samples: for each path.
        keeps_open_light: whether direct light without shadows is summed up, too: of a preview
            with one lamp, where it has no noise.
        direct: pixels of direct light.
        indirect: pixels of indirect light.
    """

    def __init__(
        self,
        scene: Any,
        size: tuple[int, int],
        depth: int,
        *,
        half: bool = False,
        air: Air | None = None,
        water: Water | None = None,
        relief: SkyRelief | None = None,
    ) -> None:
        self._scene, self._depth, self._air, self._water = scene, depth, air, water
        self._relief = relief
        self._has_still = isinstance(scene, ScenePair)
        self.shade: CloudShade | None = None
        self.direct_samples = 1 if half else RAYS_PER_PATH
        self.direct = PixelLanes(size)
        self.indirect = PixelLanes((size[0] // 2, size[1] // 2)) if half else self.direct
        self._lanes = StartLanes.of(self.direct, self.indirect)
        sky = scene.environment()
        self._samples_sky = sky is not None and sky.sampling_weight() > 0.0
        self.keeps_open_light = half and has_one_lamp(scene)
        self._plays_roulette = half
        self._total = 0
        # Each scene has recordings of its own, which are freed with it.
        self._add_direct = _recorded(_add_direct)
        self._add_water = _recorded(add_water)
        self._start_paths = _recorded(_start_paths)
        self._bounce = _recorded(_bounce)
        self._hits_emitter = _recorded(_hits_emitter)
        self._add_emission = _recorded(_add_emission)
        self._stages: Mapping[str, Any] = {
            "direct light": self._add_direct,
            "water": self._add_water,
            "path start": self._start_paths,
            "bounce": self._bounce,
            "emitter hit": self._hits_emitter,
            "emission": self._add_emission,
        }

    @property
    def recordings(self) -> Mapping[str, int]:
        """Number of recordings of each stage since the scene changed."""
        return {name: stage.n_recordings for name, stage in self._stages.items()}

    def accumulator(self, kept_distances: int = 0) -> Accumulator:
        """Return an empty accumulator; see `Tracer.accumulator`."""
        return _Accumulator(self, kept_distances)

    def scene_changed(self) -> None:
        """Forget the recordings.

        Replayed after a change, they would keep some of the old scene: Dr.Jit 1.5 tracks the
        buffers of a scene that it replaced itself, but not always Embree's.
        """
        for stage in self._stages.values():
            stage.clear()

    def set_total(self, passes: int) -> None:
        """Set the number of passes over which the samples of a frame are stratified."""
        if passes != self._total:
            # A replay does not notice changes of the Python numbers in the strata.
            self.scene_changed()
            self._total = passes

    def add_direct(
        self,
        view: CameraView,
        chunk: int,
        strata: PassStrata,
        sums: Sums,
        starts: PathStarts,
        distances: Any = None,
    ) -> Sums:
        """Return the sums of direct light, albedo and air with a sample more of every pixel.

        Args:
            view: the camera.
            chunk: number of the chunk of `direct`.
            strata: of the pass.
            sums: of the chunk.
            starts: of the paths, to which those of this pass are written.
            distances: of all pixels, to which those of the chunk are written, or None.
        """
        pixels = self.direct.chunks[chunk]
        ray, held = view.rays(pixels, self.direct.size, strata, self._has_still)
        around = self._scene, self._air, self.shade, self._water, self._relief
        has_lamps, step = self._depth > 1, strata.step(1)
        *added, meets_water, origin, way, hit = self._add_direct(
            *around, pixels, ray, held, has_lamps, sums, step
        )
        # Not recorded: a replay would copy all starts before it writes to them.
        lanes = self._lanes.of_pass(chunk, pixels, strata.k, self.direct_samples)
        starts.write(origin, way, hit, *lanes)
        if distances is not None:
            dr.scatter(distances, dr.select(hit.is_valid(), hit.t, dr.inf), pixels)
        if self._water is None:
            return tuple(added)
        wet = mi.UInt32(dr.compress(meets_water))
        if dr.width(wet) == 0:
            return tuple(added)
        rays = dr.gather(mi.UInt32, pixels, wet), dr.gather(mi.Ray3f, ray, wet)
        return self._add_water(*around, wet, *rays, has_lamps, added, strata.step(2))

    def add_indirect(self, chunk: int, strata: PassStrata, sums: Sums, starts: PathStarts) -> Sums:
        """Return the sums of indirect light and albedo with one more path of every pixel.

        Args:
            chunk: number of the chunk of `indirect`.
            strata: of the pass.
            sums: of the chunk.
            starts: of all paths of the pass.
        """
        if self._depth == 1:
            return sums
        pixels = self.indirect.chunks[chunk]
        count = dr.width(pixels)
        # Full width, although all are equal, so that later steps share the kernel of the first.
        initial = dr.opaque(mi.Color3f, 1.0, count), dr.opaque(mi.Float, 0.0, count)
        first = dr.opaque(mi.UInt32, self.indirect.first_lane(chunk))
        around = self._scene, self._air, self._water
        paths, goes_on = self._start_paths(*around, pixels, starts, first, initial, strata.step(0))
        for step in range(1, self._depth):
            live = mi.UInt32(dr.compress(goes_on))
            if dr.width(live) == 0:
                return sums
            paths = dr.gather(Paths, paths, live)
            is_first = dr.opaque(mi.Bool, step == 1)
            paths, goes_on, *added = self._bounce(
                *(self._scene, self.shade, self._water, self._relief, paths, sums),
                *(strata.step(step), is_first, self._samples_sky, self._plays_roulette),
            )
            sums = added[0], added[1]
        shining = mi.UInt32(dr.compress(self._hits_emitter(paths, goes_on)))
        if dr.width(shining):
            paths = dr.gather(Paths, paths, shining)
            sums = self._add_emission(self._scene, self.shade, paths, sums[0]), sums[1]
        return sums


class _Accumulator(Accumulator):
    """Sums direct samples and paths apart, chunk by chunk of the image."""

    def __init__(self, tracer: Wavefront, kept_distances: int) -> None:
        self._tracer, self._kept_distances = tracer, kept_distances
        self._direct = tracer.direct.zero_sums(4 if tracer.keeps_open_light else 3)
        self._indirect = tracer.indirect.zero_sums(2)
        self._passes = 0

    def add_passes(self, view: CameraView, seed: int, passes: range, total: int) -> None:
        """Add what the sensor sees now."""
        tracer = self._tracer
        tracer.set_total(total)
        count = tracer.direct_samples
        grids = stratum_grid(count * total), stratum_grid(total)
        direct, indirect = self._direct, self._indirect
        starts = PathStarts.of(tracer.indirect.count)
        for k in passes:
            for sample in range(count * k, count * (k + 1)):
                strata = PassStrata(seed + 1, sample, grids[0])
                distances = None
                if count * total == self._kept_distances:
                    distances = dr.zeros(mi.Float, tracer.direct.count)
                    self.distances += (distances,)
                for i in range(len(direct)):
                    added = view, i, strata, direct[i], starts, distances
                    direct[i] = tracer.add_direct(*added)
            strata = PassStrata(seed, k, grids[1])
            for i in range(len(indirect)):
                indirect[i] = tracer.add_indirect(i, strata, indirect[i], starts)
        self._passes += len(passes)

    def layers(self) -> LightLayers:
        """Return the mean of all passes."""
        tracer = self._tracer
        count = tracer.direct_samples * self._passes
        direct, albedo, air, *open_light = tracer.direct.means(self._direct, count)
        indirect, indirect_albedo = tracer.indirect.means(self._indirect, self._passes)
        return LightLayers(direct, albedo, indirect, indirect_albedo, air, *open_light)


def _recorded(stage: Callable[..., Any]) -> Any:
    """Return a stage that is recorded once and then replayed.

    The number of live paths may equal another number by chance, which takes another recording.
    """
    return dr.freeze(stage, limit=MAX_RECORDINGS, warn_after=1 << 30)


def _add_direct(
    scene: Any,
    air: Air | None,
    shade: CloudShade | None,
    water: Water | None,
    relief: SkyRelief | None,
    pixels: Any,
    ray: Any,
    held: Any,
    has_lamps: bool,
    sums: Sums,
    strata: StepStrata,
) -> tuple[Any, ...]:
    """Add visible surfaces with direct light, their albedo, and auxiliary layers.

    Returns:
        The sums; whether rays meet water first, and then they have what lies before it alone; the
        rays; and what they meet.
    """
    u = sample_2d(pixels, strata, EMITTER_PAIR), sample_1d(pixels, strata)
    if held is None:
        hit = scene.ray_intersect_preliminary(ray, coherent=True)
    else:
        ray, hit = scene.first_hit(ray, held, coherent=True)
    light, open_light, albedo, shining, distance = surface_light(
        scene, shade, water, relief, ray, hit, u, has_lamps, coherent=True
    )
    meets = mi.Bool(False)
    if water is not None:
        surface = water.crossing(ray)
        meets = surface < distance
        distance = dr.minimum(distance, surface)
        is_below = water.is_below(ray.o)
        passed = dr.select(is_below, water.transmittance(distance), mi.Color3f(1.0))
        passed = dr.select(meets, 0.0, passed)
        light, albedo, shining = light * passed, albedo * passed, shining * passed
        open_light *= passed
        shining += dr.select(is_below, water.scattered(ray.o, ray.d, distance), 0.0)
        # There is no haze under water.
        distance = dr.select(is_below, dr.inf, distance)
    if air is not None:
        passed = passed_air(air, ray, distance)
        light, albedo, open_light = light * passed, albedo * passed, open_light * passed
        shining = shining * passed + air.scattered(ray.d) * (1.0 - passed)
    added = light, albedo, shining, open_light
    # Light without shadows is not always asked for.
    totals = (total + value for total, value in zip(sums, added, strict=False))
    return *totals, meets, ray.o, ray.d, hit


def _start_paths(
    scene: Any,
    air: Air | None,
    water: Water | None,
    pixels: Any,
    starts: PathStarts,
    first: Any,
    initial: tuple[Any, Any],
    strata: StepStrata,
) -> tuple[Paths, Any]:
    """Return paths with their first segments, and whether these meet a surface.

    Args:
        scene: of Mitsuba, or a `ScenePair`.
        air: haze before the camera, None without any.
        water: of the scene, None without any.
        pixels: of the paths.
        starts: of all paths.
        first: place of the first of these among them.
        initial: throughput and density, of full width.
        strata: of the step.
    """
    lanes = dr.arange(mi.UInt32, dr.width(pixels))
    ray, hit = starts.read(first + lanes)
    weight, pdf = initial
    if water is not None:
        ray, hit, passed = beyond_water(scene, air, water, ray, hit, sample_1d(pixels, strata))
        weight = weight * passed
    elif air is not None:
        weight = weight * passed_air(air, ray, dr.select(hit.is_valid(), hit.t, dr.inf))
    return Paths(lanes, pixels, ray.o, ray.d, hit, weight, pdf), hit.is_valid()


def _bounce(
    scene: Any,
    shade: CloudShade | None,
    water: Water | None,
    relief: SkyRelief | None,
    paths: Paths,
    sums: Sums,
    strata: StepStrata,
    is_first: Any,
    samples_sky: bool,
    plays_roulette: bool,
) -> tuple[Paths, Any, Any, Any]:
    """Light the surfaces at the ends of the paths and extend the paths.

    Returns the paths, whether they meet a surface and go on from there, and the sums.

    Direct light on the first surface has samples of its own and is left out here.

    With roulette, some paths of little throughput end, and the others carry the more. Those of the
    first surface end only where they meet another: there they cost most, and the sky, which most of
    them meet, gives most of the light.
    """
    si = paths.interaction()
    choice = sample_1d(paths.pixel, strata)
    sample, arriving = emitter_sample(
        scene, si, sample_2d(paths.pixel, strata, EMITTER_PAIR), choice
    )
    arriving *= dimmed(shade, sample.emitter, si.p)

    value, bsdf_pdf, scattered, share, albedo, normal = dr.dispatch(
        si.bsdf(),
        eval_pdf_sample_albedo,
        si,
        si.to_local(sample.d),
        choice,
        sample_2d(paths.pixel, strata, BSDF_PAIR),
    )
    if water is not None:
        wet = water.wetness(si.p, si.n)
        albedo, value, share = albedo * wet, value * wet, share * wet
        arriving = arriving * water.reaching(si.p, sample)
    arriving *= paths.weight * value
    light, _ = unoccluded(scene, si, sample, bsdf_pdf, arriving, ~is_first)
    light += dr.select(is_first, 0.0, finite(paths.weight * _emission(scene, shade, si, paths)))
    weight = finite(paths.weight * share)
    is_delta = mi.has_flag(scattered.sampled_type, mi.BSDFFlags.Delta)
    ray = si.spawn_ray(si.to_world(scattered.wo))
    goes_on, stays = dr.max(weight) > 0.0, mi.Bool(True)
    chance: Any = mi.Float(1.0)
    if plays_roulette:
        chance = dr.clip(dr.max(weight) / CERTAIN_THROUGHPUT, LEAST_CHANCE, 1.0)
        stays = sample_1d(paths.pixel, strata, 1) < chance
    goes_on &= is_first | stays
    extended = Paths(
        paths.lane,
        paths.pixel,
        ray.o,
        ray.d,
        scene.ray_intersect_preliminary(mi.Ray3f(ray.o, ray.d), active=goes_on),
        dr.select(goes_on, weight / dr.select(is_first, 1.0, chance), 0.0),
        mi.Float(dr.select(is_delta, 0.0, scattered.pdf)),
    )
    if water is not None:
        extended.weight *= water.along(ray.o, ray.d, extended.hit.t)
    light += dr.select(
        extended.hit.is_valid(), 0.0, extended.weight * _sky(scene, extended, si, samples_sky)
    )
    extended.weight = dr.select(is_first, extended.weight / chance, extended.weight)
    goes_on &= stays & extended.hit.is_valid()
    # The first weight is what the haze lets through.
    first_albedo = (albedo + ALBEDO_BIAS) * sky_share(relief, si, normal) * paths.weight
    first_albedo = dr.select(is_first, first_albedo, 0.0)
    added = _add(sums[0], paths, finite(light)), _add(sums[1], paths, first_albedo)
    return extended, goes_on, *added


def _sky(scene: Any, paths: Paths, origin: Any, is_sampled: bool) -> Any:
    """Return the light of the sky along BSDF samples, with its MIS weight."""
    sky = scene.environment()
    if sky is None:
        return mi.Color3f(0.0)
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = -paths.direction
    light = sky.eval(si)
    if not is_sampled:
        return light
    sample = dr.zeros(mi.DirectionSample3f, dr.width(paths.lane))
    sample.d, sample.emitter = paths.direction, mi.EmitterPtr(sky)
    return _bsdf_mis(paths, scene.pdf_emitter_direction(origin, sample)) * light


def _bsdf_mis(paths: Paths, emitter_pdf: Any) -> Any:
    """Return the MIS weight of a BSDF sample that meets an emitter."""
    return finite(dr.select(paths.pdf > 0.0, paths.pdf / (paths.pdf + emitter_pdf), 1.0))


def _hits_emitter(paths: Paths, goes_on: Any) -> Any:
    return goes_on & paths.hit.shape.is_emitter()


def _add_emission(scene: Any, shade: CloudShade | None, paths: Paths, light: Any) -> Any:
    """Return the sums with the emission of the surfaces at the ends of the paths."""
    si = paths.interaction()
    return _add(light, paths, finite(paths.weight * _emission(scene, shade, si, paths)))


def _add(sums: Any, paths: Paths, values: Any) -> Any:
    """Return `sums` with a value added in the lane of each path; no two paths share one."""
    dr.scatter(sums, dr.gather(mi.Color3f, sums, paths.lane) + values, paths.lane)
    return sums


def _emission(scene: Any, shade: CloudShade | None, si: Any, paths: Paths) -> Any:
    """Return the emission of the surfaces, with the MIS weight of BSDF samples."""
    emitter = si.emitter(emitters_of(scene))
    is_emitter = emitter != None  # noqa: E711  (compared lane by lane)
    sample = dr.zeros(mi.DirectionSample3f, dr.width(paths.lane))
    sample.p, sample.n, sample.uv, sample.d, sample.dist = si.p, si.n, si.uv, paths.direction, si.t
    sample.emitter = emitter
    origin = dr.zeros(mi.Interaction3f, dr.width(paths.lane))
    origin.p = paths.origin
    pdf = scene.pdf_emitter_direction(origin, sample, is_emitter)
    light = emitter.eval(si, is_emitter) * dimmed(shade, emitter, paths.origin)
    return _bsdf_mis(paths, pdf) * light
