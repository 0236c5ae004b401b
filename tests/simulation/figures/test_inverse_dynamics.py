"""Inverse dynamics against MuJoCo, the balance of power, and sums by hand."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.figures.figure_mass import FigureMass
from pipeline.simulation.figures.inverse_dynamics import (
    ExternalForces,
    FigureMotion,
    FrameMasses,
    inverse_dynamics,
)
from pipeline.simulation.figures.kinematics import JointTree, tree_jacobian
from pipeline.simulation.figures.skeleton import BODY, Skeleton
from pipeline.simulation.spatial import (
    Array,
    matrix,
    normalized,
    quaternion,
    rotation,
    turn,
    turn_inverse,
)

Maker = Callable[[np.random.Generator, int], Skeleton]
MOMENTS = 5


def _random_links(skeleton: Skeleton, rng: np.random.Generator) -> list[MassProperties]:
    """Return random link masses of a skeleton without solids."""
    found = []
    for link in skeleton.links:
        spread = rng.normal(size=(3, 3))
        second = spread @ spread.T + 0.1 * np.eye(3)
        inertia = np.trace(second) * np.eye(3) - second
        found.append(MassProperties(rng.uniform(0.1, 2), link.ends.mean(axis=0), inertia))
    return found


def _moving(skeleton: Skeleton, rng: np.random.Generator, n: int = MOMENTS) -> FigureMotion:
    """Return random states within joint limits, with a moving body."""
    J = len(skeleton.parents)
    X_WB = np.zeros((n, 4, 4))
    X_WB[:, :3, :3] = matrix(normalized(rng.normal(size=(n, 4))))
    X_WB[:, :3, 3], X_WB[:, 3, 3] = rng.normal(size=(n, 3)), 1.0
    span = skeleton.upper - skeleton.lower
    return FigureMotion(
        skeleton.lower + rng.random((n, J)) * span,
        rng.normal(size=(n, J)) * 3,
        rng.normal(size=(n, J)) * 20,
        X_WB,
        *rng.normal(size=(3, n, 3)) * np.array([2.0, 5.0, 5.0])[:, None, None],
    )


def _mujoco(skeleton: Skeleton, masses: FrameMasses) -> mujoco.MjModel:
    """Build the figure in MuJoCo: a free body, then one body for each joint with mass."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, -GRAVITY, 0.0]
    root = spec.worldbody.add_body(name="body")
    root.add_freejoint(name="free")
    _weigh(root, masses, BODY)
    carrier, origin = {BODY: root}, {BODY: np.zeros(3)}
    waiting: dict[int, list[int]] = {}
    for j in JointTree.of(skeleton).outward:
        above = int(skeleton.parents[j])
        # MuJoCo has no links without mass: joints of a ball share a body.
        chain = [*waiting.pop(above, []), j]
        if masses.mass[j] == 0.0:
            waiting[j] = chain
            continue
        base = int(skeleton.parents[chain[0]])
        body = carrier[base].add_body(name=f"b{j}", pos=skeleton.places[j] - origin[base])
        _weigh(body, masses, j)
        for k in chain:
            slides = skeleton.prismatic[k]
            kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
            assert np.allclose(skeleton.places[k], skeleton.places[j])
            body.add_joint(name=f"j{k}", type=kind, axis=skeleton.axes[k])
        carrier[j], origin[j] = body, skeleton.places[j]
    assert not waiting
    return spec.compile()


def _weigh(body: mujoco.MjsBody, masses: FrameMasses, frame: int) -> None:
    body.mass, body.ipos = masses.mass[frame], masses.centre[frame]
    full = masses.inertia[frame]
    body.fullinertia = full[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    body.explicitinertial = True


def _mujoco_load(
    skeleton: Skeleton, masses: FrameMasses, motion: FigureMotion
) -> tuple[Array, Array]:
    """Return joint torques (n, J), and force and moment of the body (n, 6)."""
    model = _mujoco(skeleton, masses)
    data = mujoco.MjData(model)
    joints = range(len(skeleton.parents))
    place = [int(model.joint(f"j{j}").qposadr[0]) for j in joints]
    speed = [int(model.joint(f"j{j}").dofadr[0]) for j in joints]
    torques, wrenches = np.zeros(motion.q.shape), np.zeros((len(motion.q), 6))
    for k in range(len(motion.q)):
        X = motion.X_WB[k]
        R = X[:3, :3]
        data.qpos[:3], data.qpos[3:7] = X[:3, 3], quaternion(R)
        data.qpos[place] = motion.q[k]
        # MuJoCo has angular quantities in body axes.
        data.qvel[3:6], data.qacc[3:6] = R.T @ motion.spin[k], R.T @ motion.spin_rate[k]
        data.qacc[:3] = motion.acceleration[k]
        data.qvel[speed], data.qacc[speed] = motion.speeds[k], motion.accelerations[k]
        mujoco.mj_inverse(model, data)
        torques[k] = data.qfrc_inverse[speed]
        wrenches[k] = [*data.qfrc_inverse[:3], *(R @ data.qfrc_inverse[3:6])]
    return torques, wrenches


def _assert_matches_mujoco(skeleton: Skeleton, masses: FrameMasses, motion: FigureMotion) -> None:
    load = inverse_dynamics(JointTree.of(skeleton), masses, motion)
    torques, wrenches = _mujoco_load(skeleton, masses, motion)
    ours = np.concatenate([load.force, load.moment], axis=-1)
    assert np.abs(load.torques - torques).max(initial=0.0) <= 1e-8 * np.abs(torques).max(
        initial=0.0
    )
    for part in (slice(0, 3), slice(3, 6)):
        assert np.abs(ours - wrenches)[:, part].max() <= 1e-8 * np.abs(wrenches[:, part]).max()


def _masses(figure: Figure) -> FrameMasses:
    return FrameMasses.of(figure.skeleton, FigureMass(figure).links)


def test_library_figures_match_mujoco(shipped: Figure) -> None:
    skeleton = shipped.skeleton
    _assert_matches_mujoco(skeleton, _masses(shipped), _moving(skeleton, np.random.default_rng(1)))


def test_random_figures_match_mujoco(random_skeleton: Maker) -> None:
    rng = np.random.default_rng(2)
    for _ in range(30):
        skeleton = random_skeleton(rng, int(rng.integers(1, 13)))
        masses = FrameMasses.of(skeleton, _random_links(skeleton, rng))
        _assert_matches_mujoco(skeleton, masses, _moving(skeleton, rng))


def test_external_forces_act_by_their_jacobians(shipped: Figure) -> None:
    """By virtual work: τ changes by -Jᵀ F, and the body by -F and its moment."""
    skeleton, rng = shipped.skeleton, np.random.default_rng(3)
    tree, masses, motion = JointTree.of(skeleton), _masses(shipped), _moving(skeleton, rng)
    frames = [BODY, *(limb.joints[-1] for limb in skeleton.limbs)]
    places = np.array([np.zeros(3), *(limb.tip for limb in skeleton.limbs)])
    forces = rng.normal(size=(MOMENTS, len(frames), 3)) * 50.0
    R_WB, p_WB = motion.X_WB[:, :3, :3], motion.X_WB[:, :3, 3]
    X, points = tree.pose(motion.q), np.empty_like(forces)
    expected = np.zeros_like(motion.q)
    for i, (frame, place) in enumerate(zip(frames, places, strict=True)):
        p_B = np.broadcast_to(place, (MOMENTS, 3))
        if frame != BODY:
            inside = place - skeleton.places[frame]
            p_B = X[:, frame, :3, 3] + turn(X[:, frame, :3, :3], inside)
        points[:, i] = p_WB + turn(R_WB, p_B)
        J = tree_jacobian(tree, motion.q, frame, place)[..., :3]
        expected += (J * turn_inverse(R_WB, forces[:, i])[:, None]).sum(axis=-1)
    free = inverse_dynamics(tree, masses, motion)
    pushed = inverse_dynamics(tree, masses, motion, ExternalForces(frames, points, forces))
    size = max(float(np.abs(expected).max(initial=0.0)), 1.0)
    assert np.abs(free.torques - pushed.torques - expected).max(initial=0.0) < 1e-10 * size
    assert np.allclose(free.force - pushed.force, forces.sum(axis=1))
    arms = np.cross(points - p_WB[:, None], forces).sum(axis=1)
    assert np.allclose(free.moment - pushed.moment, arms)


def _swaying(skeleton: Skeleton, times: Array) -> FigureMotion:
    """Return a motion in closed form: joints swing, the body circles and turns."""
    rate = 2.0 + np.arange(len(skeleton.parents)) % 3
    middle, far = 0.5 * (skeleton.lower + skeleton.upper), 0.2
    angle = times[:, None] * rate
    X = np.tile(np.eye(4), (len(times), 1, 1))
    axis = normalized(np.array([1.0, 2.0, -0.5]))
    X[:, :3, :3] = rotation(axis, 0.7 * np.sin(times))
    X[:, :3, 3] = np.stack([np.cos(times), np.sin(2 * times), times], axis=-1)
    return FigureMotion(
        middle + far * np.sin(angle),
        far * rate * np.cos(angle),
        -far * rate**2 * np.sin(angle),
        X,
        0.7 * np.cos(times)[:, None] * axis,
        -0.7 * np.sin(times)[:, None] * axis,
        np.stack([-np.cos(times), -4 * np.sin(2 * times), 0 * times], axis=-1),
    )


def _energy(skeleton: Skeleton, masses: FrameMasses, motion: FigureMotion, dt: float) -> Array:
    """Return kinetic and potential energy (n,), all speeds by differences of poses [J]."""
    X = motion.X_WB[:, None] @ JointTree.of(skeleton).pose(motion.q)
    X = np.concatenate([X, motion.X_WB[:, None]], axis=1)
    R, p = X[..., :3, :3], X[..., :3, 3]
    centres = p + turn(R, masses.centre)
    v = np.gradient(centres, dt, axis=0, edge_order=2)
    # Rotations change by the cross product with the angular velocity.
    W = np.gradient(R, dt, axis=0, edge_order=2) @ np.swapaxes(R, -1, -2)
    ω = np.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)
    inertia = R @ masses.inertia @ np.swapaxes(R, -1, -2)
    kinetic = 0.5 * masses.mass * (v * v).sum(axis=-1) + 0.5 * (ω * turn(inertia, ω)).sum(axis=-1)
    result: Array = (kinetic + masses.mass * GRAVITY * centres[..., 1]).sum(axis=-1)
    return result


@pytest.mark.sample(3)
@pytest.mark.slow
def test_power_is_the_rate_of_energy(shipped: Figure) -> None:
    skeleton, masses = shipped.skeleton, _masses(shipped)
    times = np.linspace(0.0, 1.0, 2001)
    dt = times[1] - times[0]
    motion = _swaying(skeleton, times)
    load = inverse_dynamics(JointTree.of(skeleton), masses, motion)
    velocity = np.stack([-np.sin(times), 2 * np.cos(2 * times), np.ones_like(times)], axis=-1)
    power = (load.torques * motion.speeds).sum(axis=-1)
    power += (load.force * velocity).sum(axis=-1) + (load.moment * motion.spin).sum(axis=-1)
    energy = _energy(skeleton, masses, motion, dt)[1:-1]
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:-2] + power[2:-1])) * dt])
    assert np.abs(energy - energy[0] - work).max() < 1e-5 * np.ptp(energy)


def test_straight_two_link_leg_by_hand(figure: Callable[..., Figure]) -> None:
    """Held out level, each joint carries the weight beyond it times its arm."""
    thing = figure(
        "{nodes: {a: [0, 0], b: [0, 1], k: [1, 0], f: [2.5, 0], l: [-1, 0], m: [-2.5, 0]},"
        " chains: [[a, b], [a, k, f], [a, l, m]], radius: 0.1}"
    )
    skeleton, links = thing.skeleton, FigureMass(thing).links
    leg = skeleton.legs[0]
    upper, lower = (links[i] for i in leg.links)
    hip, knee = (skeleton.places[skeleton.links[i].joint] for i in leg.links)
    q = np.zeros(len(skeleton.parents))
    still = FigureMotion(q, 0 * q, 0 * q, np.eye(4), *np.zeros((3, 3)))
    torques = inverse_dynamics(
        JointTree.of(skeleton), FrameMasses.of(skeleton, links), still
    ).torques
    bend = [j for j in leg.joints if skeleton.joint_names[j].endswith("_bend")]
    pitch = [j for j in leg.joints if skeleton.joint_names[j].endswith("_pitch")]
    along = normalized((knee - hip) * [1, 0, 1])
    arm = [
        (lower.centre - knee) @ along,
        (lower.centre - hip) @ along,
        (upper.centre - hip) @ along,
    ]
    assert torques[bend] == pytest.approx([lower.mass * GRAVITY * arm[0]])
    both = GRAVITY * (lower.mass * arm[1] + upper.mass * arm[2])
    assert torques[pitch] == pytest.approx([both])
    yaw = [j for j in leg.joints if skeleton.joint_names[j].endswith("_yaw")]
    assert torques[yaw] == pytest.approx(0.0, abs=1e-12 * both)
