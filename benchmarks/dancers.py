"""Dancers: steps a second beside plain MuJoCo with the same model.

One dancer dances the Macarena by each controller; then MuJoCo alone is driven by what drove it,
so that the same model goes the same way. The overhead is what controllers, the finding of
contacts and the reading of states add. Times are those of the processor, the best of several.

    python benchmarks/dancers.py
"""

from __future__ import annotations

import os
import time

# One core: numpy reads these when it is imported.
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from pipeline.simulation.dancers.dance_goals import dance_choreography
from pipeline.simulation.dancers.dance_moves import beat_duration, plan_moves
from pipeline.simulation.dancers.dancer_motion import DancerMotion
from pipeline.simulation.dancers.torso import dancer_proportions
from pipeline.simulation.simulate import Simulation
from pipeline.spec import read_scene

RATE, SECONDS, TIMES, CHUNK = 96.0, 8.0, 8, 24
"""Steps of the world a second, length of a measurement [s], how often it is made, and how many
steps are measured at once."""

SCENE = "pronk: 1\nduration: {seconds}\ncast:\n- {{dancer: torso, controller: {by}, start: 0.5}}\n"


def dancer(by: str) -> DancerMotion:
    """Return a dancer about to begin."""
    scene = read_scene(SCENE.format(seconds=60, by=by))
    _, member = scene.dancers[0]
    dance = scene.dances[member.dance]
    choreography = dance_choreography(dancer_proportions(member), dance, member.dance, True)
    moves = plan_moves(member, dance, 60.0, "cast[0]")
    return DancerMotion(member, choreography, moves, beat_duration(member, dance), 1.0 / RATE)


def overhead(by: str) -> tuple[float, float, float]:
    """Return microseconds a step of ours and of MuJoCo alone, and the part that ours is longer.

    Each quarter of a second is measured on its own, and its best time counts: what else the
    machine does is left out.
    """
    driven = recorded(by)
    ours, plain = np.full((2, len(driven) // CHUNK), np.inf)
    for _ in range(TIMES):
        one, other = dancer(by), dancer(by)
        model, data, step = other.moving.model, other.moving.data, other.moving._mujoco.mj_step
        for i in range(len(ours)):
            began = time.process_time()
            for _ in range(CHUNK):
                one.advance()
            ours[i] = min(ours[i], time.process_time() - began)
            began = time.process_time()
            for ctrl, push in driven[i * CHUNK : (i + 1) * CHUNK]:
                data.ctrl[:], data.qfrc_applied[:] = ctrl, push
                step(model, data, other.substeps)
            plain[i] = min(plain[i], time.process_time() - began)
    count = len(ours) * CHUNK * one.substeps
    ours_us, plain_us = 1e6 * ours.sum() / count, 1e6 * plain.sum() / count
    return ours_us, plain_us, ours_us / plain_us - 1.0


def recorded(by: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return what drives a dancer at each control: so MuJoCo alone goes the same way."""
    one, rows = dancer(by), []
    for _ in range(round(SECONDS * RATE)):
        one.advance()
        rows.append((one.moving.data.ctrl.copy(), one.moving.push.copy()))
    return rows


def film(by: str) -> float:
    """Return seconds of the processor for a second of film, with the building of the world."""
    scene = read_scene(SCENE.format(seconds=10, by=by))
    began = time.process_time()
    simulation = Simulation(scene)
    while not simulation.finished:
        simulation.step()
    return (time.process_time() - began) / 10.0


def main() -> None:
    """Measure and print."""
    for by in ("force-field", "joint-torque"):
        ours, plain, more = overhead(by)
        print(
            f"{by:12}: {1e6 / ours:7.0f} steps a second, MuJoCo alone {1e6 / plain:7.0f}; "
            f"overhead {100 * more:.0f}%; {film(by):.3f} s a second of film"
        )


if __name__ == "__main__":
    main()
