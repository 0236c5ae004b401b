"""Inverse kinematics along a motion: all legs at once, against one leg after the other.

Six, a hundred and a thousand legs of the beetle follow a foot's path. Side by side in one run: our
batch, which begins with the geometry of the legs; with warm starts, damped iterations, preferred
values and limits included, with MuJoCo's kinematics and Jacobians, leg by leg; the same with
kinematics in plain numpy; and mink, whose steps are quadratic programs, where it is installed
(`requirements/bench.txt`). All stop at the same distance from the goal.

Prints microseconds a leg and step, and how many times faster the batch is.

    python benchmarks/ik.py [steps]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import mujoco
import numpy as np

try:
    import mink
except ImportError:
    mink = None

from pipeline.simulation.figures.figure import build_figure
from pipeline.simulation.figures.inverse_kinematics import TIP_ITERATION
from pipeline.simulation.figures.kinematics import LimbBatch
from pipeline.simulation.figures.limb_chains import group_chains
from pipeline.simulation.figures.skeleton import Limb, Skeleton
from pipeline.simulation.figures.tip_ik import solve_tips
from pipeline.simulation.spatial import Array, cross, rotation
from pipeline.spec import read_scene

Follow = Callable[[Array], float]
"""Bring all tips to goals (L, 3); return the greatest distance left [m]."""

STEPS_A_CYCLE = 240

DAMPING = 1e-4
"""λ of the iterations with warm starts, in lengths of the limb."""


def beetle() -> Skeleton:
    """Return the shipped beetle's."""
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{figure: beetle}]\n")
    return build_figure("beetle", scene.figures["beetle"], 1.0).skeleton


def batched(legs: LimbBatch) -> Follow:
    """Follow with the batch."""
    chains = group_chains(legs, np.arange(len(legs.lengths)) // 6)

    def follow(goals: Array) -> float:
        return float(solve_tips(legs, chains, goals[None]).residual.max())

    return follow


def in_mujoco(skeleton: Skeleton, limbs: list[Limb]) -> Follow:
    """Follow leg by leg, MuJoCo computing tips and Jacobians."""
    models = {limb.name: _model(skeleton, limb) for limb in limbs}
    qs = [skeleton.preferred[list(limb.joints)].copy() for limb in limbs]
    bounds = [_bounds(skeleton, limb) for limb in limbs]
    datas = {name: mujoco.MjData(model) for name, model in models.items()}

    def follow(goals: Array) -> float:
        worst = 0.0
        for q, limb, own, goal in zip(qs, limbs, bounds, goals, strict=True):
            model, data = models[limb.name], datas[limb.name]
            J = np.zeros((3, model.nv))
            damping = (DAMPING * limb.length) ** 2 * np.eye(3)
            gain = TIP_ITERATION.rest_gain
            while True:
                data.qpos[:] = q
                mujoco.mj_kinematics(model, data)
                error = goal - data.site_xpos[0]
                if (left := float(np.sqrt(error @ error))) <= TIP_ITERATION.tolerance * limb.length:
                    break
                mujoco.mj_comPos(model, data)
                mujoco.mj_jacSite(model, data, J, None, 0)
                _iterate(own, q, J, error, damping, gain)
                gain = 0.0
            worst = max(worst, left)
        return worst

    return follow


def _model(
    skeleton: Skeleton, limb: Limb, limits: tuple[Array, Array] | None = None
) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    body, above = spec.worldbody, np.zeros(3)
    for i, j in enumerate(limb.joints):
        body = body.add_body(pos=skeleton.places[j] - above)
        body.mass, body.inertia, body.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        joint = body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=skeleton.axes[j])
        if limits is not None:
            joint.range = np.degrees([limits[0][i], limits[1][i]])
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        above = skeleton.places[j]
    body.add_site(name="tip", pos=limb.tip - above)
    return spec.compile()


def _bounds(skeleton: Skeleton, limb: Limb) -> tuple[Array, Array, Array]:
    joints = list(limb.joints)
    return skeleton.lower[joints], skeleton.upper[joints], skeleton.preferred[joints]


def _iterate(
    bounds: tuple[Array, Array, Array],
    q: Array,
    J: Array,
    error: Array,
    damping: Array,
    gain: float,
) -> None:
    """Move the joint values `q` of one limb by one step, as `solve` does for all."""
    lower, upper, preferred = bounds
    if gain:
        z = gain * (preferred - q)
        q += z + J.T @ np.linalg.solve(J @ J.T + damping, error - J @ z)
    else:
        q += J.T @ np.linalg.solve(J @ J.T + damping, error)
    np.minimum(np.maximum(q, lower, out=q), upper, out=q)


def with_mink(skeleton: Skeleton, limbs: list[Limb]) -> Follow:
    """Follow leg by leg with mink: a task for the tip, joint limits, damping."""
    legs = []
    for limb in limbs:
        lower, upper, preferred = _bounds(skeleton, limb)
        model = _model(skeleton, limb, (lower, upper))
        tip = mink.FrameTask("tip", "site", position_cost=1.0, orientation_cost=0.0)
        limits = [mink.ConfigurationLimit(model)]
        legs.append((limb, mink.Configuration(model, preferred.copy()), tip, limits))

    def follow(goals: Array) -> float:
        worst = 0.0
        for (limb, configuration, tip, limits), goal in zip(legs, goals, strict=True):
            tip.set_target(mink.SE3.from_translation(goal))
            damping = (DAMPING * limb.length) ** 2
            while True:
                error = goal - configuration.data.site_xpos[0]
                if (left := float(np.sqrt(error @ error))) <= TIP_ITERATION.tolerance * limb.length:
                    break
                velocity = mink.solve_ik(
                    configuration, [tip], 1.0, "daqp", damping=damping, limits=limits
                )
                configuration.integrate_inplace(velocity, 1.0)
            worst = max(worst, left)
        return worst

    return follow


def leg_by_leg(skeleton: Skeleton, limbs: list[Limb]) -> Follow:
    """Follow with a plain loop over legs and joints."""
    qs = [skeleton.preferred[list(limb.joints)].copy() for limb in limbs]
    bounds = [_bounds(skeleton, limb) for limb in limbs]

    def tip_and_jacobian(limb: Limb, q: Array) -> tuple[Array, Array]:
        R, p, before = np.eye(3), np.zeros(3), np.zeros(3)
        axes, places = [], []
        for value, j in zip(q, limb.joints, strict=True):
            p = p + R @ (skeleton.places[j] - before)
            before = skeleton.places[j]
            axes.append(R @ skeleton.axes[j])
            places.append(p)
            R = R @ rotation(skeleton.axes[j], value)
        tip = p + R @ (limb.tip - before)
        return tip, cross(np.array(axes), tip - np.array(places)).T

    def follow(goals: Array) -> float:
        worst = 0.0
        for q, limb, own, goal in zip(qs, limbs, bounds, goals, strict=True):
            damping = (DAMPING * limb.length) ** 2 * np.eye(3)
            gain = TIP_ITERATION.rest_gain
            while True:
                tip, J = tip_and_jacobian(limb, q)
                error = goal - tip
                if (left := float(np.sqrt(error @ error))) <= TIP_ITERATION.tolerance * limb.length:
                    break
                _iterate(own, q, J, error, damping, gain)
                gain = 0.0
            worst = max(worst, left)
        return worst

    return follow


def timed(follow: Follow, legs: LimbBatch, steps: int) -> float:
    """Return microseconds a leg and step along a foot's path."""
    centre = legs.pose(legs.preferred).tips
    phase = 2.0 * np.pi * np.arange(len(centre)) * 0.618

    def goals(step: int) -> Array:
        t = phase + 2.0 * np.pi * step / STEPS_A_CYCLE
        way = np.stack([np.sin(t), 0.4 * np.maximum(np.cos(t), 0.0), 0.0 * t], axis=-1)
        return centre + 0.16 * legs.lengths[:, None] * way

    follow(goals(0))
    paths = [goals(step) for step in range(1, steps + 1)]
    began = time.perf_counter()
    worst = max(follow(path) for path in paths)
    spent = time.perf_counter() - began
    assert worst <= 1.01 * TIP_ITERATION.tolerance * legs.lengths.max()
    return spent / (steps * len(centre)) * 1e6


def main(steps: int) -> None:
    """Measure and print."""
    skeleton = beetle()
    print("microseconds a leg and step; in brackets, how many times faster the batch is")
    for count in (6, 100, 1000):
        limbs = [skeleton.legs[i % 6] for i in range(count)]
        legs = LimbBatch.of([(skeleton, limb) for limb in limbs])
        runs = max(4, steps * 6 // count)
        ours = timed(batched(legs), legs, max(runs, 20))
        theirs = timed(in_mujoco(skeleton, limbs), legs, runs)
        plain = timed(leg_by_leg(skeleton, limbs), legs, max(4, runs // 4))
        line = (
            f"{count:5d} legs: batch {ours:6.1f}   MuJoCo {theirs:6.1f} ({theirs / ours:.1f})"
            f"   numpy {plain:6.1f} ({plain / ours:.1f})"
        )
        if mink is not None:
            program = timed(with_mink(skeleton, limbs), legs, max(4, runs // 4))
            line += f"   mink {program:6.1f} ({program / ours:.1f})"
        print(line)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
