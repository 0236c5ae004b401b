"""Motion of bodies, heads and free limbs: gaze, follow-through, motion style."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import Mock, patch

import numpy as np
import pytest

from pipeline.errors import SceneError
from pipeline.simulation import scheduler
from pipeline.simulation import simulate as simulation
from pipeline.simulation.figures.network import FEELER
from pipeline.simulation.locomotion.body_motion.free_limb_motion import LimbClearance
from pipeline.simulation.locomotion.body_motion.gaze import BodyMotion
from pipeline.simulation.locomotion.body_motion.limb_avoidance import LimbAvoidance
from pipeline.simulation.locomotion.gaits.moods import MoodSchedule, MotionStyle
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.scheduler import BatchLimits
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, matrix, turn
from tests.simulation.conftest import SHIPPED, scene_of

ROW = 1.0 / 96.0

LIBRARY = [name for name in SHIPPED if name not in ("inchworm", "robot_arm")]

MAX_JOINT_ACCELERATION = 250.0
"""Greatest acceleration of a free joint [rad/s²]: that of ears in a bound."""


class Recording:
    """A finished simulation of one creature in a fixed motion style.

    Args:
        member: config of the creature.
        style: changes of its motion style.
    """

    def __init__(
        self,
        member: str,
        terrain: str = "flat",
        duration: float = 3,
        more: str = "",
        **style: float,
    ) -> None:
        fixed = list[MotionStyle]()

        def fixed_style(schedule: MoodSchedule, _time: float) -> MotionStyle:
            if not fixed:
                count = len(schedule.effects)
                changed = {key: np.full(count, value) for key, value in style.items()}
                fixed.append(replace(MotionStyle.neutral(count), **changed))
            return fixed[0]

        with patch.object(MoodSchedule, "style", fixed_style):
            self.simulation = Simulation(
                scene_of(member, terrain=terrain, duration=duration, more=more)
            )
            while not self.simulation.finished:
                self.simulation.step()
        troupe = self.simulation.troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        self.walkers = troupe
        self.recorder = self.simulation.recorder
        self.names = [node.name for node in self.simulation.take().nodes]

    @property
    def q(self) -> Array:
        """(K, M) values of the free joints [rad]."""
        count = len(self.walkers.pose_solver.free_limbs.joints.names)
        return self.recorder.values[:, self.recorder.values.shape[1] - count :]

    def joint(self, name: str) -> Array:
        """(K,) values of a free joint [rad]."""
        names = self.walkers.pose_solver.free_limbs.joints.names
        return self.q[:, [own.partition(".")[2] for own in names].index(name)]

    @property
    def pitch(self) -> Array:
        """(K,) of the body [degrees]."""
        return np.degrees(np.arcsin(self.recorder.rotations[:, 0, 1, 0]))

    @property
    def look(self) -> tuple[Array, Array]:
        """Eyes (K, 3) [m] and gaze directions (K, 3), by the poses of the nodes alone."""
        skeleton = self.walkers.herd.figures[0].skeleton
        limb = next(limb for limb in skeleton.limbs if limb.kind == "head")
        link = skeleton.links[limb.links[-1]]
        node = self.names.index(f"{self.walkers.herd.names[0]}.{link.name}")
        R, p = self.recorder.rotations[:, node], self.recorder.positions[:, node]
        # The gaze is along +X in the preferred pose.
        ahead = self.walkers.pose_solver.free_limbs.necks.rest[0].T @ [1.0, 0.0, 0.0]
        return p + turn(R, limb.tip - link.ends[0]), turn(R, np.tile(ahead, (len(R), 1)))


def angle(a: Array, b: Array) -> Array:
    """Return the angles between vectors (n, 3) [degrees]."""
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1.0, 1.0)))


# --- carriage ----------------------------------------------------------


@pytest.mark.nightly
def test_a_creature_looks_aside_while_it_stands() -> None:
    recording = Recording("{figure: dog}", duration=0.1)
    for joint in ("head.base_yaw", "tail.base_yaw"):
        assert abs(recording.joint(joint).mean()) > 0.1
    joints = recording.walkers.pose_solver.free_limbs.joints
    part = np.array([[0.0], [0.5], [1.0]])
    motion = Mock(spec=BodyMotion, speed_fraction=part, style=Mock(wander=np.ones((3, 1))))
    carriage = joints.standing(motion)
    np.testing.assert_allclose(carriage, (1.0 - part) * carriage[0])
    assert np.abs(carriage[0]).max() > 0.1
    motion.style.wander[:] = 0.0
    assert not joints.standing(motion).any()


# --- gaze --------------------------------------------------------------

PLACES = [(6, 1, 2), (6, 1, -4), (8, 0, -6), (8, 0.5, 0)]


@pytest.mark.nightly
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "name", ["antelope", "beetle", "camel", "centipede", "horse", "kangaroo", "ostrich", "person"]
)
def test_gaze_meets_an_ordered_place(name: str, place: tuple[float, float, float]) -> None:
    recording = Recording(f"{{figure: {name}, look_at: {list(place)}}}", duration=1, wander=0.0)
    eyes, look = recording.look
    assert angle(look, place - eyes).max() < 1.0


def test_gaze_follows_a_passed_place() -> None:
    recording = Recording("{figure: horse, look_at: [14, 1, 6], walk: {speed: 1}}", wander=0.0)
    eyes, look = recording.look
    assert angle(look, np.array([14, 1, 6]) - eyes).max() < 1.0


def test_gaze_changes_target_without_a_jolt() -> None:
    other = "\n- {figure: beetle, name: bug, at: [6, 3], walk: {}}"
    script = "script:\n- {at: 1, who: horse, do: {look_at: bug}}\n"
    script += "- {at: 3, who: horse, do: {look: ahead}}"
    recording = Recording("{figure: horse, walk: {gait: walk}}" + other, duration=5, more=script)
    joints = recording.walkers.pose_solver.free_limbs.joints
    yaw = np.degrees(recording.q[:, joints.names.index("horse.head.base_yaw")])
    assert np.abs(yaw[:96]).max() < 5.0
    assert yaw[288] < -15.0  # to the right
    assert np.abs(yaw[-48:]).max() < 5.0
    assert np.abs(np.diff(yaw, 2)).max() < np.degrees(60.0) * ROW**2


@pytest.mark.parametrize("angle_deg", [150, -150])
def test_head_turns_before_the_body(angle_deg: int) -> None:
    script = "script:\n- {at: 0.5, who: beetle, do: stop}\n"
    script += f"- {{at: 3, who: beetle, do: {{turn_deg: {angle_deg}}}}}"
    recording = Recording("{figure: beetle, walk: {}}", duration=5, more=script, wander=0.0)
    R = recording.recorder.rotations[:, 0]
    turned = np.unwrap(np.arctan2(-R[:, 2, 0], R[:, 0, 0])) * np.sign(angle_deg)
    yaw = recording.joint("head.base_yaw") * np.sign(angle_deg)
    assert np.abs(yaw[: 3 * 96]).max() < 0.01
    third = int(np.argmax(turned > 0.3 * turned.max()))
    assert yaw[third] > 0.12
    assert np.argmax(yaw > 0.1) < np.argmax(turned > 0.2)


def test_head_turns_into_a_curve() -> None:
    member = "{figure: person, walk: {path: [[2, 0], [2, 2]]}}"
    ahead, not_ahead = (
        Recording(member, wander=0.0, head_turn=t).joint("head.base_yaw") for t in (1, 0)
    )
    assert ahead.min() < -0.4
    assert np.abs(not_ahead).max() < 0.1


@pytest.mark.nightly
def test_head_stays_level_on_a_pitching_body() -> None:
    hills = "{kind: hills, height: 1.4, spacing: 4}"
    recording = Recording("{figure: camel, scale: 0.4, walk: {}}", hills, duration=4, wander=0.0)
    _, look = recording.look
    assert np.abs(recording.pitch).max() > 8.0
    assert np.degrees(np.abs(np.arcsin(look[:, 1]))).max() < 2.5


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("{figure: scorpion, look_at: [1, 1, 1]}", "has no head"),
        ("{figure: horse, look_at: bee}", "nobody in the cast"),
        ("{figure: horse, name: h, look_at: h}", "cannot do that to itself"),
        ("{figure: horse, look_at: [1, 1]}", "look_at"),
        ("{figure: inchworm, walk: {}, look_at: [1, 1, 1]}", "looks nowhere"),
    ],
)
def test_impossible_look_targets_are_refused(member: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Simulation(scene_of(member, duration=1))


# --- follow-through ------------------------------------------------------------------


@pytest.mark.sample(3)
@pytest.mark.slow
@pytest.mark.parametrize("name", LIBRARY)
def test_free_joints_keep_their_limits_and_move_smoothly(name: str) -> None:
    recording = Recording(f"{{figure: {name}, walk: {{}}}}", duration=2)
    limits = recording.walkers.pose_solver.free_limbs.joints.limits
    assert (recording.q > limits.lower).all()
    assert (recording.q < limits.upper).all()
    assert (
        np.abs(np.diff(recording.q, 2, axis=0)).max(initial=0.0) < MAX_JOINT_ACCELERATION * ROW**2
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("looseness", [0.0, 2.0, 30.0])
def test_joint_limits_hold_at_any_looseness(looseness: float) -> None:
    recording = Recording(
        "{figure: horse, walk: {gait: bound}}", looseness=looseness, tail_raise=3.0
    )
    limits = recording.walkers.pose_solver.free_limbs.joints.limits
    assert (recording.q > limits.lower).all()
    assert (recording.q < limits.upper).all()


@pytest.mark.nightly
def test_creature_at_rest_has_only_idle_motion() -> None:
    for name in ("horse", "scorpion", "person"):
        still = Recording(f"{{figure: {name}}}", duration=1, wander=0.0)
        assert np.abs(still.q - still.q[0]).max() < 1e-12
        assert np.ptp(Recording(f"{{figure: {name}}}", duration=1).q, axis=0).max() > (
            0.01 if name != "scorpion" else 0.001
        )


@pytest.mark.nightly
def test_tail_lags_more_towards_its_tip() -> None:
    """Overlap: at the rhythm of a bound each joint lags behind the one before."""
    recording = Recording("{figure: horse, walk: {gait: bound}}", duration=6, wander=0.0, sway=0.0)
    cycle = recording.walkers.herd.cycle[0]
    times = ROW * np.arange(len(recording.q))
    whole = (times > 1.0) & (times <= 1.0 + np.floor(5.0 / cycle) * cycle)
    wave = np.exp(-2j * np.pi * times[whole] / cycle)
    names = ["tail.base_pitch", "tail.joint1_bend", "tail.joint2_bend"]
    turned = [recording.joint(name)[whole] for name in names]
    swings = [np.mean((q - q.mean()) * wave) for q in turned]
    lags = -np.unwrap(np.angle(swings))
    assert (np.diff(lags) > 0.04).all()
    assert (np.diff(np.abs(swings)) > 0.0).all()


@pytest.mark.nightly
def test_looseness_scales_the_swing_of_a_tail() -> None:
    member = "{figure: horse, walk: {gait: bound}}"
    stiff, usual, floppy = (
        np.ptp(Recording(member, sway=0.0, wander=0.0, looseness=loose).joint("tail.joint2_bend"))
        for loose in (0.0, 1.0, 2.0)
    )
    assert stiff < 1e-12
    assert floppy > 1.5 * usual > 0.1


def test_tail_swings_on_after_a_stop() -> None:
    script = "script:\n- {at: 1, who: kangaroo, do: stop}"
    recording = Recording(
        "{figure: kangaroo, walk: {gait: hop}}", duration=5, more=script, wander=0.0
    )
    body = recording.recorder.positions[:, 0]
    moving = np.linalg.norm(np.diff(body, axis=0), axis=-1) / ROW
    rest = int(np.flatnonzero(moving > 1e-3)[-1]) + 1
    tail = recording.joint("tail.joint2_bend")
    after = np.abs(tail - tail[-1])
    assert after[rest : rest + 20].max() > 5e-4
    assert after[-5:].max() < 0.2 * after[rest : rest + 20].max()


# --- bodies -----------------------------------------------------------------------


def test_body_pitches_down_when_braking() -> None:
    script = "script:\n- {at: 1, who: horse, do: stop}\n- {at: 4, who: horse, do: walk}"
    recording = Recording("{figure: horse, walk: {gait: trot}}", duration=6, more=script)
    assert -4.0 < recording.pitch[96:200].min() < -0.5
    assert 0.5 < recording.pitch[4 * 96 :].max() < 4.0
    assert np.abs(recording.pitch[370:384]).max() < 0.2


@pytest.mark.nightly
def test_pitched_body_keeps_its_feet_below_it() -> None:
    level, proud = (
        Recording("{figure: horse, walk: {speed: 1.1}}", duration=3, body_pitch=held)
        for held in (0.0, 0.15)
    )
    assert 7.0 < np.mean(proud.pitch - level.pitch) < 8.6
    ends = [
        recording.walkers.sequencer.feet.end - recording.recorder.positions[-1, 0]
        for recording in (level, proud)
    ]
    moved = np.abs(ends[1] - ends[0])[:, [0, 2]].max(axis=1)
    # Rotated with the body the feet would be 17 cm off; forelegs lose a little reach.
    assert moved[1::2].max() < 0.03
    assert moved[::2].max() < 0.1
    assert not [note for note in proud.simulation.take().notes if note.kind == "clamped"]


def test_style_pitch_is_bounded() -> None:
    recording = Recording("{figure: beetle, walk: {}}", duration=1, body_pitch=9.0)
    assert np.abs(recording.pitch).max() < 17.0


# --- motion style ----------------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name",
    [
        "horse",
        pytest.param("camel", marks=pytest.mark.nightly),
        pytest.param("kangaroo", marks=pytest.mark.nightly),
        "centipede",
        pytest.param("ostrich", marks=pytest.mark.nightly),
    ],
)
def test_head_raise_lifts_the_head(name: str) -> None:
    member = f"{{figure: {name}, walk: {{}}}}"
    low, usual, high = (
        Recording(member, duration=1, head_raise=raised).look for raised in (-0.3, 0.0, 0.3)
    )
    tall = usual[0][0, 1]
    for lower, higher in ((low, usual), (usual, high)):
        assert (higher[0][:, 1] - lower[0][:, 1]).mean() > 0.005 * tall


@pytest.mark.nightly
def test_head_raise_turns_an_upright_neck_up() -> None:
    low, high = (
        Recording("{figure: person}", duration=1, head_raise=r, wander=0.0).look for r in (0.0, 0.3)
    )
    assert np.degrees(np.arcsin(high[1][:, 1] - low[1][:, 1])).min() > 4.0


def test_tail_raise_lifts_the_tail() -> None:
    down, up = (Recording("{figure: horse}", duration=1, tail_raise=r) for r in (0.0, 0.4))
    raised = (up.joint("tail.base_pitch") - down.joint("tail.base_pitch")).mean()
    assert 0.35 < raised <= 0.4


def test_motion_styles_of_several_moments_stack() -> None:
    moments = [MotionStyle.neutral(3), MotionStyle.neutral(3)]
    moments[1] = replace(moments[1], sway=np.array([0.0, 2.0, 1.0]))
    stacked = MotionStyle.stacked(moments)
    np.testing.assert_array_equal(stacked.sway, [[1, 1, 1], [0, 2, 1]])
    assert MotionStyle.stacked([moments[0]] * 5).head_raise.shape == (5, 3)


# --- limb clearance -----------------------------------------------------------


RAMP = "{kind: ramp, size: [16, 3], cells: [320, 30], start: 1.0, slope_deg: 28, height: 0.8}"


def _lowest(part: str) -> float:
    """Return the least height of the end of a scorpion's limb above a ramp [m]."""
    recording = Recording(
        "{figure: scorpion, name: s, scale: 0.8, at: [0.2, 0], walk: {speed: 0.55}}", RAMP, 2.5
    )
    skeleton = recording.walkers.herd.figures[0].skeleton
    limb = next(limb for limb in skeleton.limbs if limb.name == part)
    link = skeleton.links[limb.links[-1]]
    node = recording.names.index(f"s.{link.name}")
    R, p = recording.recorder.rotations[:, node], recording.recorder.positions[:, node]
    tip = p + turn(R, limb.tip - link.ends[0])
    height = recording.walkers.world.ground.height(tip[:, 0], tip[:, 2])
    return float((tip[:, 1] - height).min()) - limb.tip_radius


def test_feelers_rise_over_ground_ahead_of_the_feet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert _lowest("feeler_r1") > 0.02
    monkeypatch.setattr(LimbClearance, "wishes", lambda self, rows, others: np.zeros_like(others))
    monkeypatch.setattr(LimbAvoidance, "apply", lambda self, times, q, *bodies: q)
    assert _lowest("feeler_r1") < -0.05


# --- rows -------------------------------------------------------------------------

CAST = (
    "{figure: horse, at: [0, -3], walk: {gait: transverse gallop}}",
    "{figure: beetle, at: [0, 3], look_at: horse, walk: {path: [[1, 3], [2, 5]]}}",
    "{figure: scorpion, scale: 0.5, at: [-3, 0], walk: {}}",
)


@pytest.mark.nightly
def test_rows_do_not_depend_on_batch_size(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = []
    for rows in (96, 1, 7):
        monkeypatch.setattr(scheduler, "BATCH_LIMITS", BatchLimits(rows, rows))
        take = simulation.simulate(scene_of(*CAST, duration=1.5))
        found.append((take.positions.tobytes(), take.rotations.tobytes(), take.values.tobytes()))
    assert found[1] == found[0]
    assert found[2] == found[0]


@pytest.mark.nightly
def test_frame_rate_does_not_change_the_motion() -> None:
    takes = [simulation.simulate(scene_of(*CAST, more=f"fps: {fps}")) for fps in (24, 48)]
    slow, quick = takes[0].values, takes[1].values[::2]
    idle = [
        i
        for i, channel in enumerate(takes[0].channels)
        if any(kind in channel.name for kind in (".head.", ".tail.", ".feeler"))
    ]
    assert len(idle) > 20
    off = np.degrees(np.abs(slow - quick)[:, idle])
    assert off.max() < 0.02 * np.degrees(np.ptp(slow[:, idle], axis=0).max())


def test_feelers_keep_out_of_boulders() -> None:
    """A scorpion's feeler would go 65 mm deep into a boulder."""
    scorpion = "{figure: scorpion, name: s, at: [-5, 0], heading_deg: 141, walk: {}}"
    simulation = Simulation(scene_of(scorpion, terrain="boulders", seed=4, duration=0.6))
    while not simulation.finished:
        simulation.step()
    take, troupe = simulation.take(), simulation.troupes[0]
    assert isinstance(troupe, WalkerTroupe)
    skeleton = troupe.herd.figures[0].skeleton
    names = [node.name for node in take.nodes]
    ground, deepest = simulation.world.ground, -1.0
    for link in (link for link in skeleton.links if link.kind == FEELER):
        node = names.index(f"s.{link.name}")
        R, p = matrix(take.rotations[:, node]), take.positions[:, node]
        for part in np.linspace(0.25, 1.0, 4):
            place = p + turn(R, part * (link.ends[1] - link.ends[0]))
            depth = ground.height(place[:, 0], place[:, 2]) - place[:, 1]
            deepest = max(deepest, float(depth.max()))
    corners = np.concatenate([link.ends for link in skeleton.links])
    assert deepest < 0.01 * np.linalg.norm(np.ptp(corners, axis=0))
