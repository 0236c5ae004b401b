"""Shot: the renderer's input for one frame.

A shot is a value. Two shots with equal digests give the same frame on the same backend, so the
digest, with the backend and the denoiser, is the key of a finished frame.

Meshes are in world coordinates: metres, Y up, right handed. From frame to frame usually only
vertices and camera change; a mesh that stands still should be the same object in every shot, so
that neither its digest nor its copy in Mitsuba is made again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from render.config import Film, Light, Material
from render.development import Development, Tone
from render.footprints import FootprintRaster
from render.ground_wear import GroundWear
from render.lettering import Lettering
from render.panorama_file import file_digest
from render.plume import Plume, Puff
from render.water import WaterSurface


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh with one material, posed for this frame.

    A mesh with colours has no pattern: its material's base colour is multiplied by them.

    Attributes:
        name: unique within the shot.
        vertices: (V, 3) float32, world positions [m].
        faces: (F, 3) uint32, counter-clockwise seen from outside. Constant over a film:
            hidden triangles are collapsed, never removed.
        material: a key of `Shot.materials`.
        uv: (V, 2) float32 texture coordinates of ground [m], or None.
        smooth: shade with interpolated vertex normals.
        warned: (F,) faces that are hatched in the warning colour, or None. Constant over a film.
        rest: (V, 3) float32 vertices of a body in its own frame, longest along the first axis
            [m], on which patterns lie; or None. Constant.
        footprints: all footprints of the film in this ground, or None. Constant.
        colors: (V, 3) float32 linear colours, or None. Constant over a film.
        normals: (V, 3) float32 normals to shade with, None to have them computed. What is longer
            than 1 casts its shadow rays from so many metres above itself.
        owner: name of the performer that it is a part of, or empty. Constant.
        cover: (V, 4) float32 linear colour in place of that of the material, and its share; or
            None. On a body it takes the place of the base colour, under the pattern. Constant over
            a film.
        wear: bare soil in this ground, or None. Constant.
    """

    name: str
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    material: str
    uv: NDArray[np.float32] | None = None
    smooth: bool = True
    warned: NDArray[np.bool_] | None = None
    rest: NDArray[np.float32] | None = None
    footprints: FootprintRaster | None = None
    colors: NDArray[np.float32] | None = None
    normals: NDArray[np.float32] | None = None
    owner: str = ""
    cover: NDArray[np.float32] | None = None
    wear: GroundWear | None = None

    @cached_property
    def topology(self) -> bytes:
        """Digest of everything that is constant in one build."""
        head = f"{self.name}|{self.owner}|{self.material}|{self.smooth}|{len(self.vertices)}"
        uv = b"" if self.uv is None else self.uv.tobytes()
        warned = b"" if self.warned is None else b"tinted" + self.warned.tobytes()
        rest = b"" if self.rest is None else b"rest" + self.rest.tobytes()
        footprints = b"" if self.footprints is None else b"prints" + self.footprints.bytes
        colors = b"" if self.colors is None else b"colors" + self.colors.tobytes()
        bent = b"" if self.normals is None else b"normals"
        cover = b"" if self.cover is None else b"cover" + self.cover.tobytes()
        wear = b"" if self.wear is None else b"wear" + self.wear.bytes
        extra = rest + footprints + colors + bent + cover + wear
        content = head.encode() + self.faces.tobytes() + uv + warned + extra
        return hashlib.blake2b(content, digest_size=16).digest()

    @cached_property
    def digest(self) -> bytes:
        """Digest of the whole mesh."""
        content = self.topology + self.vertices.tobytes()
        content += b"" if self.normals is None else self.normals.tobytes()
        return hashlib.blake2b(content, digest_size=16).digest()


@dataclass(frozen=True)
class Lens:
    """A thin lens.

    Attributes:
        radius: of its aperture [m].
        focus: distance of the plane of focus, along the viewing direction [m].
    """

    radius: float
    focus: float


@dataclass(frozen=True)
class CameraPose:
    """Pose and lens of the camera in one frame.

    Attributes:
        p_WC: position of the camera in the world [m].
        p_WT: the point it looks at [m].
        up: direction that is up in the frame.
        fov_deg: vertical field of view [degrees].
        lens: None for a pinhole, to which all is sharp.
    """

    p_WC: tuple[float, float, float]
    p_WT: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_deg: float = 35.0
    lens: Lens | None = None

    @property
    def top(self) -> NDArray[np.float64]:
        """A direction that is upward in the frame.

        Looking straight up or down, the top of the frame is -Z, as on a map.
        """
        sight, up = np.subtract(self.p_WT, self.p_WC), np.asarray(self.up, float)
        if np.linalg.norm(np.cross(sight, up)) < 1e-6 * np.linalg.norm(sight):
            return np.array([0.0, 0.0, -1.0])
        return up

    @property
    def axes(self) -> NDArray[np.float64]:
        """Unit vectors to the right, up and ahead, as rows."""
        ahead = np.subtract(self.p_WT, self.p_WC) / np.linalg.norm(
            np.subtract(self.p_WT, self.p_WC)
        )
        right = np.cross(ahead, self.top)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, ahead), ahead])


@dataclass(frozen=True)
class LampPlace:
    """Position of a lamp.

    Attributes:
        p_WL: position in the world [m].
        p_WS: target of a spotlight, None for a lamp that shines all around.
        gain: factor on its brightness, for invisible lamps.
    """

    p_WL: tuple[float, float, float]
    p_WS: tuple[float, float, float] | None = None
    gain: float = 1.0


@dataclass(frozen=True, eq=False)
class Moment:
    """Meshes, camera and lamps at one moment of an exposure.

    Attributes:
        meshes: surfaces in world coordinates, of one topology in all moments of a shot.
        camera: pose at this moment.
        lamps: places of the lamps of the shot's light; empty if they are fixed.
        time: since the film began [s]; 0 if light, water and air stand still.
        plumes: flames and smoke.
        puffs: dust and spray.
        footprint_count: number of the ground's footprints made so far.
    """

    meshes: tuple[Mesh, ...]
    camera: CameraPose
    lamps: tuple[LampPlace, ...] = ()
    time: float = 0.0
    plumes: tuple[Plume, ...] = ()
    puffs: tuple[Puff, ...] = ()
    footprint_count: int = 0


@dataclass(frozen=True, eq=False)
class Shot:
    """The renderer's input for one frame.

    Attributes:
        meshes: surfaces in world coordinates.
        materials: name -> material, written out in full.
        light: the lights, written out in full.
        camera: pose of this frame.
        film: size, samples, depth, denoiser, exposure and look.
        seed: of the sampler; constant over a film, which flickers less than one per frame.
        later: moments of the exposure after the first, evenly spaced; empty without motion blur.
        lamps: places of the lamps of the light; empty if they are fixed.
        scenery: surfaces that stand still over the whole film, in an acceleration structure of
            their own that is never rebuilt. Constant over a film; none of them glows.
        after: the moment when the next frame begins, for the pass of motion; None without it.
        tone: exposure and contrast as metered; as the light is set up by default.
        time: since the film began [s]; 0 if light, water and air stand still.
        water: that stands over the ground, or None. Constant over a film.
        plumes: flames and smoke.
        puffs: dust and spray.
        footprint_count: number of the ground's footprints made so far.
        words: over the picture.
    """

    meshes: tuple[Mesh, ...]
    materials: Mapping[str, Material]
    light: Light
    camera: CameraPose
    film: Film
    seed: int = 0
    later: tuple[Moment, ...] = ()
    lamps: tuple[LampPlace, ...] = ()
    scenery: tuple[Mesh, ...] = ()
    after: Moment | None = None
    tone: Tone = field(default_factory=Tone)
    time: float = 0.0
    water: WaterSurface | None = None
    plumes: tuple[Plume, ...] = ()
    puffs: tuple[Puff, ...] = ()
    footprint_count: int = 0
    words: tuple[Lettering, ...] = ()

    @property
    def development(self) -> Development:
        """How its light is shown: its tone, compensated by the film, and the film's look."""
        stops = self.tone.stops + self.film.exposure
        return Development(replace(self.tone, stops=stops), self.film.look, self.words)

    @property
    def moments(self) -> tuple[Moment, ...]:
        """All moments of the exposure."""
        first = Moment(
            *(self.meshes, self.camera, self.lamps, self.time, self.plumes, self.puffs),
            self.footprint_count,
        )
        return (first, *self.later)

    @cached_property
    def build(self) -> str:
        """Digest of everything that a Mitsuba scene is built for; equal shots share the scene."""
        values = (
            *(f"{name}={m.model_dump_json()}" for name, m in sorted(self.materials.items())),
            *_light_values(self.light),
            self.film.model_dump_json(exclude=_NOT_TRACED),
            "pinhole" if self.camera.lens is None else "lens",
        )
        still = (b"scenery", *(mesh.digest for mesh in self.scenery)) if self.scenery else ()
        water = (repr(self.water).encode(),) if self.water is not None else ()
        return _digest(
            (
                *(mesh.topology for mesh in self.meshes),
                *(value.encode() for value in values),
                *still,
                *water,
            )
        )

    @cached_property
    def digest(self) -> str:
        """Digest of everything that the frame depends on, as hexadecimal digits."""
        camera = repr((self.camera, self.seed)).encode()
        shown = str(self.development).encode()
        pieces = [self.build.encode(), camera, shown, *(mesh.digest for mesh in self.meshes)]
        if self.lamps:
            pieces.append(repr(self.lamps).encode())
        if any(moment.time for moment in self.moments):
            pieces.append(repr([moment.time for moment in self.moments]).encode())
        if any(moment.plumes or moment.puffs for moment in self.moments):
            airborne = [(moment.plumes, moment.puffs) for moment in self.moments]
            pieces.append(repr(airborne).encode())
        if any(moment.footprint_count for moment in self.moments):
            pieces.append(repr([moment.footprint_count for moment in self.moments]).encode())
        for moment in (*self.later, *((self.after,) if self.after else ())):
            placed = repr((moment.camera, moment.lamps) if moment.lamps else moment.camera)
            pieces += [placed.encode(), *(mesh.digest for mesh in moment.meshes)]
        return _digest(pieces)


_NOT_TRACED = {"preset", "codec", "container", "exposure", "look"}
"""Keys of a film that concern what is made of traced light; its preset is expanded already."""


def _light_values(light: Light) -> tuple[str, ...]:
    """Return all that a light depends on: of a panorama its content, not its path."""
    if light.hdr is None:
        return (light.model_dump_json(),)
    values = light.model_dump_json(exclude={"hdr": {"file"}})
    return values, file_digest(Path(light.hdr.file))


def _digest(pieces: Iterable[bytes]) -> str:
    state = hashlib.blake2b(digest_size=20)
    for piece in pieces:
        state.update(len(piece).to_bytes(8, "little"))
        state.update(piece)
    return state.hexdigest()
