"""Places: where goldens stand, and what they were compared with."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import UsageError
from pipeline.spec import library

FOLDER = "goldens"
"""Beside the scenes."""

MADE = "golden"
"""Folder in that of the outputs: what checks have made, and what they say of it."""


@dataclass(frozen=True, slots=True)
class GoldenFolder:
    """The golden of one scene, or what would become it.

    Attributes:
        path: such as goldens/first_steps.
    """

    path: Path

    @property
    def card(self) -> Path:
        """What it is of, its limits, and digests of its files."""
        return self.path / "golden.yaml"

    @property
    def motion(self) -> Path:
        """How everything moves."""
        return self.path / "motion.json"

    @property
    def cues(self) -> Path:
        """The camera's way and the notes of the score."""
        return self.path / "cues.json"

    @property
    def film(self) -> Path:
        """What the film is and when it sounds."""
        return self.path / "film.json"

    @property
    def spreads(self) -> Path:
        """How far other seeds differ."""
        return self.path / "spreads.json"

    def frame(self, number: int) -> Path:
        """Return the picture of a frame."""
        return self.path / f"{number:04d}.png"


def goldens_of(file: Path, given: Path | None) -> Path:
    """Return the folder of a scene's goldens: the one that is given, else beside the scene.

    A shipped scene has nothing of the user's beside it; its goldens stand in this folder.
    """
    if given is not None:
        return given
    shipped = file.resolve().parent == library().resolve()
    return Path(FOLDER) if shipped else file.parent / FOLDER


def refuse_in_ci(what: str) -> None:
    """Make sure that no automaton writes goldens.

    Raises:
        UsageError: this runs in continuous integration.
    """
    if os.environ.get("CI", "").lower() not in ("", "0", "false"):
        raise UsageError(
            f"CI is set, and goldens are not {what} by an automaton: somebody has to look. "
            "Do it on a machine of your own and commit the folder"
        )
