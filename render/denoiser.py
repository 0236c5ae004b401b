"""The denoiser: Intel's Open Image Denoise on the CPU.

It repeats itself to the bit at a fixed number of threads only, so the number is a
constant and no property of the machine.
"""

from __future__ import annotations

import importlib
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from render.config.film import Denoise
from render.errors import DenoiseError
from render.exposure import GLEAM, Exposure, Image

THREADS = 2
"""Threads of the denoiser; part of the key of a frame."""

MEMORY = 128
"""What the denoiser may take beside its pictures [MiB]: it goes over large ones tile by tile. Like
the threads a constant, for tiles that are laid otherwise round otherwise."""

_QUALITY = {"fast": "Fast", "high": "High"}

_SEEN = 0.8 * GLEAM
"""Colour from which on a pixel shows a surface, and not the sky beside it."""

WITHOUT = "write `film: {denoise: off}` to do without"


class Denoiser:
    """Removes the noise that few samples leave.

    A denoiser that is missing or does not start is told only to who wants a picture cleaned.

    Attributes:
        key: what its answer depends on besides the picture.
    """

    def __init__(self) -> None:
        self._fault = ""
        try:
            self._oidn: Any = importlib.import_module("mitsuba_oidn")
        except ImportError as error:
            self._fail("is missing", error, f"install mitsuba-oidn, or {WITHOUT}")
            return
        try:
            self._device: Any = self._oidn.Device(self._oidn.DeviceType.CPU)
            self._device.num_threads = THREADS
            self._device.commit()
            self._filter = self._device.new_filter("RT")
            self._filter.hdr = True
            self._filter.max_memory_mb = MEMORY
            self.key = f"oidn {self._oidn.oidn_version()} threads {THREADS} memory {MEMORY}"
        except (self._oidn.Error, RuntimeError) as error:
            self._fail("does not start", error, f"install mitsuba-oidn anew, or {WITHOUT}")

    def _fail(self, what: str, error: Exception, remedy: str) -> None:
        reason = (str(error).strip().splitlines() or ["no reason given"])[0]
        self._fault = f"the denoiser {what}: {reason}; {remedy}"
        self.key = "no denoiser"

    def clean(self, exposure: Exposure, mode: Denoise, *, wide: bool = False) -> Image:
        """Return the light of an exposure without its noise, (H, W, 3), linear.

        Light that came straight from a lamp is clean and keeps its sharp edges. The other is
        divided by the colour of the surface, which leaves the soft light that fell on it;
        that is cleaned, and coloured again by clean colours: no grain of the ground is taken
        for noise, and none of it is lost. Where its few samples met the sky alone, the light
        is that of the surfaces beside.

        Lamps that are wide have soft shadows, which few samples leave grainy: what they do for
        surfaces is cleaned in the same way, by itself.

        Args:
            exposure: of one frame.
            mode: how well.
            wide: whether it was lit by a key light so wide that its shadows are soft.

        Raises:
            DenoiseError: the denoiser is missing or failed.
        """
        if mode == "off":
            return exposure.light
        known = exposure.dye.max(axis=-1, keepdims=True) > 0.0
        fallen = np.asarray(exposure.indirect / np.where(known, exposure.dye, 1.0), np.float32)
        soft = exposure.enlarged(self._cleaned(_filled(fallen, known), mode))
        # In place, for pictures of a film's size are large.
        soft *= exposure.color
        soft += self._lit(exposure, mode) if wide else exposure.direct
        return soft

    def _lit(self, exposure: Exposure, mode: Literal["fast", "high"]) -> Image:
        """Return direct light with clean shadows; where no surface is seen it is as it was."""
        known = exposure.color.max(axis=-1, keepdims=True) > _SEEN
        fallen = np.asarray(exposure.direct / np.where(known, exposure.color, 1.0), np.float32)
        fallen[~known[..., 0]] = 0.0
        cleaned = self._cleaned(_filled(fallen, known), mode)
        cleaned *= exposure.color
        return np.where(known, cleaned, exposure.direct)

    def _cleaned(self, light: Image, mode: Literal["fast", "high"]) -> Image:
        self.require()
        cleaned = np.empty_like(light)
        try:
            self._filter.quality = getattr(self._oidn.Quality, _QUALITY[mode])
            self._filter.set_image("color", light)
            self._filter.set_image("output", cleaned)
            self._filter.commit()
            self._filter.execute()
        except (self._oidn.Error, RuntimeError) as error:
            raise DenoiseError(f"the denoiser failed: {error}; {WITHOUT}") from error
        return cleaned

    def require(self) -> None:
        """Make sure that it is there.

        Raises:
            DenoiseError: it is missing or does not start; the message says what to install.
        """
        if self._fault:
            raise DenoiseError(self._fault)


def _filled(light: Image, known: NDArray[np.bool_]) -> Image:
    """Return light with what is not known taken from the nearest that is, coarser and coarser.

    Args:
        light: (H, W, 3), 0 where it is not known.
        known: (H, W, 1).
    """
    height, width = known.shape[:2]
    if known.all() or max(height, width) == 1:
        return light
    count = _halved(known.astype(np.float32))
    mean = np.asarray(_halved(light) / np.maximum(count, 1.0), np.float32)
    wide = _filled(mean, count > 0.0)
    near = wide.repeat(2, axis=0)[:height].repeat(2, axis=1)[:, :width]
    return np.where(known, light, near)


def _halved(picture: Image) -> Image:
    """Return the sums of two by two pixels; a last row or column that is odd stands alone."""
    height, width = picture.shape[:2]
    even = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)))
    rows = even[0::2] + even[1::2]
    return np.asarray(rows[:, 0::2] + rows[:, 1::2], np.float32)
