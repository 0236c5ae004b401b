"""Frame ranges in the notation of film pipelines."""

from __future__ import annotations

import hashlib

from fileseq import FrameSet
from fileseq.exceptions import FileSeqException

from pipeline.errors import UsageError

MAX_NAME_LENGTH = 80
"""Of frame ranges in a file's name; systems allow 255 bytes in all."""

ALLOWED = "a frame, a range, every n-th of a range, separated by commas, such as 1-48,60-90x5"


def parse_frames(text: str | None, last: int) -> tuple[int, ...]:
    """Return the frames of ranges, ascending, each once.

    Args:
        text: such as "1-48,60-90x5"; None for all.
        last: the last frame of the scene.

    Raises:
        UsageError: it cannot be read, or names frames that the scene does not have.
    """
    if text is None:
        return tuple(range(1, last + 1))
    frames = read_frames(text)
    outside = [frame for frame in frames if not 1 <= frame <= last]
    if outside:
        raise UsageError(f"--frames '{text}': the scene has frames 1-{last}, no {outside[0]}")
    return frames


def read_frames(text: str) -> tuple[int, ...]:
    """Return the frames of ranges, ascending, each once, of whatever scene.

    Raises:
        UsageError: they cannot be read.
    """
    try:
        named = FrameSet(text)
    except (FileSeqException, ValueError):
        raise UsageError(f"--frames '{text}': cannot be read; write {ALLOWED}") from None
    if not named:
        raise UsageError(f"--frames '{text}': names no frame; write {ALLOWED}")
    if any(frame != int(frame) for frame in named):
        raise UsageError(f"--frames '{text}': frames are whole; write {ALLOWED}")
    return tuple(sorted({int(frame) for frame in named}))


def described(frames: tuple[int, ...]) -> str:
    """Return the shortest notation of ascending `frames`, fit for a file's name."""
    text = str(FrameSet(frames)).replace(",", "_")
    if len(text) <= MAX_NAME_LENGTH:
        return text
    digest = hashlib.blake2b(text.encode(), digest_size=6).hexdigest()
    return f"{frames[0]}-{frames[-1]}_{digest}"


def contiguous(frames: tuple[int, ...]) -> bool:
    """Return whether ascending `frames` have no gaps."""
    return frames[-1] - frames[0] + 1 == len(frames)


def counted(frames: int) -> str:
    """Return a number of frames in words."""
    return "1 frame" if frames == 1 else f"{frames} frames"
