"""Events: the sound events of a take as lines of JSON."""

from __future__ import annotations

import json

from pipeline.simulation.clock import Clock
from pipeline.simulation.take import Take


def event_lines(take: Take) -> bytes:
    """Return the events that a film of `take` shows, one object a line.

    `time` is that of the cause, in seconds; `frame` is the first that shows it.
    """
    header = take.header
    clock = Clock(header.rate, header.frames, header.steps, header.samples)
    lines = []
    for event in take.events:
        if event.frame > header.frames:
            continue
        time = clock.time_of(event.step, event.fraction)
        words = {
            "frame": event.frame,
            "time": float(time),
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
        lines.append(json.dumps(words, ensure_ascii=False))
    return "".join(f"{line}\n" for line in lines).encode()
