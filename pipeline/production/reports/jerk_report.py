"""Jerk report: figure 3 of 1998 with our columns beside it, for people and programs.

Source: Matarić, Zordan and Mason 1998, section 7.3 and figure 3.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any

import drawsvg
import numpy as np

from pipeline.atomic_file import write_if_changed
from pipeline.production.reports.canvas import MARGIN, Canvas, Panel
from pipeline.production.reports.jerk_trials import (
    Agreement,
    Column,
    Trial,
    agreements,
    dancer_of,
    is_figure_three,
    trials_of,
)
from pipeline.production.reports.plot_colors import FAINT, INK
from pipeline.production.reports.plot_files import write_plot
from pipeline.production.reports.tables import Report, table_lines
from pipeline.production.run.order import Order
from pipeline.production.run.production import working
from pipeline.production.run.progress import Reporter, stage
from pipeline.simulation.dance_trials import (
    CUTOFF_FREQUENCY,
    MINIMUM_DIMENSIONLESS_JERK,
    PAPER_JERK,
    SAMPLE_RATE,
    MeasuredMove,
    RetimedPath,
)
from pipeline.simulation.spatial import Array
from pipeline.spec import Dance

# --- Jerk plot: paths and speeds of the hands, subtask by subtask, for both controllers

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


MIN_RANK_DIFFERENCE = 4
"""Difference of ranks from which on a movement is listed with its circumstances."""

RESTING_DISTANCE = 0.05
"""Distance between the ends of a movement below which it has no dimensionless jerk [m]."""

MEASURES = (
    *("T_s", "D_m", "C_m2_s5", "mean_m2_s6", "dimensionless", "least_m2_s5"),
    *("same_way_m2_s5", "energy_J", "largest_torque_Nm"),
)
"""Quantities of a movement, with units."""

METHOD = (
    f"jerk: third derivative of the middle of the palm, at {SAMPLE_RATE:g} Hz after a low-pass of "
    f"{CUTOFF_FREQUENCY:g} Hz\n"
    "C = integral of its square [m²/s⁵]; mean = C/T [m²/s⁶], figure 3's printed unit; "
    f"C T⁵/D² >= {MINIMUM_DIMENSIONLESS_JERK:g}\n"
    "least = of the quintic between the same ends; same way = of the best timing of the same path\n"
    "between the same ends; ends are places, speeds and accelerations\n"
    "the weight of the arms is compensated, unless the scene says otherwise"
)


def report_jerk(order: Order, reporter: Reporter) -> Report:
    """Return how smoothly the first dancer of a scene moves, by both controllers.

    Writes a table and plots of hand paths and speeds into the scene's folder.

    Raises:
        PronkError: the scene has no dancer, or something cannot be made.
    """
    _, member, dance = dancer_of(order.scene)
    with working(order, reporter) as run:
        with stage(reporter, "dance", 1) as current:
            trials = trials_of(order.scene)
            current.advance(1)
            current.result = f"danced {2 * len(trials)} times"
        compared = {t.name: agreements(t) if is_figure_three(dance) else [] for t in trials}
        text = _text(member.name, dance, trials, compared)
        table = run.outputs.folder / f"{order.name}_jerk.csv"
        write_if_changed(table, table_csv(dance, trials).encode("utf-8"))
        svg = jerk_svg(f"{member.name}: {member.dance}", dance, trials[-1])
        files = (table, *write_plot(run.outputs, "jerk", svg))
    facts = [_facts(trial, compared[trial.name]) for trial in trials]
    return Report("\n".join([text, *map(str, files)]), facts)


def table_csv(dance: Dance, trials: Sequence[Trial]) -> str:
    """Return all measures, one movement per line."""
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    write(["trial", "by", "subtask", "name", *MEASURES])
    for trial in trials:
        for column in trial.columns.values():
            for k, values in _measures(column).items():
                row = [f"{value:.6g}" for value in values.values()]
                write([trial.name, column.name, k + 1, dance.subtasks[k].name, *row])
    return text.getvalue()


def _measures(column: Column) -> dict[int, dict[str, float]]:
    """Return the quantities of each movement of a column, by the number of the subtask."""
    found = {}
    for k, movement in sorted(column.movements.items()):
        j = movement.jerk
        values = (j.time, j.distance, j.integral, j.mean, j.dimensionless, movement.floor)
        rest = (column.smoothest[k].integral, movement.energy, movement.torque)
        found[k] = dict(zip(MEASURES, (*values, *rest), strict=True))
    return found


def _text(
    name: str, dance: Dance, trials: Sequence[Trial], compared: dict[str, list[Agreement]]
) -> str:
    lines = [f"{name}: jerk of the moving hand", METHOD]
    for trial in trials:
        lines += ["", f"at {trial.name}", *_table(dance, trial)]
        lines += _rank_lines(dance, trial, compared[trial.name])
    if is_figure_three(dance):
        lines += ["", "* not done: fields cannot turn a hand (subtasks 3 and 4)"]
    return "\n".join(lines)


def _table(dance: Dance, trial: Trial) -> list[str]:
    has_printed = is_figure_three(dance)
    heads = ["", *(f"1998 {name}" for name in PAPER_JERK if has_printed)]
    for name in trial.columns:
        heads += [f"{name} T", "C", "mean", "C T⁵/D²", "least", "same way", "J", "N m"]
    rows = [heads]
    for k, subtask in enumerate(dance.subtasks):
        printed = [PAPER_JERK[name][k] for name in PAPER_JERK] if has_printed else []
        row = [f"{k + 1:2d} {subtask.name}", *("*" if v is None else f"{v}" for v in printed)]
        for column in trial.columns.values():
            row += _cells(column.movements.get(k), column.smoothest.get(k))
        rows.append(row)
    return table_lines(rows)


def _cells(movement: MeasuredMove | None, smoothest: RetimedPath | None) -> list[str]:
    if movement is None or smoothest is None:
        return ["*"] * 8
    j = movement.jerk
    values = [f"{j.time:.2f}", f"{j.integral:.0f}", f"{j.mean:.0f}"]
    values.append("-" if j.distance < RESTING_DISTANCE else f"{j.dimensionless:.0f}")
    values += [f"{movement.floor:.0f}", f"{smoothest.integral:.0f}"]
    return [*values, f"{movement.energy:.0f}", f"{movement.torque:.0f}"]


def _rank_lines(dance: Dance, trial: Trial, compared: Sequence[Agreement]) -> Iterator[str]:
    for agreement in compared:
        yield (
            f"  order of our {agreement.ours} and their {agreement.theirs}: "
            f"{agreement.rank:+.2f} over {len(agreement.subtasks)} subtasks"
        )
        ranks = zip(agreement.subtasks, agreement.own, agreement.other, strict=True)
        for k, own, other in ranks:
            if abs(own - other) >= MIN_RANK_DIFFERENCE:
                why = _circumstances(dance, trial.columns[agreement.ours], k)
                yield f"    {k + 1}: {own}. here and {other}. there; {why}"


def _circumstances(dance: Dance, column: Column, k: int) -> str:
    """Return properties of a movement that bear on its jerk."""
    jerk, subtask = column.movements[k].jerk, dance.subtasks[k]
    times, hand = column.danced.times, column.danced.hands[subtask.hand]
    move = next(m for m in column.danced.moves[subtask.hand] if m.subtask == k)
    path = hand[(times >= move.begin) & (times <= move.land)]
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    found = [f"T = {jerk.time:.2f} s"]
    if jerk.distance > RESTING_DISTANCE:
        found.append(f"the way is {length / jerk.distance:.1f} times the straight one")
    if subtask.via:
        found.append(f"{len(subtask.via)} sub-goals on it")
    found.append("ends in a touch" if subtask.touch else "ends in the air")
    return ", ".join(found)


def _facts(trial: Trial, compared: Sequence[Agreement]) -> dict[str, Any]:
    return {
        "trial": trial.name,
        "columns": {
            name: {str(k + 1): values for k, values in _measures(column).items()}
            for name, column in trial.columns.items()
        },
        "rank_correlations": {f"{a.ours}/{a.theirs}": a.rank for a in compared},
    }
