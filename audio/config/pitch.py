"""Configuration of pitches: notes, MIDI numbers, and rules by size, foot or part."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import Field, PlainValidator

from audio.config import checked_by
from audio.harmony import parse_chord, parse_note, parse_steps
from audio.names import normalized_name

PITCH_RULES = ("by size", "by foot", "by part")
_RULE_WITH_FIRST_NOTE = re.compile(r"(by foot|by part) from (.+)")


def _parse_pitch(pitch: object) -> int | str:
    allowed = (
        f"a MIDI number 0 to 127, a note such as C4, or one of: {', '.join(PITCH_RULES)}, "
        "or 'by foot from C3'"
    )
    if isinstance(pitch, int) and not isinstance(pitch, bool) and 0 <= pitch <= 127:
        return pitch
    if not isinstance(pitch, str):
        raise ValueError(f"a pitch is {allowed}; got {pitch!r}")
    if normalized_name(pitch) in PITCH_RULES:
        return normalized_name(pitch)
    try:
        if first_note_of_rule(pitch) is not None:
            return " ".join(pitch.split())
        return parse_note(pitch)
    except ValueError as error:
        raise ValueError(f"{error} (a pitch is {allowed})") from error


def first_note_of_rule(rule: str) -> int | None:
    """Return the MIDI pitch that a rule such as "by foot from C3" names; None for other rules.

    Raises:
        ValueError: the text after "from" is not a note.
    """
    match = _RULE_WITH_FIRST_NOTE.fullmatch(" ".join(rule.split()))
    return parse_note(match[2]) if match else None


ScaleName = Annotated[str, checked_by(parse_steps)]
ChordName = Annotated[str, checked_by(parse_chord)]
# One validator instead of a union, so that a mistake is reported once.
Pitch = Annotated[
    int | str,
    PlainValidator(_parse_pitch, json_schema_input_type=Annotated[int, Field(ge=0, le=127)] | str),
]
