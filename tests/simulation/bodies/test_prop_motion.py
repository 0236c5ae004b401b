"""Props moved by velocity and by force: closed forms and invariances."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import SceneError
from pipeline.simulation.bodies.integrated_attitude import SpunAttitude, TorquedAttitude
from pipeline.simulation.bodies.integrated_motion import (
    MAX_DEGREE,
    IntegratedMotion,
    PiecewisePolynomial,
    phi_functions,
)
from pipeline.simulation.bodies.prop_paths import prop_mass
from pipeline.simulation.dynamics.gravity import GRAVITY
from pipeline.simulation.dynamics.mass import MassProperties
from pipeline.simulation.keyframe_track import Track
from pipeline.simulation.simulate import Simulation, simulate
from pipeline.simulation.spatial import Array, heading, matrix, rotation
from pipeline.simulation.take import Take
from pipeline.spec.keyframes import Ease
from pipeline.spec.prop import BoxShape, ForceMotion
from tests.simulation.conftest import scene_of

EASES: tuple[Ease, ...] = ("spline", "linear", "in", "out", "in-out", "hold")

KEYS = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(-5, 5), st.sampled_from(EASES)),
    min_size=1,
    max_size=6,
)


def track_of(keys: list[tuple[float, float, Ease]]) -> Track:
    times = np.cumsum([gap for gap, _, _ in keys])
    return Track.of([(float(t), (v,), e) for t, (_, v, e) in zip(times, keys, strict=True)])


def pose(take: Take, node: str) -> tuple[Array, Array]:
    """Return R_WB (K, 3, 3) and p_WB (K, 3) of a node."""
    i = [one.name for one in take.nodes].index(node)
    return matrix(take.rotations[:, i]), take.positions[:, i]


def times_of(take: Take) -> Array:
    return np.arange(len(take.positions)) / float(take.header.rate * take.header.samples)


@given(KEYS)
def test_pieces_equal_the_track(keys: list[tuple[float, float, Ease]]) -> None:
    track = track_of(keys)
    times = np.linspace(0.0, track.times[-1] + 1.0, 97)
    away = np.abs(times[:, None] - track.times).min(axis=1) > 1e-6
    times = times[away]
    np.testing.assert_allclose(PiecewisePolynomial.of(track).at(times), track(times), atol=1e-11)


@given(KEYS)
def test_a_velocity_is_integrated_exactly(keys: list[tuple[float, float, Ease]]) -> None:
    track = track_of(keys)
    end = float(track.times[-1]) + 0.5
    place = IntegratedMotion.by_velocity(PiecewisePolynomial.of(track), np.array([2.0])).at(
        np.array([end])
    )[0]
    # Gauss' rule of four points is exact for what is no more than of seventh degree.
    nodes, weights = np.polynomial.legendre.leggauss(4)
    edges = [0.0, *track.times, end]
    whole = sum(
        0.5 * (b - a) * float(weights @ track(0.5 * (a + b) + 0.5 * (b - a) * nodes)[:, 0])
        for a, b in pairwise(edges)
    )
    np.testing.assert_allclose(place[0, 0], 2.0 + whole, atol=1e-11)


@pytest.mark.slow
@given(st.floats(-60.0, 0.0))
def test_phi_functions_equal_their_integrals(z: float) -> None:
    # φ_n(z) = ∫₀¹ exp((1 - s) z) s^(n-1) / (n-1)! ds.
    nodes, weights = np.polynomial.legendre.leggauss(64)
    s = 0.5 + 0.5 * nodes
    found = phi_functions(np.array([z]))[:, 0]
    assert found[0] == pytest.approx(math.exp(z), rel=1e-12)
    for n in range(1, MAX_DEGREE + 3):
        whole = 0.5 * weights @ (np.exp((1 - s) * z) * s ** (n - 1)) / math.factorial(n - 1)
        assert found[n] == pytest.approx(whole, rel=1e-10)


@given(KEYS, st.sampled_from([0.0, 1e-6, 0.3, 7.0, 400.0]))
def test_a_force_with_drag_satisfies_its_equation(
    keys: list[tuple[float, float, Ease]], drag: float
) -> None:
    pieces = PiecewisePolynomial.of(track_of(keys))
    carried = IntegratedMotion.by_acceleration(pieces, np.array([1.0]), np.array([-2.0]), drag)
    begins = np.append(pieces.begins, pieces.begins[-1] + 1.0)
    times = np.concatenate([a + (b - a) * np.linspace(0.05, 0.95, 7) for a, b in pairwise(begins)])
    h = 1e-4
    v = carried.at(times)[1]
    slope = (carried.at(times + h)[0] - carried.at(times - h)[0]) / (2 * h)
    np.testing.assert_allclose(slope, v, atol=2e-4 * (1 + drag))
    change = (carried.at(times + h)[1] - carried.at(times - h)[1]) / (2 * h)
    if drag < 100.0:
        inner = np.abs(times[:, None] - pieces.begins).min(axis=1) > 2 * h
        expected = pieces.at(times) - drag * v
        np.testing.assert_allclose(change[inner], expected[inner], atol=2e-3)


def test_a_throw_is_a_parabola() -> None:
    member = (
        "{name: a, prop: {shape: ball}, at: [1, 2, 3],"
        " force: {gravity: true, velocity: [1, 4, -2], mass: 3}}"
    )
    take = simulate(scene_of(member))
    t = times_of(take)[:, None]
    expected = np.array([1.0, 2.0, 3.0]) + t * [1, 4, -2] - 0.5 * GRAVITY * t * t * [0, 1, 0]
    np.testing.assert_allclose(pose(take, "a")[1], expected, atol=1e-11)


def test_drag_ends_in_the_terminal_velocity() -> None:
    member = (
        "{name: a, prop: {shape: ball}, at: [0, 50, 0], force: {gravity: true, mass: 2, drag: 5}}"
    )
    take = simulate(scene_of(member))
    t, k = times_of(take), 2.5
    fall = GRAVITY / k * (t - (1 - np.exp(-k * t)) / k)
    np.testing.assert_allclose(pose(take, "a")[1][:, 1], 50 - fall, atol=1e-11)


def test_pieces_of_constant_force_are_pieces_of_parabolas() -> None:
    keys = "[{at: 0, force: [4, 0, 0]}, {at: 0.7, force: [-4, 0, 0], ease: hold}," + (
        " {at: 1.4, force: [0, 0, 0], ease: hold}]"
    )
    member = f"{{name: a, prop: {{shape: box}}, at: [0, 1, 0], force: {{mass: 2, keys: {keys}}}}}"
    p = pose(simulate(scene_of(member)), "a")[1]
    # Speeds up for 0.7 s, slows down for 0.7 s: it comes to rest after a t².
    assert p[-1, 0] == pytest.approx(2.0 * 0.7**2, abs=1e-11)
    np.testing.assert_allclose(np.diff(p[140:, 0]), 0.0, atol=1e-11)


def test_a_constant_torque_gives_constant_angular_acceleration() -> None:
    config = ForceMotion(torque=(0.0, 0.6, 0.0), mass=5.0)
    box = BoxShape(shape="box", size=(0.4, 0.2, 0.9))
    moment = prop_mass(box, config).inertia[1, 1]
    member = (
        "{name: a, prop: {shape: box, size: [0.4, 0.2, 0.9]}, at: [0, 1, 0], heading_deg: 20,"
        " force: {torque: [0, 0.6, 0], mass: 5}}"
    )
    take = simulate(scene_of(member))
    t = times_of(take)
    expected = heading(math.radians(20) + 0.5 * 0.6 / moment * t * t)
    np.testing.assert_allclose(pose(take, "a")[0], expected, atol=1e-9)


def test_momentum_and_energy_are_conserved_without_torque() -> None:
    mass = MassProperties(2.0, np.zeros(3), np.diag([0.2, 0.5, 0.6]))
    still = PiecewisePolynomial.of(Track.of([(0.0, (0.0, 0.0, 0.0), "linear")]))
    body = TorquedAttitude(
        still, mass, rotation(np.array([0.6, 0.8, 0.0]), 1.0), np.array([1.0, 6, 2]), 0
    )
    momenta, energies = [], []
    for time in np.linspace(0.0, 5.0, 60):
        body.at(np.array([time]))
        momenta.append(body.momentum)
        energies.append(body.energy)
    np.testing.assert_allclose(momenta, np.tile(momenta[0], (60, 1)), atol=1e-8)
    np.testing.assert_allclose(energies, energies[0], rtol=1e-8)


def test_a_torque_changes_momentum_by_its_impulse() -> None:
    mass = MassProperties(
        2.0, np.zeros(3), np.array([[0.3, 0.05, 0], [0.05, 0.5, -0.1], [0, -0.1, 0.6]])
    )
    keys = [(0.0, (0.2, -0.4, 0.1), "linear"), (1.0, (1.0, 0.4, -0.9), "linear")]
    torque = PiecewisePolynomial.of(Track.of(keys))  # type: ignore[arg-type]
    body = TorquedAttitude(
        torque, mass, rotation(np.array([0.6, 0.8, 0.0]), 1.0), np.array([1.0, 2, 2]), 0
    )
    start = body.momentum
    np.testing.assert_allclose(body.at(np.zeros(1))[0], rotation(np.array([0.6, 0.8, 0]), 1.0))
    body.at(np.array([1.0]))
    np.testing.assert_allclose(body.momentum - start, [0.6, 0.0, -0.4], atol=1e-8)


def test_turning_drag_stops_a_spin() -> None:
    mass = MassProperties(2.0, np.zeros(3), 0.5 * np.eye(3))
    still = PiecewisePolynomial.of(Track.of([(0.0, (0.0, 0.0, 0.0), "linear")]))
    body = TorquedAttitude(still, mass, np.eye(3), np.array([0.0, 8.0, 0.0]), 0.75)
    (R,) = body.at(np.array([2.0]))
    np.testing.assert_allclose(R, heading(8.0 / 1.5 * (1 - math.exp(-3.0))), atol=1e-9)


@pytest.mark.parametrize("ease", EASES)
def test_a_spin_about_one_axis_is_exact(ease: Ease) -> None:
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    keys = [(0.0, tuple(axis), "linear"), (0.4, tuple(9 * axis), ease), (1.1, tuple(-axis), ease)]
    spin = Track.of(keys)  # type: ignore[arg-type]
    angle = (
        IntegratedMotion.by_velocity(PiecewisePolynomial.of(spin), np.zeros(3)).at(np.array([1.7]))[
            0
        ]
        @ axis
    )
    turned = SpunAttitude(PiecewisePolynomial.of(spin), heading(0.3)).at(np.array([1.7]))[0]
    np.testing.assert_allclose(turned, rotation(axis, float(angle[0])) @ heading(0.3), atol=1e-12)


def test_a_spin_about_a_moving_axis_converges_at_fourth_order() -> None:
    keys = [(0.0, (9.0, 0.0, 0.0), "linear"), (1.0, (0.0, 0.0, 9.0), "linear")]
    pieces = PiecewisePolynomial.of(Track.of(keys))  # type: ignore[arg-type]
    exact = SpunAttitude(pieces, np.eye(3)).at(np.linspace(0.0, 1.0, 4001))[-1]
    (whole,) = SpunAttitude(pieces, np.eye(3)).at(np.array([1.0]))
    np.testing.assert_allclose(whole, exact, atol=1e-8)
    np.testing.assert_allclose(whole.T @ whole, np.eye(3), atol=1e-13)


def test_velocity_and_spin_are_those_given() -> None:
    member = (
        "{name: a, prop: {shape: box}, at: [1, 1, 0], rotation_deg: [10, 0, 0],"
        " velocity: [0.5, 0, -1], spin_deg: [0, 90, 0]}"
    )
    take = simulate(scene_of(member))
    R, p = pose(take, "a")
    t = times_of(take)
    np.testing.assert_allclose(p, [1, 1, 0] + t[:, None] * [0.5, 0, -1], atol=1e-12)
    tilt = rotation(np.array([1.0, 0, 0]), math.radians(10))
    np.testing.assert_allclose(R, heading(np.radians(90) * t) @ tilt, atol=1e-12)


def test_a_spinning_parent_carries_its_child_round() -> None:
    wheel = "{name: wheel, prop: {shape: cylinder}, at: [0, 2, 0], spin_deg: [0, 0, 180]}"
    seat = "{name: seat, parent: wheel, prop: {shape: box}, at: [1, 0, 0]}"
    p = pose(simulate(scene_of(seat, wheel)), "seat")[1]
    np.testing.assert_allclose(np.linalg.norm(p - [0, 2, 0], axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(p[[96, 192]], [[-1, 2, 0], [1, 2, 0]], atol=1e-12)


def test_another_frame_rate_samples_the_same_motion() -> None:
    member = (
        "{name: a, prop: {shape: box, size: [0.2, 0.3, 0.9]}, at: [0, 1, 0], force: {spin_deg:"
        " [200, 300, 10], keys: [{at: 0, torque: [0, 0, 1]}, {at: 1, torque: [3, 0, 0]}]}}"
    )
    one, other = (simulate(scene_of(member, more=f"fps: {fps}")) for fps in (24, 60))
    R, R_other = pose(one, "a")[0], pose(other, "a")[0]
    np.testing.assert_allclose(R[::8], R_other[::20], atol=1e-8)


def test_a_rigid_body_as_parent_carries_its_child() -> None:
    body = "{name: crate, body: {shape: box}, at: [0, 3, 0], spin_deg: [90, 40, 0]}"
    flag = "{name: flag, parent: crate, prop: {shape: ball, radius: 0.05}, at: [0, 0.5, 0]}"
    take = simulate(scene_of(flag, body))
    R, p = pose(take, "crate")
    np.testing.assert_allclose(pose(take, "flag")[1], p + R @ [0, 0.5, 0], atol=1e-12)


def test_scale_does_not_apply_to_children() -> None:
    keys = "[{at: 0, scale: 1}, {at: 1, scale: [1, 3, 0.5], ease: linear}]"
    base = f"{{name: base, prop: {{shape: box}}, at: [0, 1, 0], keyframes: {keys}}}"
    child = "{name: top, parent: base, prop: {shape: ball}, at: [0, 0.5, 0], spin_deg: [0, 60, 0]}"
    other = "{name: other, prop: {shape: ball}, keyframes: [{at: 0, scale: 2}]}"
    take = simulate(scene_of(child, base, other))
    names = [node.name for node in take.nodes]
    assert [names[i] for i in take.scaled] == ["base", "other"]
    t = np.clip(times_of(take), 0.0, 1.0)
    expected = np.stack([1 + 0 * t, 1 + 2 * t, 1 - 0.5 * t], axis=-1)
    np.testing.assert_allclose(take.scales[:, 0], expected, atol=1e-12)
    np.testing.assert_allclose(take.scales[:, 1], 2.0, atol=1e-12)
    np.testing.assert_allclose(pose(take, "top")[1], np.tile([0, 1.5, 0], (len(t), 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ("velocity: [1, 0, 0], keyframes: [{at: 0, scale: 2}]", "conflicts with keyframes"),
        ("velocity: [1, 0, 0], force: {}", "conflicts with velocity"),
        ("force: {gravity: true}, spin_deg: [0, 1, 0]", "conflicts with force"),
        (
            "velocity: [{at: 0, linear: [1, 0, 0]}], spin_deg: [0, 1, 0]",
            "conflicts with the keys of velocity",
        ),
        ("velocity: [{at: 0}]", "should say a velocity"),
        ("velocity: [{at: 0, linaer: [1, 0, 0]}]", "did you mean 'linear'"),
        ("velocity: [{at: 1, linear: [1, 0, 0]}, {at: 0, linear: [1, 0, 0]}]", "in order"),
        ("velocity: [1, 0]", "must hold 3 values"),
        ("velocity: fast", "should be"),
        ("velocity: []", "must hold"),
        ("force: {force: [1, 0, 0], keys: [{at: 0, force: [0, 0, 0]}]}", "conflicts with keys"),
        ("force: {keys: [{at: 0}]}", "should say a force"),
        ("force: {mas: 2}", "did you mean 'mass'"),
        ("force: {mass: 0}", "greater than 0"),
        ("force: {keys: [{at: 0, torque: [0, 0, 1], ease: jump}]}", "'hold'"),
        ("falls: 1, keyframes: [{at: 0, scale: 2}]", "conflicts with the scale"),
        (
            "held: [{by: b, at: 1, until: 2, then: fall}], keyframes: [{at: 0, scale: 2}]",
            "conflicts with the scale",
        ),
        ("keyframes: [{at: 0, position: [0, 0, 0], tangent: {scale: [1, 1, 1]}}]", "needs the sc"),
        (
            "keyframes: [{at: 0, position: [0, 0, 0], tangent: {position: [1, 1, 1]}}]",
            "needs a spline",
        ),
        ("keyframes: [{at: 0, scale: [1, 0, 1]}]", "greater than 0"),
        ("keyframes: [{at: 0, scale: [1, 1]}]", "must hold 3 values"),
    ],
)
def test_invalid_motions_are_refused(config: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        Simulation(
            scene_of(f"{{prop: {{shape: ball}}, {config}}}", "{name: b, prop: {shape: box}}")
        )
    assert all(problem.line > 0 for problem in caught.value.problems)
