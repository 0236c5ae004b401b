"""Digests of scenes, such as the key under which the take of a scene is kept."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection
from typing import Any

from pipeline.spec.dancer import beat_at
from pipeline.spec.file_references import content_digest
from pipeline.spec.renamed_keys import RENAMED_KEYS
from pipeline.spec.scene import Scene

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
    """Return a digest of all that the simulation reads: scenes with equal keys have equal takes.

    Names of materials are in it, for parts carry them; how the materials look is not.
    """
    # Later blocks of the language are left out of scenes without them, whose keys stay the same.
    later = [part for part in ("dances", "moods", "story") if getattr(scene, part)]
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
    values = {part: _part(scene, part) for part in sorted(set(parts))}
    text = json.dumps(values, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
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
    key = _PRESENT_KEYS.get(part, part)
    if key not in Scene.model_fields:
        raise KeyError(part)
    value = _with_first_keys(scene.model_dump(mode="json", include={key})[key])
    if part == "terrain":
        return _simulated_terrain(value)
    if part == "cast":
        return [_simulated_member(member) for member in value]
    if part != "figures":
        return value
    used = sorted({member.figure for _, member in scene.creatures})
    # The order of nodes stays as it is: in this order the analysis meets them.
    return [[name, value[name]] for name in used]


_PRESENT_KEYS = {key.old: key.new for key in RENAMED_KEYS if not key.block}
_FIRST_KEYS = {key.new: key.old for key in RENAMED_KEYS if key.block}


def _with_first_keys(value: Any) -> Any:
    """Return values by the first names of their keys, so that a renamed key keeps its takes."""
    if isinstance(value, dict):
        return {_FIRST_KEYS.get(k, k): _with_first_keys(below) for k, below in value.items()}
    return [_with_first_keys(below) for below in value] if isinstance(value, list) else value


LOOKS_OF_TERRAIN = (
    *("show_forbidden", "footprints", "surroundings", "edging", "water", "scatter"),
)
"""Keys of a terrain that only its picture follows."""


def _simulated_terrain(terrain: dict[str, Any]) -> dict[str, Any]:
    """Return what the simulation reads of a terrain: the contents of files, not their names."""
    terrain = {key: value for key, value in terrain.items() if key not in LOOKS_OF_TERRAIN}
    if "file" in terrain:
        terrain["file"] = content_digest(terrain["file"])
    if "of" in terrain:
        terrain["of"] = [_simulated_terrain(term) for term in terrain["of"]]
    return terrain


def _simulated_member(member: dict[str, Any]) -> dict[str, Any]:
    """Return what the simulation reads of a member: the contents of files, not their names."""
    block, key = (member["many"], "of") if "many" in member else (member, "body")
    body = block.get(key) or {}
    if "file" not in body:
        return member
    block = block | {key: body | {"file": content_digest(body["file"])}}
    return member | {"many": block} if "many" in member else block
