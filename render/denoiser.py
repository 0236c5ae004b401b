"""The denoiser: Intel's Open Image Denoise on the CPU.

Its bits depend on the number of threads, so the number is a constant.
"""

from __future__ import annotations

import importlib
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from render.config.film import Denoise
from render.errors import DenoiseError
from render.frame import Image, LensBlur, LightLayers
from render.image_resizing import double_size, half_size
from render.shadow_smoothing import smooth_shadows

THREADS = 2
"""Part of the key of a frame."""

MEMORY_MIB = 320
"""Memory beside the images, which sets the tiles of large ones [MiB]; a frame of 1280x720 is one
tile. A constant, because other tiles round differently."""

_QUALITY = {"fast": "Fast", "high": "High"}

_REMEDY = "write `film: {denoise: off}` to render without it"


class Denoiser:
    """Removes the noise of few samples.

    A denoiser that is missing or does not start raises only when it is used.

    Attributes:
        key: all that its result depends on besides the image.
    """

    def __init__(self) -> None:
        self._fault = ""
        try:
            self._oidn: Any = importlib.import_module("mitsuba_oidn")
        except ImportError as error:
            self._fail("is missing", error, f"install mitsuba-oidn, or {_REMEDY}")
            return
        try:
            self._device: Any = self._oidn.Device(self._oidn.DeviceType.CPU)
            self._device.num_threads = THREADS
            self._device.commit()
            self._device.new_filter("RT")
            self.key = f"oidn {self._oidn.oidn_version()} threads {THREADS} memory {MEMORY_MIB}"
        except (self._oidn.Error, RuntimeError) as error:
            self._fail("does not start", error, f"reinstall mitsuba-oidn, or {_REMEDY}")

    def _fail(self, problem: str, error: Exception, remedy: str) -> None:
        reason = (str(error).strip().splitlines() or ["no reason given"])[0]
        self._fault = f"the denoiser {problem}: {reason}; {remedy}"
        self.key = "no denoiser"

    def clean(self, layers: LightLayers, mode: Denoise, *, has_soft_lights: bool = False) -> Image:
        """Return the denoised light of a frame, (H, W, 3), linear.

        Direct light is clean and keeps its sharp edges. Indirect light is divided by the albedo,
        which leaves the soft irradiance; that is denoised and multiplied by the clean albedo, so
        that texture is neither taken for noise nor lost. Where all samples of a pixel met the
        sky, its irradiance is that of the surfaces beside it. Sky and haze are added unchanged.

        The soft shadows of wide lights are noisy, too, and so is the shade of leaves with few
        samples: their direct light is denoised in the same way, by itself. Where one lamp gives all
        of it, only its shadows are noisy, and `smooth_shadows` takes a tenth of the time.

        Args:
            layers: of one frame.
            mode: quality.
            has_soft_lights: whether shadows are so soft, for the samples, that they are noisy.

        Raises:
            DenoiseError: the denoiser is missing or failed.
        """
        if mode == "off":
            return layers.light
        irradiance = _irradiance(layers.indirect, layers.indirect_albedo)
        soft = layers.full_size(self._denoise(irradiance, mode))
        # In place, because frames of a film's size are large.
        soft *= layers.albedo
        soft += self._clean_direct(layers, mode) if has_soft_lights else layers.direct
        soft += layers.air
        return soft

    def clean_blur(self, light: Image, blur: LensBlur, mode: Literal["fast", "high"]) -> Image:
        """Return light that is also denoised as a whole where it is out of focus.

        What `clean` takes for clean, the colours of surfaces and the sky, is noisy there. Where
        the blur is wide, a smaller picture holds all that is seen, with less noise: grain that
        the denoiser would take for leaves.

        Args:
            light: of `clean`.
            blur: of the lens.
            mode: quality.

        Raises:
            DenoiseError: the denoiser failed.
        """
        height, width = light.shape[:2]
        picture = np.ascontiguousarray(light)
        cleaned = picture + blur.soft * (self._denoise(picture, mode) - picture)
        for halvings, share in enumerate(blur.coarse, start=1):
            if not share.any():
                break
            picture = half_size(picture)
            coarse = self._denoise(picture, mode)
            for _ in range(halvings):
                coarse = double_size(coarse)
            cleaned += share * (coarse[:height, :width] - cleaned)
        return cleaned

    def _clean_direct(self, layers: LightLayers, mode: Literal["fast", "high"]) -> Image:
        """Return direct light with clean shadows."""
        if layers.open_light is not None:
            return smooth_shadows(layers.direct, layers.open_light)
        cleaned = self._denoise(_irradiance(layers.direct, layers.albedo), mode)
        cleaned *= layers.albedo
        return cleaned

    def _denoise(self, light: Image, mode: Literal["fast", "high"]) -> Image:
        self.require()
        cleaned = np.empty_like(light)
        try:
            # A new one each time, which takes no time: its memory is free while frames are traced.
            cleaner = self._device.new_filter("RT")
            cleaner.hdr = True
            cleaner.max_memory_mb = MEMORY_MIB
            cleaner.quality = getattr(self._oidn.Quality, _QUALITY[mode])
            cleaner.set_image("color", light)
            cleaner.set_image("output", cleaned)
            cleaner.commit()
            cleaner.execute()
        except (self._oidn.Error, RuntimeError) as error:
            raise DenoiseError(f"the denoiser failed: {error}; {_REMEDY}") from error
        return cleaned

    def require(self) -> None:
        """Raise if the denoiser is missing or does not start.

        Raises:
            DenoiseError: the message says what to install.
        """
        if self._fault:
            raise DenoiseError(self._fault)


def _irradiance(light: Image, albedo: Image) -> Image:
    """Return light divided by albedo, (H, W, 3), filled where all samples met the sky."""
    # Channel by channel: numpy's maximum along a short axis takes ten times as long.
    known = ((albedo[..., 0] > 0.0) | (albedo[..., 1] > 0.0) | (albedo[..., 2] > 0.0))[..., None]
    return _filled(np.divide(light, albedo, out=light.copy(), where=known), known)


def _filled(light: Image, known: NDArray[np.bool_]) -> Image:
    """Return light with unknown pixels filled from coarser and coarser levels (push-pull).

    Args:
        light: (H, W, 3), 0 where it is unknown.
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


def _halved(image: Image) -> Image:
    """Return the sums of two by two pixels, with zeros beyond an odd border."""
    height, width = image.shape[:2]
    even = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)))
    rows = even[0::2] + even[1::2]
    return np.asarray(rows[:, 0::2] + rows[:, 1::2], np.float32)
