"""Kinds of swings: work, touchdown and ground clearance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

import numpy as np
import pytest

from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.locomotion.swing import swing_planner
from pipeline.simulation.locomotion.swing.passive_swing import simulate_fall
from pipeline.simulation.locomotion.swing.swing_dynamics import ROWS, SwingTrial
from pipeline.simulation.locomotion.swing.swing_planner import PLANNERS
from pipeline.simulation.locomotion.swing.swing_trajectory import (
    KNOTS,
    PIECES,
    POINTS,
    bend_at,
    clearance_height,
    fit_bend,
)
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground
from pipeline.spec import Scene
from pipeline.spec.walk import Walk as WalkConfig

if TYPE_CHECKING:
    from tests.simulation.conftest import Walk

HILLS = "{kind: hills, height: 0.8, spacing: 5, size: [40, 40]}"


def test_every_swing_kind_has_a_planner() -> None:
    kinds = set(get_args(WalkConfig.model_fields["swing"].annotation))
    assert kinds == {"spline", *PLANNERS}


# --- bends --------------------------------------------------------------------------


def test_bends_start_and_end_at_rest_and_are_smooth() -> None:
    bend = np.random.default_rng(1).normal(size=(POINTS, 3))
    s = np.linspace(0.0, 1.0, 4001)
    p = bend_at(np.broadcast_to(bend, (len(s), POINTS, 3)), s)
    h = s[1]
    speed, change = np.diff(p, axis=0) / h, np.diff(p, 2, axis=0) / h**2
    assert not p[[0, -1]].any()
    assert np.abs(speed[[0, -1]]).max() < 1e-3
    assert np.abs(change[[0, -1]]).max() < 0.05 * np.abs(change).max()
    # The acceleration is continuous: it changes by its slope times the step.
    assert np.abs(np.diff(change, axis=0)).max() < 1.5 * PIECES**3 * np.abs(np.diff(
        bend, 3, axis=0)).max() * h + 1e-4 * np.abs(change).max()  # fmt: skip


def test_fitted_bends_converge_to_fourth_order() -> None:
    """Errors in the middle of the swing, away from its ends."""

    def error(waves: float) -> float:
        values = np.sin(waves * KNOTS)[:, None] * np.ones(3)
        s = np.linspace(0.3, 0.7, 101)
        p = bend_at(np.broadcast_to(fit_bend(values), (len(s), POINTS, 3)), s)
        return float(np.abs(p - np.sin(waves * s)[:, None]).max())

    assert error(3.0) < 1e-4
    assert error(6.0) / error(3.0) == pytest.approx(16.0, rel=0.3)


# --- work -----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Planned:
    """A planned swing and the plain swing it replaces."""

    trial: SwingTrial
    height: float
    bend: Array
    plain: float

    @property
    def both(self) -> Array:
        """(rows, 2, 3) positions of the foot, planned and plain [m]."""
        tips = self.trial.tips
        return np.stack([tips(self.height, self.bend), tips(self.plain, 0 * self.bend)], axis=1)


Record = Callable[[Scene], list[Planned]]


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> Record:
    """Return a function that simulates scenes and keeps all planned swings."""

    def run(scene: Scene) -> list[Planned]:
        found = list[Planned]()

        def recording(kind: str) -> swing_planner.Planner:
            def planner(
                trial: SwingTrial, ground: Ground, foot_radius: float, least: float
            ) -> tuple[float, Array]:
                height, bend = PLANNERS[kind](trial, ground, foot_radius, least)
                plain = clearance_height(ground, trial.start, trial.end, foot_radius, least)
                found.append(Planned(trial, height, bend, plain))
                return height, bend

            return planner

        planners = {kind: recording(kind) for kind in PLANNERS}
        monkeypatch.setattr(swing_planner, "PLANNERS", planners)
        simulation = Simulation(scene)
        while not simulation.finished:
            simulation.step()
        monkeypatch.undo()
        return found

    return run


TEMPO = "gait: trot, cycle: 1.05, speed: 0.95"


LARGER = {"cat": 2.0, "dog": 1.5, "frog": 1.7, "lizard": 1.4, "mouse": 4.0}
"""Scales of figures whose legs are too short for this tempo."""

HARDLY_LIFTED = ("centipede", "crab", "frog", "lizard", "scorpion")
"""Figures whose sprawled legs swing low: least effort has little to save."""


def walking(figure: str, swing: str) -> str:
    scale = LARGER.get(figure, 1.0)
    return f"{{figure: {figure}, scale: {scale}, walk: {{swing: {swing}, {TEMPO}}}}}"


@pytest.mark.sample(1)
@pytest.mark.slow
def test_least_effort_needs_less_work_than_the_spline(
    shipped: Figure, scene_of: Callable[..., Scene], record: Record
) -> None:
    if not shipped.skeleton.legs:
        return
    swings = record(scene_of(walking(shipped.name, "least-effort"), duration=1.0))
    assert swings
    works = np.array([one.trial.works(one.both)[0] for one in swings])
    assert (works[:, 0] <= works[:, 1] * (1 + 1e-12)).all()
    least, plain = works.sum(axis=0)
    assert least < (0.96 if shipped.name in HARDLY_LIFTED else 0.85) * plain


UPRIGHT = ("horse", "person", "ostrich", "kangaroo")


@pytest.mark.sample(1)
@pytest.mark.slow
def test_free_leg_needs_less_work_than_a_led_one(
    shipped: Figure, scene_of: Callable[..., Scene], record: Record
) -> None:
    """The free leg saves work while it falls; catching up afterwards takes more."""
    if not shipped.skeleton.legs:
        return
    swings = record(scene_of(walking(shipped.name, "passive"), duration=0.5))
    free = [one for one in swings if one.bend.any()]
    works = np.zeros((1, 2))
    for one in free:
        last = simulate_fall(one.trial, one.plain)[1]
        assert last >= 1
        power = one.trial.powers(one.both)[0][: last + 1]
        assert power[:, 0].sum() < power[:, 1].sum()
        works = np.concatenate([works, power.sum(axis=0)[None]])
    if shipped.name in UPRIGHT:
        assert len(free) == len(swings)
        by_itself, led = works.sum(axis=0)
        assert by_itself < 0.55 * led


def test_no_torque_about_the_hip_of_a_free_leg(
    scene_of: Callable[..., Scene], record: Record
) -> None:
    """The force on the foot that replaces the muscles points along the leg."""
    for one in record(scene_of(walking("ostrich", "passive"), duration=0.5)):
        trial, last = one.trial, simulate_fall(one.trial, one.plain)[1]
        assert last > ROWS // 3
        motion, _ = trial.motion(one.both)
        torques = trial.load(motion).torques
        model = trial.model
        shares = []
        for row in range(6, last - 3):
            pushes = []
            for k in (0, 1):
                pose = model.batch.pose(motion.q[row, k][None])
                J = trial.R_WB[row + 1] @ pose.jacobian[0].T
                f = np.linalg.lstsq(J.T, torques[row, k], rcond=1e-9)[0]
                hip = trial.p_WB[row + 1] + trial.R_WB[row + 1] @ model.batch.places[0, 0]
                leg = one.both[row + 1, k] - hip
                ahead = (trial.end - trial.start) * [1.0, 0.0, 1.0]
                across = ahead - (ahead @ leg) / (leg @ leg) * leg
                pushes.append(abs(float(f @ across) / np.linalg.norm(across)))
            shares.append(pushes)
        free, led = np.mean(shares, axis=0)
        assert free < 0.2 * led


# --- walks ----------------------------------------------------------------

CASTS = [(figure, swing) for figure in ("horse", "person") for swing in ("passive", "least-effort")]


@pytest.fixture(scope="module", params=CASTS, ids=" ".join)
def level_feet_walks(
    request: pytest.FixtureRequest,
    scene_of: Callable[..., Scene],
    walk_through: Callable[[Scene], Walk],
) -> Walk:
    """Return walks of mammals over hills."""
    return walk_through(scene_of(walking(*request.param), terrain=HILLS, duration=2.5, seed=2))


@pytest.mark.sample(2)
@pytest.mark.slow
def test_feet_stand_still_on_their_footholds(level_feet_walks: Walk) -> None:
    down = level_feet_walks.standing[1:] & level_feet_walks.standing[:-1]
    moved = np.linalg.norm(np.diff(level_feet_walks.tips, axis=0), axis=-1)
    assert moved[down].max() < 1e-4
    ends = np.array(level_feet_walks.ends)[level_feet_walks.standing]
    assert np.abs(level_feet_walks.tips[level_feet_walks.standing] - ends).max() < 1e-4
    assert not level_feet_walks.take.notes


def test_touchdowns_are_at_foot_down_phases(level_feet_walks: Walk) -> None:
    herd = level_feet_walks.walkers.herd
    names = [f"{herd.names[0]}.{leg}" for leg in herd.leg_names]
    assert len(level_feet_walks.take.contacts) > 3
    for contact in level_feet_walks.take.contacts:
        leg = names.index(contact.part)
        before, after = (float(level_feet_walks.phases[contact.step + k][0]) for k in (0, 1))
        off = before + contact.fraction * (after - before) - herd.down[leg]
        assert abs(off - round(off)) < 1e-9


def test_soles_stay_above_the_ground(level_feet_walks: Walk) -> None:
    ground, herd = level_feet_walks.simulation.world.ground, level_feet_walks.walkers.herd
    x, y, z = np.moveaxis(level_feet_walks.tips, -1, 0)
    assert (y - ground.height(x, z) - herd.foot_radius / ground.normal(x, z)[..., 1]).min() > -1e-3


def test_joint_limits_hold_and_knees_do_not_flip(level_feet_walks: Walk) -> None:
    legs, q = level_feet_walks.walkers.herd.legs, level_feet_walks.q
    assert (q >= legs.lower).all()
    assert (q <= legs.upper).all()
    skeleton = level_feet_walks.walkers.herd.figures[0].skeleton
    for i, leg in enumerate(skeleton.legs):
        # Ankles, the last joints of legs with feet, bend both ways.
        for k, joint in enumerate(leg.joints[:-1]):
            if skeleton.joint_names[joint].endswith("_bend"):
                bends = q[:, i, k] - legs.extended[i, k]
                assert bends.min() * bends.max() >= 0.0


def test_joints_do_not_jump(level_feet_walks: Walk) -> None:
    dt = level_feet_walks.simulation.world.clock.dt
    assert np.abs(np.diff(level_feet_walks.q, axis=0)).max() < 20.0 * dt
    assert np.abs(np.diff(level_feet_walks.q, 2, axis=0)).max() < 550.0 * dt**2


@pytest.mark.nightly
def test_plain_swings_do_not_depend_on_planned_ones(
    scene_of: Callable[..., Scene], walk_through: Callable[[Scene], Walk]
) -> None:
    plain = "{name: a, figure: beetle, walk: {}}"
    least = "{name: b, figure: beetle, at: [0, 8], walk: {swing: least-effort}}"
    alone = [walk_through(scene_of(one, duration=0.5)) for one in (plain, least)]
    both = walk_through(scene_of(plain, least, duration=0.5))
    apart = np.concatenate([one.take.positions for one in alone], axis=1)
    assert np.array_equal(both.take.positions, apart)
    assert both.take.contacts == tuple(
        sorted(
            (c for one in alone for c in one.take.contacts),
            key=lambda c: (c.step, c.fraction, c.part),
        )
    )
