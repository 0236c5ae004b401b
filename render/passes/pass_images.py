"""Pass images: depth, normals, motion, coverage and mattes of one frame.

Depth, normal and motion are those of the middle of a pixel, because a mean over an edge would be
the place of nothing. Coverage and mattes are means over the pixel, the lens and the exposure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from render.passes.cryptomatte import Cryptomatte

Image = NDArray[np.float32]

SKY_DEPTH = 1e10
"""Depth of the sky [m]: files of half the programs hold no infinity."""


@dataclass(frozen=True, eq=False)
class PassImages:
    """The passes of one frame that the film asks for; the others are None.

    Attributes:
        depth: (H, W) distance along the viewing direction [m], `SKY_DEPTH` in the sky.
        normal: (H, W, 3) unit normal in the world; 0 in the sky.
        motion: (H, W, 2) way in the picture until the next frame [pixels], right and up.
        alpha: (H, W) share of the pixel that shows anything but the sky.
        mattes: of objects, performers and materials.
    """

    depth: Image | None = None
    normal: Image | None = None
    motion: Image | None = None
    alpha: Image | None = None
    mattes: tuple[Cryptomatte, ...] = ()

    def parts(self) -> Sequence[PassPart]:
        """Return the parts of a file that hold the passes."""
        parts = []
        if self.depth is not None:
            parts.append(PassPart("depth", {"Z": self.depth}))
        if self.normal is not None:
            xyz = {f"N.{axis}": self.normal[..., i] for i, axis in enumerate("XYZ")}
            parts.append(PassPart("normal", xyz))
        if self.motion is not None:
            uv = {f"forward.{axis}": self.motion[..., i] for i, axis in enumerate("uv")}
            parts.append(PassPart("motion", uv))
        if self.alpha is not None:
            parts.append(PassPart("alpha", {"A": self.alpha}))
        for matte in self.mattes:
            layers = {
                f"{matte.name}{k:02d}.{channel}": layer[..., i]
                for k, layer in enumerate(matte.layers)
                for i, channel in enumerate("RGBA")
            }
            parts.append(PassPart(matte.name, layers, matte.attributes))
        return parts


@dataclass(frozen=True, eq=False)
class PassPart:
    """One part of a file of several.

    Attributes:
        name: of the part.
        channels: name -> (H, W) float32.
        attributes: texts beside the pixels.
    """

    name: str
    channels: Mapping[str, NDArray[np.float32]]
    attributes: Mapping[str, str] = field(default_factory=dict)
