"""Two hundred changes that a golden check detects, and two hundred that it ignores.

A tenth of each list runs in the full tier, the whole at night.
"""

from __future__ import annotations

import os
import subprocess
import sys
import wave
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.goldens.golden_candidate import Candidate, golden_scene
from pipeline.production.goldens.golden_card import Framing, read_card
from pipeline.production.goldens.golden_case import Case, GoldenFolder, GoldenRenderer
from pipeline.production.goldens.golden_check import check
from pipeline.production.goldens.golden_content import Content, read_content
from pipeline.production.goldens.golden_record import record
from pipeline.production.goldens.judges import judge_frames
from pipeline.production.goldens.verdict import Outcome
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.production.run.workers import FrameJob, film_in_processes
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.simulation.take_store import write_take
from pipeline.spec import Scene, read_scene
from render.backend import choose, libraries
from render.image_files import read_png
from render.shot import Shot

ROOT = Path(__file__).parents[3]
COUNT, TENTH = 200, 20
FRAMES = 12

SCENE = """\
pronk: 1
fps: 24
frames: 12
seed: 3
terrain: {kind: flat, size: [8, 8], cells: [8, 8], material: ground}
cast:
  - name: bug
    figure: beetle
    scale: 0.6
    walk: {gait: tripod, cycle: 0.25, speed: 0.6}
materials:
  ground: {preset: dry soil}
camera: {at: [0.9, 0.5, 0.9], look_at: [0.1, 0.12, 0]}
light: LIGHT
film: {size: [640, 360], depth: 3}
golden: {frames: [8], size: [96, 54], samples: 64}
"""

LIGHTS = (
    "{studio: {fill: 0.3, rim: 0.5}}",
    "{sun: {hour: 16.5, day: 172, latitude_deg: 48}}",
)


@dataclass(frozen=True)
class Base:
    """A scene with its take and its golden."""

    case: Case
    take: Take
    renderer: GoldenRenderer

    @property
    def scene(self) -> Scene:
        """The scene as it was recorded."""
        return self.case.scene

    @property
    def golden(self) -> Content:
        """Its golden as it stands in its folder."""
        return read_content(self.case.golden, read_card(self.case.golden.card))

    def changed(self, word: str, other: str) -> Candidate:
        """Return the candidate of the scene with other settings; its motion must be the same."""
        text = text_of(LIGHTS[int(self.case.name[-1])])
        assert word in text
        return Candidate(read_scene(text.replace(word, other)), self.take)


def text_of(light: str) -> str:
    return SCENE.replace("LIGHT", light)


@pytest.fixture(scope="module")
def bases(tmp_path_factory: pytest.TempPathFactory) -> list[Base]:
    """Return two scenes with their goldens."""
    folder = tmp_path_factory.mktemp("goldens")
    renderer = GoldenRenderer("llvm")
    return [
        record_base(f"bug{k}", text_of(light), folder, renderer) for k, light in enumerate(LIGHTS)
    ]


def record_base(name: str, text: str, folder: Path, renderer: GoldenRenderer) -> Base:
    """Record the golden of a scene."""
    scene = read_scene(text)
    case = Case(name, scene, GoldenFolder(folder / name), folder / "out", "bug")
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("CI", raising=False)
        record(case, renderer, Reporter(), seeds=4)
    (folder / "out" / "golden").mkdir(parents=True, exist_ok=True)
    return Base(case, simulate(scene), renderer)


# --- detected changes -------------------------------------------------------------


def without_a_link(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    parts = base.take.parts
    gone = int(draw.integers(len(parts)))
    return Candidate(base.scene, replace(base.take, parts=parts[:gone] + parts[gone + 1 :]))


def foot_moved(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    """Move the last node of a leg by 2 cm, in all rows or in one of a golden's frames."""
    names = [node.name for node in base.take.nodes]
    feet = [name for name in names if name.startswith(("bug.l", "bug.r")) and name.endswith(".3")]
    node = names.index(feet[int(draw.integers(len(feet)))])
    way = draw.normal(size=3)
    positions = base.take.positions.copy()
    rows = slice(None) if k % 2 else slice(28, 29)
    positions[rows, node] += 0.02 * way / np.linalg.norm(way)
    return Candidate(base.scene, replace(base.take, positions=positions))


def other_material(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    if k % 2:
        presets = ("sand", "grass", "snow", "wood", "blue plastic", "clay", "steel")
        other = presets[int(draw.integers(len(presets)))]
        return base.changed("{preset: dry soil}", f"{{preset: {other}}}")
    parts = list(base.take.parts)
    n = int(draw.integers(len(parts)))
    parts[n] = replace(parts[n], material="bone" if parts[n].material != "bone" else "steel")
    return Candidate(base.scene, replace(base.take, parts=tuple(parts)))


def light_off(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    if base.case.name == "bug1":
        # A cloud before the sun, or the sun nearly set.
        return base.changed("hour: 16.5", ("hour: 16.5, clouds: 1.0", "hour: 19")[k % 2])
    return base.changed(*((("fill: 0.3", "fill: 0.0"), ("rim: 0.5", "rim: 0.0"))[k % 2]))


class Shifted(Candidate):
    """Shows the frame after one of the golden's, or films a frame twice."""

    def __init__(self, base: Base, k: int) -> None:
        super().__init__(base.scene, base.take)
        self.k = k

    def shots(self, framing: Framing) -> Iterator[tuple[int, Shot]]:
        """Give one frame the shot of the next, if `k` is even."""
        chosen = framing.numbers[self.k // 2 % len(framing.numbers)]
        numbers = [n + (n == chosen and self.k % 2 == 0) for n in framing.numbers]
        shifted = super().shots(framing.model_copy(update={"numbers": tuple(numbers)}))
        yield from zip(framing.numbers, (shot for _, shot in shifted), strict=True)

    def frame_order(self) -> Sequence[int]:
        """Show a frame twice, if `k` is odd."""
        frames = list(super().frame_order())
        if self.k % 2:
            at = self.k % (FRAMES - 1)
            frames[at + 1] = frames[at]
        return frames


def frame_shifted(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    return Shifted(base, k)


def footfall_dropped(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    steps = [n for n, event in enumerate(base.take.events) if event.cause == "footfall"]
    gone = steps[int(draw.integers(len(steps)))]
    events = base.take.events
    return Candidate(base.scene, replace(base.take, events=events[:gone] + events[gone + 1 :]))


def camera_moved(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    place = np.array([0.9, 0.5, 0.9])
    way = draw.normal(size=3)
    place += 0.01 * way / np.linalg.norm(way)
    return base.changed("at: [0.9, 0.5, 0.9]", f"at: {place.tolist()}")


class Late(Candidate):
    """Sounds a frame late, or early."""

    def __init__(self, base: Base, late: bool) -> None:
        super().__init__(base.scene, base.take)
        self.late = late

    def write_sound(self, path: Path) -> None:
        """Write it a frame late, or early."""
        super().write_sound(path)
        with wave.open(str(path)) as file:
            params, data = file.getparams(), file.readframes(file.getnframes())
        size = params.sampwidth * params.nchannels * 48_000 // 24
        data = bytes(size) + data[:-size] if self.late else data[size:] + bytes(size)
        with wave.open(str(path), "wb") as file:
            file.setparams(params)
            file.writeframes(data)


def sound_shifted(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    return Late(base, k % 2 == 0)


Mutation = Callable[[Base, int, np.random.Generator], Candidate]
MUTATIONS: tuple[tuple[Mutation, tuple[str, ...]], ...] = (
    (without_a_link, ("motion",)),
    (foot_moved, ("motion",)),
    (other_material, ()),
    (light_off, ("frames",)),
    (frame_shifted, ()),
    (footfall_dropped, ("motion",)),
    (camera_moved, ("motion",)),
    (sound_shifted, ("film",)),
)
"""Changes of a scene, and the layers that must detect each."""


def _case_numbers(count: int) -> list[object]:
    """Return case numbers: the first tenth in the full tier, the rest nightly."""
    return [
        pytest.param(k, marks=pytest.mark.slow if k < TENTH else pytest.mark.nightly)
        for k in range(count)
    ]


@pytest.mark.parametrize("k", _case_numbers(COUNT))
def test_changes_of_a_film_are_detected(bases: list[Base], k: int) -> None:
    mutate, layers = MUTATIONS[k % len(MUTATIONS)]
    turn = k // len(MUTATIONS)
    base = bases[turn % 2]
    verdict = check(
        base.case,
        base.renderer,
        Reporter(),
        candidate=mutate(base, turn // 2, np.random.default_rng(k)),
    )
    changed = {layer.layer for layer in verdict.layers if layer.outcome is Outcome.CHANGED}
    assert changed, str(verdict)
    assert changed >= set(layers), str(verdict)


# --- ignored changes --------------------------------------------------------------


def check_frames(
    base: Base, frames: dict[int, NDArray[np.uint8]], environment: str = ""
) -> Outcome:
    verdict = judge_frames(base.golden, frames, environment or base.renderer.environment)
    return verdict.outcome


def other_seed(base: Base, k: int, folder: Path) -> None:
    """Make another noise at the samples that the golden was calibrated with."""
    framing = base.golden.framing
    assert framing is not None
    frames = dict(Candidate(base.scene, base.take).frames(framing, base.renderer.loaded, 100 + k))
    assert check_frames(base, frames) is Outcome.WITHIN


def elsewhere(base: Base, k: int, folder: Path) -> None:
    """Change the noise, and name another environment."""
    framing = base.golden.framing
    assert framing is not None
    frames = dict(Candidate(base.scene, base.take).frames(framing, base.renderer.loaded, 1000 + k))
    assert check_frames(base, frames, "another") is Outcome.WITHIN


def other_threads(base: Base, k: int, folder: Path) -> None:
    """Render one frame with one thread, which another one rendered with two."""
    framing = Framing(numbers=(k % FRAMES + 1,), size=(96, 54), samples=4)
    candidate = Candidate(base.scene, base.take)
    one, two = (
        dict(candidate.frames(framing, GoldenRenderer("llvm", threads).loaded))
        for threads in (1, 2)
    )
    assert all(np.array_equal(one[n], two[n]) for n in framing.numbers)


def other_jobs(base: Base, k: int, folder: Path) -> None:
    """Render the golden's frames in two processes, as `pronk render --jobs 2` does."""
    golden = base.golden
    assert golden.framing is not None
    scene = golden_scene(base.scene, golden.framing)
    outputs = Outputs(folder, "bug")
    outputs.frames.mkdir(parents=True)
    write_take(base.take, outputs.take)
    keys = {number: "key" for number in golden.frames}
    job = FrameJob(scene, outputs.take, outputs, choose("llvm"), keys)
    film_in_processes(job, 2, FileRecords(outputs.folder, {}), lambda done, pace: None)
    frames = {number: read_png(outputs.frame(number)) for number in golden.frames}
    assert check_frames(base, frames) is Outcome.IDENTICAL


SOMEWHERE_ELSE = """
import sys
import numpy as np
from pipeline.production.goldens.golden_card import Framing
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.spec import read_scene
from render.backend import Backend
from render.renderer import Renderer

text, variant, library, place = sys.argv[1:]
framing = Framing(numbers=(8,), size=(96, 54), samples=64)
renderer = Renderer(Backend(variant, library, "0", "asked for"))
np.savez(place, **{str(n): p for n, p in Candidate(read_scene(text)).frames(framing, renderer)})
"""


def rendered_by(variant: str, library: str, text: str, folder: Path) -> dict[int, Any] | None:
    """Return the golden's frames as another backend renders them, None if that is not here."""
    place = folder / "frames.npz"
    command = [sys.executable, "-c", SOMEWHERE_ELSE, text, variant, library, str(place)]
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    if done.returncode:
        # Anything else is a mistake of the script above.
        assert b"ImportError" not in done.stderr, done.stderr.decode()
        return None
    with np.load(place) as frames:
        return {int(number): frames[number] for number in frames}


@pytest.mark.nightly
def test_another_variant_passes_by_the_variances(tmp_path: Path) -> None:
    """On plain ground in a studio: of patterns and far ground scalar keeps the mean colours."""
    text = text_of(LIGHTS[0]).replace("{preset: dry soil}", "{preset: red rubber}")
    base = record_base("plain", text, tmp_path, GoldenRenderer("llvm"))
    frames = rendered_by("scalar_rgb", "", text, tmp_path)
    assert frames is not None
    assert not np.array_equal(frames[8], base.golden.frames[8])
    assert check_frames(base, frames, "scalar_rgb") is Outcome.WITHIN


@pytest.mark.nightly
def test_another_llvm_changes_no_bit(bases: list[Base], tmp_path: Path) -> None:
    for library in libraries()[1:]:
        frames = rendered_by("llvm_ad_rgb", library, text_of(LIGHTS[0]), tmp_path)
        if frames is not None:
            assert check_frames(bases[0], frames, "another") is Outcome.IDENTICAL
            return
    pytest.skip("there is no second LLVM that works on this machine")


HARMLESS = (other_seed,) * 12 + (elsewhere,) * 4 + (other_threads,) * 3 + (other_jobs,)


@pytest.mark.parametrize("k", _case_numbers(COUNT))
def test_changes_that_keep_the_film_pass(bases: list[Base], k: int, tmp_path: Path) -> None:
    # Likewise mixed in every tenth of the list.
    HARMLESS[k % len(HARMLESS)](bases[k // len(HARMLESS) % 2], k, tmp_path)
