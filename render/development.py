"""Development: scene light as a picture, by exposure, contrast and look.

The order is that of a camera and its darkroom: glare of the lens, darkening towards its corners,
more exposure of shade, the curve of the film, then the grading, and at last words over it. Slope,
offset, power and saturation are those of the colour decision list of the American Society of
Cinematographers (ASC CDL 1.2, 2009).
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from render.color import CURVE_SAMPLES, LUMINANCE, curve, curve_index, inset, outset
from render.config.look import PLAIN, Look
from render.image_resizing import half_size
from render.lettering import Lettering, lettered
from render.shadow_fill import fill_stops

Integer = TypeVar("Integer", np.uint8, np.uint16)
Image = NDArray[np.float32]

BAND_ROWS = 128
"""Rows of an image that are developed together, so that they stay in the cache."""

_SHOULDER = 0.8
"""Value above which highlights roll off, where white is below the end of the curve."""

LOWEST_WHITE = 0.68
"""Lowest `Tone.white`; below it even light would look glaring."""

_PALER = 0.22
"""Power of the contrast by which the saturation falls: contrast of each channel adds to it."""

_GLARE_FROM = 2.0
"""Exposed light from which it glares; white paper in the sun is about 1."""
_GLARE_MOST = 4000.0
"""Exposed light of which no more glares: as much as a low sun in haze, which has a wide glow."""
_GLARE_SHARE = 0.16
"""Share of that light that bloom 1 spreads."""
_GLARE_LEVELS = 4
"""Halvings of the quarter image; each adds a glow of twice the width."""


@dataclass(frozen=True, slots=True)
class Tone:
    """Exposure and contrast, as metered for a cut.

    Attributes:
        stops: of exposure.
        contrast: about middle grey, in stops per stop.
        white: value of the curve from which highlights are white, `LOWEST_WHITE` to 1.
    """

    stops: float = 0.0
    contrast: float = 1.0
    white: float = 1.0


@dataclass(frozen=True, slots=True)
class Development:
    """All that decides how scene light is shown.

    Attributes:
        tone: with the author's compensation.
        look: grading.
        words: over the picture.
    """

    tone: Tone = field(default_factory=Tone)
    look: Look = PLAIN
    words: tuple[Lettering, ...] = ()

    @classmethod
    def read(cls, text: str) -> Self:
        """Return the development that `str` wrote.

        Raises:
            ValueError: it is another text.
        """
        *tone, look = values = json.loads(text)
        words: tuple[Lettering, ...] = ()
        if isinstance(look, list):
            words = tuple(Lettering.of_list(one) for one in look)
            *tone, look = values[:-1]
        stops, contrast, white = (float(value) for value in tone)
        return cls(Tone(stops, contrast, white), Look.model_validate(look), words)

    def __str__(self) -> str:
        look = self.look.model_dump(exclude={"preset"})
        tone = self.tone.stops, self.tone.contrast, self.tone.white
        # Without words it is the text that it was before there were any.
        words = [[one.as_list() for one in self.words]] if self.words else []
        return json.dumps([*tone, {"preset": "plain", **look}, *words])


def developed(light: Image, how: Development | None = None) -> NDArray[np.uint8]:
    """Return scene light as an 8-bit sRGB image.

    Args:
        light: (H, W, 3) linear sRGB, 0 or more; 0.18 is middle grey.
        how: exposure and look, as it is by default.

    Returns:
        (H, W, 3) sRGB, ready to show.
    """
    return _quantized(light, how or Development(), np.uint8)


def developed16(light: Image, how: Development | None = None) -> NDArray[np.uint16]:
    """Return scene light as a 16-bit sRGB image; see `developed`."""
    return _quantized(light, how or Development(), np.uint16)


def _quantized(light: Image, how: Development, kind: type[Integer]) -> NDArray[Integer]:
    top, look = np.iinfo(kind).max, how.look
    glare = _glare(light, how.tone.stops) if look.bloom > 0.0 else None
    dim = _vignette(light.shape[:2], look.vignette) if look.vignette > 0.0 else None
    fill = _fill(light, how) if look.shadows > 0.0 else None
    out = np.empty(light.shape, kind)
    for band in range(0, len(light), BAND_ROWS):
        rows = slice(band, band + BAND_ROWS)
        seen = light[rows]
        if glare is not None:
            seen = seen + np.float32(_GLARE_SHARE * look.bloom) * _quadrupled(
                glare, range(*rows.indices(len(light))), light.shape[1]
            )
        if dim is not None:
            seen = seen * dim[rows]
        if fill is not None:
            seen = seen * _quadrupled(fill, range(*rows.indices(len(light))), light.shape[1])
        for i, c in enumerate(_tone_mapped(seen, how)):
            out[rows, ..., i] = np.clip(c * top + 0.5, 0, top)
    return lettered(out, how.words) if how.words else out


def _tone_mapped(light: Image, how: Development) -> list[Image]:
    """Return the channels of the tone-mapped image, about 0 to 1."""
    curves = _graded_curves(how.look, how.tone.white)
    contrast = how.tone.contrast * how.look.contrast
    bent = [
        curves[i][curve_index(c, how.tone.stops, contrast)]
        for i, c in enumerate(inset([light[..., k] for k in range(3)]))
    ]
    saturation = np.float32(how.look.saturation * contrast**-_PALER)
    if saturation != 1.0:
        r, g, b = LUMINANCE
        grey = (r * bent[0] + g * bent[1] + b * bent[2]) * (1 - saturation)
        bent = [grey + saturation * c for c in bent]
    shown = outset(bent)
    black, white = np.float32(how.look.black), np.float32(how.look.white)
    if black == 0.0 and white == 1.0:
        return shown
    return [black + (white - black) * np.clip(c, 0, 1) for c in shown]


@lru_cache(maxsize=64)
def _graded_curves(look: Look, white: float) -> list[Image]:
    """Return the curve of each channel with slope, offset and power, sampled as `curve` is."""
    found = []
    bent = curve().astype(np.float64) / white
    # Highlights roll off to 1 where the curve ends, along a hyperbola that rises all the way.
    above, most = np.maximum(bent - _SHOULDER, 0.0), 1.0 / white - _SHOULDER
    bent = bent - above + above / (1.0 + above * (1.0 / (1.0 - _SHOULDER) - 1.0 / most))
    for slope, offset, power in zip(look.slope, look.offset, look.power, strict=True):
        value = np.clip(slope * bent + offset, 0.0, 1.0) ** power
        found.append(np.asarray(value, np.float32))
    assert len(found[0]) == CURVE_SAMPLES
    return found


def _vignette(size: tuple[int, ...], strength: float) -> Image:
    """Return the factor of light in each pixel, (H, W, 1): 1 in the middle, least in corners.

    Args:
        size: of the image: rows, columns.
        strength: 0 for none, 1 for black corners.
    """
    height, width = size
    y = (np.arange(height, dtype=np.float32) + 0.5) / height * 2 - 1
    x = (np.arange(width, dtype=np.float32) + 0.5) / width * 2 - 1
    square = (0.5 * (y[:, None] ** 2 + x**2))[..., None]
    return np.asarray((1 - np.float32(strength) * square * square) ** 2, np.float32)


def _fill(light: Image, how: Development) -> Image:
    """Return the factor of light that opens shade, in a quarter of the size (H, W, 1)."""
    small = half_size(half_size(np.maximum(light, np.float32(0.0))))
    return np.exp2(fill_stops(small, how.tone.stops, how.tone.contrast, how.look.shadows))


def _glare(light: Image, stops: float) -> Image:
    """Return the light that glares, in a quarter of the size and widely blurred.

    Args:
        light: (H, W, 3).
        stops: of exposure.
    """
    gain = np.float32(2.0**stops)
    small = half_size(half_size(np.clip(light, 0.0, np.float32(_GLARE_MOST) / gain)))
    # Differences of channels are kept: a red lamp glares red.
    bright = small.max(axis=-1, keepdims=True) * gain
    share = np.clip(1 - _GLARE_FROM / np.maximum(bright, 1e-6), 0, 1)
    levels = [_blurred(small * share)]
    while len(levels) < _GLARE_LEVELS and min(levels[-1].shape[:2]) >= 4:
        levels.append(_blurred(half_size(levels[-1])))
    total = levels[-1]
    for level in reversed(levels[:-1]):
        total = level + _blurred(_enlarged(total, level.shape[:2]))
    return np.asarray(total / np.float32(len(levels)), np.float32)


def _blurred(image: Image) -> Image:
    """Return an image filtered by the binomial of five pixels both ways."""
    for axis in (0, 1):
        wide = np.pad(image, [(2, 2) if k == axis else (0, 0) for k in range(3)], mode="edge")
        n = image.shape[axis]
        a, b, c, d, e = (wide.take(range(k, k + n), axis=axis) for k in range(5))
        image = (a + e + np.float32(4) * (b + d) + np.float32(6) * c) * np.float32(1 / 16)
    return image


def _enlarged(image: Image, size: tuple[int, ...]) -> Image:
    """Return an image of twice the size, each pixel repeated, cut to a size."""
    return image.repeat(2, axis=0)[: size[0]].repeat(2, axis=1)[:, : size[1]]


def _quadrupled(image: Image, rows: range, width: int) -> Image:
    """Return rows of an image of four times the size, linear between the centres of pixels."""
    y = (np.arange(rows.start, rows.stop, dtype=np.float32) + 0.5) / 4 - 0.5
    top, height = np.floor(y).astype(np.intp), len(image)
    near = image[top.clip(0, height - 1)]
    near = near + (y - top)[:, None, None] * (image[(top + 1).clip(0, height - 1)] - near)
    # Along rows the four places between two centres are columns of their own.
    wide = np.pad(near, ((0, 0), (1, 1), (0, 0)), mode="edge")
    step = wide[:, 1:] - wide[:, :-1]
    found = np.empty((len(y), 4 * step.shape[1], image.shape[2]), np.float32)
    for k in range(4):
        np.multiply(step, np.float32((k + 0.5) / 4), out=found[:, k::4])
        found[:, k::4] += wide[:, :-1]
    return found[:, 2 : width + 2]
