"""Motion digest: equal for equal motion, whatever code computed it.

Fingerprints of three bytes for each row and each track locate the first bit that differs.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.take import Header, Take

ARRAYS = (
    *("positions", "rotations", "alive", "scales", "values"),
    *("terrain/vertices", "terrain/faces", "terrain/forbidden"),
)
TABLES = ("nodes", "channels", "contacts", "events", "notes")


def motion_digest(take: Take) -> str:
    """Return a digest of poses, channels, contacts, events, notes and the ground.

    It leaves out title, key, versions and the digest of the code, so that rewritten code keeps it,
    and meshes and parts, which are looks. `Take.digest` covers them all.
    """
    state = hashlib.blake2b(digest_size=20)
    tables = take.tables()
    members = {
        "facts": header_facts(take.header),
        "tables": {name: tables[name] for name in TABLES},
        "scaled": take.scaled,
        "terrain": [take.terrain.cells, take.terrain.material],
    }
    state.update(json.dumps(members, sort_keys=True).encode())
    for name, values in take.arrays():
        if name in ARRAYS:
            state.update(f"{name}{values.dtype.str}{values.shape}".encode())
            state.update(np.ascontiguousarray(values).tobytes())
    return state.hexdigest()


def header_facts(header: Header) -> dict[str, Any]:
    """Return the entries of a header that comparable takes share."""
    return {
        "rate": str(header.rate),
        "frames": header.frames,
        "samples": header.samples,
        "steps": header.steps,
        "seed": header.seed,
    }


FINGERPRINT_SIZE = 3
"""Bytes of a fingerprint: one of 16 million different rows has the same."""


@dataclass(frozen=True, slots=True)
class Fingerprints:
    """Fingerprints of the bits of a take.

    Attributes:
        rows: of each row, over all nodes and channels.
        tracks: of each node, then of each channel, over all rows.
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
            tuple(_fingerprint(values[k] for values in moving) for k in range(len(take.positions))),
            tuple(_fingerprint(track) for track in tracks),
        )

    def packed(self) -> dict[str, str]:
        """Return the fingerprints as plain values."""
        return {
            name: base64.b85encode(b"".join(prints)).decode("ascii")
            for name, prints in (("rows", self.rows), ("tracks", self.tracks))
        }

    @staticmethod
    def unpacked(members: dict[str, str]) -> Fingerprints:
        """Return the fingerprints that `packed` wrote."""
        return Fingerprints(_split(members["rows"]), _split(members["tracks"]))


def _fingerprint(arrays: Iterable[NDArray[Any]]) -> bytes:
    return hashlib.blake2b(
        b"".join(a.tobytes() for a in arrays), digest_size=FINGERPRINT_SIZE
    ).digest()


def _split(text: str) -> tuple[bytes, ...]:
    joined = base64.b85decode(text)
    return tuple(joined[k : k + FINGERPRINT_SIZE] for k in range(0, len(joined), FINGERPRINT_SIZE))
