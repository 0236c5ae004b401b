"""Changes that a golden check detects, and changes that it ignores.

More than a hundred named ones of each: a twentieth runs in the full tier, the whole at night. And
two hundred drawn at random of each, at night.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.production.goldens.golden_candidate import Candidate, golden_scene
from pipeline.production.goldens.golden_card import Framing
from pipeline.production.goldens.golden_case import GoldenRenderer
from pipeline.production.goldens.golden_check import check
from pipeline.production.goldens.judges import judge_frames
from pipeline.production.goldens.verdict import Outcome
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.outputs import Outputs
from pipeline.production.run.progress import Reporter
from pipeline.production.run.workers import FrameJob, film_in_processes
from pipeline.simulation.take_store import write_take
from render.backend import choose, libraries
from render.image_files import read_png
from render.renderer import Renderer
from render.shot import Shot
from tests.production.goldens import harmless_films, harmless_takes
from tests.production.goldens.golden_bases import FRAME, LIGHTS, Base, Bases, record_base, text_of
from tests.production.goldens.golden_faults import Fault
from tests.production.goldens.harmless_films import Harmless
from tests.production.goldens.picture_faults import CAMERA, LIGHT, MATERIALS
from tests.production.goldens.scene_faults import CAST, TIMING, WORDS
from tests.production.goldens.sound_faults import SOUND, shifted

ROOT = Path(__file__).parents[3]
COUNT = 200
FRAMES = 12

FAULTS = (*SOUND, *LIGHT, *CAMERA, *MATERIALS, *TIMING, *CAST, *WORDS)
HARMLESS = (
    *harmless_films.WORDS,
    *harmless_takes.TAKE,
    *harmless_films.SOUND,
    *harmless_films.CUES,
    *harmless_films.PICTURES,
)


@pytest.fixture(scope="module")
def bases(tmp_path_factory: pytest.TempPathFactory) -> Bases:
    """Return two scenes with their goldens."""
    return Bases(tmp_path_factory.mktemp("goldens"))


# --- named changes ----------------------------------------------------------------


class Elsewhere(GoldenRenderer):
    """A renderer that says to be of another environment."""

    def __init__(self, renderer: GoldenRenderer, environment: str) -> None:
        self._renderer, self._environment = renderer, environment

    @property
    def loaded(self) -> Renderer:
        """The renderer."""
        return self._renderer.loaded

    @property
    def environment(self) -> str:
        """The environment that it says."""
        return self._environment


@pytest.mark.nightly
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_is_found_and_named(bases: Bases, fault: Fault) -> None:
    base = bases[fault.base]
    verdict = check(base.case, base.renderer, Reporter(), (fault.layer,), fault.make(base))
    assert verdict.outcome is Outcome.CHANGED, str(verdict)
    assert fault.says in str(verdict)


@pytest.mark.nightly
@pytest.mark.parametrize("change", HARMLESS, ids=lambda change: change.name)
def test_a_harmless_change_passes(bases: Bases, change: Harmless) -> None:
    base = bases[change.base]
    where = change.environment
    renderer = Elsewhere(base.renderer, where) if where else base.renderer
    verdict = check(base.case, renderer, Reporter(), change.layers, change.make(base))
    assert verdict.passed, str(verdict)


def test_there_are_a_hundred_of_each() -> None:
    for named in (FAULTS, HARMLESS):
        assert len({one.name for one in named}) == len(named) >= 100


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


def sound_shifted(base: Base, k: int, draw: np.random.Generator) -> Candidate:
    return base.altered(sound=shifted(FRAME if k % 2 == 0 else -FRAME))


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


@pytest.mark.nightly
@pytest.mark.parametrize("k", range(COUNT))
def test_changes_of_a_film_are_detected(bases: Bases, k: int) -> None:
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
def test_another_llvm_changes_no_bit(bases: Bases, tmp_path: Path) -> None:
    for library in libraries()[1:]:
        frames = rendered_by("llvm_ad_rgb", library, text_of(LIGHTS[0]), tmp_path)
        if frames is not None:
            assert check_frames(bases[0], frames, "another") is Outcome.IDENTICAL
            return
    pytest.skip("there is no second LLVM that works on this machine")


NOISE = (other_seed,) * 12 + (elsewhere,) * 4 + (other_threads,) * 3 + (other_jobs,)


@pytest.mark.nightly
@pytest.mark.parametrize("k", range(COUNT))
def test_changes_that_keep_the_film_pass(bases: Bases, k: int, tmp_path: Path) -> None:
    # Likewise mixed in every tenth of the list.
    NOISE[k % len(NOISE)](bases[k // len(NOISE) % 2], k, tmp_path)
