"""What a simulation depends on, as a key under which its take may be kept."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection
from typing import Any

from pipeline.spec.body_files import cast_simulated
from pipeline.spec.in_time import beat_at
from pipeline.spec.scene import Scene
from pipeline.spec.terrain import simulated

SIMULATED = (
    "pronk",
    "rate",
    "frames",
    "seed",
    "samples",
    "steps",
    "terrain",
    "figures",
    "cast",
    "script",
    "detect",
)
"""The parts of a scene that the simulation reads: not its looks, its camera or its voices."""


def simulation_key(scene: Scene) -> str:
    """Return a digest of all that the simulation reads: equal keys have equal takes.

    Names of materials are in it, for parts carry them; how the materials look is not.
    """
    # What no scene had when takes were first kept is left out where there is none of it.
    later = [part for part in ("dances", "moods") if getattr(scene, part)]
    if any(member.beat is not None for _, member in scene.dancers):
        later.append("beats")
    return scene_digest(scene, (*SIMULATED, *later))


def scene_digest(scene: Scene, parts: Collection[str]) -> str:
    """Return a digest of parts of a scene, as hexadecimal digits.

    Args:
        scene: any scene.
        parts: names of its fields. `frames` stands for the number of frames however it was
            given, `rate` for frames a second, `detect` for that of its sound, `beats` for the first
            beat of its score and how long each lasts; of `figures` only those of the cast count.

    Raises:
        KeyError: a part is no field of a scene.
    """
    words = {part: _part(scene, part) for part in sorted(set(parts))}
    text = json.dumps(words, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return hashlib.blake2b(text.encode("ascii"), digest_size=20).hexdigest()


def _part(scene: Scene, part: str) -> Any:
    if part == "rate":
        return str(scene.rate)
    if part == "frames":
        return scene.n_frames
    if part == "detect":
        return scene.sound.detect.model_dump(mode="json")
    if part == "beats":
        return beat_at(1.0, scene.sound)
    if part not in Scene.model_fields:
        raise KeyError(part)
    words = scene.model_dump(mode="json", include={part})[part]
    if part == "terrain":
        return simulated(words)
    if part == "cast":
        return cast_simulated(words)
    if part != "figures":
        return words
    used = sorted({member.figure for _, member in scene.creatures})
    # The order of nodes stays as it is: in this order the analysis meets them.
    return [[name, words[name]] for name in used]
