"""Dance goals: each subtask of a dance on one person, for both controllers.

Places become sites on links of the torso; angles become postures. Angles of the arm give a field a
place too, by forward kinematics; a field has no effect on angles of the wrist alone.
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
    scaled_position,
)
from pipeline.simulation.dancers.reach_limits import beyond_limits, inside_body, out_of_reach
from pipeline.simulation.dancers.torso import (
    ARM,
    HAND_RADIUS,
    LINKS,
    WRIST,
    Torso,
    build_torso,
    joint_name,
)
from pipeline.simulation.dynamics.linkage import Disc, Site
from pipeline.simulation.dynamics.mujoco_linkage import LinkageSimulation
from pipeline.simulation.people.proportions import Proportions
from pipeline.simulation.spatial import Array
from pipeline.spec.dance import Dance, Drum, Hand, Subtask, Where

CHEST = LINKS.index("chest")

HANGING_ANGLES = {"shoulder_flexion": 4.0, "shoulder_abduction": 9.0, "elbow_flexion": 14.0}
"""Angles of a hanging arm that are not 0 [degrees]."""

REACHING_ANGLES = {
    "shoulder_flexion": 35.0,
    "shoulder_abduction": 18.0,
    "shoulder_rotation": 20.0,
    "elbow_flexion": 70.0,
    "wrist_pronation": 50.0,
}
"""Preferred angles of a reaching arm where the subtask gives none [degrees]."""


@dataclass(frozen=True, eq=False)
class Goal:
    """A subtask on one person.

    Attributes:
        subtask: the subtask in the dance.
        sites: numbers of the sites on the way, the last one included; empty for turns alone.
        position_keys: scene key of each site given as a position; empty for named places.
        held: (7,) preferred angles of arm and wrist [rad].
        given: (7,) whether the author gave the angle.
        trunk: joint -> given angle of waist and neck [rad].
        surface: surface that the hand touches.
        press: depth of the last site below the surface [m].
    """

    subtask: Subtask
    sites: tuple[int, ...]
    position_keys: tuple[str, ...]
    held: Array
    given: Array
    trunk: dict[str, float]
    surface: Surface | None
    press: float


@dataclass(frozen=True, slots=True)
class PlacedSubtask:
    """A subtask of a dance, a pose or an instruction, with its place in the scene.

    Attributes:
        path: path in the scene, for messages.
        subtask: the subtask.
        is_fixed: whether its places are metres in the dancer's frame; places of dances are
            scaled to the person and move with the chest.
        place_path: path of its place, where that is outside the subtask.
    """

    path: str
    subtask: Subtask
    is_fixed: bool = False
    place_path: str = ""


@dataclass(frozen=True, eq=False)
class Choreography:
    """All subtasks of a dancer on one person.

    Attributes:
        torso: torso with all sites.
        goals: one per subtask.
        ready: side -> number of the site where its hand starts.
    """

    torso: Torso
    goals: tuple[Goal, ...]
    ready: dict[str, int]


def dance_choreography(
    person: Proportions, dance: Dance, name: str, compensated: bool
) -> Choreography:
    """Returns a dance on one person.

    Args:
        person: proportions of the person.
        dance: the dance.
        name: name of the dance, for messages.
        compensated: whether the arms' weight is compensated.

    Raises:
        SceneError: if a place is out of reach or inside the body, or an angle beyond its joint.
    """
    ready = ReadyPlaces(f"dances.{name}", dance.ready)
    return build_choreography(person, placed_subtasks(dance, name), dance.drums, ready, compensated)


def placed_subtasks(dance: Dance, name: str) -> list[PlacedSubtask]:
    """Returns the subtasks of a dance with their paths."""
    return [
        PlacedSubtask(f"dances.{name}.subtasks[{i}]", subtask)
        for i, subtask in enumerate(dance.subtasks)
    ]


@dataclass(frozen=True, slots=True)
class ReadyPlaces:
    """Start places of the hands: path in the scene, and side -> place."""

    path: str
    places: Mapping[Hand, Where]


def build_choreography(
    person: Proportions,
    parts: Sequence[PlacedSubtask],
    drums: Mapping[str, Drum],
    ready: ReadyPlaces,
    compensated: bool,
) -> Choreography:
    """Returns subtasks on one person.

    Args:
        person: proportions of the person.
        parts: the subtasks, in the order of their numbers.
        drums: drums by name.
        ready: start places of the hands.
        compensated: whether the arms' weight is compensated.

    Raises:
        SceneError: if a place is out of reach or inside the body, or an angle beyond its joint.
    """
    surfaces = body_surfaces(person)
    surfaces |= {name: drum_surface(person, drum) for name, drum in drums.items()}
    plain = LinkageSimulation(build_torso(person).linkage, 1e-3)
    sites, rows, problems = list[Site](), list[list[tuple[str, str]]](), list[Problem]()
    for i, part in enumerate(parts):
        placed = list(_sites(person, part, i, surfaces, plain))
        positions = _positions(part.subtask, placed)
        rows.append([(site.name, key if (site, key) in positions else "") for site, key in placed])
        problems += out_of_reach(person, part.subtask.hand, placed, part.path, part.place_path)
        problems += inside_body(plain.linkage.links, positions, part.path, part.place_path)
        if not part.is_fixed:
            problems += beyond_limits(part.subtask.joints, part.path)
        sites += [site for site, _ in placed]
    for side, place in ready.places.items():
        sites.append(_site(person, f"ready.{side}", place, surfaces))
        placed = [(sites[-1], f"ready.{side}")]
        problems += out_of_reach(person, side, placed, ready.path)
        problems += inside_body(plain.linkage.links, placed, ready.path)
    if problems:
        raise SceneError(problems)
    discs = tuple(
        Disc(name, np.array(drum.at) - [0.0, 0.5 * drum.height, 0.0], drum.radius, drum.height)
        for name, drum in drums.items()
    )
    torso = build_torso(person, tuple(sites), discs, compensated)
    goals = tuple(
        _goal(person, part.subtask, [(torso.site(site), key) for site, key in row], surfaces)
        for part, row in zip(parts, rows, strict=True)
    )
    return Choreography(torso, goals, {side: torso.site(f"ready.{side}") for side in ready.places})


def hanging_posture() -> Array:
    """Returns the angles (7,) of a hanging arm [rad]."""
    return np.radians([HANGING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)])


def reaching_posture() -> Array:
    """Returns the preferred angles (7,) of a reaching arm [rad]."""
    return np.radians([REACHING_ANGLES.get(joint, 0.0) for joint in (*ARM, *WRIST)])


def _goal(
    person: Proportions,
    subtask: Subtask,
    row: Sequence[tuple[int, str]],
    surfaces: dict[str, Surface],
) -> Goal:
    names = (*ARM, *WRIST)
    angles = {key.removesuffix("_deg"): math.radians(a) for key, a in subtask.joints.items()}
    reaching = reaching_posture()
    held = np.array([angles.get(joint, reaching[k]) for k, joint in enumerate(names)])
    given = np.array([joint in angles for joint in names])
    trunk = {joint: angle for joint, angle in angles.items() if joint not in names}
    surface = surfaces.get(subtask.touch or "")
    # Distance of a hand's centre from a surface that it touches.
    radius = HAND_RADIUS * person.height
    press = (
        0.0 if surface is None else radius - float((surface.aim - surface.place) @ surface.normal)
    )
    sites, keys = tuple(site for site, _ in row), tuple(key for _, key in row)
    return Goal(subtask, sites, keys, held, given, trunk, surface, press)


def _sites(
    person: Proportions,
    part: PlacedSubtask,
    i: int,
    surfaces: dict[str, Surface],
    plain: LinkageSimulation,
) -> Iterator[tuple[Site, str]]:
    """Yields the sites of a subtask with their keys in the scene."""
    subtask = part.subtask
    if part.is_fixed and subtask.reach is not None:
        yield Site(f"{i}.reach", -1, np.array(subtask.reach)), "reach"
        return
    for k, place in enumerate(subtask.via):
        yield _site(person, f"{i}.via.{k}", place, surfaces), f"via[{k}]"
    if subtask.touch is not None:
        surface = surfaces[subtask.touch]
        link = link_number(surface)
        if subtask.lift:
            lifted = surface.aim + subtask.lift * surface.normal
            yield Site(f"{i}.lift", link, lifted), "lift"
        yield Site(f"{i}.touch", link, surface.aim), "touch"
    elif subtask.reach is not None:
        yield _site(person, f"{i}.reach", subtask.reach, surfaces), "reach"
    elif subtask.trace is not None:
        for k, position in enumerate(subtask.trace):
            yield _site(person, f"{i}.trace.{k}", position, surfaces), f"trace[{k}]"
    elif any(f"{joint}_deg" in subtask.joints for joint in ARM):
        yield Site(f"{i}.joints", CHEST, _forward_kinematics(subtask, plain)), "joints"


def _site(person: Proportions, name: str, place: Where, surfaces: dict[str, Surface]) -> Site:
    if isinstance(place, str):
        surface = surfaces[place]
        return Site(name, link_number(surface), surface.aim)
    return Site(name, CHEST, scaled_position(person, place))


def _positions(subtask: Subtask, placed: Sequence[tuple[Site, str]]) -> list[tuple[Site, str]]:
    """Returns the sites of a subtask that are given as positions."""
    named = {"touch", "lift", "joints"}
    named |= {f"via[{k}]" for k, place in enumerate(subtask.via) if isinstance(place, str)}
    return [(site, key) for site, key in placed if key not in named]


def _forward_kinematics(subtask: Subtask, plain: LinkageSimulation) -> Array:
    """Returns the position (3,) of the hand at the given joint angles of its arm [m]."""
    names = [hinge.name for hinge in plain.linkage.hinges]
    plain.q[:] = 0.0
    for joint in ARM:
        angle = subtask.joints.get(f"{joint}_deg", HANGING_ANGLES.get(joint, 0.0))
        plain.q[names.index(joint_name(joint, subtask.hand))] = math.radians(angle)
    plain.settle()
    sites = [site.name for site in plain.linkage.sites]
    return plain.places[sites.index(f"palm_{subtask.hand}")].copy()
