"""Production: one scene to its take, score, frames and film, doing only what is due."""

from __future__ import annotations

from collections.abc import Collection

from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.film_end import notes_after_end
from pipeline.production.run.film_stage import make_film
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.production.run.frame_stage import make_frames, note_levels, shooting_of
from pipeline.production.run.notes import clock_of, take_notes
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working
from pipeline.production.run.score_stage import store_events, store_exports, write_score
from pipeline.production.run.take_stage import store_take, take_of
from pipeline.production.shots.title_timing import require_titles
from pipeline.production.sound.export_kind import ExportKind
from pipeline.simulation.take import Take


def render(order: Order, reporter: Reporter) -> Outputs:
    """Make the film of a scene, its score and the files beside them.

    Raises:
        PronkError: something cannot be made; earlier outputs stay.
    """
    frames = parse_frames(order.frames, order.scene.n_frames)
    require_encoders(order.scene)
    require_titles(order.scene)
    with working(order, reporter) as run:
        run.frames = frames
        shooting = shooting_of(run)
        take = shooting.take
        if order.sound:
            write_score(run, take, shooting)
        make_frames(run, shooting, frames)
        note_levels(run, shooting, frames)
        run.refuse_notes()
        make_film(run, frames)
        run.finish()
        return run.outputs


def simulate_only(order: Order, reporter: Reporter) -> tuple[Outputs, Take]:
    """Simulate a scene and store its take and events."""
    with working(order, reporter) as run:
        take = take_of(run)
        store_events(run, take)
        run.finish()
        return run.outputs, take


def store_only(order: Order, take: Take, reporter: Reporter) -> Outputs:
    """Store a take that was made elsewhere, and its events."""
    with working(order, reporter) as run:
        run.notes = [*notes_after_end(order.scene), *take_notes(take, clock_of(order.scene))]
        store_take(run, take)
        store_events(run, take)
        run.finish()
        return run.outputs


def score_only(order: Order, reporter: Reporter, exports: Collection[ExportKind] = ()) -> Outputs:
    """Write the score of a scene, simulating if necessary.

    Args:
        order: settings of the run.
        reporter: of progress.
        exports: what is written for other programs.
    """
    with working(order, reporter) as run:
        shooting = shooting_of(run)
        score = write_score(run, shooting.take, shooting)
        if exports:
            store_exports(run, score, exports)
        run.finish()
        return run.outputs
