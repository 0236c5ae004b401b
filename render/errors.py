"""Errors of the renderer, as one tree.

RenderError
├── BackendMissing     no variant of Mitsuba works as asked
├── DeviceMemoryShort  the GPU has too little memory for the shot
├── ShotError          the shot cannot be drawn: a material is missing, a number is not finite
├── DenoiseError       the denoiser is missing or failed
├── FrameFileError     an image could not be written or read
└── EncodeError        the film could not be encoded
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Parts of `jit_malloc(): out of memory! Could not allocate N bytes of device memory.` and of the
# messages of CUDA and OptiX.
_MEMORY_MESSAGES = (
    "out of memory",
    "CUDA_ERROR_OUT_OF_MEMORY",
    "OPTIX_ERROR_DEVICE_OUT_OF_MEMORY",
)


class RenderError(Exception):
    """Root of all errors of the renderer; the message says what to do."""


class BackendMissing(RenderError):
    """No variant of Mitsuba works as asked on this machine."""


class DeviceMemoryShort(RenderError):
    """The GPU has too little memory for the shot."""


class ShotError(RenderError):
    """The shot cannot be drawn."""


class DenoiseError(RenderError):
    """The denoiser is missing or failed."""


class FrameFileError(RenderError):
    """An image could not be written or read.

    Attributes:
        path: of the image.
    """

    def __init__(self, path: Path, reason: str) -> None:
        # Both are arguments, so that it can be pickled.
        super().__init__(path, reason)
        self.path = path

    def __str__(self) -> str:
        return "{} {}".format(*self.args)


class EncodeError(RenderError):
    """The film could not be encoded."""


@contextmanager
def device_memory_errors() -> Iterator[None]:
    """Convert Dr.Jit's lack of device memory inside the block to `DeviceMemoryShort`.

    Raises:
        DeviceMemoryShort: the GPU has too little memory.
    """
    try:
        yield
    except RuntimeError as error:
        text = "\n".join(_chained_messages(error))
        # Without host memory there is nothing to fall back to.
        if any(part in text for part in _MEMORY_MESSAGES) and "host memory" not in text:
            line = next(x for x in text.splitlines() if any(part in x for part in _MEMORY_MESSAGES))
            raise DeviceMemoryShort(f"the GPU has too little memory: {line.strip()}") from error
        raise


def _chained_messages(error: BaseException | None) -> Iterator[str]:
    while error is not None:
        yield str(error)
        error = error.__cause__ or error.__context__
