"""The denoiser: Intel's Open Image Denoise on the CPU.

It repeats itself to the bit at a fixed number of threads only, so the number is a
constant and no property of the machine.
"""

from __future__ import annotations

from typing import Any

import mitsuba_oidn as oidn
import numpy as np
from numpy.typing import NDArray

from render.errors import DenoiseError
from render.words.film import Denoise

THREADS = 2
"""Threads of the denoiser; part of the key of a frame."""

_QUALITY = {"fast": oidn.Quality.Fast, "high": oidn.Quality.High}


class Denoiser:
    """Removes the noise that few samples leave.

    Attributes:
        key: what its answer depends on besides the picture.
    """

    def __init__(self) -> None:
        self._device: Any = oidn.Device(oidn.DeviceType.CPU)
        self._device.num_threads = THREADS
        self._device.commit()
        self.key = f"oidn {oidn.oidn_version()} threads {THREADS}"

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
            DenoiseError: the denoiser failed.
        """
        if mode == "off":
            return light
        try:
            return np.asarray(
                oidn.denoise(
                    light, albedo=albedo, hdr=True, quality=_QUALITY[mode], device=self._device
                )
            )
        except (oidn.Error, RuntimeError) as error:
            raise DenoiseError(
                f"the denoiser failed: {error}; write `film: {{denoise: off}}` to do without"
            ) from error
