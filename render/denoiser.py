"""The denoiser: Intel's Open Image Denoise on the CPU.

It repeats itself to the bit at a fixed number of threads only, so the number is a
constant and no property of the machine.
"""

from __future__ import annotations

import importlib
from typing import Any, Literal

import numpy as np

from render.errors import DenoiseError
from render.exposure import Exposure, Image
from render.words.film import Denoise

THREADS = 2
"""Threads of the denoiser; part of the key of a frame."""

_QUALITY = {"fast": "Fast", "high": "High"}

FLOOR = np.float32(0.05)
"""Added to colours that light is divided by: what is black or bare metal has a gleam yet."""

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
            self.key = f"oidn {self._oidn.oidn_version()} threads {THREADS}"
        except (self._oidn.Error, RuntimeError) as error:
            self._fail("does not start", error, f"install mitsuba-oidn anew, or {WITHOUT}")

    def _fail(self, what: str, error: Exception, remedy: str) -> None:
        reason = (str(error).strip().splitlines() or ["no reason given"])[0]
        self._fault = f"the denoiser {what}: {reason}; {remedy}"
        self.key = "no denoiser"

    def clean(self, exposure: Exposure, mode: Denoise) -> Image:
        """Return the light of an exposure without its noise, (H, W, 3), linear.

        Light that came straight from a lamp is clean and keeps its sharp edges. The other is
        divided by the colour of the surface, which leaves the soft light that fell on it;
        that is cleaned, and coloured again by clean colours: no grain of the ground is taken
        for noise, and none of it is lost.

        Raises:
            DenoiseError: the denoiser is missing or failed.
        """
        if mode == "off":
            return exposure.light
        fallen = exposure.indirect / (exposure.dye + FLOOR)
        soft = exposure.enlarged(self._cleaned(fallen, mode))
        return exposure.direct + (exposure.color + FLOOR) * soft

    def _cleaned(self, light: Image, mode: Literal["fast", "high"]) -> Image:
        self.require()
        quality = getattr(self._oidn.Quality, _QUALITY[mode])
        try:
            return np.asarray(
                self._oidn.denoise(light, hdr=True, quality=quality, device=self._device)
            )
        except (self._oidn.Error, RuntimeError) as error:
            raise DenoiseError(f"the denoiser failed: {error}; {WITHOUT}") from error

    def require(self) -> None:
        """Make sure that it is there.

        Raises:
            DenoiseError: it is missing or does not start; the message says what to install.
        """
        if self._fault:
            raise DenoiseError(self._fault)
