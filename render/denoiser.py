"""The denoiser: Intel's Open Image Denoise on the CPU.

It repeats itself to the bit at a fixed number of threads only, so the number is a
constant and no property of the machine.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from render.errors import DenoiseError
from render.words.film import Denoise

THREADS = 2
"""Threads of the denoiser; part of the key of a frame."""

_QUALITY = {"fast": "Fast", "high": "High"}

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

    def clean(
        self, light: NDArray[np.float32], albedo: NDArray[np.float32], mode: Denoise
    ) -> NDArray[np.float32]:
        """Return the picture without its noise.

        Args:
            light: (H, W, 3) linear.
            albedo: (H, W, 3), the colour of what is seen first; it keeps the grain of the
                ground, which looks like noise otherwise.
            mode: off, fast or high.

        Raises:
            DenoiseError: the denoiser is missing or failed.
        """
        if mode == "off":
            return light
        self.require()
        quality = getattr(self._oidn.Quality, _QUALITY[mode])
        try:
            return np.asarray(
                self._oidn.denoise(
                    light, albedo=albedo, hdr=True, quality=quality, device=self._device
                )
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
