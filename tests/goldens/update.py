"""Write the motion goldens of shipped scenes that are new or move otherwise.

    python tests/goldens/update.py [scene ...] [--all]

A golden that still holds is left as it is, so that version control shows what changed
alone; with --all it is written too, with the bits and versions of this machine. Goldens
whose scene is gone are removed unless scenes are named.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pipeline.errors import GoldenMissing, PronkError, UsageError
from pipeline.production.goldens.motion_comparison import compare
from pipeline.production.goldens.motion_file import read_golden, write_golden
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.production.goldens.motion_sensitivity import predictable_steps
from pipeline.production.goldens.motion_verdict import MotionOutcome
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import load_scene
from pipeline.spec.scene_library import SUFFIX, library, shipped_scenes
from pipeline.spec.suggestions import hint

MOTION = Path(__file__).parent / "motion"


def main() -> int:
    """Write outdated goldens and print why; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help="names of shipped scenes; all if none is named")
    parser.add_argument("--all", action="store_true", help="also write goldens that still hold")
    words = parser.parse_args()
    try:
        for name in words.scenes or shipped_scenes():
            sys.stdout.write(f"{update(name, words.all)}\n")
            sys.stdout.flush()
        if not words.scenes:
            for path in orphans():
                path.unlink()
                sys.stdout.write(f"{path.stem}: removed, for the scene is gone\n")
    except PronkError as error:
        sys.stderr.write(f"error: {error}\n")
        return error.exit_code
    return 0


def update(name: str, always: bool) -> str:
    """Write the golden of a shipped scene if outdated; return the reason."""
    if name not in shipped_scenes():
        raise UsageError(f"no shipped scene is called {name!r}, {hint(name, shipped_scenes())}")
    scene = load_scene(library() / (name + SUFFIX))
    take = simulate(scene)
    path = MOTION / f"{name}.json"
    due, why = _due(path, take)
    if due or always:
        write_golden(golden_of(take, name, predictable_steps(scene, take)), path)
        why += f"\n  written: {path.stat().st_size / 1000:.0f} kB"
    return why


def _due(path: Path, take: Take) -> tuple[bool, str]:
    try:
        verdict = compare(read_golden(path), take)
    except GoldenMissing:
        return True, f"{path.stem}: new"
    except PronkError as error:
        return True, str(error)
    return verdict.outcome is MotionOutcome.CHANGED, str(verdict)


def orphans() -> list[Path]:
    """Return the goldens without a scene."""
    return [path for path in sorted(MOTION.glob("*.json")) if path.stem not in shipped_scenes()]


if __name__ == "__main__":
    sys.exit(main())
