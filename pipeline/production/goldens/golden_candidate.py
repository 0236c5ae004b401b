"""Golden candidate: the present results of a scene, to be compared with its golden or recorded."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from audio.midi_file import midi_bytes, read_note_list
from audio.score import Score
from audio.tempo_plan import tempo_plan
from audio.wav_file import write_wav
from pipeline.production.goldens.cue_facts import Cues, cues_of
from pipeline.production.goldens.film_facts import FilmFacts, facts_of_film
from pipeline.production.goldens.golden_card import Framing
from pipeline.production.goldens.look_facts import look_of
from pipeline.production.goldens.slate import slate
from pipeline.production.reports.stills import spread
from pipeline.production.run.interrupts import held_back
from pipeline.production.run.scene_run import translated_errors
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.simulate import simulate
from pipeline.simulation.take import Take
from pipeline.spec import Scene
from render.film_codecs import CODECS
from render.film_encoder import write_film
from render.film_segments import Picture
from render.renderer import Renderer
from render.shot import Shot

WIDTH = 256
"""Default width of a golden's frames [pixels]."""

_SEED_STEP = 104_729
"""Between the seeds of pictures that differ by noise alone."""


def framing_of(scene: Scene) -> Framing:
    """Return the frames of a scene's golden."""
    width, height = scene.film.resolved().size
    # Both sides even, and no side shorter than a tile.
    size = scene.golden.size or (WIDTH, max(2 * round(WIDTH * height / width / 2), 16))
    numbers = scene.golden.frames or spread(scene.n_frames, 3)
    return Framing(numbers=tuple(sorted(set(numbers))), size=size, samples=scene.golden.samples)


def golden_scene(scene: Scene, framing: Framing) -> Scene:
    """Return the scene with the film settings of its golden's frames, without denoiser."""
    settings = {
        "size": framing.size,
        "samples": framing.samples,
        "soft_light": "full",
        "denoise": "off",
        "format": "png",
    }
    return scene.model_copy(update={"film": scene.film.model_copy(update=settings)})


class Candidate:
    """The present results of a scene, each made when first needed.

    Args:
        scene: as its author wrote it.
        take: of the scene, if there is one already.
    """

    def __init__(self, scene: Scene, take: Take | None = None) -> None:
        self.scene = scene
        self._take = take

    @cached_property
    def take(self) -> Take:
        """The take."""
        return self._take or simulate(self.scene)

    @cached_property
    def score(self) -> Score:
        """The score."""
        return build_score(self._shooting.scene, self.take, self._shooting.poses)[0]

    @cached_property
    def _shooting(self) -> ShotBuilder:
        return ShotBuilder(self.scene, self.take)

    @cached_property
    def cues(self) -> Cues:
        """Settings, parts, camera poses and notes of the score."""
        with translated_errors():
            notes = read_note_list(midi_bytes(self.score))
            ticks = str(tempo_plan(self.score).grid.ticks_per_frame)
        shooting = self._shooting
        look = look_of(shooting.film, shooting.light, shooting.materials)
        return cues_of(shooting.poses, ticks, notes, self.take, look)

    @cached_property
    def film(self) -> FilmFacts:
        """Facts of the film, with slates instead of rendered frames."""
        with translated_errors(), tempfile.TemporaryDirectory(prefix="pronk-") as folder:
            wav = Path(folder, "sound.wav")
            self.write_sound(wav)
            path = Path(folder, f"film{self.scene.film.resolved().suffix}")
            self.write_film(path, wav)
            return facts_of_film(path, wav)

    def write_film(self, path: Path, sound: Path) -> None:
        """Write the film of slates with its sound."""
        codec = self.scene.film.resolved().codec
        write_film(path, self._slates(CODECS[codec].bits), self.scene.rate, sound, codec=codec)

    def write_sound(self, path: Path) -> None:
        """Write the sound of the film."""
        write_wav(self.score, path)

    def frame_order(self) -> Sequence[int]:
        """Return the frames of the film in the order in which they are shown."""
        return range(1, self.scene.n_frames + 1)

    def _slates(self, bits: int) -> Iterator[Picture]:
        for number in self.frame_order():
            picture = slate(number)
            # 257 = 65535 / 255, so that white stays white.
            yield picture.astype(np.uint16) * 257 if bits == 16 else picture

    def frames(
        self, framing: Framing, renderer: Renderer, seed: int = 0
    ) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        """Render the frames of a golden and yield each.

        Args:
            framing: numbers, size and samples.
            renderer: of the frames.
            seed: 0 for the golden's noise, another number for other noise.

        Raises:
            FilmingError: a frame cannot be rendered.
        """
        for number, shot in self.shots(framing):
            with translated_errors(), held_back():
                other = replace(shot, seed=shot.seed + _SEED_STEP * seed)
                yield number, renderer.render(other).srgb8

    def shots(self, framing: Framing) -> Iterator[tuple[int, Shot]]:
        """Yield the numbers and shots of a golden's frames."""
        shooting = ShotBuilder(golden_scene(self.scene, framing), self.take)
        for number in framing.numbers:
            yield number, shooting.shot(number)
