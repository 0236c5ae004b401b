"""Channel curves: values of a performer over time, and the states of its mind, for the page."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.production.reports.mind_plot import mind_traces
from pipeline.simulation.take import Take
from pipeline.spec import Scene

MAX_POINTS = 400
"""Points of a curve, which is no wider on the page [pixels]."""


def channel_facts(scene: Scene, take: Take, performer: str) -> dict[str, Any]:
    """Return the curves and strips of a performer as plain values.

    Args:
        scene: of the take.
        take: that is shown.
        performer: member of the cast.

    Returns:
        `curves` with name, unit, least, most and `points` [[time, value], ...]; `strips` with
        title and `spans` [[name, from, to], ...]; times in seconds.
    """
    rate = float(take.header.rate) * take.header.samples
    rows = take.header.frames * take.header.samples
    shown = np.unique(np.linspace(0, rows - 1, min(MAX_POINTS, rows)).round().astype(int))
    mind = next((m for m in mind_traces(scene, take) if m.name == performer), None)
    strips = [] if mind is None else list(mind.strips)
    # States of a mind are numbers of names, which the strips show.
    named = {"behaviour", "focus", "gaze"} if strips else set()
    curves = []
    for column, channel in enumerate(take.channels):
        owner, _, quantity = channel.name.partition(".")
        if owner != performer or quantity in named:
            continue
        values = take.values[:rows, column]
        finite = values[np.isfinite(values)]
        curves.append(
            {
                "name": quantity,
                "unit": channel.unit,
                "least": float(finite.min()) if len(finite) else 0.0,
                "most": float(finite.max()) if len(finite) else 0.0,
                "points": [
                    [round(row / rate, 4), round(float(values[row]), 5)]
                    for row in shown
                    if np.isfinite(values[row])
                ],
            }
        )
    return {
        "who": performer,
        "curves": curves,
        "strips": [
            {"title": title, "spans": _spans(names[:rows], rate)} for title, names in strips
        ],
    }


def _spans(names: Sequence[str], rate: float) -> list[list[Any]]:
    """Return runs of equal names with start and end [s], without those of no name."""
    spans, row = [], 0
    for name, run in itertools.groupby(names):
        count = sum(1 for _ in run)
        if name:
            spans.append([name, round(row / rate, 4), round((row + count) / rate, 4)])
        row += count
    return spans
