"""Cut list: the cuts of a film as YAML, those that a director decides with their reasons."""

from __future__ import annotations

from pipeline.production.camera.director.edit_decision import decisions_yaml
from pipeline.production.reports.tables import Report
from pipeline.production.run.frame_stage import shooting_of
from pipeline.production.run.order import Order
from pipeline.production.run.progress import Reporter
from pipeline.production.run.scene_run import working


def report_cuts(order: Order, reporter: Reporter) -> Report:
    """Return the cuts of a scene's film, simulating if necessary.

    Args:
        order: the scene.
        reporter: of progress.

    Raises:
        PronkError: something cannot be made.
    """
    with working(order, reporter) as run:
        decisions = shooting_of(run).decisions
        run.finish()
    return Report(decisions_yaml(decisions), [decision.facts for decision in decisions])
