"""Coat: the pattern of a thing or a creature, which lies on it and goes with it."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from render.config import Material
from render.surfaces.bsdf_plugins import PIXEL
from render.surfaces.patterns import BRIGHTEST, bent, colored, level_of, source
from render.surfaces.texture_mapping import Sample, patch_texels, texels

PATCHES = (1.7, 19.0)
"""Tiles of a coat that the map of patches spans, and how far it is turned [deg]."""


class Coat:
    """What is seen of a body: a `render.surfaces.bsdf_plugins.Look`."""

    def __init__(self, words: Material) -> None:
        self.words = words
        # Not a constant of the kernel: another lens must not compile it again.
        self.values: dict[str, Any] = {PIXEL: dr.opaque(mi.Float, 1e-3)}
        self._first = source(texels(words.texture), self.values, "first")
        self._patches = None
        if words.color2 is not None:
            self._patches = source(patch_texels(), self.values, "patches")

    def __call__(self, si: Any) -> tuple[Any, Any]:
        """Return colour and normal at points that were hit."""
        words, n = self.words, si.sh_frame.n
        uv = si.uv / words.texture_scale
        level = level_of(si, words.texture_scale, self.values[PIXEL])
        first = self._first.at(uv.x, uv.y, 0.0, level)
        color = colored(words.color, first)
        if self._patches is not None and words.color2 is not None:
            span, turn = PATCHES
            patch = self._patches.at(uv.x / span, uv.y / span, turn, None)
            # One layer is enough for a body, which is smaller than a few tiles.
            color = dr.lerp(color, colored(words.color2, first), patch.shade)
        if words.bump == 0:
            return dr.clip(color, 0.003, BRIGHTEST), n
        return dr.clip(color, 0.003, BRIGHTEST), bent(n, _gradient(si, first), words.bump)


def _gradient(si: Any, sample: Sample) -> Any:
    """Return the gradient in the world of a relief that is laid by texture coordinates."""
    along, across = si.dp_du, si.dp_dv
    # Texture coordinates are metres, so that both are about one metre long.
    return mi.Vector3f(
        sample.slope_u * along / dr.maximum(dr.squared_norm(along), 1e-8)
        + sample.slope_v * across / dr.maximum(dr.squared_norm(across), 1e-8)
    )
