"""Scene: all that an author asks for, typed and validated. No arrays, no files."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, field_validator, model_validator

from pipeline.spec.cast import Creature, Dancer, Member, called, names_of
from pipeline.spec.dance import Dance
from pipeline.spec.detect import SceneSound
from pipeline.spec.faults import fault, refuse
from pipeline.spec.figure import Figure
from pipeline.spec.golden import Golden, faults_of_golden
from pipeline.spec.in_time import faults_of_beats, in_time
from pipeline.spec.mood import MOODS, Mood
from pipeline.spec.places import Places
from pipeline.spec.rate import Rate, rate_of
from pipeline.spec.references import faults_of_references
from pipeline.spec.script import Instruction
from pipeline.spec.terrain import FlatTerrain, Terrain
from pipeline.spec.timing import (
    DEFAULT_SAMPLES,
    DEFAULT_STEPS,
    MOST_FRAMES,
    faults_of_timing,
    frames_of,
)
from pipeline.spec.tree import Tree
from pipeline.spec.values import Name, Number, Whole, Words
from render.config import Camera, Cuts, Film, Light, Material

VERSION = 1
"""The version of the language that this pronk reads."""

MOST_INSTRUCTIONS = 10_000
"""Of a script."""


def _named(cast: tuple[Member, ...]) -> tuple[Member, ...]:
    names = names_of([called(member) for member in cast])
    pairs = zip(cast, names, strict=True)
    return tuple(member.model_copy(update={"name": name}) for member, name in pairs)


class Scene(Words):
    """A scene: what is in it, how long it lasts, how it is filmed and heard."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    title: str = Field("", max_length=200, description="Title of the film.")
    fps: Rate = Field(24, description="Frames a second: 24, 25, 60 or '30000/1001'.")
    duration: Annotated[Number, Field(gt=0, le=MOST_FRAMES)] | None = Field(
        None, description="How long the film lasts [s]; give this or frames."
    )
    frames: Annotated[Whole, Field(gt=0, le=MOST_FRAMES)] | None = Field(
        None, description="How many frames the film has; give this or duration."
    )
    seed: Annotated[Whole, Field(ge=0, lt=2**63)] = Field(
        1, description="Where all random numbers of the scene come from."
    )
    samples: Annotated[Whole, Field(ge=1, le=64)] = Field(
        DEFAULT_SAMPLES, description="Samples of the motion that are kept a frame."
    )
    steps: Annotated[Whole, Field(ge=1, le=1024)] = Field(
        DEFAULT_STEPS, description="Steps of the world a frame; a multiple of samples."
    )
    terrain: Terrain = Field(FlatTerrain(), description="The ground.")
    figures: dict[Name, Figure] = Field({}, description="Drawings of figures, by name.")
    dances: dict[Name, Dance] = Field({}, description="What dancers do, by name.")
    cast: Annotated[tuple[Member, ...], Field(min_length=1), AfterValidator(_named)] = Field(
        description="Who is in the scene."
    )
    moods: dict[Name, Mood] = Field(
        {}, description="The author's own moods, beside and before those of the library."
    )
    script: Annotated[tuple[Instruction, ...], Field(max_length=MOST_INSTRUCTIONS)] = Field(
        (), description="What performers are to do, and when."
    )
    materials: dict[Name, Material] = Field(
        {}, description="The author's own materials, usable wherever a material is named."
    )
    camera: Cuts = Field((Camera(),), description="One camera, or a list of cuts.")
    light: Light = Field(Light(), description="What lights the scene.")
    film: Film = Field(Film(), description="Size and quality of the frames.")
    sound: SceneSound = Field(SceneSound(), description="What the scene sounds like.")
    golden: Golden = Field(Golden(), description="What golden checks render.")
    _places: Places = PrivateAttr(default_factory=Places)

    @field_validator("pronk", mode="before")
    @classmethod
    def _version(cls, version: Any) -> Any:
        if isinstance(version, bool) or not isinstance(version, int):
            raise fault(f"should be the number of the version, {VERSION}")
        if version != VERSION:
            raise fault(f"this pronk reads version {VERSION} of the language, not {version}")
        return version

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        given = {word: getattr(self, word) for word in self.model_fields_set}
        timing = faults_of_timing(given)
        last = None if timing else self.n_frames
        golden = faults_of_golden(self.golden, given, last)
        beats = faults_of_beats(self.cast, self.sound, self.script)
        refuse([*timing, *faults_of_references(self), *beats, *golden])
        return self

    @property
    def places(self) -> Places:
        """Where its words stand."""
        return self._places

    def standing_in(self, tree: Tree) -> Self:
        """Return the scene, which was made of a tree, with the places of its words."""
        self._places = Places(tree)
        return self

    @property
    def creatures(self) -> list[tuple[int, Creature]]:
        """Its creatures, with their places in the cast."""
        return [(i, member) for i, member in enumerate(self.cast) if isinstance(member, Creature)]

    @property
    def dancers(self) -> list[tuple[int, Dancer]]:
        """Its dancers, with their places in the cast, in time with its score if they are to be."""
        return [
            (i, in_time(member, self.sound))
            for i, member in enumerate(self.cast)
            if isinstance(member, Dancer)
        ]

    @property
    def all_moods(self) -> dict[str, Mood]:
        """The moods that may be named in it."""
        return {name: Mood.model_validate(name) for name in MOODS} | self.moods

    @property
    def rate(self) -> Fraction:
        """Frames a second."""
        return rate_of(self.fps)

    @property
    def n_frames(self) -> int:
        """Number of frames: the least that last as long as the duration."""
        if self.frames is not None:
            return self.frames
        assert self.duration is not None
        return frames_of(self.duration, self.rate)
