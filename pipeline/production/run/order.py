"""Order: the settings of one run on a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import UsageError
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.spec import Scene, find_scene
from render.backend import Choice


@dataclass(frozen=True, slots=True)
class Order:
    """The settings of one run.

    Attributes:
        scene: to be filmed.
        name: of the scene, its folder and its files.
        out: folder that holds the scenes' folders.
        frames: ranges such as "1-48,60-90x5"; None for all.
        jobs: number of processes that render.
        sound: whether the film has sound, and MIDI and WAV are written.
        subframe: whether sounds stand at the exact times of their causes, not on frames.
        backend: variant of Mitsuba.
        strict: whether notes are an error.
        film: whether a film is made of the frames.

    Raises:
        UsageError: the scene does not have these frames.
    """

    scene: Scene
    name: str
    out: Path
    frames: str | None = None
    jobs: int = 1
    sound: bool = True
    subframe: bool = False
    backend: Choice = "auto"
    strict: bool = False
    film: bool = True

    def __post_init__(self) -> None:
        # Early, before anything is made.
        parse_frames(self.frames, self.scene.n_frames)


def refuse_clashes(scenes: Sequence[str], out: Path) -> None:
    """Refuse two scenes that would write to one folder.

    Args:
        scenes: files or names of scenes; those that do not exist are refused later.
        out: folder of their outputs.

    Raises:
        UsageError: two scenes have one name.
    """
    names: set[str] = set()
    for scene in scenes:
        try:
            name = find_scene(scene).stem
        except UsageError:
            continue
        if name in names:
            raise UsageError(
                f"two scenes are called '{name}', and both would write to "
                f"{out / name}; render one after the other, each with an --out of its own"
            )
        names.add(name)
