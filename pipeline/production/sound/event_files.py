"""Event files: the sound events of a take as JSON lines and as CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from typing import Any

from pipeline.atomic_file import write_if_changed
from pipeline.production.run.outputs import Outputs
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take

COLUMNS = (
    *("frame", "time", "duration", "cause", "who", "part", "other", "x", "y", "z"),
    *("strength", "energy", "size", "material", "surface"),
)
"""CSV columns; the keys of the JSON lines, except that `place` is split into x, y and z."""


def write_events(outputs: Outputs, take: Take) -> bool:
    """Write the sound events of a take; return whether a file changed."""
    changed = write_if_changed(outputs.events, events_jsonl(take))
    return write_if_changed(outputs.event_table, events_csv(take)) or changed


def events_jsonl(take: Take) -> bytes:
    """Return the events within the film, one JSON object per line.

    `time` is the time of the cause [s]; `frame` is the first frame that shows it.
    """
    lines = (json.dumps(record, ensure_ascii=False) for record in _records(take))
    return "".join(f"{line}\n" for line in lines).encode()


def events_csv(take: Take) -> bytes:
    """Return the events within the film as CSV in UTF-8 with a header line.

    Source: RFC 4180 2005.
    """
    out = io.StringIO(newline="")
    table = csv.DictWriter(out, COLUMNS)
    table.writeheader()
    for record in _records(take):
        x, y, z = record.pop("place")
        table.writerow({**record, "x": x, "y": y, "z": z})
    return out.getvalue().encode()


def _records(take: Take) -> Iterator[dict[str, Any]]:
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
