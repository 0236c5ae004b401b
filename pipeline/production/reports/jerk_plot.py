"""Jerk plot: where hands go and how fast, subtask by subtask, both controllers in one panel."""

from __future__ import annotations

import drawsvg
import numpy as np

from pipeline.production.reports.canvas import FONT, Canvas, Panel
from pipeline.production.reports.colors import FAINT, INK, PANEL, PAPER
from pipeline.production.reports.jerk_trials import Column, Trial
from pipeline.simulation.dancers.same_way import Timed
from pipeline.simulation.spatial import Array
from pipeline.spec import Dance

COLORS = {"torque": "#2f8f9d", "force": "#e07a3f"}

ACROSS, WIDTH, HEIGHT, GAP, MARGIN, TOP = 4, 330, 300, 18, 36, 96
"""Panels side by side, their size, and what is around them [pixels]."""

PATH, SPEED = 150, 104
"""Heights of the two drawings in a panel [pixels]."""


def jerk_svg(title: str, dance: Dance, trial: Trial) -> str:
    """Return the plot as SVG: paths from the front, speeds over time."""
    count = len(dance.subtasks)
    down = -(-count // ACROSS)
    width = 2 * MARGIN + ACROSS * WIDTH + (ACROSS - 1) * GAP
    height = TOP + down * (HEIGHT + GAP) + MARGIN
    canvas = Canvas(drawsvg.Drawing(width, height, font_family=FONT))
    canvas.draw(drawsvg.Rectangle(0, 0, width, height, fill=PAPER))
    canvas.say(title, (MARGIN, 46), 30, INK, bold=True)
    told = (
        f"hand paths from the front, and speeds, at {trial.name}; thin: of least jerk on that path"
    )
    canvas.say(told, (MARGIN, 74), 15, FAINT)
    for n, (by, color) in enumerate(COLORS.items()):
        x = width - MARGIN - 170 + 90 * n
        canvas.draw(drawsvg.Line(x, 69, x + 22, 69, stroke=color, stroke_width=3))
        canvas.say(by, (x + 28, 74), 15, INK)
    for k, one in enumerate(dance.subtasks):
        x = MARGIN + (k % ACROSS) * (WIDTH + GAP)
        y = TOP + (k // ACROSS) * (HEIGHT + GAP)
        canvas.draw(drawsvg.Rectangle(x, y, WIDTH, HEIGHT, rx=10, fill=PANEL))
        canvas.say(f"{k + 1} {one.name}", (x + 14, y + 24), 14, INK, bold=True)
        ways = {by: _way(column, k, one.hand) for by, column in trial.columns.items()}
        drawn = {by: way for by, way in ways.items() if way is not None}
        _paths(canvas, Panel(x + 14, y + 34, WIDTH - 28, PATH), drawn)
        best = {by: trial.columns[by].best[k] for by in drawn}
        _speeds(canvas, Panel(x + 14, y + 48 + PATH, WIDTH - 28, SPEED - 16), drawn, best)
    return str(canvas.picture.as_svg())


def _way(column: Column, k: int, side: str) -> tuple[Array, Array] | None:
    """Return times from the begin (n,) and places (n, 3) of a subtask, None if it was not done."""
    if k not in column.found:
        return None
    danced = column.danced
    move = next(m for m in danced.moves[side] if m.subtask == k)
    inside = (danced.times >= move.begin) & (danced.times <= move.land + 0.25)
    return danced.times[inside] - move.begin, danced.hands[side][inside]


def _paths(canvas: Canvas, box: Panel, ways: dict[str, tuple[Array, Array]]) -> None:
    if not ways:
        return
    every = np.concatenate([way[:, [2, 1]] for _, way in ways.values()])
    low, high = every.min(axis=0), every.max(axis=0)
    middle = 0.5 * (low + high)
    # At least a quarter of a metre, so that a hand that rests is a point.
    scale = min(box.width / max(high[0] - low[0], 0.25), box.height / max(high[1] - low[1], 0.25))
    for by, (_, way) in ways.items():
        # Seen from the front: its right hand is to the left.
        x = box.x + 0.5 * box.width - scale * (way[:, 2] - middle[0])
        y = box.y + 0.5 * box.height - scale * (way[:, 1] - middle[1])
        _line(canvas, x, y, COLORS[by], 2.5)
        canvas.draw(drawsvg.Circle(float(x[-1]), float(y[-1]), 4, fill=COLORS[by]))


def _speeds(
    canvas: Canvas,
    box: Panel,
    ways: dict[str, tuple[Array, Array]],
    best: dict[str, Timed],
) -> None:
    found = {}
    for by, (t, way) in ways.items():
        if len(t) > 2:
            found[by] = t, np.linalg.norm(np.gradient(way, t, axis=0), axis=1)
    if not found:
        return
    fastest = max(0.2, *(float(speed.max()) for _, speed in found.values()))
    longest = max(float(t[-1]) for t, _ in found.values())
    bottom = box.y + box.height
    canvas.draw(drawsvg.Line(box.x, bottom, box.x + box.width, bottom, stroke=FAINT))
    for by, (t, speed) in found.items():
        x, y = box.x + box.width * t / longest, bottom - box.height * speed / fastest
        _line(canvas, x, y, COLORS[by], 2.0)
        one = best[by]
        if len(one.times) > 2:
            smooth = np.linalg.norm(np.gradient(one.places, one.times, axis=0), axis=1)
            x = box.x + box.width * (one.times - one.times[0]) / longest
            y = bottom - box.height * np.minimum(smooth / fastest, 1.0)
            _line(canvas, x, y, COLORS[by], 0.8)
    canvas.say(f"{fastest:.1f} m/s", (box.x, box.y + 10), 11, FAINT)
    canvas.say(f"{longest:.1f} s", (box.x + box.width, bottom + 13), 11, FAINT, "end")


def _line(canvas: Canvas, x: Array, y: Array, color: str, width: float) -> None:
    points = np.stack([x, y], axis=-1).round(2).ravel().tolist()
    words = {"close": False, "fill": "none", "stroke": color, "stroke_width": width}
    canvas.draw(drawsvg.Lines(*points, **words))
