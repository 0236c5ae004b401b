"""What is wrong with a file that a terrain names, as a problem at the place of its name."""

from __future__ import annotations

from dataclasses import replace

from pipeline.errors import Problem, SceneError


def refused(message: str) -> SceneError:
    """Return the refusal of a terrain's file."""
    return SceneError([Problem("file", message)])


def below(error: SceneError, path: str) -> SceneError:
    """Return an error whose problems lie below `path` in the scene."""
    return SceneError([replace(one, path=f"{path}.{one.path}") for one in error.problems])
