"""Scene sequence: several scenes as one film, cut or faded into each other.

A file whose top has `sequence:` in place of a cast. Its clips are stretches of scenes; each scene
is simulated and rendered on its own, and the sequence joins their frames and their sound.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from pipeline.errors import Problem, SceneError, UsageError
from pipeline.foreign_files.confinement import Confinement
from pipeline.foreign_files.safe_file import ForeignFileError
from pipeline.spec.model_base import ConfigModel, Fault, Number, raise_faults
from pipeline.spec.scene import Scene
from pipeline.spec.scene_library import (
    SCENES,
    SEQUENCE,
    existing_file,
    is_path,
    missing_file_message,
    scenes_in,
    shipped_file,
    shipped_scenes,
)
from pipeline.spec.scene_loader import confinement_beside, load_scene, refuse_newer
from pipeline.spec.suggestions import hint
from pipeline.spec.timing import frames_of
from pipeline.spec.validation import check, in_order
from pipeline.spec.yaml_reader import read_file
from pipeline.spec.yaml_tree import SourceMap
from render.config import Film
from render.config.titles import MAX_TITLES, Title

MAX_CLIPS = 200

Transition = Annotated[Number, Field(ge=0, le=30)]


class Clip(ConfigModel):
    """A stretch of a scene in a sequence."""

    scene: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        description="File of the scene, from the folder of the sequence, or name of a shipped one."
    )
    start: Annotated[Number, Field(ge=0, le=1e6)] = Field(
        0.0, description="Where it begins in the scene [s]."
    )
    end: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="Where it ends in the scene [s]; at its end if left out."
    )
    dissolve: Transition = Field(
        0.0, description="How long the clip before goes over into this one [s]; 0 is a cut."
    )
    fade_in: Transition = Field(0.0, description="How long it comes up from black [s].")
    fade_out: Transition = Field(0.0, description="How long it goes down to black [s].")
    set: Annotated[tuple[str, ...], Field(max_length=100)] = Field(
        (), description="Changes of the scene, PATH=VALUE each, as --set takes them."
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.end is not None and self.end <= self.start:
            raise_faults([Fault(("end",), f"must be after start, {self.start:g} s")])
        return self


def _clip(value: Any) -> Any:
    return {"scene": value} if isinstance(value, str) else value


class SequenceFile(ConfigModel):
    """Several scenes as one film."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    title: str = Field("", max_length=200, description="Title of the film.")
    film: Film = Field(
        Film(), description="Size and quality of the frames of all scenes, where it gives them."
    )
    titles: Annotated[tuple[Title, ...], Field(max_length=MAX_TITLES)] = Field(
        (), description="Words over the whole film, at its own times."
    )
    sequence: Annotated[
        tuple[Annotated[Clip, BeforeValidator(_clip)], ...],
        Field(min_length=1, max_length=MAX_CLIPS),
    ] = Field(description="The clips in their order: names or files of scenes, or their stretches.")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        raise_faults(self._faults())
        return self

    def _faults(self) -> Iterator[Fault]:
        if self.sequence[0].dissolve:
            yield Fault(("sequence", 0, "dissolve"), "no clip is before the first; try fade_in")
        for k, (before, clip) in enumerate(pairwise(self.sequence), start=1):
            if clip.dissolve and clip.fade_in:
                yield Fault(("sequence", k, "fade_in"), "comes from black or dissolves, not both")
            if clip.dissolve and before.fade_out:
                message = "goes to black, and the next clip dissolves from it; leave out one"
                yield Fault(("sequence", k - 1, "fade_out"), message)


@dataclass(frozen=True, slots=True)
class LoadedClip:
    """A clip with its scene.

    Attributes:
        name: of its folder and files.
        scene: that it is a stretch of.
        first: its first frame in the scene, from 1.
        last: its last.
        rise: frames of its transition at the beginning.
        fall: frames of its transition at the end.
        at: frames of the film before it.
    """

    name: str
    scene: Scene
    first: int
    last: int
    rise: int
    fall: int
    at: int

    @property
    def frames(self) -> int:
        """Number of its frames."""
        return self.last - self.first + 1


@dataclass(frozen=True, slots=True)
class SceneSequence:
    """A sequence with all its scenes.

    Attributes:
        name: of the sequence and of its files.
        title: of the film.
        titles: over the whole film.
        clips: in their order.
        source_map: locations of its values.
    """

    name: str
    title: str
    titles: tuple[Title, ...]
    clips: tuple[LoadedClip, ...]
    source_map: SourceMap

    @property
    def rate(self) -> Fraction:
        """Frames a second, of all its scenes."""
        return self.clips[0].scene.rate

    @property
    def n_frames(self) -> int:
        """Number of frames of the film."""
        return self.clips[-1].at + self.clips[-1].frames


def is_sequence(path: Path, untrusted: bool = False) -> bool:
    """Return whether a file holds a sequence of scenes.

    Raises:
        SceneError: an untrusted one is a link that leads elsewhere, or no regular file.
    """
    if untrusted:
        confinement_beside(path)
    tree, _ = read_file(path)
    return tree is not None and SEQUENCE in tree.entries


def load_sequence(
    path: Path, before: Sequence[str] = (), after: Sequence[str] = (), untrusted: bool = False
) -> SceneSequence:
    """Load a sequence with all its scenes.

    Args:
        path: of its file.
        before: `path=value` each, laid over every scene before what the sequence says.
        after: the same, last.
        untrusted: whether to refuse what lies outside of its folder, but for shipped scenes.

    Raises:
        SceneError: it or one of its scenes is wrong; holds every problem found.
    """
    confinement = confinement_beside(path) if untrusted else None
    tree, problems = read_file(path)
    if tree is None:
        raise SceneError(in_order(problems, [str(path)]))
    refuse_newer(tree)
    file, invalid = check(SequenceFile, tree)
    if file is None or problems:
        raise SceneError(in_order([*problems, *invalid], [str(path)]))
    source_map = SourceMap(tree)
    given = file.film.model_dump(mode="json", include=file.film.model_fields_set)
    film = [f"film.{key}={json.dumps(value)}" for key, value in given.items()]
    scenes = list[Scene]()
    for k, clip in enumerate(file.sequence):
        try:
            found = _found(clip.scene, path.parent, confinement)
            scenes.append(load_scene(found, [*before, *film, *clip.set, *after], untrusted))
        except UsageError as error:
            problems.append(Problem(f"sequence[{k}].scene", str(error)))
        except ForeignFileError as error:
            problems.append(Problem(f"sequence[{k}].scene", f"{clip.scene!r} {error}"))
        except SceneError as error:
            # Those of the scene's file say where; a change of the sequence's own does not.
            problems += [one if one.line else _of_clip(one, k) for one in error.problems]
    if not problems:
        problems = list(_mismatches(file, scenes))
    if problems:
        raise source_map.with_locations(SceneError(problems))
    return SceneSequence(
        path.stem, file.title, file.titles, tuple(_placed(file, scenes)), source_map
    )


def _found(text: str, folder: Path, confinement: Confinement | None) -> Path:
    """Return the file of a clip's scene: beside the sequence, else a shipped one.

    Raises:
        UsageError: there is none.
        ForeignFileError: it leads out of the confinement.
    """
    found = existing_file(folder, text, confinement) or shipped_file(text)
    if found is not None:
        return found
    if is_path(text):
        raise UsageError(missing_file_message(folder, text))
    beside = {} if confinement is not None else scenes_in(folder)
    raise UsageError(f"no scene is called {text!r}, {hint(text, shipped_scenes(), SCENES, beside)}")


def _of_clip(problem: Problem, k: int) -> Problem:
    return Problem(f"sequence[{k}]", f"{problem.file}: {problem.path}: {problem.message}")


def _mismatches(file: SequenceFile, scenes: Sequence[Scene]) -> Iterator[Problem]:
    """Yield why scenes cannot be joined, or clips are not in them."""
    first = scenes[0]
    for k, (clip, scene) in enumerate(zip(file.sequence, scenes, strict=True)):
        if scene.rate != first.rate:
            message = (
                f"has {scene.rate} frames a second and the first scene {first.rate}; "
                f"'set: [fps={first.fps}]' changes it"
            )
            yield Problem(f"sequence[{k}].scene", message)
        own, other = scene.film.resolved(), first.film.resolved()
        for key in ("size", "codec", "format", "suffix"):
            if getattr(own, key) != getattr(other, key):
                said = f"has {key} {getattr(own, key)} and the first scene {getattr(other, key)}"
                said += f"; give film: {{{key}: ...}} to the sequence" * (key != "suffix")
                yield Problem(f"sequence[{k}].scene", said)
                break
        length = float(scene.n_frames / scene.rate)
        if clip.start >= length:
            yield Problem(f"sequence[{k}].start", f"the scene ends at {length:g} s")
        elif clip.end is not None and frames_of(clip.end, scene.rate) > scene.n_frames:
            yield Problem(f"sequence[{k}].end", f"the scene ends at {length:g} s")
        else:
            yield from _too_long(file, scene, k)


def _too_long(file: SequenceFile, scene: Scene, k: int) -> Iterator[Problem]:
    first, last = _stretch(file.sequence[k], scene)
    rise, fall = _transitions(file, k, scene.rate)
    if rise + fall > last - first + 1:
        seconds = float((last - first + 1) / scene.rate)
        yield Problem(f"sequence[{k}]", f"lasts {seconds:g} s, less than its transitions together")


def _stretch(clip: Clip, scene: Scene) -> tuple[int, int]:
    """Return the first and the last frame of a clip in its scene, from 1."""
    first = min(round(Fraction(repr(clip.start)) * scene.rate), scene.n_frames - 1) + 1
    last = scene.n_frames if clip.end is None else frames_of(clip.end, scene.rate)
    return first, max(last, first)


def _transitions(file: SequenceFile, k: int, rate: Fraction) -> tuple[int, int]:
    """Return the frames of the transitions of a clip, at its beginning and its end."""
    clip = file.sequence[k]
    after = file.sequence[k + 1].dissolve if k + 1 < len(file.sequence) else 0.0
    seconds = (clip.dissolve or clip.fade_in, after or clip.fade_out)
    rise, fall = (round(Fraction(repr(float(time))) * rate) for time in seconds)
    return rise, fall


def _placed(file: SequenceFile, scenes: Sequence[Scene]) -> Iterator[LoadedClip]:
    at = 0
    for k, (clip, scene) in enumerate(zip(file.sequence, scenes, strict=True)):
        first, last = _stretch(clip, scene)
        rise, fall = _transitions(file, k, scene.rate)
        at -= rise if clip.dissolve else 0
        name = f"{k + 1:02d}_{Path(clip.scene).stem}"
        yield LoadedClip(name, scene, first, last, rise, fall, at)
        at += last - first + 1
