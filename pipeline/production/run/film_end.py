"""Film end: orders, keys and cuts of a scene that would begin after its film is over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from pipeline.production.run.notes import Note, clock_of, cut_path, place_of
from pipeline.spec import Scene
from pipeline.spec.body import Body
from pipeline.spec.creature import Creature
from pipeline.spec.keyframes import PoseKey
from pipeline.spec.prop import Prop, VelocityKey
from pipeline.spec.script import order_text
from render.config.camera import KEYFRAME_KEYS

VALUES = {
    "keyframe": ("position", "rotation_deg", "scale"),
    "velocity": ("linear", "spin_deg"),
    "force": ("force", "torque"),
    "camera keyframe": KEYFRAME_KEYS,
}
"""Values that keys of each kind may give; each has a track of its own."""


class EasedKey(Protocol):
    """A key at a time, and the interpolation that leads to it."""

    @property
    def at(self) -> float:
        """When [s]."""
        ...

    @property
    def ease(self) -> str:
        """Interpolation towards it."""
        ...


@dataclass(frozen=True, slots=True)
class Beginning:
    """The moment at which something that a scene asks for begins.

    Attributes:
        time: [s].
        path: of the value that says when, such as `script[2].at`.
        part: whom or what it is about.
        lost: what happens if the film is over by then, such as "never given".
        kind: of the note on it.
    """

    time: float
    path: str
    part: str
    lost: str = "never begins"
    kind: str = "never_begins"


def notes_after_end(scene: Scene) -> list[Note]:
    """Return a note on each order, key and cut that begins when the film is over."""
    clock = clock_of(scene)
    last_shown = float((clock.frames - 1) / clock.rate)
    length = f"the film ends at {float(clock.frames / clock.rate):.6g} s"
    given = [b for b in _simulated(scene) if clock.step_from(b.time) >= clock.last_step]
    shown = [b for b in _camera(scene) if b.time > last_shown]
    return [_note(scene, beginning, length) for beginning in (*given, *shown)]


def _note(scene: Scene, beginning: Beginning, length: str) -> Note:
    place = place_of(scene, beginning.path) or beginning.path
    time, text = round(beginning.time, 3), f"{beginning.lost}; {length}"
    return Note(beginning.kind, "scene", beginning.part, time, None, text, place)


def _simulated(scene: Scene) -> Iterator[Beginning]:
    """Yield what the simulation would begin."""
    for i, order in enumerate(scene.script):
        if order.at is not None:
            part = f"{order.who}: {order_text(order.do)}"
            path = f"script[{i}].at"
            yield Beginning(order.at, path, part, "never given", "order_never_given")
    for i, dancer in scene.dancers:
        key = "start" if dancer.beat is None else "beat"
        yield Beginning(dancer.start, f"cast[{i}].{key}", f"{dancer.name}: dance")
    for i, member in enumerate(scene.cast):
        path, name = f"cast[{i}]", member.name
        yield from _poses(getattr(member, "pose", ()), f"{path}.pose", name)
        if isinstance(member, Creature) and member.pronk is not None:
            yield Beginning(member.pronk.start, f"{path}.pronk.start", f"{name}: pronk")
        if isinstance(member, Prop):
            yield from _prop(member, path)
        for k, hold in enumerate(member.held if isinstance(member, Prop | Body) else ()):
            yield Beginning(hold.at, f"{path}.held[{k}].at", f"{name}: held by {hold.by}")


def _prop(prop: Prop, path: str) -> Iterator[Beginning]:
    yield from _keys(prop.keyframes, "keyframe", f"{path}.keyframes", prop.name)
    velocities = [key for key in prop.velocity or () if isinstance(key, VelocityKey)]
    yield from _keys(velocities, "velocity", f"{path}.velocity", prop.name)
    if prop.force is not None:
        yield from _keys(prop.force.keys, "force", f"{path}.force.keys", prop.name)
    if prop.falls is not None:
        yield Beginning(prop.falls, f"{path}.falls", f"{prop.name}: falls")


def _keys(keys: Sequence[EasedKey], kind: str, path: str, name: str) -> Iterator[Beginning]:
    """Yield the beginnings of keys: at the key before that gives the same value.

    The first that gives a value is in effect from the start.
    """
    latest: dict[str, float] = {}
    for i, key in enumerate(keys):
        given = [value for value in VALUES[kind] if getattr(key, value) is not None]
        begin = min(
            key.at if key.ease == "hold" and value in latest else latest.get(value, 0.0)
            for value in given
        )
        latest.update(dict.fromkeys(given, key.at))
        yield Beginning(begin, f"{path}[{i}].at", f"{name}: {kind}")


def _poses(keys: Sequence[PoseKey], path: str, name: str) -> Iterator[Beginning]:
    """Yield the beginnings of pose keys: at the key before on the same part, or with its blend."""
    latest: dict[str, float] = {}
    for i, key in enumerate(keys):
        named = [key.limb, key.node, "body" if key.body else None, *(key.joints or ())]
        targets = [target for target in named if target is not None]
        blends = [latest.get(target, key.at - key.blend) for target in targets]
        if key.release is not None:
            blends.append(key.at)
            targets.append(key.release)
        latest.update(dict.fromkeys(targets, key.at))
        yield Beginning(min(blends), f"{path}[{i}].at", f"{name}: pose of {', '.join(targets)}")


def _camera(scene: Scene) -> Iterator[Beginning]:
    """Yield what the camera would begin."""
    for i, cut in enumerate(scene.camera):
        path = cut_path(scene, i)
        if i:
            yield Beginning(cut.start, f"{path}.start", f"cut {i + 1}")
        yield from _keys(cut.keyframes, "camera keyframe", f"{path}.keyframes", f"cut {i + 1}")
