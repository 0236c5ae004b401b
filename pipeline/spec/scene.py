"""Scene: everything an author asks for, typed and validated. No arrays, no files."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, field_validator, model_validator

from pipeline.spec.cast import Member
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dance import Dance
from pipeline.spec.dancer import Dancer, faults_of_beats, with_score_times
from pipeline.spec.figure import Figure
from pipeline.spec.model_base import (
    ConfigModel,
    Fault,
    Integer,
    Name,
    Point,
    Position,
    Positive,
    fault_error,
    raise_faults,
)
from pipeline.spec.mood import MOODS, Mood
from pipeline.spec.name_references import faults_of_references
from pipeline.spec.partial_scene import Path, located_instructions, member_names
from pipeline.spec.relations import with_behaviours
from pipeline.spec.script import Instruction
from pipeline.spec.sound_thresholds import SceneSound
from pipeline.spec.story import Story
from pipeline.spec.terrain import Terrain
from pipeline.spec.terrain.kinds import FlatTerrain
from pipeline.spec.timing import (
    DEFAULT_ROWS_PER_FRAME,
    DEFAULT_STEPS,
    MAX_FRAMES,
    Rate,
    faults_of_timing,
    frames_of,
    rate_of,
)
from pipeline.spec.yaml_tree import SourceMap, SourceNode
from render.config import MATERIALS, Camera, Cuts, Film, Light, Material
from render.config.film import Even
from render.config.titles import MAX_TITLES, Title

MAX_GOLDEN_FRAMES = 24
"""Frames of one golden, which is kept in version control."""


class Golden(ConfigModel):
    """Frames that a golden check renders: few, small, with a fixed number of rays."""

    frames: (
        Annotated[
            tuple[Annotated[Integer, Field(ge=1)], ...],
            Field(min_length=1, max_length=MAX_GOLDEN_FRAMES),
        ]
        | None
    ) = Field(
        None, description="Frames to compare; the first, the middle and the last if left out."
    )
    size: tuple[Even, Even] | None = Field(
        None, description="Width and height [pixels], even; 256 wide if left out."
    )
    samples: Annotated[Integer, Field(ge=1, le=65536)] = Field(
        64,
        description="Rays through each pixel: more rays leave less noise to hide differences in.",
    )


def faults_of_golden(golden: Golden, given: dict[str, Any], last: int | None) -> list[Fault]:
    """Find frames that the scene does not have.

    Args:
        golden: the frames to render.
        given: values that the author wrote; defaults are not checked.
        last: last frame of the scene, None if unknown.
    """
    if "golden" not in given or golden.frames is None or last is None:
        return []
    return [
        Fault(("golden", "frames", i), f"the scene has frames 1-{last}, no {frame}")
        for i, frame in enumerate(golden.frames)
        if frame > last
    ]


VERSION = 1
"""The version of the language that this pronk reads."""

MAX_INSTRUCTIONS = 10_000
"""Instructions of one script."""


def _named(cast: tuple[Member, ...]) -> tuple[Member, ...]:
    pairs = zip(cast, member_names(cast), strict=True)
    return tuple(member.model_copy(update={"name": name}) for member, name in pairs)


class Scene(ConfigModel):
    """A scene: its cast, length, camera and sound."""

    pronk: Literal[1] = Field(description="Version of the scene language.")
    title: str = Field("", max_length=200, description="Title of the film.")
    fps: Rate = Field(24, description="Frames a second: 24, 25, 60 or '30000/1001'.")
    duration: Annotated[Positive, Field(le=MAX_FRAMES)] | None = Field(
        None, description="How long the film lasts [s]; give this or frames."
    )
    frames: Annotated[Integer, Field(gt=0, le=MAX_FRAMES)] | None = Field(
        None, description="How many frames the film has; give this or duration."
    )
    seed: Annotated[Integer, Field(ge=0, lt=2**63)] = Field(
        1, description="Seed of all random numbers of the scene."
    )
    rows_per_frame: Annotated[Integer, Field(ge=1, le=64)] = Field(
        DEFAULT_ROWS_PER_FRAME, description="Rows of the motion that are kept per frame."
    )
    steps: Annotated[Integer, Field(ge=1, le=1024)] = Field(
        DEFAULT_STEPS, description="Steps of the world per frame; a multiple of rows_per_frame."
    )
    terrain: Terrain = Field(FlatTerrain(), description="The ground.")
    figures: dict[Name, Figure] = Field({}, description="Drawings of figures, by name.")
    dances: dict[Name, Dance] = Field({}, description="Dances, by name.")
    cast: Annotated[tuple[Member, ...], Field(min_length=1), AfterValidator(_named)] = Field(
        description="The performers of the scene."
    )
    moods: dict[Name, Mood] = Field(
        {}, description="The author's own moods, which come before those of the library."
    )
    places: dict[Name, Point | Position] = Field(
        {}, description="Places by name, [x, z] on the ground or [x, y, z] [m]."
    )
    script: Annotated[tuple[Instruction, ...], Field(max_length=MAX_INSTRUCTIONS)] = Field(
        (), description="Orders to performers, and when they are given."
    )
    story: Story | None = Field(
        None, description="Relations, goals and beats, of which the scene makes a story by itself."
    )
    materials: dict[Name, Material] = Field({}, description="The author's own materials, by name.")
    camera: Cuts = Field((Camera(),), description="One camera, or a list of cuts.")
    light: Light = Field(Light(), description="Lights of the scene.")
    film: Film = Field(Film(), description="Size and quality of the frames.")
    titles: Annotated[tuple[Title, ...], Field(max_length=MAX_TITLES)] = Field(
        (), description="Words over the picture: titles, captions and end credits."
    )
    sound: SceneSound = Field(SceneSound(), description="Sound of the scene.")
    golden: Golden = Field(Golden(), description="Frames of the regression test.")
    _source_map: SourceMap = PrivateAttr(default_factory=SourceMap)

    @field_validator("pronk", mode="before")
    @classmethod
    def _version(cls, version: Any) -> Any:
        if isinstance(version, bool) or not isinstance(version, int):
            raise fault_error(f"should be the number of the version, {VERSION}")
        if version != VERSION:
            raise fault_error(f"this pronk reads version {VERSION} of the language, not {version}")
        return version

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        given = {key: getattr(self, key) for key in self.model_fields_set}
        timing = faults_of_timing(given)
        last = None if timing else self.n_frames
        golden = faults_of_golden(self.golden, given, last)
        beats = faults_of_beats(self.cast, self.sound, self.instructions)
        raise_faults([*timing, *faults_of_references(self), *beats, *golden])
        return self

    @property
    def source_map(self) -> SourceMap:
        """Locations of its values in its file."""
        return self._source_map

    def with_source(self, tree: SourceNode) -> Self:
        """Return this scene, made of a tree, with the locations of its values."""
        self._source_map = SourceMap(tree)
        return self

    @property
    def instructions(self) -> list[tuple[Path, Instruction]]:
        """Instructions of its script and of the beats of its story, with their paths."""
        return list(located_instructions(self))

    @property
    def characters(self) -> list[Character]:
        """Its characters, with what relations and goals of the story make them do."""
        story = self.story or Story()
        return [
            with_behaviours(member, story.behaviours_of(member.name))
            for member in self.cast
            if isinstance(member, Character)
        ]

    @property
    def creatures(self) -> list[tuple[int, Creature]]:
        """Its creatures, with their indices in the cast."""
        return [(i, member) for i, member in enumerate(self.cast) if isinstance(member, Creature)]

    @property
    def dancers(self) -> list[tuple[int, Dancer]]:
        """Its dancers, with their indices in the cast; their times are those of the score."""
        return [
            (i, with_score_times(member, self.sound))
            for i, member in enumerate(self.cast)
            if isinstance(member, Dancer)
        ]

    @property
    def all_moods(self) -> dict[str, Mood]:
        """Moods that it may name."""
        return {name: Mood.model_validate(name) for name in MOODS} | self.moods

    def material(self, name: str) -> Material:
        """Return a material by its name: the author's own, else that of the library."""
        return self.materials[name] if name in self.materials else MATERIALS[name]

    @property
    def rate(self) -> Fraction:
        """Frames a second."""
        return rate_of(self.fps)

    @property
    def n_frames(self) -> int:
        """Number of frames: the fewest that last as long as the duration."""
        if self.frames is not None:
            return self.frames
        assert self.duration is not None
        return frames_of(self.duration, self.rate)
