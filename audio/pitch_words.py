"""How an author writes pitches: by number, by name, or by what they follow."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field, PlainValidator

from audio.chords import parse_chord, parse_steps
from audio.names import folded
from audio.scales import parse_note

PITCH_RULES = ("by size", "by foot", "by part")
_COUNTED_FROM = re.compile(r"(by foot|by part) from (.+)")


def _known_scale(text: str) -> str:
    parse_steps(text)
    return text


def _known_chord(text: str) -> str:
    parse_chord(text)
    return text


def _known_pitch(pitch: object) -> int | str:
    allowed = (
        f"a MIDI number 0 to 127, a note such as C4, or one of: {', '.join(PITCH_RULES)}, "
        "or 'by foot from C3'"
    )
    if isinstance(pitch, int) and not isinstance(pitch, bool) and 0 <= pitch <= 127:
        return pitch
    if not isinstance(pitch, str):
        raise ValueError(f"a pitch is {allowed}; got {pitch!r}")
    if folded(pitch) in PITCH_RULES:
        return folded(pitch)
    try:
        if counted_from(pitch) is not None:
            return " ".join(pitch.split())
        return parse_note(pitch)
    except ValueError as error:
        raise ValueError(f"{error} (a pitch is {allowed})") from error


def counted_from(pitch: str) -> int | None:
    """Return the MIDI pitch of the first part for "by foot from C3"; None for another rule.

    Raises:
        ValueError: what it counts from is no note.
    """
    match = _COUNTED_FROM.fullmatch(" ".join(pitch.split()))
    return parse_note(match[2]) if match else None


ScaleName = Annotated[str, AfterValidator(_known_scale)]
ChordName = Annotated[str, AfterValidator(_known_chord)]
# One validator instead of a union, so that a slip is reported once and in our words.
Pitch = Annotated[
    int | str,
    PlainValidator(_known_pitch, json_schema_input_type=Annotated[int, Field(ge=0, le=127)] | str),
]
