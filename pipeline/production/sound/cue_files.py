"""Cue files for editing programs: an Audacity label track and a CMX 3600 edit list.

Timecode counts rates of n * 1000/1001 as n, without drop-frame numbers: frames are counted.

Source: CMX 3600.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import ceil

from audio.notes import first_notes
from audio.score import Score
from pipeline.atomic_file import write_if_changed
from pipeline.production.run.outputs import Outputs

TITLE_LENGTH = 70
"""Greatest length of an edit list's title [characters]."""

SECONDS_PER_DAY = 24 * 3600

MIN_TIMECODE_RATE, MAX_TIMECODE_RATE = 2, 100
"""Frame rates whose frame numbers fit into two digits [1/s]."""


def write_cues(outputs: Outputs, score: Score, film: str) -> bool:
    """Write labels and edit list; return whether a file changed.

    A film whose rate has no timecode gets no edit list; an older one is deleted.

    Args:
        outputs: paths of the files.
        score: its markers and notes become cues.
        film: name of the film's file.
    """
    changed = write_if_changed(outputs.labels, audacity_labels(score))
    edits = edit_list(score, film)
    if edits is not None:
        return write_if_changed(outputs.edit_list, edits) or changed
    existed = outputs.edit_list.exists()
    outputs.edit_list.unlink(missing_ok=True)
    return existed or changed


def audacity_labels(score: Score) -> bytes:
    """Return a label track: one line of start [s], end [s] and text per label, tab-separated.

    A sustained sound is a region, any other a point.
    """
    labels = [
        (Fraction(marker.frame - 1) / score.rate, 0.0, marker.label) for marker in score.markers
    ]
    for note in first_notes(score):
        labels.append((note.onset, note.event.duration, note.event.label))
    labels.sort(key=lambda label: label[0])
    return "".join(_label(*label) for label in labels).encode("utf-8", "replace")


def _label(start: Fraction, duration: float, text: str) -> str:
    return f"{float(start):.6f}\t{float(start) + duration:.6f}\t{_single_line(text)}\n"


def edit_list(score: Score, clip: str) -> bytes | None:
    """Return the edit list of a film in UTF-8; None if its rate or length has no timecode.

    The first frame is 00:00:00:00, as in the MIDI file. The locators of each edit follow it:
    sounds in red, script instructions in green.

    Args:
        score: with the film's cuts among its markers.
        clip: name of the film's file.
    """
    base = timecode_base(score.rate)
    if base is None or score.frames > SECONDS_PER_DAY * base:
        return None
    starts = [1, *dict.fromkeys(marker.frame for marker in score.markers if marker.kind == "cut")]
    locators = sorted(_locators(score), key=lambda locator: locator[0])
    lines = [f"TITLE: {_single_line(score.title or clip)[:TITLE_LENGTH]}", "FCM: NON-DROP FRAME"]
    ends = [*starts[1:], score.frames + 1]
    for number, (first, end) in enumerate(zip(starts, ends, strict=True), start=1):
        span = f"{timecode(first - 1, base)} {timecode(end - 1, base)}"
        lines += ["", f"{number:03d}  AX       V     C        {span} {span}"]
        lines.append(f"* FROM CLIP NAME: {_single_line(clip)}")
        lines += [
            f"* LOC: {timecode(frame - 1, base)} {color:<7} {_single_line(text)}"
            for frame, color, text in locators
            if first <= frame < end
        ]
    return "".join(f"{line}\r\n" for line in lines).encode("utf-8", "replace")


def _locators(score: Score) -> Iterator[tuple[int, str, str]]:
    """Yield frame, color and text of each locator."""
    for marker in score.markers:
        if marker.kind != "cut":
            yield marker.frame, "GREEN", marker.label
    for note in first_notes(score):
        # The onset, not the event's frame: quantisation may have moved the note.
        frame = 1 + ceil(note.onset * score.rate)
        yield frame, "RED", note.event.label


def timecode_base(rate: Fraction) -> int | None:
    """Return the integer frame rate that timecode counts in; None if the rate has no timecode."""
    base = round(rate)
    exists = rate in (base, Fraction(base * 1000, 1001))
    return base if exists and MIN_TIMECODE_RATE <= base <= MAX_TIMECODE_RATE else None


def timecode(frames: int, base: int) -> str:
    """Return the timecode of a frame.

    Args:
        frames: since the start of the film, less than a day.
        base: frames a second.
    """
    seconds, frame = divmod(frames, base)
    minutes, second = divmod(seconds, 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour:02d}:{minute:02d}:{second:02d}:{frame:02d}"


def _single_line(text: str) -> str:
    return " ".join(text.split())
