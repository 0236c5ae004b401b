"""Seeded: random numbers that depend on a key alone."""

from __future__ import annotations

from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.random.bit_generator import ISeedSequence
from numpy.typing import NDArray


class _Digest(ISeedSequence):
    """A digest as the state of a generator.

    It is as random as what numpy makes of a number, which takes five times as long.
    """

    def __init__(self, digest: bytes) -> None:
        self._words = np.frombuffer(digest, np.uint64)

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> NDArray[Any]:
        """Return its words, the four of 64 bits that PCG64 asks for."""
        return self._words.view(dtype)[:n_words]


def seeded(*key: object) -> np.random.Generator:
    """Return a generator of random numbers; equal keys give equal ones, whoever asks and when."""
    # The stubs of numpy do not know that a generator takes any such state.
    state: Any = _Digest(_digest(key, 32))
    return np.random.Generator(np.random.PCG64(state))


def random_pair(*key: object) -> tuple[float, float]:
    """Return two random numbers from 0 to 1; a generator takes three times as long to make."""
    digest = _digest(key, 16)
    return int.from_bytes(digest[:6]) / 2**48, int.from_bytes(digest[6:12]) / 2**48


def _digest(key: tuple[object, ...], size: int) -> bytes:
    """Return so many bytes."""
    data = "\x1f".join(map(str, key)).encode("utf-8", "replace")
    return blake2b(data, digest_size=size).digest()
