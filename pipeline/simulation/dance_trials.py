"""Dance trials: the public face of the dancers for reports that dance again, outside a take.

A trial varies controller, durations or gains, so no take holds it.
"""

from pipeline.simulation.dancers.dance_measurement import (
    DanceRecord,
    MeasuredMove,
    first_of_each,
    measure_moves,
    record_dance,
    same_way,
)
from pipeline.simulation.dancers.figure_three import COLUMNS, SUBTASKS
from pipeline.simulation.dancers.jerk import CUTOFF, LEAST, RATE, rank_correlation
from pipeline.simulation.dancers.minimum_jerk_retiming import RetimedPath

__all__ = [
    "COLUMNS",
    "CUTOFF",
    "LEAST",
    "RATE",
    "SUBTASKS",
    "DanceRecord",
    "MeasuredMove",
    "RetimedPath",
    "first_of_each",
    "measure_moves",
    "rank_correlation",
    "record_dance",
    "same_way",
]
