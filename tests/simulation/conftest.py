"""Scenes and figures of several tests, simulated or built once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.simulation.figures.figure import Figure, build_figure
from pipeline.simulation.figures.skeleton import BODY, Link, Skeleton
from pipeline.simulation.locomotion.herd import Herd
from pipeline.simulation.locomotion.walker_troupe import WalkerTroupe
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.spatial import Array, turn
from pipeline.simulation.take import Take
from pipeline.spec import Scene, find_scene, load_scene, read_scene

HEADER = "pronk: 1\nduration: {duration}\nseed: {seed}\nterrain: {terrain}\ncast:\n{cast}"


def scene_of(
    *cast: str, terrain: str = "flat", duration: float = 2, seed: int = 3, more: str = ""
) -> Scene:
    """Return a scene of cast members, each a YAML flow mapping."""
    rows = "".join(f"- {member}\n" for member in cast)
    text = HEADER.format(duration=duration, seed=seed, terrain=terrain, cast=rows)
    return read_scene(f"{text}{more}\n")


@dataclass
class Walk:
    """A simulation with the state of its feet at every step."""

    simulation: Simulation
    swinging: list[NDArray[np.bool_]] = field(default_factory=list)
    phases: list[Array] = field(default_factory=list)
    lifted: list[Array] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)

    @property
    def walkers(self) -> WalkerTroupe:
        """The creatures of the scene."""
        troupe = self.simulation.troupes[0]
        assert isinstance(troupe, WalkerTroupe)
        return troupe

    def record_step(self) -> None:
        """Record the state of this step."""
        walkers = self.walkers
        self.swinging.append(walkers.sequencer.feet.swinging.copy())
        self.phases.append(walkers.phase.copy())
        self.lifted.append(walkers.sequencer.feet.lift_phase.copy())
        self.ends.append(walkers.sequencer.feet.end.copy())

    @cached_property
    def take(self) -> Take:
        """The take of the simulation."""
        return self.simulation.take()

    @cached_property
    def q(self) -> Array:
        """(K, L, n) joint values of the legs, padded as their batch is [rad]."""
        herd, values = self.walkers.herd, self.simulation.recorder.values
        first, is_joint = 2 * len(herd.names), herd.legs.is_joint
        q = np.zeros((len(values), *is_joint.shape))
        q[:, is_joint] = values[:, first : first + int(is_joint.sum())]
        return q

    @cached_property
    def tips(self) -> Array:
        """(K, L, 3) tips of the legs, by the poses of the last links alone [m]."""
        return tips_of(self.simulation, self.walkers.herd)

    @cached_property
    def standing(self) -> NDArray[np.bool_]:
        """(K, L) which feet are down."""
        return ~np.array(self.swinging)


def tips_of(simulation: Simulation, herd: Herd) -> Array:
    """Return the tips (K, L, 3) of legs, by the poses of their last links alone [m]."""
    recorder, found, first = simulation.recorder, [], 0
    for figure in herd.figures:
        for leg in figure.skeleton.legs:
            node = first + leg.links[-1]
            ends = figure.skeleton.links[leg.links[-1]].ends
            R, p = recorder.rotations[:, node], recorder.positions[:, node]
            found.append(p + turn(R, ends[1] - ends[0]))
        first += len(figure.skeleton.links)
    return np.stack(found, axis=1)


def walk_through(scene: Scene) -> Walk:
    """Simulate `scene`, which has a row at every step, and record every step."""
    assert scene.steps == scene.rows_per_frame
    walk = Walk(Simulation(scene))
    walk.record_step()
    while not walk.simulation.finished:
        walk.simulation.step()
        walk.record_step()
    return walk


BEETLE = "{{figure: beetle, scale: {scale}, heading_deg: {heading}, at: {at}, walk: {walk}}}"

WRITTEN = (
    "{gait: {up: {l1: 0, l2: 0.3, l3: 0.6, r1: 0.5, r2: 0.8, r3: 0.1},"
    " down: {l1: 0.25, l2: 0.6, l3: 0.9, r1: 0.8, r2: 0, r3: 0.4}}, cycle: 1.1, stride: 0.3}"
)

WALKS = {
    "first steps": "",
    "flat, quick": BEETLE.format(scale=1, heading=30, at=[0, 0], walk="{speed: 1.2, cycle: 0.6}"),
    "hills, tripod": BEETLE.format(scale=0.5, heading=200, at=[1, 2], walk="{gait: tripod}"),
    "hills, wave": BEETLE.format(scale=0.8, heading=-75, at=[0, 1], walk="{gait: wave}"),
    "rough, tripod": BEETLE.format(scale=0.5, heading=0, at=[0, 0], walk="{gait: tripod}"),
    "rough, slow wave": BEETLE.format(
        scale=0.5, heading=200, at=[3, 1], walk="{gait: wave, speed: 0.3}"
    ),
    "rough, written out": BEETLE.format(scale=0.5, heading=90, at=[2, -2], walk=WRITTEN),
    "rough, passive": BEETLE.format(
        scale=0.5, heading=0, at=[0, 0], walk="{speed: 0.4, swing: passive}"
    ),
    "rough, least effort": BEETLE.format(
        scale=0.5, heading=200, at=[3, 1], walk="{swing: least-effort}"
    ),
    "rough, halts": BEETLE.format(
        scale=0.5, heading=70, at=[0, 0], walk="{speed: 0.74, cycle: 0.6}"
    ),
}

TERRAINS = {
    "flat": "flat",
    "hills": "{kind: hills, height: 1.4, spacing: 4}",
    "rough": "{kind: fractal, height: 2, roughness: 0.55, size: [20, 20]}",
}


def scene_named(name: str) -> Scene:
    """Return one of the scenes of `WALKS`."""
    if name == "first steps":
        return load_scene(find_scene("first_steps"))
    terrain = TERRAINS[name.split(",")[0]]
    return scene_of(WALKS[name], terrain=terrain, duration=4, seed=1)


@pytest.fixture(name="scene_of", scope="session")
def _scene_of() -> Callable[..., Scene]:
    """Return `scene_of`."""
    return scene_of


@pytest.fixture(name="walk_through", scope="session")
def _walk_through() -> Callable[[Scene], Walk]:
    """Return `walk_through`."""
    return walk_through


@pytest.fixture(scope="session", params=list(WALKS))
def walk(request: pytest.FixtureRequest) -> Walk:
    """Return each walk of `WALKS` in turn."""
    return walk_through(scene_named(request.param))


@pytest.fixture(scope="session")
def first_steps() -> Walk:
    """Return the walk of the shipped scene `first_steps`."""
    return walk_through(scene_named("first steps"))


@pytest.fixture(scope="session")
def figure() -> Callable[..., Figure]:
    """Return a function that builds a figure from its YAML flow mapping."""

    def build(config: str, scale: float = 1.0) -> Figure:
        scene = read_scene(
            f"pronk: 1\nduration: 1\nfigures: {{thing: {config}}}\ncast: [{{figure: thing}}]\n"
        )
        return build_figure("thing", scene.figures["thing"], scale)

    return build


@pytest.fixture(scope="session")
def beetle() -> Figure:
    """Return the shipped beetle at its drawn size."""
    scene = read_scene("pronk: 1\nduration: 1\ncast: [{figure: beetle}]\n")
    return build_figure("beetle", scene.figures["beetle"], 1.0)


def random_skeleton(rng: np.random.Generator, joints: int) -> Skeleton:
    """Return a random tree of hinges and slides, each with one link."""
    parents = np.array([int(rng.integers(-1, j)) for j in range(joints)], dtype=np.int64)
    axes = rng.normal(size=(joints, 3))
    # Some axes are coordinate axes, so that parallel and crossing axes occur.
    square = rng.random(joints) < 0.4
    axes[square] = np.eye(3)[rng.integers(0, 3, int(square.sum()))]
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    places = rng.uniform(-1, 1, (joints, 3))
    for j in np.flatnonzero(rng.random(joints) < 0.3):
        if parents[j] != BODY:
            places[j] = places[parents[j]]  # two joints of a ball
    ends = np.stack([places, places + rng.uniform(-1, 1, (joints, 3))], axis=1)
    body = Link("body", "body", BODY, np.zeros((2, 3)), (0.1, 0.1), "", False)
    links = [
        Link(f"link{j}", "leg", j, ends[j], (0.1, 0.1), "", j not in parents) for j in range(joints)
    ]
    return Skeleton(
        joint_names=tuple(f"joint{j}" for j in range(joints)),
        parents=parents,
        axes=axes,
        places=places,
        prismatic=rng.random(joints) < 0.3,
        lower=np.full(joints, -1.5),
        upper=np.full(joints, 1.5),
        preferred=np.full(joints, 0.2),
        extended=np.zeros(joints),
        links=(body, *links),
        limbs=(),
    )


@pytest.fixture(name="random_skeleton", scope="session")
def _random_skeleton() -> Callable[[np.random.Generator, int], Skeleton]:
    """Return `random_skeleton`."""
    return random_skeleton


SHIPPED = sorted(
    path.stem for path in (Path(__file__).parents[2] / "scenes/figures").glob("*.yaml")
)


def _library(name: str) -> Figure:
    scene = read_scene(f"pronk: 1\nduration: 1\ncast: [{{figure: {name}}}]\n")
    return build_figure(name, scene.figures[name], 1.0)


@pytest.fixture(scope="session")
def library() -> Callable[[str], Figure]:
    """Return a function that builds a shipped figure by name."""
    return _library


@pytest.fixture(scope="session", params=SHIPPED)
def shipped(request: pytest.FixtureRequest) -> Figure:
    """Return each shipped figure in turn."""
    return _library(request.param)
