"""Order: what is asked of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import UsageError
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.spec import Scene
from render.backend import Choice


@dataclass(frozen=True, slots=True)
class Order:
    """What is asked of a run.

    Attributes:
        scene: what to make.
        name: of the scene; its folder and files are called so.
        out: folder that holds the scenes' folders.
        frames: ranges such as "1-48,60-90x5"; None for all.
        jobs: processes that render at once.
        sound: whether the film has sound, and MIDI and WAV are written.
        subframe: whether sounds stand at the exact times of their causes, not on frames.
        backend: which variant of Mitsuba.

    Raises:
        UsageError: if the frames asked for are none of the scene's.
    """

    scene: Scene
    name: str
    out: Path
    frames: str | None = None
    jobs: int = 1
    sound: bool = True
    subframe: bool = False
    backend: Choice = "auto"

    def __post_init__(self) -> None:
        # Before anything is made, for this scene or for others of the same command.
        parse_frames(self.frames, self.scene.n_frames)


def refuse_clashes(orders: Sequence[Order]) -> None:
    """Make sure that no two of `orders` write to one place.

    Raises:
        UsageError: if two scenes have one name.
    """
    names = [order.name for order in orders]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(
                f"two scenes are called '{name}', and both would write to "
                f"{orders[0].out / name}; render one after the other, each with an --out of its own"
            )
