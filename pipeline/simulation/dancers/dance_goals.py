"""Goals: what each subtask of a dance comes to on one person, for both controllers.

Places become spots of the torso, whose links carry them; angles become postures. What is said
in angles is a place for a field as well: there the hand is by them, which takes no inverse
kinematics. What turns a hand alone is nothing to a field.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.dancers.body_surfaces import (
    Surface,
    body_surfaces,
    drum_surface,
    link_number,
    scaled_place,
)
from pipeline.simulation.dancers.reach_limits import (
    beyond_limits,
    inside_body,
    out_of_reach,
)
from pipeline.simulation.dancers.torso import (
    ARM,
    HAND_RADIUS,
    LINKS,
    WRIST,
    Torso,
    sided,
    torso_of,
)
from pipeline.simulation.dynamics.linkage import Disc, Spot
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance, Drum, Hand, Subtask, Where

CHEST = LINKS.index("chest")

HANGING_ANGLES = {"shoulder_flexion": 4.0, "shoulder_abduction": 9.0, "elbow_flexion": 14.0}
"""How arms hang, where it is not 0 [degrees]."""

REACHING_ANGLES = {
    "shoulder_flexion": 35.0,
    "shoulder_abduction": 18.0,
    "shoulder_rotation": 20.0,
    "elbow_flexion": 70.0,
    "wrist_pronation": 50.0,
}
"""How arms are held that reach for something, unless a subtask says otherwise [degrees]."""


@dataclass(frozen=True, eq=False)
class Goal:
    """A subtask on one person.

    Attributes:
        words: the subtask.
        spots: numbers of the places on the way and of the last, none where it only turns.
        said: the word that each of them is said in as a position, empty where it is a name.
        held: (7,) angles of the arm and wrist that it is held near to [rad].
        given: (7,) which of these the author gave.
        trunk: joint -> angle of waist and neck that the author gave [rad].
        surface: what is touched.
        press: how far under it the last place is [m].
    """

    words: Subtask
    spots: tuple[int, ...]
    said: tuple[str, ...]
    held: Array
    given: Array
    trunk: dict[str, float]
    surface: Surface | None
    press: float

    @property
    def is_for_fields(self) -> bool:
        """Whether a force on the hand can do it."""
        return bool(self.spots)


@dataclass(frozen=True, slots=True)
class PlacedSubtask:
    """A subtask of a dance, or of what a dancer is posed in or told.

    Attributes:
        path: in the scene, for messages.
        words: it.
        still: whether its places are of where the dancer stands, and in metres; those of dances
            go along with the chest, in proportion.
        said: the path of its place instead, where that is none of its own words.
    """

    path: str
    words: Subtask
    still: bool = False
    said: str = ""


@dataclass(frozen=True, eq=False)
class Choreography:
    """What a dancer does, on one person.

    Attributes:
        torso: with all places.
        goals: one a subtask.
        ready: side -> number of the spot where its hand is at first.
    """

    torso: Torso
    goals: tuple[Goal, ...]
    ready: dict[str, int]


def dance_choreography(
    who: Proportions, dance: Dance, name: str, compensated: bool
) -> Choreography:
    """Return a dance on one person.

    Args:
        who: the person.
        dance: its words.
        name: of the dance, for messages.
        compensated: whether the arms' weight is.

    Raises:
        SceneError: a place is out of reach or inside the body, or an angle beyond its joint.
    """
    ready = ReadyPlaces(f"dances.{name}", dance.ready)
    return build_choreography(who, placed_subtasks(dance, name), dance.drums, ready, compensated)


def placed_subtasks(dance: Dance, name: str) -> list[PlacedSubtask]:
    """Return the subtasks of a dance, with their paths."""
    return [
        PlacedSubtask(f"dances.{name}.subtasks[{i}]", one) for i, one in enumerate(dance.subtasks)
    ]


@dataclass(frozen=True, slots=True)
class ReadyPlaces:
    """Where hands are at first: the path of what says so, and side -> place."""

    path: str
    places: Mapping[Hand, Where]


def build_choreography(
    who: Proportions,
    parts: Sequence[PlacedSubtask],
    drums: Mapping[str, Drum],
    ready: ReadyPlaces,
    compensated: bool,
) -> Choreography:
    """Return subtasks on one person.

    Args:
        who: the person.
        parts: the subtasks, numbered as they stand here.
        drums: that stand before it, by name.
        ready: where its hands are at first.
        compensated: whether the arms' weight is.

    Raises:
        SceneError: a place is out of reach or inside the body, or an angle beyond its joint.
    """
    surfaces = body_surfaces(who)
    surfaces |= {drum: drum_surface(who, words) for drum, words in drums.items()}
    plain = LinkageSimulation(torso_of(who).linkage, 1e-3)
    spots, rows, problems = list[Spot](), list[list[tuple[str, str]]](), list[Problem]()
    for i, part in enumerate(parts):
        own = list(_spots(who, part, i, surfaces, plain))
        positions = _positions(part.words, own)
        rows.append([(spot.name, word if (spot, word) in positions else "") for spot, word in own])
        problems += out_of_reach(who, part.words.hand, own, part.path, part.said)
        problems += inside_body(plain.linkage.links, positions, part.path, part.said)
        if not part.still:
            problems += beyond_limits(part.words.joints, part.path)
        spots += [spot for spot, _ in own]
    for side, place in ready.places.items():
        spots.append(_spot(who, f"ready.{side}", place, surfaces))
        own = [(spots[-1], f"ready.{side}")]
        problems += out_of_reach(who, side, own, ready.path)
        problems += inside_body(plain.linkage.links, own, ready.path)
    if problems:
        raise SceneError(problems)
    discs = tuple(
        Disc(drum, np.array(w.at) - [0.0, 0.5 * w.height, 0.0], w.radius, w.height)
        for drum, w in drums.items()
    )
    torso = torso_of(who, tuple(spots), discs, compensated)
    goals = tuple(
        _goal(who, part.words, [(torso.spot(spot), word) for spot, word in row], surfaces)
        for part, row in zip(parts, rows, strict=True)
    )
    return Choreography(torso, goals, {side: torso.spot(f"ready.{side}") for side in ready.places})


def hanging_posture() -> Array:
    """Return (7,) how an arm hangs [rad]."""
    return np.radians([HANGING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)])


def reaching_posture() -> Array:
    """Return (7,) how an arm is held that reaches for something [rad]."""
    return np.radians([REACHING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)])


def _goal(
    who: Proportions,
    one: Subtask,
    row: Sequence[tuple[int, str]],
    surfaces: dict[str, Surface],
) -> Goal:
    names = (*ARM, *WRIST)
    angles = {word.removesuffix("_deg"): math.radians(a) for word, a in one.joints.items()}
    easy = reaching_posture()
    held = np.array([angles.get(joint, easy[k]) for k, joint in enumerate(names)])
    given = np.array([joint in angles for joint in names])
    trunk = {joint: angle for joint, angle in angles.items() if joint not in names}
    surface = surfaces.get(one.touch or "")
    # How far its middle is from the surface when a hand touches.
    radius = HAND_RADIUS * who.height
    press = (
        0.0 if surface is None else radius - float((surface.aim - surface.place) @ surface.normal)
    )
    spots, said = tuple(spot for spot, _ in row), tuple(word for _, word in row)
    return Goal(one, spots, said, held, given, trunk, surface, press)


def _spots(
    who: Proportions,
    part: PlacedSubtask,
    i: int,
    surfaces: dict[str, Surface],
    plain: LinkageSimulation,
) -> Iterator[tuple[Spot, str]]:
    """Yield the places of a subtask and the words that they are said in."""
    one = part.words
    if part.still and one.reach is not None:
        yield Spot(f"{i}.reach", -1, np.array(one.reach)), "reach"
        return
    for k, place in enumerate(one.via):
        yield _spot(who, f"{i}.via.{k}", place, surfaces), f"via[{k}]"
    if one.touch is not None:
        surface = surfaces[one.touch]
        link = link_number(surface)
        if one.lift:
            lifted = surface.aim + one.lift * surface.normal
            yield Spot(f"{i}.lift", link, lifted), "lift"
        yield Spot(f"{i}.touch", link, surface.aim), "touch"
    elif one.reach is not None:
        yield _spot(who, f"{i}.reach", one.reach, surfaces), "reach"
    elif one.trace is not None:
        for k, position in enumerate(one.trace):
            yield _spot(who, f"{i}.trace.{k}", position, surfaces), f"trace[{k}]"
    elif any(f"{joint}_deg" in one.joints for joint in ARM):
        yield Spot(f"{i}.joints", CHEST, _hand_by_angles(one, plain)), "joints"


def _spot(who: Proportions, name: str, place: Where, surfaces: dict[str, Surface]) -> Spot:
    if isinstance(place, str):
        surface = surfaces[place]
        return Spot(name, link_number(surface), surface.aim)
    return Spot(name, CHEST, scaled_place(who, place))


def _positions(one: Subtask, own: Sequence[tuple[Spot, str]]) -> list[tuple[Spot, str]]:
    """Return those places of a subtask that are said as positions."""
    named = {"touch", "lift", "joints"}
    named |= {f"via[{k}]" for k, place in enumerate(one.via) if isinstance(place, str)}
    return [(spot, word) for spot, word in own if word not in named]


def _hand_by_angles(one: Subtask, plain: LinkageSimulation) -> Array:
    """Return (3,) where the hand is when the joints of its arm are as they are given [m]."""
    names = [hinge.name for hinge in plain.linkage.hinges]
    plain.q[:] = 0.0
    for joint in ARM:
        angle = one.joints.get(f"{joint}_deg", HANGING_ANGLES.get(joint, 0.0))
        plain.q[names.index(sided(joint, one.hand))] = math.radians(angle)
    plain.settle()
    spots = [spot.name for spot in plain.linkage.spots]
    place: Array = plain.places[spots.index(f"palm_{one.hand}")].copy()
    return place
