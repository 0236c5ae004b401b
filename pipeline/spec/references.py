"""Names in a scene that must name something else in it.

The scene is read here as it stands, typed or still raw and perhaps wrong elsewhere, so that
a wrong name is found beside the other mistakes of the file and not after them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from pydantic import BaseModel

from audio.names import matches_pattern
from pipeline.spec.acting import (
    PEOPLE_ALONE,
    fault_of_thing,
    faults_of_acting,
    faults_of_hug,
    faults_of_touch,
)
from pipeline.spec.cast import called, names_of
from pipeline.spec.dancer_orders import DANCERS_ALONE, faults_of_orders
from pipeline.spec.detect import Detect
from pipeline.spec.faults import MOST_FAULTS, Fault, Step
from pipeline.spec.group import DIRECTED
from pipeline.spec.minding import faults_of_minds, faults_of_urges
from pipeline.spec.mood import MOODS
from pipeline.spec.nearest import hint
from pipeline.spec.script import FORMS
from render.config import MATERIALS

Place = tuple[Step, ...]

CAUSES = tuple(Detect.model_fields)
"""What is heard."""

JUMPS = ("hop_over", "jump")
"""What is jumped at once."""

UNMOVED = ("prop", "body")
"""What follows no script."""

HOPPING = ("hop", "stop", *JUMPS, "go_to", "turn_deg", "speed", "wait", "look_at", "look")
"""What a creature can be told that hops and does not walk."""


def faults_of_references(scene: object) -> list[Fault]:
    """Find names of what does not exist, and names that are used twice.

    Args:
        scene: a scene, or the mapping that is to become one.
    """
    finders = (
        _figures,
        _repeated_names,
        _names_of_many,
        _materials,
        _followed,
        _carried,
        _attached,
        _scripted,
        _minded,
        _hopped,
        _moods,
        _seen,
        _voiced,
    )
    return list(islice((fault for find in finders for fault in find(scene)), MOST_FAULTS))


def _figures(scene: object) -> Iterator[Fault]:
    figures = _get(scene, "figures")
    if isinstance(scene, Mapping) and not isinstance(scene.get("figures", {}), Mapping):
        return  # Whatever the file was meant to draw, it is reported already.
    known = _keys(figures)
    for i, member in _items(_get(scene, "cast")):
        figure = _get(member, "figure")
        if isinstance(figure, str) and figure not in known:
            message = f"no figure is called '{figure}', {hint(figure, known)}"
            yield Fault(("cast", i, "figure"), message)


def _repeated_names(scene: object) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for i, member in _items(_get(scene, "cast")):
        name = _get(member, "name")
        if not isinstance(name, str) or not name:
            continue
        if name in first:
            message = f"the name '{name}' is taken by cast[{first[name]}]"
            yield Fault(("cast", i, "name"), message)
        first.setdefault(name, i)


def _names_of_many(scene: object) -> Iterator[Fault]:
    """Find members that are called as a body of `many` is, which have numbers of their own."""
    cast = [member for _, member in _items(_get(scene, "cast"))]
    numbered: dict[str, tuple[str, int, int]] = {}
    for k, (name, member) in enumerate(zip(_names(scene), cast, strict=True)):
        total = getattr(_get(member, "many"), "total", 0)
        numbered |= {f"{name}_{n + 1}": (name, k, total) for n in range(total)}
    for i, member in enumerate(cast):
        own = _get(member, "name")
        if isinstance(own, str) and own in numbered:
            name, k, total = numbered[own]
            message = (
                f"the name '{own}' is taken by a body of cast[{k}], "
                f"whose bodies are called {name}_1 to {name}_{total}"
            )
            yield Fault(("cast", i, "name"), message)


def _materials(scene: object) -> Iterator[Fault]:
    known = _keys(_get(scene, "materials")) | MATERIALS.keys()
    named = [((*place, "material"), name) for place, name in _named_materials(scene)]
    for i, member in _items(_get(scene, "cast")):
        listed = _items(_get(_get(member, "many"), "materials"))
        named += [(("cast", i, "many", "materials", k), name) for k, name in listed]
    for place, name in named:
        if isinstance(name, str) and name not in known:
            yield Fault(place, f"no material is called '{name}', {hint(name, known)}")


def _named_materials(scene: object) -> Iterator[tuple[Place, Any]]:
    yield ("terrain",), _get(_get(scene, "terrain"), "material")
    for key in _keys(_get(scene, "figures")):
        figure = _get(_get(scene, "figures"), key)
        yield ("figures", key), _get(figure, "material")
        nodes = _get(figure, "nodes")
        for node in _keys(nodes):
            yield ("figures", key, "nodes", node), _get(_get(nodes, node), "material")
    for i, member in _items(_get(scene, "cast")):
        yield ("cast", i), _get(member, "material")


def _followed(scene: object) -> Iterator[Fault]:
    known = set(_names(scene))
    for place, cut in _listed_or_alone(_get(scene, "camera")):
        for below, follow in _listed_or_alone(_get(cut, "follow")):
            if isinstance(follow, str) and follow not in known:
                message = f"nobody in the cast is called '{follow}', {hint(follow, known)}"
                yield Fault(("camera", *place, "follow", *below), message)
        parent = _get(cut, "parent")
        if isinstance(parent, str) and (name := parent.partition(".")[0]) not in known:
            message = f"nobody in the cast is called '{name}', {hint(name, known)}"
            yield Fault(("camera", *place, "parent"), message)
        focuses: list[tuple[Place, Any]] = [(("focus",), _get(cut, "focus"))]
        for k, key in _items(_get(cut, "keyframes")):
            focuses.append((("keyframes", k, "focus"), _get(key, "focus")))
        for below, focus in focuses:
            if isinstance(focus, str) and (name := focus.partition(".")[0]) not in known:
                message = f"nobody in the cast is called '{name}', {hint(name, known)}"
                yield Fault(("camera", *place, *below), message)


def _carried(scene: object) -> Iterator[Fault]:
    """Find lamps that nobody carries who is in the cast."""
    known = _names(scene)
    for i, lamp in _items(_get(_get(scene, "light"), "lamps")):
        parent = _get(lamp, "parent")
        if isinstance(parent, str) and (name := parent.partition(".")[0]) not in known:
            message = f"nobody in the cast is called '{name}', {hint(name, known)}"
            yield Fault(("light", "lamps", i, "parent"), message)


def _attached(scene: object) -> Iterator[Fault]:
    names, cast = _names(scene), dict(_items(_get(scene, "cast")))
    for i, member in cast.items():
        places: list[tuple[Place, Any]] = [(("parent",), _get(member, "parent"))]
        for k, hold in _items(_get(member, "held")):
            places.append((("held", k, "by"), _get(hold, "by")))
        group = _get(member, "group")
        places += [(("group", word), _get(group, word)) for word in ("follow", "around")]
        for k, whom in _items(_get(group, "avoid")):
            places.append((("group", "avoid", k), whom))
        for place, whom in places:
            if not isinstance(whom, str):
                continue
            name = whom.partition(".")[0]
            if name not in names:
                message = f"nobody in the cast is called '{name}', {hint(name, names)}"
                yield Fault(("cast", i, *place), message)
            elif name == names[i]:
                yield Fault(("cast", i, *place), f"'{name}' cannot go along with itself")
            elif _get(cast[names.index(name)], "group") is not None:
                message = f"'{name}' is a group, which nobody can go along with"
                yield Fault(("cast", i, *place), message)


def _minded(scene: object) -> Iterator[Fault]:
    """Find behaviours of characters towards nobody who is fit for them."""
    names = _names(scene)
    members = dict(zip(names, (m for _, m in _items(_get(scene, "cast"))), strict=True))
    yield from faults_of_minds(names, members)


def _scripted(scene: object) -> Iterator[Fault]:
    names = _names(scene)
    members = dict(zip(names, (m for _, m in _items(_get(scene, "cast"))), strict=True))
    for i, instruction in _items(_get(scene, "script")):
        when = _get(instruction, "when")
        where: Place = ("script", i, "when")
        yield from faults_of_touch(_get(when, "touch"), (*where, "touch"), members)
        yield from faults_of_hug(_get(when, "hug"), (*where, "hug"), members)
        who = (("who",), _get(instruction, "who"))
        for place, name in (who, (("when", "arrived"), _get(when, "arrived"))):
            if isinstance(name, str) and name not in names:
                message = f"nobody in the cast is called '{name}', {hint(name, names)}"
                yield Fault(("script", i, *place), message)
            elif isinstance(name, str):
                if _thing(members[name]) != "dancer":
                    yield from _asked(name, instruction, ("script", i), place, members)
                elif place == ("who",):
                    do, hangs = _get(instruction, "do"), _get(members[name], "parent") is not None
                    known = _keys(_get(scene, "dances"))
                    yield from faults_of_orders(name, do, ("script", i, "do"), known, hangs)


def _asked(
    name: str, instruction: object, path: Place, place: Place, members: Mapping[str, object]
) -> Iterator[Fault]:
    """Find what a member is told that it cannot do, or waited for that never comes."""
    member, do = members[name], _get(instruction, "do")
    if _get(member, "character") is not None:
        if place == ("who",):
            yield from faults_of_acting(member, name, do, (*path, "do"), members)
            yield from faults_of_urges(member, name, do, (*path, "do"))
        elif (fault := fault_of_thing(member, name, (*path, *place))) is not None:
            yield fault
    elif _thing(member) in UNMOVED:
        yield Fault((*path, *place), f"'{name}' is a {_thing(member)}, which no script moves")
    elif (group := _get(member, "group")) is not None:
        yield from _directed(group, name, instruction, path, place)
    elif not _walks(member) and not _hops(member):
        message = f"'{name}' neither walks nor hops; give it walk: {{}} or pronk: {{}}"
        yield Fault((*path, *place), message)
    elif place == ("who",):
        yield from _told(member, name, instruction, (*path, "do"))


def _walks(member: object) -> bool:
    return (isinstance(member, Mapping) and "walk" in member) or _get(member, "walk") is not None


def _hops(member: object) -> bool:
    return (isinstance(member, Mapping) and "pronk" in member) or _get(member, "pronk") is not None


def _told(member: object, name: str, instruction: object, path: Place) -> Iterator[Fault]:
    """Find what a creature is told that it cannot do, as it goes."""
    do = _get(instruction, "do")
    word = do if isinstance(do, str) else next((w for w in FORMS if _get(do, w) is not None), None)
    if word in PEOPLE_ALONE:
        message = f"'{name}' is a creature; only a child or an adult can be told to {word}"
        yield Fault(path if word == do else (*path, word), message, at_key=word != do)
    elif word in DANCERS_ALONE:
        message = f"'{name}' is a creature; only a dancer can be told to {word}"
        yield Fault(path if word == do else (*path, word), message, at_key=word != do)
    elif word in JUMPS and _get(member, "pose"):
        yield Fault(path, f"'{name}' is posed, and who is posed does not jump; take pose away")
    elif word == "hop" and _walks(member):
        yield Fault(path, f"'{name}' walks; tell it walk, or to jump")
    elif word is not None and not _walks(member) and word not in HOPPING:
        right = "; tell it hop" if word == "walk" else ""
        message = f"'{name}' hops, and can be told {', '.join(HOPPING)}{right}"
        yield Fault(path if word == do else (*path, word), message, at_key=word != do)


def _hopped(scene: object) -> Iterator[Fault]:
    """Find what nobody can jump over."""
    names, cast = _names(scene), dict(_items(_get(scene, "cast")))
    for i, one in _items(_get(scene, "script")):
        whom = _get(_get(one, "do"), "hop_over")
        if not isinstance(whom, str):
            continue
        if whom not in names:
            message = f"nobody in the cast is called '{whom}', {hint(whom, names)}"
        elif whom == _get(one, "who"):
            message = f"'{whom}' cannot jump over itself"
        elif _thing(cast[names.index(whom)]) == "group" or _get(cast[names.index(whom)], "many"):
            message = f"'{whom}' is many things; name a prop, a body or a creature"
        else:
            continue
        yield Fault(("script", i, "do", "hop_over"), message)


def _directed(
    group: object, name: str, instruction: object, path: Place, place: Place
) -> Iterator[Fault]:
    """Find what a script asks of a group that it cannot do."""
    rule = _get(group, "rule")
    if rule not in DIRECTED:
        yield Fault((*path, *place), f"'{name}' is a group that no script moves")
    elif place != ("who",):
        yield Fault((*path, *place), f"'{name}' is a group, which never arrives")
    elif _get(_get(instruction, "do"), "go_to") is None:
        yield Fault((*path, "do"), f"'{name}' is a group; all it can be told is go_to")


def _moods(scene: object) -> Iterator[Fault]:
    known = _keys(_get(scene, "moods")) | MOODS.keys()
    said: list[tuple[Place, Any]] = [
        (("cast", i, "mood"), _get(member, "mood")) for i, member in _items(_get(scene, "cast"))
    ]
    for i, instruction in _items(_get(scene, "script")):
        said.append((("script", i, "do", "mood"), _get(_get(instruction, "do"), "mood")))
    for place, mood in said:
        for name in [mood] if isinstance(mood, str) else sorted(_keys(mood)):
            if name not in known:
                yield Fault(place, f"no mood is called '{name}', {hint(name, known)}")


def _seen(scene: object) -> Iterator[Fault]:
    names, cast = _names(scene), dict(_items(_get(scene, "cast")))
    looks: list[tuple[Place, Any, Any]] = [
        (("cast", i), _get(member, "look_at"), names[i]) for i, member in cast.items()
    ]
    for i, one in _items(_get(scene, "script")):
        looks.append((("script", i, "do"), _get(_get(one, "do"), "look_at"), _get(one, "who")))
    people = {name for i, name in enumerate(names) if _get(cast.get(i), "character") is not None}
    for place, whom, who in looks:
        if not isinstance(whom, str) or who in people:
            continue
        if whom not in names:
            message = f"nobody in the cast is called '{whom}', {hint(whom, names)}"
        elif whom == who:
            message = f"'{whom}' cannot look at itself"
        elif (what := _thing(cast[names.index(whom)])) is not None or whom in people:
            what = what or "character"
            message = f"'{whom}' is a {what}; give the place that is to be looked at, [x, y, z]"
        else:
            continue
        yield Fault((*place, "look_at"), message)


def _voiced(scene: object) -> Iterator[Fault]:
    """Find voices and thresholds that no sound of the scene will ever have."""
    sound = _get(scene, "sound")
    whose: list[tuple[Place, Any]] = []
    for i, voice in _items(_get(sound, "voices")):
        when, place = _get(voice, "when"), ("sound", "voices", i, "when")
        whose.append(((*place, "who"), _get(when, "who")))
        cause = _get(when, "cause")
        if isinstance(cause, str) and not any(matches_pattern(name, cause) for name in CAUSES):
            yield Fault((*place, "cause"), f"nothing is caused by '{cause}', {hint(cause, CAUSES)}")
    for cause in CAUSES:
        words = _get(_get(sound, "detect"), cause)
        whose.append((("sound", "detect", cause, "who"), _get(words, "who")))
    for at, who in whose:
        if isinstance(who, str) and who.strip("*") and not _is_meant(who, scene):
            names = _names(scene)
            yield Fault(at, f"nobody in the cast is called '{who}', {hint(who, names)}")


def _is_meant(who: str, scene: object) -> bool:
    """Tell whether a pattern is for anybody; bodies and groups have numbers behind their names."""
    cast = [member for _, member in _items(_get(scene, "cast"))]
    for name, member in zip(_names(scene), cast, strict=True):
        several = _get(member, "many") is not None or _get(member, "group") is not None
        if matches_pattern(name, who) or (several and who.startswith(f"{name}_")):
            return True
    return False


def _thing(member: object) -> str | None:
    """Return what a member is that is no creature."""
    things = {"prop": "prop", "body": "body", "group": "group", "many": "body", "dancer": "dancer"}
    return next((things[word] for word in things if _get(member, word) is not None), None)


def _names(scene: object) -> list[str]:
    return names_of([called(member) for _, member in _items(_get(scene, "cast"))])


def _listed_or_alone(thing: object) -> list[tuple[Place, Any]]:
    if isinstance(thing, list | tuple):
        return [((i,), item) for i, item in enumerate(thing)]
    return [((), thing)]


def _get(thing: object, key: str) -> Any:
    if isinstance(thing, Mapping):
        return thing.get(key)
    if isinstance(thing, BaseModel):
        return getattr(thing, key, None)
    return None


def _keys(thing: object) -> set[str]:
    return {key for key in thing if isinstance(key, str)} if isinstance(thing, Mapping) else set()


def _items(thing: object) -> Iterator[tuple[int, Any]]:
    return iter(enumerate(thing if isinstance(thing, list | tuple) else ()))
