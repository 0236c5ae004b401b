"""Checking process: checks mutated scenes, as `pronk check` does, and says what became of each.

    python -m tests.production.checking_process FOLDER FIRST LAST

(One seed alone: its number and the next one. Its scene is then in FOLDER/scene.yaml.)

When it has started, it prints a JSON line for each seed from the FIRST on and before the LAST:
`seed`, `kind` ("right", "simulated", "refused", or "fault" for what is none of them), `text` and
`seconds`. Its memory is bounded, and Python's warnings are faults.
"""

from __future__ import annotations

import io
import json
import sys
import time
import traceback
import warnings
from pathlib import Path

import yaml

from pipeline.errors import PronkError, SceneError, SimulationError, StoreError, located
from pipeline.production.run.reporters import LogReporter
from pipeline.production.run.scene_check import check_scene, figure_remarks
from pipeline.spec import load_scene
from pipeline.unexpected_error import MemoryShort, told_error
from tests.production.fuzzing import READY, hold_memory
from tests.production.mutated_scenes import Corpus, mutated_scene

SIMULATED = 10
"""One of so many seeds is simulated, if its scene is right."""

FRAMES = 4
"""Length of the scenes that are simulated."""

MEMORY = 3 * 2**30
"""Address space that the checks may take besides what the libraries take [bytes]."""

WARM_UP = """\
pronk: 1
frames: 2
terrain: {kind: flat, size: [8, 8], cells: [8, 8]}
cast:
  - {name: bug, figure: beetle, walk: {}}
  - {name: ann, character: adult, at: [2, 2]}
  - {name: box, body: {shape: cube}, at: [-2, 1, 0]}
"""


def main() -> None:
    """Check the scenes that the arguments ask for."""
    folder, first, last = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    corpus, file = Corpus.shipped(), folder / "scene.yaml"
    file.write_text(WARM_UP)
    kind, text = outcome(file, True)
    assert kind == "simulated", text
    hold_memory(MEMORY)
    print(json.dumps(READY), flush=True)  # noqa: T201 (the result)
    for seed in range(first, last):
        file.write_bytes(mutated_scene(corpus, seed))
        began = time.monotonic()
        kind, text = outcome(file, seed % SIMULATED == 0)
        seconds = round(time.monotonic() - began, 3)
        line = {"seed": seed, "kind": kind, "text": text[:6000], "seconds": seconds}
        print(json.dumps(line), flush=True)  # noqa: T201 (the result)


def outcome(file: Path, simulated: bool = False) -> tuple[str, str]:
    """Check the scene in a file, as `pronk check` does, and return what became of it.

    Args:
        file: of the scene.
        simulated: whether the first frames of a right scene are simulated as well.

    Returns:
        "right", "simulated", "refused" or "fault", and what was said.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return ("simulated" if simulated else "right"), checked(file, simulated)
    except PronkError as error:
        fault = fault_of(error, file.read_bytes(), simulated)
        return ("fault", f"{fault}: {error}") if fault else ("refused", located(error, file))
    except Exception as error:
        told = told_error(error)
        return "fault", str(told) if not isinstance(told, MemoryShort) else traceback.format_exc()


def checked(file: Path, simulated: bool) -> str:
    """Check the scene in a file, and simulate its first frames if asked."""
    scene = load_scene(file)
    if simulated:
        frames = min(scene.n_frames, FRAMES)
        scene = scene.model_copy(update={"frames": frames, "duration": None})
    text = check_scene(scene, LogReporter(io.StringIO()), "scene", simulated)
    for remark in figure_remarks(scene):
        assert remark.problem.message
    return text


def fault_of(error: PronkError, content: bytes, simulated: bool) -> str:
    """Return what is wrong with a refusal, "" for nothing: each names its file and its line."""
    if isinstance(error, SimulationError) and simulated:
        # It names step, time and part instead.
        return "" if str(error).strip() else "the refusal says nothing"
    if isinstance(error, StoreError):
        # No line is to blame where rows of a film of a million frames exceed the limit of memory.
        return ""
    if not isinstance(error, SceneError):
        return f"a refusal without a line ({type(error).__name__})"
    if not error.problems:
        return "a refusal without a problem"
    parses = holds_values(content)
    for problem in error.problems:
        if not problem.message.strip() or not problem.file:
            return "a problem without a message or a file"
        if not problem.line and parses:
            return "a problem without a line"
    return ""


def holds_values(content: bytes) -> bool:
    """Return whether a content is YAML that holds anything, by another reader's judgement."""
    try:
        return yaml.safe_load(content.decode("utf-8")) is not None
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError, TypeError):
        return False


if __name__ == "__main__":
    main()
