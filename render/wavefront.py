"""The wavefront tracer: all paths of a picture advance together, one bounce at a time.

It solves what Mitsuba's `path` solves, with the same scene, lights and surfaces, and differs
in how the work is laid out, which decides the speed on a CPU:

- Only paths that still go on are worked on. Outdoors four of five rays that leave a surface
  end in the sky; a loop inside one kernel drags the others along in half-empty vectors.
- Samples are stratified pass by pass (`strata`), so that rays that lie beside each other in
  memory, those of a small square of the picture, go into the same part of the sphere.
- A pass is traced in Python once and then played back, whatever has moved.
- The colour of what is seen first comes along without rays of its own.

Sums are added up pass after pass and pixel by pixel, never by threads that meet, so that the
same seed gives the same bits.

Source: Laine, Karras, Aila, Megakernels Considered Harmful, 2013, for wavefronts; Veach,
Robust Monte Carlo Methods for Light Transport Simulation, 1997, ch. 9, for the weights of
rays to lights and rays along the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from render.strata import grid

Image = NDArray[np.float32]

LANES = 1 << 19
"""Most paths that are under way at once, which bounds the memory."""

TILE = 4
"""Side of the squares of pixels whose paths lie beside each other."""

TOGETHER = 1
"""The pair, along the surface, of which all pixels have the same cell in the same pass."""


@dataclass
class Draws:
    """What one step of one pass draws its samples by.

    Attributes:
        key: of the numbers that pixels draw in this pass.
        base: of those that they keep over all passes.
        k: number of the pass.
        grid: columns and rows of cells in each pair of dimensions, one for every pass.
    """

    key: mi.UInt32
    base: mi.UInt32
    k: mi.UInt32
    grid: tuple[int, int]


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


@dataclass(frozen=True)
class Chance:
    """Where the samples of one pass of a picture lie."""

    seed: int
    k: int
    grid: tuple[int, int]

    def draws(self, step: int) -> Draws:
        """Return what step `step` of the paths draws by; 0 is at the eye."""
        key = self.seed * 0x9E3779B1 + step * 0xC2B2AE3D
        drawn = Draws(
            mi.UInt32((key + (self.k + 1) * 0x85EBCA77) & 0xFFFFFFFF),
            mi.UInt32(key & 0xFFFFFFFF),
            mi.UInt32(self.k),
            self.grid,
        )
        # Numbers that a kernel had to be compiled for would cost more than they say.
        dr.make_opaque(drawn)
        return drawn


@dataclass
class Sums:
    """What the paths of all passes have brought, lane by lane."""

    light: mi.Color3f
    color: mi.Color3f


class Wavefront:
    """Traces one scene.

    Args:
        scene: of Mitsuba; see `refusal` for what it must not have.
        size: width and height of the picture [pixels].
        depth: longest path, in segments.
    """

    def __init__(self, scene: Any, size: tuple[int, int], depth: int) -> None:
        self._scene, self._size, self._depth = scene, size, depth
        order = _tiled(*size)
        self._back = np.argsort(order)
        self._parts = [mi.UInt32(p) for p in np.array_split(order, -(-len(order) // LANES))]
        # Each scene has recordings of its own, which go when it goes.
        self._seen: Any = dr.freeze(_seen)
        self._colored: Any = dr.freeze(_colored)
        self._shaded: Any = dr.freeze(_shaded)
        self._lit: Any = dr.freeze(_lit)
        self._ended: Any = dr.freeze(_ended)

    def expose(
        self, sensor: Any, seed: int, passes: range, of: int, colors: bool
    ) -> tuple[Image, Image | None]:
        """Return the light and the colour of what is seen first; see `tracer.Tracer`."""
        cells = grid(of)
        lights, albedos = [], []
        for pixels in self._parts:
            sums = Sums(*(dr.opaque(mi.Color3f, 0.0, len(pixels)) for _ in range(2)))
            for k in passes:
                self._pass(sensor, pixels, Chance(seed, k, cells), sums, colors)
            lights.append(np.array(sums.light))
            albedos.append(np.array(sums.color))
        light = self._picture(lights, len(passes))
        return light, self._picture(albedos, len(passes)).clip(0.0, 1.0) if colors else None

    def _pass(self, sensor: Any, pixels: Any, chance: Chance, sums: Sums, colors: bool) -> None:
        """Add one sample of every pixel to the sums."""
        count = dr.width(pixels)
        # Held in full, although all are equal, so that later steps have the kernel of the first.
        fresh = dr.opaque(mi.Color3f, 1.0, count), dr.opaque(mi.Float, 0.0, count)
        paths, sums.light = self._seen(
            self._scene, sensor, pixels, self._size, fresh, sums.light, chance.draws(0)
        )
        for step in range(1, self._depth):
            going = mi.UInt32(dr.compress(paths.hit.is_valid()))
            if dr.width(going) == 0:
                break
            paths = dr.gather(Paths, paths, going)
            if colors and step == 1:
                sums.color = self._colored(paths, sums.color)
            paths, sums.light = self._shaded(self._scene, paths, sums.light, chance.draws(step))
        shining = mi.UInt32(dr.compress(self._lit(paths)))
        if dr.width(shining):
            paths = dr.gather(Paths, paths, shining)
            sums.light = self._ended(self._scene, paths, sums.light)

    def _picture(self, parts: list[Image], count: int) -> Image:
        width, height = self._size
        rows = np.concatenate(parts, axis=1)[:, self._back].T / np.float32(count)
        return np.ascontiguousarray(rows.reshape(height, width, 3), np.float32)


def _seen(
    scene: Any,
    sensor: Any,
    pixels: Any,
    size: tuple[int, int],
    fresh: tuple[Any, Any],
    light: Any,
    draws: Draws,
) -> tuple[Paths, Any]:
    """Send a ray through every pixel; return the paths, and the sums with the sky that they see."""
    place, lens = _pair(pixels, draws, 0), _pair(pixels, draws, 1)
    column, row = pixels % size[0], pixels // size[0]
    film = mi.Point2f((mi.Float(column) + place.x) / size[0], (mi.Float(row) + place.y) / size[1])
    ray, _ = sensor.sample_ray(0.0, 0.5, film, lens)
    lanes = dr.arange(mi.UInt32, dr.width(pixels))
    none = dr.zeros(mi.PreliminaryIntersection3f)
    paths, sky = _met(scene, Paths(lanes, pixels, ray.o, ray.d, none, *fresh))
    return paths, light + sky


def _met(scene: Any, paths: Paths) -> tuple[Paths, Any]:
    """Find what each ray meets, and the light of the sky where that is nothing."""
    hit = scene.ray_intersect_preliminary(paths.ray)
    sky = scene.environment()
    shine = mi.Color3f(0.0)
    if sky is not None:
        nothing = dr.zeros(mi.SurfaceInteraction3f)
        nothing.wi = -paths.toward
        shine = dr.select(hit.is_valid(), 0.0, paths.weight * sky.eval(nothing))
    # What carries nothing ends here.
    hit.t = dr.select(dr.max(paths.weight) > 0.0, hit.t, dr.inf)
    return replace(paths, hit=hit), shine


def _colored(paths: Paths, color: Any) -> Any:
    """Return the sums of colours with those of the surfaces that were met."""
    si = paths.met()
    return _added(color, paths, si.bsdf().eval_diffuse_reflectance(si))


def _shaded(scene: Any, paths: Paths, light: Any, draws: Draws) -> tuple[Paths, Any]:
    """Light the surfaces that were met and send the paths on; return them and the sums."""
    si = paths.met()
    lamp, arriving = scene.sample_emitter_direction(si, _pair(paths.pixel, draws, 0), False)
    value: Any
    share: Any
    value, density, going, share = si.bsdf().eval_pdf_sample(
        mi.BSDFContext(),
        si,
        si.to_local(lamp.d),
        _line(paths.pixel, draws),
        _pair(paths.pixel, draws, 1),
    )
    reached = paths.weight * value * arriving
    reached *= dr.select(lamp.delta, 1.0, lamp.pdf / (lamp.pdf + density))
    asked = (lamp.pdf > 0.0) & (dr.max(reached) > 0.0)
    hidden = scene.ray_test(si.spawn_ray_to(lamp.p), asked)
    gained = paths.weight * _glow(scene, si, paths) + dr.select(asked & ~hidden, reached, 0.0)
    free = mi.has_flag(going.sampled_type, mi.BSDFFlags.Delta)
    further = si.spawn_ray(si.to_world(going.wo))
    onward, sky = _met(
        scene,
        Paths(
            paths.lane,
            paths.pixel,
            further.o,
            further.d,
            paths.hit,
            paths.weight * share,
            mi.Float(dr.select(free, 0.0, going.pdf)),
        ),
    )
    return onward, _added(light, paths, gained + sky)


def _lit(paths: Paths) -> Any:
    """Return which paths meet a surface that gives off light."""
    return paths.hit.is_valid() & paths.hit.shape.is_emitter()


def _ended(scene: Any, paths: Paths, light: Any) -> Any:
    """Return the sums with the light of the surfaces at which paths end."""
    si = paths.met()
    return _added(light, paths, paths.weight * _glow(scene, si, paths))


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
    share = dr.select(paths.pdf > 0.0, paths.pdf / (paths.pdf + density), 1.0)
    return share * emitter.eval(si, glows)


def _pair(pixel: Any, draws: Draws, i: int) -> Any:
    """Return the `i`-th pair of numbers that a pixel draws, each pass in a cell of its own.

    Source: Kensler, Correlated Multi-Jittered Sampling, 2013.
    """
    columns, rows = draws.grid
    u, v = _uniform(pixel, draws.key + i)
    shuffle, across = _hash(pixel, draws.base + (2 * i + 1) * 0x1000193)
    cell = draws.k if i == TOGETHER else mi.permute_kensler(draws.k, columns * rows, shuffle)
    column, row = cell // rows, cell % rows
    down = _hash(pixel, draws.base + (2 * i + 2) * 0x1000193 + row)[0]
    # Within a column each row has a strip of its own, and within a row each column.
    x = mi.Float(mi.permute_kensler(row, rows, across + column)) + u
    y = mi.Float(mi.permute_kensler(column, columns, down)) + v
    return mi.Point2f((mi.Float(column) + x / rows) / columns, (mi.Float(row) + y / columns) / rows)


def _line(pixel: Any, draws: Draws) -> Any:
    count = draws.grid[0] * draws.grid[1]
    place = mi.permute_kensler(draws.k, count, _hash(pixel, draws.base)[0])
    return (mi.Float(place) + _uniform(pixel, draws.key + 2)[0]) / count


def _uniform(pixel: Any, key: Any) -> tuple[Any, Any]:
    """Return two numbers in [0, 1) of a pixel, by a hash and without a state."""
    a, b = _hash(pixel, key)
    scale = 1.0 / (1 << 24)
    return mi.Float(a >> 8) * scale, mi.Float(b >> 8) * scale


def _hash(pixel: Any, key: Any) -> Any:
    return mi.sample_tea_32(pixel, key)


def _tiled(width: int, height: int) -> NDArray[np.uint32]:
    """Return the pixels, square after square."""
    y, x = np.mgrid[0:height, 0:width]
    across = -(-width // TILE)
    place = ((y // TILE) * across + x // TILE) * TILE**2 + (y % TILE) * TILE + x % TILE
    return np.argsort(place.ravel(), kind="stable").astype(np.uint32)
