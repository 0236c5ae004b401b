"""Name references: names in a scene that must name something else in it.

The scene is read as it stands, typed or still raw (see `partial_scene`). Names in the orders
of the script are checked in `order_support`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from audio.names import matches_pattern
from pipeline.spec.behaviour import TARGETS
from pipeline.spec.model_base import MAX_FAULTS, Fault
from pipeline.spec.mood import MOODS
from pipeline.spec.order_support import NamedThings, faults_of_script
from pipeline.spec.partial_scene import (
    Path,
    cast_by_name,
    items_of,
    items_or_itself,
    located_instructions,
    named_cast,
    text_keys,
    unknown_name,
    value_at,
)
from pipeline.spec.relations import faults_of_person
from pipeline.spec.sound_thresholds import Detect
from pipeline.spec.story_checks import faults_of_story
from pipeline.spec.suggestions import hint
from pipeline.spec.targets import ANYTHING, faults_of_target
from render.config import MATERIALS

CAUSES = tuple(Detect.model_fields)
"""Causes of sounds."""


def faults_of_references(scene: object) -> list[Fault]:
    """Find names of what does not exist, and names that are used twice.

    Args:
        scene: a scene, or the mapping that is to become one.
    """
    checks = (
        _figures,
        _repeated_names,
        _names_of_many_bodies,
        _materials,
        _camera_targets,
        _lamp_parents,
        _parents_and_followers,
        faults_of_script,
        faults_of_story,
        _behaviour_targets,
        _companions,
        _moods,
        _look_targets,
        _places,
        _sound_patterns,
    )
    return list(islice((fault for check in checks for fault in check(scene)), MAX_FAULTS))


def _members(scene: object) -> Iterator[tuple[int, Any]]:
    return items_of(value_at(scene, "cast"))


def _owner(name: str) -> str:
    """Return the performer in a name such as `bug.head`."""
    return name.partition(".")[0]


def _figures(scene: object) -> Iterator[Fault]:
    if isinstance(scene, Mapping) and not isinstance(scene.get("figures", {}), Mapping):
        return  # The block is no mapping, which is reported already.
    known = text_keys(value_at(scene, "figures"))
    for i, member in _members(scene):
        figure = value_at(member, "figure")
        if isinstance(figure, str) and figure not in known:
            message = f"no figure is called '{figure}', {hint(figure, known)}"
            yield Fault(("cast", i, "figure"), message)


def _repeated_names(scene: object) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for i, member in _members(scene):
        name = value_at(member, "name")
        if not isinstance(name, str) or not name:
            continue
        if name in first:
            message = f"the name '{name}' is taken by cast[{first[name]}]"
            yield Fault(("cast", i, "name"), message)
        first.setdefault(name, i)


def _names_of_many_bodies(scene: object) -> Iterator[Fault]:
    """Find members that have the numbered name of a body of `many`."""
    numbered: dict[str, tuple[str, int, int]] = {}
    for k, (name, member) in enumerate(named_cast(scene)):
        total = getattr(value_at(member, "many"), "total", 0)
        numbered |= {f"{name}_{n + 1}": (name, k, total) for n in range(total)}
    for i, member in _members(scene):
        own = value_at(member, "name")
        if isinstance(own, str) and own in numbered:
            name, k, total = numbered[own]
            message = (
                f"the name '{own}' is taken by a body of cast[{k}], "
                f"whose bodies are called {name}_1 to {name}_{total}"
            )
            yield Fault(("cast", i, "name"), message)


def _materials(scene: object) -> Iterator[Fault]:
    own = text_keys(value_at(scene, "materials"))
    named = [((*path, "material"), value_at(owner, "material")) for path, owner in _owners(scene)]
    for i, member in _members(scene):
        listed = items_of(value_at(value_at(member, "many"), "materials"))
        named += [(("cast", i, "many", "materials", k), name) for k, name in listed]
    for path, name in named:
        if isinstance(name, str) and name not in own and name not in MATERIALS:
            close = hint(name, MATERIALS, "materials", own)
            yield Fault(path, f"no material is called '{name}', {close}")


def _owners(scene: object) -> Iterator[tuple[Path, Any]]:
    """Yield all blocks that may name a material, with their paths."""
    yield ("terrain",), value_at(scene, "terrain")
    figures = value_at(scene, "figures")
    for key in text_keys(figures):
        figure = value_at(figures, key)
        yield ("figures", key), figure
        nodes = value_at(figure, "nodes")
        for node in text_keys(nodes):
            yield ("figures", key, "nodes", node), value_at(nodes, node)
    dances = value_at(scene, "dances")
    for key in text_keys(dances):
        drums = value_at(value_at(dances, key), "drums")
        for drum in text_keys(drums):
            yield ("dances", key, "drums", drum), value_at(drums, drum)
    for i, member in _members(scene):
        yield ("cast", i), member
        yield ("cast", i, "hair"), value_at(member, "hair")


def _camera_targets(scene: object) -> Iterator[Fault]:
    known = cast_by_name(scene).keys()
    named: list[tuple[Path, Any]] = []
    for place, cut in items_or_itself(value_at(scene, "camera")):
        for below, follow in items_or_itself(value_at(cut, "follow")):
            if isinstance(follow, str) and follow not in known:
                yield unknown_name(follow, known, ("camera", *place, "follow", *below))
        named += [((*place, key), value_at(cut, key)) for key in ("parent", "focus")]
        for k, key in items_of(value_at(cut, "keyframes")):
            named.append(((*place, "keyframes", k, "focus"), value_at(key, "focus")))
    for path, name in named:
        if isinstance(name, str) and _owner(name) not in known:
            yield unknown_name(_owner(name), known, ("camera", *path))


def _lamp_parents(scene: object) -> Iterator[Fault]:
    known = cast_by_name(scene).keys()
    for i, lamp in items_of(value_at(value_at(scene, "light"), "lamps")):
        parent = value_at(lamp, "parent")
        if isinstance(parent, str) and _owner(parent) not in known:
            yield unknown_name(_owner(parent), known, ("light", "lamps", i, "parent"))


def _parents_and_followers(scene: object) -> Iterator[Fault]:
    """Find parents, holders and targets of groups that do not exist or cannot be followed."""
    cast = cast_by_name(scene)
    for i, (own, member) in enumerate(named_cast(scene)):
        named: list[tuple[Path, Any]] = [(("parent",), value_at(member, "parent"))]
        for k, hold in items_of(value_at(member, "held")):
            named.append((("held", k, "by"), value_at(hold, "by")))
        group = value_at(member, "group")
        named += [(("group", key), value_at(group, key)) for key in ("follow", "around")]
        named += [(("group", "avoid", k), name) for k, name in items_of(value_at(group, "avoid"))]
        for path, target in named:
            if not isinstance(target, str):
                continue
            name, place = _owner(target), ("cast", i, *path)
            if name not in cast:
                yield unknown_name(name, cast, place)
            elif name == own:
                yield Fault(place, f"'{name}' cannot go along with itself")
            elif value_at(cast[name], "group") is not None:
                yield Fault(place, f"'{name}' is a group, which nobody can go along with")


def _behaviour_targets(scene: object) -> Iterator[Fault]:
    """Find behaviours towards nobody, towards oneself, or towards unfit characters."""
    cast = cast_by_name(scene)
    for i, (own, member) in enumerate(named_cast(scene)):
        for k, behaviour in items_of(value_at(member, "behaviours")):
            for key, fitting in TARGETS.items():
                if isinstance(name := value_at(behaviour, key), str):
                    path = ("cast", i, "behaviours", k, key)
                    yield from faults_of_target(name, own, fitting, path, cast)


def _companions(scene: object) -> Iterator[Fault]:
    """Find companions that are nobody, oneself, or do not walk by themselves."""
    cast = cast_by_name(scene)
    for i, (own, member) in enumerate(named_cast(scene)):
        for k, name in items_of(value_at(member, "companions")):
            if isinstance(name, str):
                path = ("cast", i, "companions", k)
                yield from faults_of_person(name, cast, path)
                if name == own:
                    yield Fault(path, f"'{own}' is no companion of itself; name another")


def _moods(scene: object) -> Iterator[Fault]:
    own = text_keys(value_at(scene, "moods"))
    mixes: list[tuple[Path, Any]] = [
        (("cast", i, "mood"), value_at(member, "mood")) for i, member in _members(scene)
    ]
    for path, instruction in located_instructions(scene):
        mixes.append(((*path, "do", "mood"), value_at(value_at(instruction, "do"), "mood")))
    for place, mix in mixes:
        for name in [mix] if isinstance(mix, str) else sorted(text_keys(mix)):
            if name not in own and name not in MOODS:
                close = hint(name, MOODS, "moods", own)
                yield Fault(place, f"no mood is called '{name}', {close}")


def _look_targets(scene: object) -> Iterator[Fault]:
    """Find what performers cannot look at from the start."""
    named = NamedThings.of(scene)
    for i, (name, member) in enumerate(named_cast(scene)):
        path = ("cast", i, "look_at")
        target = value_at(member, "look_at")
        yield from faults_of_target(target, name, ANYTHING, path, named.cast, named.places)


def _places(scene: object) -> Iterator[Fault]:
    """Find places that have the name of a member of the cast."""
    cast = cast_by_name(scene)
    for name in sorted(text_keys(value_at(scene, "places")) & cast.keys()):
        message = f"the name '{name}' is taken by a member of the cast"
        yield Fault(("places", name), message, at_key=True)


def _sound_patterns(scene: object) -> Iterator[Fault]:
    """Find voices and thresholds that fit no sound of the scene."""
    sound = value_at(scene, "sound")
    patterns: list[tuple[Path, Any]] = []
    for i, voice in items_of(value_at(sound, "voices")):
        when, place = value_at(voice, "when"), ("sound", "voices", i, "when")
        patterns.append(((*place, "who"), value_at(when, "who")))
        cause = value_at(when, "cause")
        if isinstance(cause, str) and not any(matches_pattern(name, cause) for name in CAUSES):
            close = hint(cause, CAUSES, "causes")
            yield Fault((*place, "cause"), f"nothing is caused by '{cause}', {close}")
    for cause in CAUSES:
        threshold = value_at(value_at(sound, "detect"), cause)
        patterns.append((("sound", "detect", cause, "who"), value_at(threshold, "who")))
    cast = cast_by_name(scene)
    for path, pattern in patterns:
        if isinstance(pattern, str) and pattern.strip("*") and not _is_meant(pattern, cast):
            yield unknown_name(pattern, cast, path)


def _is_meant(pattern: str, cast: Mapping[str, object]) -> bool:
    """Return whether a pattern fits anybody; the bodies of `many` and groups are numbered."""
    for name, member in cast.items():
        is_several = value_at(member, "many") is not None or value_at(member, "group") is not None
        if matches_pattern(name, pattern) or (is_several and pattern.startswith(f"{name}_")):
            return True
    return False
