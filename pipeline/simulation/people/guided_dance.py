"""Guided dance: what moves trunk and arms of a person that dances, for rooms of standing people.

The room of the dancers makes it; the rooms of characters and walkers carry it on bodies of their
own. None imports another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from pipeline.simulation.people.proportions import JOINTS, SEGMENT_MASSES, Proportions
from pipeline.simulation.people.wardrobe import Clothes
from pipeline.simulation.refusals import Refusals
from pipeline.simulation.spatial import Array
from pipeline.simulation.take import Contact
from pipeline.spec.script import Instruction, Perform

GUIDED_JOINTS = JOINTS[JOINTS.index("spine") : JOINTS.index("hand_r") + 1]
"""The joints of trunk and arms, without the pelvis, in the order of `JOINTS`."""

GUIDED_FRAMES = tuple(
    f"{link}_{side}" for link in ("upper_arm", "forearm", "hand") for side in "lr"
)
"""The frames of arms and hands, in the order of `FRAMES`."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyStrike:
    """A hand of a person strikes its own body or the other hand.

    Attributes:
        fraction: of the step at which it does, 0 to 1.
        hand: such as "hand_r".
        other: solid that is struck, such as "ribs".
        place: (3,) from the pelvis, X ahead and Z to the right [m].
        normal: (3,) outward normal of `other`, likewise.
        speed: approach speed [m/s].
    """

    fraction: float
    hand: str
    other: str
    place: Array
    normal: Array
    speed: float


@dataclass(frozen=True, slots=True, eq=False)
class GuidedPose:
    """Where trunk and arms are, in the frame of the pelvis: X ahead, Y up, Z to the right.

    Attributes:
        joints: (9, 3) `GUIDED_JOINTS`, from the pelvis [m].
        arms: (6, 3, 3) rotations of `GUIDED_FRAMES`.
        ahead: (3,) direction in which the head faces.
    """

    joints: Array
    arms: Array
    ahead: Array


class GuidedDance(Protocol):
    """A dance that is danced once, from arms that hang until they hang again.

    Attributes:
        is_over: whether its bars have ended and the arms hang again.
    """

    is_over: bool

    def pose(self) -> GuidedPose:
        """Return the present pose."""

    def advance(self) -> Sequence[BodyStrike]:
        """Advance by a world step; return the strikes of the hands."""

    def end(self) -> None:
        """Lower the arms from now on."""


class DanceGuide(Protocol):
    """The dances that one person knows."""

    def prepare(self, dance: str, path: str) -> None:
        """Learn a dance.

        Raises:
            SceneError: it has drums, or the person cannot reach its places; `path` is that of its
                name in the scene.
        """

    def begin(self, order: Perform) -> GuidedDance:
        """Return a dance that was prepared, at its start."""


GuideMaker = Callable[[str, Proportions], DanceGuide]
"""Makes the dances of a person from its name and proportions."""


class DanceGuides:
    """The dances of all people of a room that are told to dance.

    Args:
        people: proportions of those that can dance, by name.
        make: makes the dances of one of them; None if nobody can dance.

    Attributes:
        guides: by the name of the person.
    """

    def __init__(self, people: Mapping[str, Proportions], make: GuideMaker | None) -> None:
        self.guides: dict[str, DanceGuide] = {}
        self._people, self._make = people, make

    def prepare_all(self, instructions: Sequence[tuple[str, Instruction]]) -> None:
        """Let people learn the dances of all instructions.

        Args:
            instructions: of the scene, with their paths in it.

        Raises:
            SceneError: somebody cannot dance what the script says; holds the problems of all.
        """
        refusals = Refusals()
        for path, instruction in instructions:
            with refusals.gathered():
                self.prepare(instruction, path)
        refusals.refuse()

    def prepare(self, instruction: Instruction, path: str) -> None:
        """Let a person learn the dance of an instruction.

        Args:
            instruction: to any performer.
            path: its path in error messages.

        Raises:
            SceneError: the person cannot dance it.
        """
        name, do = instruction.who, instruction.do
        if name not in self._people or not isinstance(do, Perform) or self._make is None:
            return
        if name not in self.guides:
            self.guides[name] = self._make(name, self._people[name])
        self.guides[name].prepare(do.dance, f"{path}.do.dance")


def strike_contact(
    strike: BodyStrike,
    name: str,
    proportions: Proportions,
    clothes: Clothes,
    step: int,
    pelvis: tuple[Array, Array],
) -> Contact:
    """Return the contact of a strike on a person's own body.

    Args:
        strike: of a hand.
        name: of the person.
        proportions: of the person.
        clothes: that it wears.
        step: of the strike.
        pelvis: rotation (3, 3) and place (3,) of the frame of the strike [m].
    """
    R, p = pelvis
    mass = proportions.mass * (SEGMENT_MASSES["hand"] + 0.5 * SEGMENT_MASSES["forearm"])
    is_bare = strike.other in ("head", "neck") or strike.other.startswith("hand")
    x, y, z = (p + (R * strike.place).sum(axis=1)).tolist()
    u, v, w = (R * strike.normal).sum(axis=1).tolist()
    return Contact(
        step=step,
        fraction=strike.fraction,
        performer=name,
        part=strike.hand,
        other=strike.other,
        place=(x, y, z),
        normal=(u, v, w),
        speed=strike.speed,
        energy=0.5 * mass * strike.speed**2,
        material=clothes.skin,
        surface=clothes.skin if is_bare else clothes.shirt,
        size=proportions.hand * proportions.height,
        kind="hit",
    )
