"""Digest of a motion: equal where the motion is, whatever code computed it."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np

from pipeline.simulation.take import Header, Take

ARRAYS = (
    *("positions", "rotations", "alive", "scales", "values"),
    *("terrain/vertices", "terrain/faces", "terrain/forbidden"),
)
TABLES = ("nodes", "channels", "contacts", "events", "notes")


def motion_digest(take: Take) -> str:
    """Return a digest of the motion alone: poses, channels, what happened, and the ground.

    Versions, the key and the digest of the code are not in it, nor is the title, so that
    code that is written otherwise and moves alike leaves it as it is; meshes and parts are
    looks. `Take.digest` has all that.
    """
    state = hashlib.blake2b(digest_size=20)
    tables = take.tables()
    words = {
        "facts": facts_of(take.header),
        "tables": {name: tables[name] for name in TABLES},
        "scaled": take.scaled,
        "terrain": [take.terrain.cells, take.terrain.material],
    }
    state.update(json.dumps(words, sort_keys=True).encode())
    for name, values in take.arrays():
        if name in ARRAYS:
            state.update(f"{name}{values.dtype.str}{values.shape}".encode())
            state.update(np.ascontiguousarray(values).tobytes())
    return state.hexdigest()


def facts_of(header: Header) -> dict[str, Any]:
    """Return what of a header must be the same for takes to be compared."""
    return {
        "rate": str(header.rate),
        "frames": header.frames,
        "samples": header.samples,
        "steps": header.steps,
        "seed": header.seed,
    }
