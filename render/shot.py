"""Shot: all that the renderer is given for one frame.

A shot is a value. Two shots with equal digests show the same picture on the
same backend, so the digest (with the backend and the denoiser) is the key under
which a finished frame is kept.

Meshes are in world coordinates: metres, Y up, right handed. From one frame to
the next only vertices and camera change as a rule; a mesh that stands still
should be the same object in every shot, so that neither its digest nor its copy
in Mitsuba is made again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from render.config import Film, Light, Material
from render.footprints import Prints
from render.panorama_file import content_of


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles with one material, where it stands in this frame.

    Attributes:
        name: unique within the shot.
        vertices: (V, 3) float32, world positions [m].
        faces: (F, 3) uint32, counter-clockwise seen from outside. Constant over a film:
            what is hidden has its triangles collapsed, never removed.
        material: a key of `Shot.materials`.
        uv: (V, 2) float32 or None, texture coordinates [m] of ground, which patterns are laid on.
        smooth: shade with interpolated vertex normals.
        tinted: (F,) faces that are shown in the colour of a warning, None for none. Constant
            over a film.
        rest: (V, 3) float32 or None, places of the vertices of a body in a frame of its own,
            longest along the first axis [m]: patterns lie on the body there. Constant.
        prints: what is pressed into ground over the whole film, or None. Constant.
        printed: how many of these prints have been made.
    """

    name: str
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    material: str
    uv: NDArray[np.float32] | None = None
    smooth: bool = True
    tinted: NDArray[np.bool_] | None = None
    rest: NDArray[np.float32] | None = None
    prints: Prints | None = None
    printed: int = 0

    @cached_property
    def topology(self) -> bytes:
        """Digest of all that must not change between the frames of one build."""
        head = f"{self.name}|{self.material}|{self.smooth}|{len(self.vertices)}"
        uv = b"" if self.uv is None else self.uv.tobytes()
        tint = b"" if self.tinted is None else b"tinted" + self.tinted.tobytes()
        rest = b"" if self.rest is None else b"rest" + self.rest.tobytes()
        prints = b"" if self.prints is None else b"prints" + self.prints.bytes
        words = head.encode() + self.faces.tobytes() + uv + tint + rest + prints
        return hashlib.blake2b(words, digest_size=16).digest()

    @cached_property
    def digest(self) -> bytes:
        """Digest of the whole mesh."""
        words = self.topology + self.vertices.tobytes()
        words += f"printed {self.printed}".encode() if self.printed else b""
        return hashlib.blake2b(words, digest_size=16).digest()


@dataclass(frozen=True)
class Lens:
    """A thin lens, which is sharp at one distance only.

    Attributes:
        radius: of its aperture [m].
        focus: distance of what is sharp, along the direction in which the camera looks [m].
    """

    radius: float
    focus: float


@dataclass(frozen=True)
class CameraPose:
    """Where the camera stands in one frame and how it sees.

    Attributes:
        p_WC: position of the camera in the world [m].
        p_WT: the point it looks at [m].
        up: the direction that is up in the picture.
        fov_deg: vertical field of view [degrees].
        lens: what it sees through; None for a pinhole, to which all is sharp.
    """

    p_WC: tuple[float, float, float]
    p_WT: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_deg: float = 35.0
    lens: Lens | None = None


@dataclass(frozen=True)
class LampPlace:
    """Where a lamp is.

    Attributes:
        p_WL: its place in the world [m].
        p_WS: the point that a spot shines at, None for a lamp that shines all around.
    """

    p_WL: tuple[float, float, float]
    p_WS: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Moment:
    """Where everything stands at one instant while the shutter is open.

    Attributes:
        meshes: surfaces in world coordinates, of one topology in all moments of a shot.
        camera: pose at this instant.
        lamps: places of the lamps of the shot's light; none if they stand where it says.
    """

    meshes: tuple[Mesh, ...]
    camera: CameraPose
    lamps: tuple[LampPlace, ...] = ()


@dataclass(frozen=True, eq=False)
class Shot:
    """One frame as the renderer sees it.

    Attributes:
        meshes: surfaces in world coordinates.
        materials: name -> material, written out in full.
        light: the lights, written out in full.
        camera: pose of this frame.
        film: size, samples, depth, denoiser and tone, written out in full.
        seed: of the sampler; constant over a film flickers less than one a frame.
        later: moments of the same exposure after the first, as long apart as that is after the
            shutter opened twice; none for a frame without motion blur.
        lamps: places of the lamps of the light; none if they stand where it says.
    """

    meshes: tuple[Mesh, ...]
    materials: Mapping[str, Material]
    light: Light
    camera: CameraPose
    film: Film
    seed: int = 0
    later: tuple[Moment, ...] = ()
    lamps: tuple[LampPlace, ...] = ()

    @property
    def moments(self) -> tuple[Moment, ...]:
        """All moments of the exposure, whose light is averaged."""
        return Moment(self.meshes, self.camera, self.lamps), *self.later

    @cached_property
    def build(self) -> str:
        """Digest of what a Mitsuba scene is built for: shots that share it share the scene."""
        words = (
            *(f"{name}={m.model_dump_json()}" for name, m in sorted(self.materials.items())),
            *_light_words(self.light),
            # A preset is only where words came from, and a codec is of the film.
            self.film.model_dump_json(exclude={"preset", "codec"}),
            "pinhole" if self.camera.lens is None else "lens",
        )
        return _digest((*(mesh.topology for mesh in self.meshes), *(w.encode() for w in words)))

    @cached_property
    def digest(self) -> str:
        """Digest of everything that the picture depends on, as hexadecimal digits."""
        camera = repr((self.camera, self.seed)).encode()
        pieces = [self.build.encode(), camera, *(mesh.digest for mesh in self.meshes)]
        # Without lamps the digest is what it was before there were any.
        if self.lamps:
            pieces.append(repr(self.lamps).encode())
        for moment in self.later:
            placed = repr((moment.camera, moment.lamps) if moment.lamps else moment.camera)
            pieces += [placed.encode(), *(mesh.digest for mesh in moment.meshes)]
        return _digest(pieces)


def _light_words(light: Light) -> tuple[str, ...]:
    """Return all that a light depends on: of a picture its content, wherever it lies."""
    if light.hdr is None:
        return (light.model_dump_json(),)
    words = light.model_dump_json(exclude={"hdr": {"file"}})
    return words, content_of(Path(light.hdr.file))


def _digest(pieces: Iterable[bytes]) -> str:
    state = hashlib.blake2b(digest_size=20)
    for piece in pieces:
        state.update(len(piece).to_bytes(8, "little"))
        state.update(piece)
    return state.hexdigest()
