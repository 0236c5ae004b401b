"""Events: what instructions of the script can wait for, and what counts as each.

The schema, `pronk list events` and the table in the documentation follow from this table; the
model of the condition is `script.When`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class EventKind:
    """A kind of event.

    Attributes:
        example: as an author writes it after `when`.
        meaning: when it happens.
        never: what a film in which it never happens tells of its members.
        of_many: when it happens to a member that is many bodies, empty where that has no event.
    """

    example: str
    meaning: str
    never: str
    of_many: str = ""


EVENTS: Mapping[str, EventKind] = {
    "arrived": EventKind(
        "arrived: bug",
        "a performer has reached the end of its path, or has done its order",
        "{names} never arrived",
    ),
    "touch": EventKind(
        "touch: [spider, ball]",
        "two members begin to touch",
        "{names} never touched",
        "one of them begins to",
    ),
    "near": EventKind(
        "near: [kid, gate], within: 1.5",
        "the surfaces of two members (or of one and a place) come within a distance, 1 m if left "
        "out",
        "{names} never came within {within:g} m",
        "the nearest does",
    ),
    "fell": EventKind(
        "fell: crate",
        "a member falls: off its feet, on its side, over an edge, or down",
        "{names} never fell",
        "each time that another one falls, so first with the first",
    ),
    "at_rest": EventKind(
        "at_rest: ball",
        "a member that has moved, by a fifth of its size or by 10 cm, comes to rest for 0.25 s",
        "{names} never came to rest",
        "all of them rest",
    ),
    "hug": EventKind(
        "hug: [kid, mother]",
        "the first has closed its arms around the second, in this order",
        "{names} never hugged",
    ),
    "served": EventKind(
        "served: kid",
        "a person has been served at the head of a queue",
        "{names} was never served",
    ),
    "failed": EventKind(
        "failed: kid, act: hug",
        "a performer gives up an order of this kind (any, if `act` is left out), with a note that "
        "says why",
        "{names} never failed{act}",
    ),
}
"""All events by the key of the condition that waits for them."""


def event_table() -> str:
    """Return all events as a table in Markdown, as the documentation shows them."""
    rows = [f"| `{kind.example}` | {kind.meaning} | {kind.of_many} |" for kind in EVENTS.values()]
    head = "| event | happens when | of `many` bodies |\n|---|---|---|"
    return "\n".join([head, *rows])
