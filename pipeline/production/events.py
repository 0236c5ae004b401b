"""Events: the sound events of a take as lines of JSON and as a table."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from typing import Any

from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take

COLUMNS = (
    *("frame", "time", "duration", "cause", "who", "part", "other", "x", "y", "z"),
    *("strength", "energy", "size", "material", "surface"),
)
"""Of the table; as the words of the lines, but for the place."""


def event_lines(take: Take) -> bytes:
    """Return the events that a film of `take` shows, one object a line.

    `time` is that of the cause, in seconds; `frame` is the first that shows it.
    """
    lines = (json.dumps(words, ensure_ascii=False) for words in _events(take))
    return "".join(f"{line}\n" for line in lines).encode()


def event_table(take: Take) -> bytes:
    """Return the same events as comma-separated values in UTF-8, a line of names first.

    Source: RFC 4180 2005.
    """
    out = io.StringIO(newline="")
    table = csv.DictWriter(out, COLUMNS)
    table.writeheader()
    for words in _events(take):
        x, y, z = words.pop("place")
        table.writerow({**words, "x": x, "y": y, "z": z})
    return out.getvalue().encode()


def _events(take: Take) -> Iterator[dict[str, Any]]:
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    for event in take.events:
        if event.frame > header.frames:
            continue
        first, last = event.track
        yield {
            "frame": event.frame,
            "time": float(clock.time_of(event.step, event.fraction)),
            "duration": round(float((last - first) / (clock.rate * clock.samples)), 6),
            "cause": event.cause,
            "who": event.who,
            "part": event.part,
            "other": event.other,
            "place": [round(c, 6) for c in event.place],
            "strength": round(event.strength, 6),
            "energy": round(event.energy, 9),
            "size": round(event.size, 6),
            "material": event.material,
            "surface": event.surface,
        }
