"""Assembly: the parts of a simulation, built from a scene and connected to each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from pipeline.simulation.attachment import attachments_of
from pipeline.simulation.casting import drawing_notes, figures_of, troupes_of
from pipeline.simulation.clock import Clock
from pipeline.simulation.contact_coupling import ContactCoupling, coupling_of
from pipeline.simulation.event_detection import EventDetection
from pipeline.simulation.inventory import obstacles_of
from pipeline.simulation.mechanism import NodeAlias
from pipeline.simulation.node_names import NodeNames, node_aliases
from pipeline.simulation.obstacles import Obstacle
from pipeline.simulation.recorder import Recorder
from pipeline.simulation.scheduler import RowScheduler
from pipeline.simulation.script import Script
from pipeline.simulation.terrain import build_ground
from pipeline.simulation.troupe import Troupe, World
from pipeline.simulation.versions import header_of
from pipeline.spec.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Assembly:
    """The parts of one simulation.

    Attributes:
        world: the constants that every troupe reads.
        troupes: all troupes, in the order of their nodes.
        obstacles: returns their solids, computed at the first call.
        recorder: the take under construction.
        aliases: names of drawing nodes for the nodes of creatures.
        script: instructions of the scene.
        detection: detectors of sound events.
        coupling: the troupe that hits obstacles and its obstacles, None without any.
        scheduler: decides when rows are written.
    """

    world: World
    troupes: Sequence[Troupe]
    obstacles: Callable[[], Sequence[Obstacle]]
    recorder: Recorder
    aliases: tuple[NodeAlias, ...]
    script: Script
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
    detect = scene.sound.detect
    world = World(ground, clock, scene.seed, scene.script, scene.all_moods, detect, directed)
    figures = figures_of(scene)
    troupes = troupes_of(scene, figures, world)
    inventories = [troupe.inventory for troupe in troupes]
    obstacles = cache(lambda: obstacles_of(inventories))
    recorder = Recorder(header_of(scene, key), clock, ground, inventories)
    recorder.add_facts((), (), drawing_notes(figures))
    aliases = node_aliases(figures, recorder.nodes)
    names = NodeNames.joined(recorder.nodes, aliases)
    attachments = attachments_of(scene.cast, names, recorder.nodes, clock)
    for troupe in troupes:
        troupe.bind(recorder.nodes, recorder.meshes, names)
    recorder.attach(attachments)
    detection = EventDetection(scene, clock, recorder, figures)
    script = Script(scene.script, clock)
    coupling = coupling_of(scene, troupes, recorder, attachments, obstacles)
    scheduler = RowScheduler(
        clock, troupes, recorder, attachments, coupling, detection.record_batch
    )
    return Assembly(
        world, troupes, obstacles, recorder, aliases, script, detection, coupling, scheduler
    )
