"""Answers: what a simulation is asked about itself, as plain values."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from pipeline.production.direct.numbers import number, numbers
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene

Answer = dict[str, object]


class Answers:
    """What can be told of a scene and of its simulation as it is now."""

    def __init__(self, scene: Scene, simulation: Simulation) -> None:
        self.scene = scene
        self.simulation = simulation
        nodes = simulation.recorder.nodes
        self.names = frozenset([m.name for m in scene.cast] + [node.performer for node in nodes])
        self._first: dict[str, int] = {}
        for i, node in enumerate(nodes):
            self._first.setdefault(node.performer, i)

    def about(self, what: Collection[str], who: Collection[str]) -> Answer:
        """Return what is asked, about some performers or about all."""
        row = self.simulation.last_row()
        return {topic: TOPICS[topic](self, row, frozenset(who) or self.names) for topic in what}

    def time(self, row: int = 0, who: Collection[str] = ()) -> Answer:
        """Return where in the scene the simulation is."""
        del row, who
        clock, step = self.simulation.world.clock, self.simulation.step_number
        return {
            "step": step,
            "frame": min(step // clock.steps + 1, clock.frames),
            "time": float(clock.time_of(step)),
            "steps_a_frame": clock.steps,
            "frames": clock.frames,
            "duration": float(clock.time_of(clock.last_step)),
            "finished": self.simulation.finished,
        }

    def performers(self, row: int, who: Collection[str]) -> Answer:
        """Return who is in the cast: what each is, and what it is called."""
        del row
        return {
            member.name: {"is": type(member).__name__.lower(), "called": member.kind_name}
            for member in self.scene.cast
            if member.name in who
        }

    def places(self, row: int, who: Collection[str]) -> Answer:
        """Return where performers are: their first nodes [m]."""
        positions = self.simulation.recorder.positions[row]
        return {name: numbers(positions[node]) for name, node in self._first.items() if name in who}

    def poses(self, row: int, who: Collection[str]) -> Answer:
        """Return positions [m] and rotations wxyz of all nodes, by their names."""
        recorder = self.simulation.recorder
        p, q, alive = (x[row] for x in (recorder.positions, recorder.quaternions, recorder.alive))
        return {
            node.name: {"position": numbers(p[i]), "rotation": numbers(q[i])}
            for i, node in enumerate(recorder.nodes)
            if node.performer in who and alive[i]
        }

    def channels(self, row: int, who: Collection[str]) -> Answer:
        """Return the numbers that change, by their names."""
        recorder = self.simulation.recorder
        values = recorder.values[row]
        return {
            channel.name: number(values[i])
            for i, channel in enumerate(recorder.channels)
            if channel.name.partition(".")[0] in who
        }

    def notes(self, row: int, who: Collection[str]) -> list[Answer]:
        """Return what the author should know so far."""
        del row
        return [
            {"kind": note.kind, "step": note.step, "part": note.part, "text": note.text}
            for note in self.simulation.recorder.notes
            if note.part.partition(".")[0] in who
        ]


TOPICS: Mapping[str, Callable[[Answers, int, Collection[str]], object]] = {
    "time": Answers.time,
    "performers": Answers.performers,
    "places": Answers.places,
    "poses": Answers.poses,
    "channels": Answers.channels,
    "notes": Answers.notes,
}
"""What can be asked about, see `words.Topic`."""
