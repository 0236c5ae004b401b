"""Speeds: how fast what is heard for a while goes, from begin to end."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.simulation.take import SoundEvent, Take

BY_THEIR_WAY = frozenset({"roll", "slide", "swoosh", "whistle"})
"""Causes that sound as fast as the middle of what makes them goes."""


def speeds_of(take: Take, event: SoundEvent, nodes: Mapping[str, int]) -> tuple[float, ...]:
    """Return speeds at even times from the onset to the end, about one a frame [m/s].

    Empty where the sound does not last, or nobody's way says how fast it is.

    Args:
        take: what happened.
        event: one of its sound events.
        nodes: numbers of the take's nodes by name.
    """
    first, last = event.track
    rows = min(last, len(take.positions) - 1) - first
    if event.cause not in BY_THEIR_WAY or rows < 1:
        return ()
    wanted = (event.part, f"{event.who}.{event.part}", event.who)
    node = next((nodes[name] for name in wanted if name in nodes), None)
    if node is None:
        return ()
    header = take.header
    way = take.positions[first : first + rows + 1, node]
    velocity = np.gradient(way, float(1 / (header.rate * header.samples)), axis=0)
    speed = np.sqrt((velocity * velocity).sum(axis=1))
    count = max(round(rows / header.samples), 1)
    # Even times, so that the last one is that of the end.
    at = np.linspace(0, rows, count + 1)
    return tuple(float(v) for v in np.interp(at, np.arange(rows + 1), speed))
