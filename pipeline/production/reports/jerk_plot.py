"""Jerk plot: paths and speeds of the hands, subtask by subtask, for both controllers."""

from __future__ import annotations

import drawsvg
import numpy as np

from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.jerk_trials import Column, Trial
from pipeline.production.reports.plot_colors import FAINT, INK
from pipeline.simulation.dance_trials import RetimedPath
from pipeline.simulation.spatial import Array
from pipeline.spec import Dance

COLORS = {"torque": "#2f8f9d", "force": "#e07a3f"}

ACROSS, WIDTH, HEIGHT, GAP, TOP = 4, 330, 300, 18, 96
"""Panels side by side, their size, the gap between them and the room above [pixels]."""

PATH, SPEED = 150, 104
"""Heights of the two drawings in a panel [pixels]."""

MIN_EXTENT = 0.25
"""Least extent of a path that fills its drawing, so that a hand at rest is a point [m]."""

MIN_SPEED = 0.2
"""Least maximum of a speed axis [m/s]."""

SETTLING = 0.25
"""Time shown after the end of a movement [s]."""


def jerk_svg(title: str, dance: Dance, trial: Trial) -> str:
    """Return the plot as SVG: paths from the front, speeds over time."""
    down = -(-len(dance.subtasks) // ACROSS)
    width = 2 * MARGIN + ACROSS * WIDTH + (ACROSS - 1) * GAP
    canvas = Canvas.page(width, TOP + down * (HEIGHT + GAP) + MARGIN, title)
    legend = (
        f"hand paths from the front, and speeds, at {trial.name}; thin: of least jerk on that path"
    )
    canvas.text(legend, (MARGIN, 74), 15, FAINT)
    for n, (name, color) in enumerate(COLORS.items()):
        x = width - MARGIN - 170 + 90 * n
        canvas.draw(drawsvg.Line(x, 69, x + 22, 69, stroke=color, stroke_width=3))
        canvas.text(name, (x + 28, 74), 15, INK)
    for k, subtask in enumerate(dance.subtasks):
        x = MARGIN + (k % ACROSS) * (WIDTH + GAP)
        y = TOP + (k // ACROSS) * (HEIGHT + GAP)
        canvas.panel(Panel(x, y, WIDTH, HEIGHT))
        canvas.text(f"{k + 1} {subtask.name}", (x + 14, y + 24), 14, INK, bold=True)
        paths = {
            name: _path(column, k, subtask.hand)
            for name, column in trial.columns.items()
            if k in column.movements
        }
        smoothest = {name: trial.columns[name].smoothest[k] for name in paths}
        if paths:
            _draw_paths(canvas, Panel(x + 14, y + 34, WIDTH - 28, PATH), paths)
            speeds = Panel(x + 14, y + 48 + PATH, WIDTH - 28, SPEED - 16)
            _draw_speeds(canvas, speeds, paths, smoothest)
    return canvas.svg


def _path(column: Column, k: int, side: str) -> tuple[Array, Array]:
    """Return times since the start (n,) [s] and places (n, 3) [m] of the hand in a subtask."""
    danced = column.danced
    move = next(m for m in danced.moves[side] if m.subtask == k)
    inside = (danced.times >= move.begin) & (danced.times <= move.land + SETTLING)
    return danced.times[inside] - move.begin, danced.hands[side][inside]


def _draw_paths(canvas: Canvas, box: Panel, paths: dict[str, tuple[Array, Array]]) -> None:
    places = np.concatenate([path[:, [2, 1]] for _, path in paths.values()])
    low, high = places.min(axis=0), places.max(axis=0)
    middle = 0.5 * (low + high)
    scale = min(
        box.width / max(high[0] - low[0], MIN_EXTENT),
        box.height / max(high[1] - low[1], MIN_EXTENT),
    )
    for name, (_, path) in paths.items():
        # From the front, the dancer's right hand is on the left.
        x = box.x + 0.5 * box.width - scale * (path[:, 2] - middle[0])
        y = box.y + 0.5 * box.height - scale * (path[:, 1] - middle[1])
        _draw_line(canvas, x, y, COLORS[name], 2.5)
        canvas.draw(drawsvg.Circle(float(x[-1]), float(y[-1]), 4, fill=COLORS[name]))


def _draw_speeds(
    canvas: Canvas,
    box: Panel,
    paths: dict[str, tuple[Array, Array]],
    smoothest: dict[str, RetimedPath],
) -> None:
    speeds = {
        name: (t, np.linalg.norm(np.gradient(path, t, axis=0), axis=1))
        for name, (t, path) in paths.items()
        if len(t) > 2
    }
    if not speeds:
        return
    fastest = max(MIN_SPEED, *(float(speed.max()) for _, speed in speeds.values()))
    longest = max(float(t[-1]) for t, _ in speeds.values())
    bottom = box.y + box.height
    canvas.draw(drawsvg.Line(box.x, bottom, box.x + box.width, bottom, stroke=FAINT))
    for name, (t, speed) in speeds.items():
        x, y = box.x + box.width * t / longest, bottom - box.height * speed / fastest
        _draw_line(canvas, x, y, COLORS[name], 2.0)
        best = smoothest[name]
        if len(best.times) > 2:
            smooth = np.linalg.norm(np.gradient(best.places, best.times, axis=0), axis=1)
            x = box.x + box.width * (best.times - best.times[0]) / longest
            y = bottom - box.height * np.minimum(smooth / fastest, 1.0)
            _draw_line(canvas, x, y, COLORS[name], 0.8)
    canvas.text(f"{fastest:.1f} m/s", (box.x, box.y + 10), 11, FAINT)
    canvas.text(f"{longest:.1f} s", (box.x + box.width, bottom + 13), 11, FAINT, "end")


def _draw_line(canvas: Canvas, x: Array, y: Array, color: str, width: float) -> None:
    points = np.stack([x, y], axis=-1).round(2).ravel().tolist()
    style = {"close": False, "fill": "none", "stroke": color, "stroke_width": width}
    canvas.draw(drawsvg.Lines(*points, **style))
