"""Fingerprints: three bytes for each row and each track, to find where the first bit differs."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from pipeline.simulation.take import Take

SIZE = 3
"""Bytes of a fingerprint: one in 16 million different rows looks the same."""


@dataclass(frozen=True, slots=True)
class Fingerprints:
    """Of the bits of a take.

    Attributes:
        rows: of each row, all nodes and channels together.
        tracks: of each node, then of each channel, all rows together.
    """

    rows: tuple[bytes, ...]
    tracks: tuple[bytes, ...]

    @staticmethod
    def of(take: Take) -> Fingerprints:
        """Return the fingerprints of `take`."""
        moving = (take.positions, take.rotations, take.alive, take.scales, take.values)
        tracks: list[list[NDArray[Any]]] = [
            [take.positions[:, j], take.rotations[:, j], take.alive[:, j]]
            for j in range(len(take.nodes))
        ]
        for n, j in enumerate(take.scaled):
            tracks[j].append(take.scales[:, n])
        tracks.extend([take.values[:, c]] for c in range(len(take.channels)))
        return Fingerprints(
            tuple(_print(values[k] for values in moving) for k in range(len(take.positions))),
            tuple(_print(track) for track in tracks),
        )

    def packed(self) -> dict[str, str]:
        """Return them as plain values."""
        return {
            name: base64.b85encode(b"".join(prints)).decode("ascii")
            for name, prints in (("rows", self.rows), ("tracks", self.tracks))
        }

    @staticmethod
    def unpacked(words: dict[str, str]) -> Fingerprints:
        """Return what `packed` wrote."""
        return Fingerprints(_cut(words["rows"]), _cut(words["tracks"]))


def _print(arrays: Iterable[NDArray[Any]]) -> bytes:
    return hashlib.blake2b(b"".join(a.tobytes() for a in arrays), digest_size=SIZE).digest()


def _cut(word: str) -> tuple[bytes, ...]:
    joined = base64.b85decode(word)
    return tuple(joined[k : k + SIZE] for k in range(0, len(joined), SIZE))
