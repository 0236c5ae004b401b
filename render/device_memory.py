"""Device memory: what Dr.Jit says when a graphics processor has too little of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from render.errors import DeviceMemoryShort

_SAID = ("out of memory", "CUDA_ERROR_OUT_OF_MEMORY", "OPTIX_ERROR_DEVICE_OUT_OF_MEMORY")
"""Parts of `jit_malloc(): out of memory! Could not allocate N bytes of device memory.` and of
what CUDA and OptiX say."""


@contextmanager
def told_memory() -> Iterator[None]:
    """Turn the lack of device memory inside into an error of its own.

    Raises:
        DeviceMemoryShort: that was it.
    """
    try:
        yield
    except RuntimeError as error:
        text = "\n".join(_chain(error))
        # Without memory on the host there is nothing to fall back to.
        if any(part in text for part in _SAID) and "host memory" not in text:
            line = next(x for x in text.splitlines() if any(part in x for part in _SAID))
            raise DeviceMemoryShort(
                f"the graphics processor has too little memory: {line.strip()}"
            ) from error
        raise


def _chain(error: BaseException | None) -> Iterator[str]:
    """Give the texts of an error and of those that it came of."""
    while error is not None:
        yield str(error)
        error = error.__cause__ or error.__context__
