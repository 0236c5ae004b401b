"""Edit list: the film's cuts as edits, sounds and instructions as locators, for editors.

Source: CMX 3600.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from audio.conductor import cause_of, told
from audio.score import Score
from audio.voices import openings
from pipeline.production.timecode import counted_as, timecode

TITLE = 70
"""Most letters of a title."""

DAY = 24 * 3600


def edit_list(score: Score, clip: str) -> bytes | None:
    """Return the edit list of a film, in UTF-8; None where its rate or length has no timecode.

    The first frame is 00:00:00:00, as it is in the score. Every edit is followed by the locators
    within it: sounds in red, instructions of the script in green.

    Args:
        score: with the film's cuts among its markers.
        clip: name of the film's file.
    """
    count = counted_as(score.rate)
    if count is None or score.frames > DAY * count:
        return None
    starts = [1, *dict.fromkeys(marker.frame for marker in score.markers if marker.kind == "cut")]
    places = sorted(_locators(score), key=lambda place: place[0])
    lines = [f"TITLE: {_line(score.title or clip)[:TITLE]}", "FCM: NON-DROP FRAME"]
    ends = [*starts[1:], score.frames + 1]
    for number, (first, end) in enumerate(zip(starts, ends, strict=True), start=1):
        within = f"{timecode(first - 1, count)} {timecode(end - 1, count)}"
        lines += ["", f"{number:03d}  AX       V     C        {within} {within}"]
        lines.append(f"* FROM CLIP NAME: {_line(clip)}")
        lines += [
            f"* LOC: {timecode(frame - 1, count)} {color:<7} {_line(text)}"
            for frame, color, text in places
            if first <= frame < end
        ]
    return "".join(f"{line}\r\n" for line in lines).encode("utf-8", "replace")


def _locators(score: Score) -> Iterator[tuple[int, str, str]]:
    """Give frame, colour and text of all that is marked within edits."""
    for marker in score.markers:
        if marker.kind != "cut":
            yield marker.frame, "GREEN", told(marker)
    for note in openings(score):
        # Where it is heard, which the quantisation may have moved.
        frame = 1 + ceil(note.onset * score.rate)
        yield frame, "RED", cause_of(note.event)


def _line(text: str) -> str:
    """Return a text on one line."""
    return " ".join(text.split())
