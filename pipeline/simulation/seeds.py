"""Seeds: one number in the scene, split by name.

A performer's chances depend on its name alone, so adding another performer
or changing the order of the cast leaves it as it was.
"""

from __future__ import annotations

import hashlib

import numpy as np


def generator(seed: int, name: str) -> np.random.Generator:
    """Return the random generator that belongs to `name` under the scene's `seed`."""
    words = hashlib.blake2b(name.encode(), digest_size=16).digest()
    entropy = [seed, int.from_bytes(words, "little")]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(entropy)))
