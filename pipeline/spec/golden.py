"""Golden: which frames of a scene are kept as its golden, and how they are made."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from pipeline.spec.faults import Fault
from pipeline.spec.values import Whole, Words
from render.config.film import Even

MOST_FRAMES = 24
"""Of a golden, which stands in version control."""


class Golden(Words):
    """What a golden check of the scene renders: few frames, small, of fixed samples."""

    frames: (
        Annotated[
            tuple[Annotated[Whole, Field(ge=1)], ...], Field(min_length=1, max_length=MOST_FRAMES)
        ]
        | None
    ) = Field(
        None, description="Frames to compare; the first, the middle and the last if left out."
    )
    size: tuple[Even, Even] | None = Field(
        None, description="Width and height [pixels], even; 256 wide if left out."
    )
    samples: Annotated[Whole, Field(ge=1, le=65536)] = Field(
        64,
        description="Rays through a pixel: the more, the less can hide in noise.",
    )


def faults_of_golden(golden: Golden, given: dict[str, Any], last: int | None) -> list[Fault]:
    """Find frames that the scene does not have.

    Args:
        golden: the words.
        given: the scene's words that were written; nothing is said of a default.
        last: the scene's last frame, None if that is not known.
    """
    if "golden" not in given or golden.frames is None or last is None:
        return []
    return [
        Fault(("golden", "frames", i), f"the scene has frames 1-{last}, no {frame}")
        for i, frame in enumerate(golden.frames)
        if frame > last
    ]
