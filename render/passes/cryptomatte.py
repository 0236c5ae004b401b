"""Cryptomatte: which objects cover a pixel, and by how much, with anti-aliased edges.

Every object is known by a hash of its name, so that a compositing program selects objects by
name, and a matte keeps its object when the film is rendered again. A pixel holds the objects that
cover most of it, with their shares, from the largest to the smallest.

Source: J. Friedman and A. Jones, Fully Automatic ID Mattes with Support for Motion Blur and
Transparency, 2015, and the Cryptomatte specification 1.2.0, Psyop 2018.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mmh3
import numpy as np
from numpy.typing import NDArray

RANKS = 6
"""Objects that a pixel holds; two to a layer of four channels."""


@dataclass(frozen=True, eq=False)
class Cryptomatte:
    """The mattes of one kind of name in one frame.

    Attributes:
        name: of the kind, such as CryptoObject.
        layers: (H, W, 4) float32 each: hash, share, hash, share.
        manifest: name -> hash of every object of the film, in hexadecimal digits.
    """

    name: str
    layers: tuple[NDArray[np.float32], ...]
    manifest: Mapping[str, str]

    @property
    def attributes(self) -> dict[str, str]:
        """What the file says of the mattes, as the specification has it."""
        prefix = f"cryptomatte/{_hex(_hash(self.name))[:7]}"
        return {
            f"{prefix}/name": self.name,
            f"{prefix}/hash": "MurmurHash3_32",
            f"{prefix}/conversion": "uint32_to_float32",
            f"{prefix}/manifest": json.dumps(dict(self.manifest), separators=(",", ":")),
        }


def cryptomatte(name: str, names: Sequence[str], ids: NDArray[np.uint32]) -> Cryptomatte:
    """Return the mattes of the objects that the samples of a frame meet.

    Args:
        name: of the kind.
        names: of the objects, by their numbers; "" is none, such as the sky.
        ids: (N, H, W) number of the object that each sample of a pixel meets.
    """
    named = sorted({text for text in names if text})
    hashes = {text: object_hash(text) for text in named}
    # Objects of one name are one object.
    number = {text: i + 1 for i, text in enumerate(named)}
    numbers = np.array([number.get(text, 0) for text in names], np.uint32)[ids]
    floats = np.array([0.0, *(_as_float(hashes[text]) for text in named)], np.float32)
    held, shares = _ranked(numbers)
    layers = []
    for rank in range(0, RANKS, 2):
        parts = (floats[held[rank]], shares[rank], floats[held[rank + 1]], shares[rank + 1])
        layers.append(np.stack(parts, axis=-1))
    return Cryptomatte(name, tuple(layers), {text: _hex(hashes[text]) for text in named})


def _ranked(
    numbers: NDArray[np.uint32],
) -> tuple[NDArray[np.uint32], NDArray[np.float32]]:
    """Return the objects of each pixel and their shares, (RANKS, H, W) each, largest first.

    Args:
        numbers: (N, H, W) of objects; 0 is none.
    """
    count, *size = numbers.shape
    flat = numbers.reshape(count, -1)
    held = np.zeros((RANKS, flat.shape[1]), np.uint32)
    shares = np.zeros((RANKS, flat.shape[1]), np.float32)
    held[0], shares[0] = flat[0], flat[0] > 0
    # Most pixels show one object; only edges are sorted.
    edges = np.flatnonzero((flat != flat[0]).any(axis=0))
    objects = int(flat.max(initial=0)) + 1
    pairs, counts = np.unique(
        np.arange(len(edges), dtype=np.int64) * objects + flat[:, edges], return_counts=True
    )
    edge, number = pairs // objects, pairs % objects
    counts = counts[number > 0]
    edge, number = edge[number > 0], number[number > 0]
    order = np.lexsort((number, -counts, edge))
    edge, number, counts = edge[order], number[order], counts[order]
    rank = np.arange(len(edge)) - np.searchsorted(edge, edge)
    held[:, edges], shares[:, edges] = 0, 0.0
    kept = rank < RANKS
    held[rank[kept], edges[edge[kept]]] = number[kept]
    shares[rank[kept], edges[edge[kept]]] = counts[kept] / count
    return held.reshape(RANKS, *size), shares.reshape(RANKS, *size)


def object_hash(name: str) -> int:
    """Return the hash of a name whose bits are those of a normal number.

    Programs would change the bits of infinities, of numbers that are none and of denormal ones.
    """
    value = _hash(name)
    return value ^ (1 << 23) if (value >> 23) & 255 in (0, 255) else value


def _hash(text: str) -> int:
    return mmh3.hash(text.encode(), 0, signed=False)


def _hex(value: int) -> str:
    return f"{value:08x}"


def _as_float(value: int) -> np.float32:
    return np.array([value], np.uint32).view(np.float32)[0]
