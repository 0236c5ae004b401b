"""Assembly: the parts of a simulation, built from a scene and connected to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pipeline.errors import Problem, SceneError
from pipeline.simulation.attachment import Attachment, attachments_of, split_attachments
from pipeline.simulation.casting import clothes_of, drawing_notes, figures_of, troupes_of
from pipeline.simulation.clock import Clock
from pipeline.simulation.contact_coupling import ContactCoupling, coupling_of
from pipeline.simulation.event_detection import EventDetection
from pipeline.simulation.event_monitor import EventMonitor
from pipeline.simulation.figures.figure import Figure
from pipeline.simulation.ground_places import GroundPlaces
from pipeline.simulation.group_places import group_places
from pipeline.simulation.inventory import obstacles_of
from pipeline.simulation.mechanism import NodeAlias
from pipeline.simulation.members import Members
from pipeline.simulation.node_names import NodeNames, node_aliases
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.refusals import Refusals
from pipeline.simulation.scheduler import RowScheduler
from pipeline.simulation.script import Script
from pipeline.simulation.spatial import Array
from pipeline.simulation.terrain import Ground, build_ground
from pipeline.simulation.troupe import Troupe, World, node_range, pushed_troupe
from pipeline.simulation.versions import header_of
from pipeline.spec.body import Many
from pipeline.spec.character import Character
from pipeline.spec.creature import Creature
from pipeline.spec.dancer import Dancer
from pipeline.spec.relations import attitudes_of
from pipeline.spec.scene import Scene
from pipeline.spec.yaml_tree import path_text


@dataclass(frozen=True, eq=False, slots=True)
class Assembly:
    """The parts of one simulation.

    Attributes:
        world: the constants that every troupe reads.
        troupes: all troupes, in the order of their nodes.
        recorder: the take under construction.
        aliases: names of drawing nodes for the nodes of creatures.
        script: instructions of the scene.
        members: where all members of the cast are.
        ground_places: refuses places off the terrain.
        monitor: tests the conditions that instructions wait for.
        detection: detectors of sound events.
        coupling: the troupe that hits obstacles and its obstacles, None without any.
        scheduler: decides when rows are written.
    """

    world: World
    troupes: Sequence[Troupe]
    recorder: Recorder
    aliases: tuple[NodeAlias, ...]
    script: Script
    members: Members
    ground_places: GroundPlaces
    monitor: EventMonitor
    detection: EventDetection
    coupling: ContactCoupling | None
    scheduler: RowScheduler


def assemble(scene: Scene, key: str, directed: bool) -> Assembly:
    """Builds the parts of the simulation of `scene`.

    Args:
        scene: the scene.
        key: key of the take.
        directed: whether instructions may arrive while it runs.

    Raises:
        SceneError: if the scene asks for something impossible.
    """
    clock = Clock(scene.rate, scene.n_frames, scene.steps, scene.rows_per_frame)
    ground = build_ground(scene.terrain, scene.seed)
    places = _places(scene, ground)
    ground_places = GroundPlaces(scene, ground, places)
    refusals = Refusals()
    with refusals.gathered():
        ground_places.refuse_off_terrain()
    detect = scene.sound.detect
    world = World(
        ground, clock, scene.seed, scene.script, scene.all_moods, detect, directed, places
    )
    if scene.story is not None:
        world = replace(
            world,
            beat_orders=[
                (path_text(path), order) for path, order in scene.instructions[len(scene.script) :]
            ],
            attitudes=attitudes_of(scene.story.relations),
        )
    figures, troupes = dict[str, Figure](), list[Troupe]()
    with refusals.gathered():
        figures = figures_of(scene)
        world = replace(world, clothes=clothes_of(scene, figures))
        troupes = troupes_of(scene, figures, world)
    refusals.refuse()
    inventories = [troupe.inventory for troupe in troupes]
    obstacles = cache(lambda: obstacles_of(inventories))
    recorder = Recorder(header_of(scene, key), clock, ground, inventories)
    recorder.add_facts((), (), drawing_notes(figures))
    aliases = node_aliases(figures, recorder.nodes)
    names = NodeNames.joined(recorder.nodes, aliases)
    pushed = pushed_troupe(troupes)
    falling = {node.performer for node in pushed.inventory.nodes} if pushed is not None else set()
    groups = group_places(scene, ground, names)
    members = Members(recorder, names, obstacles, places, groups)
    attachments = list[Attachment]()
    with refusals.gathered():
        _refuse_unknown_parts(scene, members)
    with refusals.gathered():
        attachments = attachments_of(scene.cast, names, recorder.nodes, clock, falling)
    for troupe in troupes:
        with refusals.gathered():
            troupe.bind(recorder.nodes, recorder.meshes, names)
    refusals.refuse()
    if pushed is not None:
        _refuse_late_carriers(pushed, troupes, attachments)
    recorder.attach(attachments)
    for troupe in troupes:
        troupe.see_attachments(attachments, recorder.nodes)
    detection = EventDetection(scene, clock, recorder, figures)
    script = Script(scene.script, clock)
    monitor = EventMonitor(
        members, clock, ground, _owners(recorder), _standing(scene), _bodies_of(scene)
    )
    coupling = coupling_of(scene, troupes, recorder, attachments, obstacles)
    scheduler = RowScheduler(
        clock, troupes, recorder, attachments, coupling, detection.record_batch
    )
    return Assembly(
        world=world,
        troupes=troupes,
        recorder=recorder,
        aliases=aliases,
        script=script,
        members=members,
        ground_places=ground_places,
        monitor=monitor,
        detection=detection,
        coupling=coupling,
        scheduler=scheduler,
    )


def _refuse_late_carriers(
    pushed: Troupe, troupes: Sequence[Troupe], attachments: Sequence[Attachment]
) -> None:
    """Refuses that bodies go with what is itself attached to bodies.

    Raises:
        SceneError: if any does.
    """
    _, late = split_attachments(attachments, node_range(troupes, pushed))
    problems = [
        Problem(
            pushed.carriers[node],
            f"'{attachment.name}' goes with a body itself, and nothing that falls can go with it; "
            f"name that body",
        )
        for attachment in late
        for node in attachment.nodes.tolist()
        if node in pushed.carriers
    ]
    if problems:
        raise SceneError(problems)


def _refuse_unknown_parts(scene: Scene, members: Members) -> None:
    """Refuses instructions that name parts which members do not have.

    Raises:
        SceneError: if any does.
    """
    problems = [
        problem
        for path, instruction in scene.instructions
        for problem in members.problems(instruction, path_text(path))
    ]
    if problems:
        raise SceneError(problems)


def _places(scene: Scene, ground: Ground) -> dict[str, Array]:
    """Returns the named places (3,) of a scene; those without a height are on the ground [m]."""
    places = {}
    for name, place in scene.places.items():
        x, z = place[0], place[-1]
        height = float(ground.height(np.array(x), np.array(z)))
        places[name] = np.array([x, place[1] if len(place) == 3 else height, z])
    return places


def _owners(recorder: Recorder) -> dict[str, str]:
    """Returns the performer of each part and node, by name."""
    return {
        **{part.name: part.performer for part in recorder.parts},
        **{node.name: node.performer for node in recorder.nodes},
    }


def _standing(scene: Scene) -> frozenset[str]:
    """Returns the names of the members that stand by themselves."""
    return frozenset(
        member.name
        for member in scene.cast
        if isinstance(member, Creature | Dancer) or (isinstance(member, Character) and member.acts)
    )


def _bodies_of(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Returns the names of the bodies of each member that is many."""
    return {
        member.name: tuple(f"{member.name}_{n + 1}" for n in range(member.many.total))
        for member in scene.cast
        if isinstance(member, Many)
    }
