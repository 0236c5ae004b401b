"""Budget: the memory and the time that a run may take, kept before it begins and while it runs."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.errors import Problem, ProductionError, SceneError
from pipeline.production.run.available_memory import available_memory
from pipeline.production.run.frame_ranges import parse_frames
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.quantities import duration_text, size_text
from pipeline.production.run.scene_cost import Job, PartCost, SceneCost, Work, scene_cost
from pipeline.spec import Scene

MEMORY_ERROR = 1.5
"""Factor by which estimates of memory may be too high: of the machine's own memory, only what
cannot be held even then is refused."""

UNTRUSTED_MEMORY, UNTRUSTED_TIME = 4 * 2**30, 1800.0
"""Limits of untrusted scenes that are given none [bytes, s]."""


class BudgetExceeded(SceneError):
    """A scene takes more than its budget, by its estimate."""


class BudgetReached(ProductionError):
    """A run has reached the limit of its budget; what was finished stays."""


@dataclass(frozen=True, slots=True)
class Budget:
    """What a run on one scene may take.

    Attributes:
        memory: of all its processes together [bytes]; None for what the machine has.
        seconds: of the clock on the wall; None for any time.
    """

    memory: int | None = None
    seconds: float | None = None

    def refuse(self, scene: Scene, job: Job) -> SceneCost:
        """Return the estimated cost of a job on a scene.

        Raises:
            BudgetExceeded: it is more than the budget, or than the machine has; names the part
                that costs most.
        """
        cost = scene_cost(scene, job)
        if self.memory is not None and cost.memory > self.memory:
            bound = f"the limit (--max-memory {size_text(self.memory)})"
            raise _too_much_memory(scene, cost, self.memory, bound)
        held = available_memory()
        if held is not None and cost.memory > MEMORY_ERROR * held.size:
            bound = f"{held.source} has free ({size_text(held.size)})"
            raise _too_much_memory(scene, cost, held.size, bound)
        if self.seconds is not None and cost.seconds > self.seconds:
            raise _too_much_time(scene, cost, self.seconds)
        return cost


def job_of(order: Order, work: Work) -> Job:
    """Return what is left to do of an order, by the files that earlier runs have left.

    Whether they are still right is not looked at: a limit of time holds while it runs, too.
    """
    outputs = Outputs(order.out / order.name, order.name)
    if work != "render":
        return Job(work, is_simulated=outputs.take.exists())
    frames = parse_frames(order.frames, order.scene.n_frames)
    suffix = order.scene.film.resolved().format
    left = [frame for frame in frames if not outputs.frame(frame, suffix).is_file()]
    processes = max(min(order.jobs, len(left)), 1)
    return Job(work, len(left), processes, outputs.take.exists(), order.sound)


def estimate_text(cost: SceneCost) -> str:
    """Return an estimate in words."""
    return f"about {size_text(cost.memory)} of memory and {duration_text(cost.seconds)}"


def _too_much_memory(scene: Scene, cost: SceneCost, limit: float, bound: str) -> BudgetExceeded:
    worst = max(cost.parts, key=lambda part: part.memory)
    takes = f"takes about {size_text(cost.memory)} of memory"
    fit = _fitting(worst, worst.memory, limit - (cost.memory - worst.memory))
    share = f"{worst.text} about {size_text(worst.memory)} of it"
    return _exceeded(scene, worst, takes, share, bound, fit)


def _too_much_time(scene: Scene, cost: SceneCost, limit: float) -> BudgetExceeded:
    worst = max(cost.parts, key=lambda part: part.seconds)
    takes = f"takes about {duration_text(cost.seconds)}"
    fit = _fitting(worst, worst.seconds, limit - (cost.seconds - worst.seconds))
    share = f"{worst.text} about {duration_text(worst.seconds)} of it"
    bound = f"the limit (--max-time {duration_text(limit)})"
    return _exceeded(scene, worst, takes, share, bound, fit)


def _exceeded(
    scene: Scene, worst: PartCost, takes: str, share: str, bound: str, fit: str
) -> BudgetExceeded:
    message = f"the scene {takes}, {share}, more than {bound}; {fit}"
    problem = scene.source_map.with_location(Problem(worst.path, message))
    return BudgetExceeded([problem])


def _fitting(worst: PartCost, amount: float, left: float) -> str:
    """Return what would fit instead of the part that costs most.

    Args:
        worst: the part.
        amount: what it takes, of memory or time.
        left: what the others leave of the limit.
    """
    count = int(worst.count * max(left, 0.0) / amount)
    if worst.unit == "cells":
        side = int(count**0.5)
        return f"about {side:,} x {side:,} cells would fit" if side > 1 else "no ground would fit"
    if count and worst.unit:
        return f"about {count:,} {worst.unit} would fit"
    return "make the scene smaller"
