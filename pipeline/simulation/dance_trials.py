"""Public interface of the dancers for reports that simulate dances outside a take.

A trial varies the controller, durations or gains, so no take contains it.
"""

from pipeline.simulation.dancers.dance_measurement import (
    DanceRecord,
    MeasuredMove,
    first_of_each_subtask,
    measure_moves,
    minimum_jerk_timing,
    record_dance,
)
from pipeline.simulation.dancers.jerk import (
    CUTOFF_FREQUENCY,
    MINIMUM_DIMENSIONLESS_JERK,
    SAMPLE_RATE,
    rank_correlation,
)
from pipeline.simulation.dancers.minimum_jerk_retiming import RetimedPath
from pipeline.simulation.dancers.paper_jerk import PAPER_JERK, PAPER_SUBTASK_COUNT

__all__ = [
    "CUTOFF_FREQUENCY",
    "MINIMUM_DIMENSIONLESS_JERK",
    "PAPER_JERK",
    "PAPER_SUBTASK_COUNT",
    "SAMPLE_RATE",
    "DanceRecord",
    "MeasuredMove",
    "RetimedPath",
    "first_of_each_subtask",
    "measure_moves",
    "minimum_jerk_timing",
    "rank_correlation",
    "record_dance",
]
