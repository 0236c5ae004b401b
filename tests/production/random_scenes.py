"""Random scenes that mix all kinds of performers with all verbs, cameras and lights.

A scene is drawn from its seed alone: terrain, cast on a grid of start places, and a script whose
targets are members, their parts, and places. Orders are drawn from `VERBS`, events from `EVENTS`,
so that new ones are drawn without a change here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any, get_args

from pipeline.errors import SceneError, SimulationError
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Scene, read_scene
from pipeline.spec.behaviour import NAMES
from pipeline.spec.character_kinds import PEOPLE
from pipeline.spec.events import EVENTS
from pipeline.spec.expression import Shown
from pipeline.spec.mood import MOODS
from pipeline.spec.order_support import performer_kind
from pipeline.spec.targets import JOINTED_CHARACTER, TargetKind, kind_of_target
from pipeline.spec.verbs import DANCER, GROUP, PERSON, VERBS, verbs_of

Block = dict[str, Any]

DURATION = 2.0
"""Length of a scene [s]."""

LAST_ORDER = 1.7
"""Orders come no later, so that the film's end cuts none off before it is given [s]."""

SPACING = 2.6
"""Distance of start places: nobody is as long at the scales below [m]."""

SIDE = 5
"""Start places along each side of the ground."""

GROUND = 24.0
"""Side of the ground [m]."""


PARTS = {
    **dict.fromkeys((*PEOPLE, "ragdoll"), ("head", "hand_l", "foot_r", "pelvis")),
    "dancer": ("head", "hand_l", "pelvis"),
    "creature": ("body",),
}
"""Parts that kinds of members have for certain."""

DRAWS = 6
"""Scenes that are drawn for a seed until one is accepted."""

SEEDS = 100_000
"""Seeds apart of the draws for one seed."""


def random_scene(seed: int, cheap: bool = False) -> Block:
    """Return the scene of a seed, as its author would write it.

    Args:
        seed: of all its choices.
        cheap: whether to leave out what needs compiled code: people, their things, and bodies.
    """
    draft = _Draft(Random(seed))
    draft.draw_cast(cheap)
    rng = draft.rng
    return {
        "pronk": 1,
        "duration": DURATION,
        "seed": seed,
        "terrain": _terrain(rng),
        "cast": draft.cast,
        "places": draft.places,
        "script": draft.script(),
        "camera": _camera(draft),
        "light": _light(draft),
        "film": {"preset": "draft", "size": [96, 54], "samples": 4},
    }


def drawn_scene(seed: int, cheap: bool = False) -> tuple[str, Scene, int]:
    """Return the first scene of a seed that the checks accept, as text and read.

    Returns:
        The text, the scene, and how many before it were refused.

    Raises:
        AssertionError: a refusal has no place, or all draws are refused.
    """
    for refused in range(DRAWS):
        text = scene_text(random_scene(seed + refused * SEEDS, cheap))
        try:
            scene = read_scene(text)
            Simulation(scene)
        except SceneError as error:
            if not all(problem.path for problem in error.problems):
                raise AssertionError(f"a refusal without a place:\n{text}") from error
        except SimulationError as error:
            raise AssertionError(f"a failure at the start:\n{text}") from error
        else:
            return text, scene, refused
    raise AssertionError(f"all of {DRAWS} scenes of seed {seed} are refused")


def scene_text(scene: Block) -> str:
    """Return a scene as a file that can be read, one key a line."""
    rows = []
    for key, value in scene.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows += [f"{key}:", *(f"  - {json.dumps(item)}" for item in value)]
        else:
            rows.append(f"{key}: {json.dumps(value)}")
    return "\n".join(rows) + "\n"


# --- cast -------------------------------------------------------------------------------


@dataclass
class _Draft:
    """A scene while it is drawn.

    Attributes:
        rng: source of all choices.
        cast: members so far.
        slots: start places that are free, [x, z].
        places: places by name.
    """

    rng: Random
    cast: list[Block] = field(default_factory=list)
    slots: list[tuple[float, float]] = field(default_factory=list)
    places: Block = field(default_factory=dict)

    def __post_init__(self) -> None:
        half = SPACING * (SIDE - 1) / 2
        steps = [SPACING * k - half for k in range(SIDE)]
        self.slots = [(x, z) for x in steps for z in steps]
        self.rng.shuffle(self.slots)
        self.places = {
            "gate": self.point(),
            "pond": self.point(),
            "high": [self.number(-4, 4), self.number(0.2, 2.5), self.number(-4, 4)],
        }

    def draw_cast(self, cheap: bool) -> None:
        """Draw two to six members, at least one of whom follows orders."""
        kinds = CHEAP if cheap else MEMBERS
        leads = CHEAP_LEADS if cheap else LEADS
        makers = [self.rng.choice(leads)]
        makers += self.rng.choices(kinds, k=self.rng.randint(1, 5))
        for number, maker in enumerate(makers):
            x, z = self.slots.pop()
            member = maker(self, [round(x, 2), round(z, 2)])
            self.cast.append({"name": f"m{number}", **member})

    def number(self, low: float, high: float) -> float:
        """Return a number of two decimals."""
        return round(self.rng.uniform(low, high), 2)

    def point(self) -> list[float]:
        """Return a place on the ground, [x, z] [m]."""
        return [self.number(-5, 5), self.number(-5, 5)]

    def names(
        self, kind: TargetKind, members: Sequence[Block], with_parts: bool = False
    ) -> list[str]:
        """Return the names of members that fit as targets.

        Args:
            kind: that they must have.
            members: to choose from.
            with_parts: whether to add parts, such as one bird of a flock.
        """
        found = []
        for member in members:
            name, own = member["name"], kind_of_target(member)
            if own == "many":
                found += [f"{name}_1"] if "body" in kind.kinds and not kind.shapes else []
            elif own == "group":
                found += [f"{name}.0"] if with_parts else []
            elif own in kind.kinds and _has_shape(member, own, kind):
                found.append(name)
                if with_parts and own in PARTS:
                    found.append(f"{name}.{self.rng.choice(PARTS[own])}")
        return found

    @property
    def performers(self) -> dict[str, str]:
        """Kinds of the members that follow orders, by name."""
        kinds = {
            member["name"]: performer_kind(member)
            for member in self.cast
            if member.get("figure") != DEAF
        }
        return {name: kind for name, kind in kinds.items() if kind is not None}

    def script(self) -> list[Block]:
        """Return up to four orders for each of the performers."""
        rows, performers = [], self.performers
        for member in self.cast:
            if member["name"] not in performers:
                continue
            for _ in range(self.rng.randint(1, 4)):
                do = _order(self, member, performers[member["name"]])
                if do is not None:
                    rows.append({**self.moment(), "who": member["name"], "do": do})
        return rows

    def moment(self) -> Block:
        """Return a time, or an event to wait for."""
        event = self.rng.choice(list(EVENTS)) if self.rng.random() < 0.3 else None
        when = self.event(event) if event else None
        return {"at": self.number(0, LAST_ORDER)} if when is None else {"when": when}

    def event(self, event: str) -> Block | None:
        """Return an event of a kind, None if no members fit it."""
        rng = self.rng
        plain = [m["name"] for m in self.cast if "group" not in m]
        acting = self.performers
        if event in ("arrived", "failed"):
            able = [name for name, kind in acting.items() if kind != GROUP]
            return {event: rng.choice(able)} if able else None
        if event == "served":
            people = [name for name, kind in acting.items() if kind == PERSON]
            return {event: rng.choice(people)} if people else None
        if event == "hug":
            hugging = [name for name, kind in acting.items() if kind == PERSON]
            hugged = self.names(JOINTED_CHARACTER, self.cast)
            pairs = [[one, other] for one in hugging for other in hugged if one != other]
            return {event: rng.choice(pairs)} if pairs else None
        if event == "touch":
            return {event: rng.sample(plain, 2)} if len(plain) > 1 else None
        if event == "near":
            pair = [*rng.sample(plain, 1), rng.choice([*self.places, *plain])]
            return {event: pair, "within": self.number(0.2, 3)} if pair[0] != pair[1] else None
        assert event in ("fell", "at_rest"), f"draw the event {event} here as well"
        return {event: rng.choice(plain)}


def _has_shape(member: Block, own: str, kind: TargetKind) -> bool:
    return not kind.shapes or own not in ("prop", "body") or member[own]["shape"] in kind.shapes


DEAF = "inchworm"
"""Figure that goes straight on: it follows neither paths nor scripts."""

WALKING = (
    *("beetle", "spider", "scorpion", "horse", "camel", "antelope"),
    *("ostrich", "person", "centipede", "tripod", DEAF),
)
HOPPING = ("hopper", "kangaroo", "antelope", "beetle", "ostrich")


def _walker(draft: _Draft, at: list[float]) -> Block:
    rng, walk = draft.rng, {}
    if rng.random() < 0.4:
        walk["path"] = [draft.point() for _ in range(rng.randint(1, 3))]
        walk["repeat"] = rng.choice(["once", "loop", "back and forth"])
    if rng.random() < 0.3:
        walk["gait"] = rng.choice(["trot", "wave"])
    if rng.random() < 0.3:
        walk["swing"] = rng.choice(["spline", "passive", "least-effort"])
    figure = rng.choice(WALKING)
    walk = {} if figure == DEAF else walk
    member = {"figure": figure, "at": at, "scale": draft.number(0.5, 0.8), "walk": walk}
    member["heading_deg"] = draft.number(-180, 180)
    if rng.random() < 0.3:
        member["mood"] = {rng.choice(list(MOODS)): draft.number(0.2, 1)}
    return member


def _hopper(draft: _Draft, at: list[float]) -> Block:
    rng, pronk = draft.rng, {}
    if rng.random() < 0.5:
        pronk = {"distance": draft.number(0.3, 1), "height": draft.number(0.2, 0.6)}
    if rng.random() < 0.2:
        pronk = {"land_at": [[at[0] + 0.6, at[1]], [at[0] + 1.2, at[1]]]}
    if rng.random() < 0.2:
        pronk["fall"] = rng.choice(["ragdoll", "rigid"])
    place = [at[0], draft.number(0.1, 1), at[1]] if rng.random() < 0.2 else at
    figure = rng.choice(HOPPING)
    return {"figure": figure, "at": place, "scale": draft.number(0.5, 0.8), "pronk": pronk}


def _statue(draft: _Draft, at: list[float]) -> Block:
    return {"figure": draft.rng.choice(("robot_arm", "beetle", "person")), "at": at, "scale": 0.7}


def _person(draft: _Draft, at: list[float]) -> Block:
    rng = draft.rng
    member: Block = {"character": rng.choice(["child", "adult"]), "at": at}
    member["heading_deg"] = draft.number(-180, 180)
    if rng.random() < 0.4:
        names = rng.sample(("anxiety", "curiosity", "aggression", "speed"), 2)
        member["traits"] = {name: draft.number(0, 1) for name in names}
    elif rng.random() < 0.3:
        member["behaviours"] = [rng.choice([{"wander": 2}, {"keep_off": 1}, {"rest": 0.5}])]
    return member


def _thing(draft: _Draft, at: list[float]) -> Block:
    rng = draft.rng
    kind = rng.choice(["ragdoll", "ball", "merry-go-round", "box", "bench"])
    member: Block = {"character": kind, "at": at, "heading_deg": draft.number(-180, 180)}
    if kind in ("ragdoll", "ball", "box") and rng.random() < 0.4:
        member["at"] = [at[0], draft.number(0.2, 1), at[1]]
        member["velocity"] = [draft.number(-1, 1), 0, draft.number(-1, 1)]
    return member


def _limp(draft: _Draft, at: list[float]) -> Block:
    return {"character": draft.rng.choice(["child", "adult"]), "at": at, "limp": True}


def _dancer(draft: _Draft, at: list[float]) -> Block:
    rng = draft.rng
    controller = rng.choice(["joint-torque", "force-field"])
    dance = rng.choice(["macarena", "waving", "clapping", "conducting"])
    build = rng.choice(["torso", "adult", "child"])
    return {"dancer": build, "dance": dance, "controller": controller, "at": at, "start": 0.3}


def _prop_shape(draft: _Draft) -> Block:
    size = [draft.number(0.2, 0.6) for _ in range(3)]
    return draft.rng.choice(
        [
            {"shape": "box", "size": size},
            {"shape": "ball", "radius": 0.2},
            {"shape": "cylinder", "radius": 0.2, "height": 0.45},
            {"shape": "cone", "radius": 0.25, "top": 0.1},
            {"shape": "gear", "teeth": 16},
        ]
    )


def _prop(draft: _Draft, at: list[float]) -> Block:
    rng, high = draft.rng, [at[0], draft.number(0.3, 1.2), at[1]]
    member: Block = {"prop": _prop_shape(draft), "at": at}
    way = rng.choice(["still", "keys", "velocity", "driven", "force", "falls", "turns", "child"])
    if way == "keys":
        end = [high[0] + draft.number(-0.5, 0.5), high[1], high[2]]
        del member["at"]
        member["keyframes"] = [
            {"at": 0, "position": high},
            {"at": 1, "position": end, "rotation_deg": [0, 90, 0]},
        ]
        if rng.random() < 0.5:
            member["keyframes"].append({"at": 1.5, "position": high, "rotation_deg": [0, 0, 0]})
            member["repeat"] = True
    elif way == "velocity":
        member |= {"at": high, "velocity": [draft.number(-0.5, 0.5), 0, 0.1]}
    elif way == "driven":
        member |= {
            "at": high,
            "velocity": [{"at": 0, "linear": [0.3, 0, 0]}, {"at": 1, "spin_deg": [0, 90, 0]}],
        }
    elif way == "force":
        keys = [{"at": 0, "force": [2, 0, 0]}, {"at": 1, "torque": [0, 0.1, 0]}]
        member |= {"at": high, "force": {"keys": keys, "drag": 1.0, "turning_drag": 0.1}}
    elif way == "falls":
        member |= {"at": high, "falls": draft.number(0, 1)}
    elif way == "turns":
        member["spin_deg"] = [0, draft.number(-180, 180), 0]
    elif way == "child" and (carriers := [m for m in draft.cast if "prop" in m]):
        member |= {"parent": rng.choice(carriers)["name"], "at": [0, 0.5, 0]}
    return member


def _body_shape(draft: _Draft) -> Block:
    points = [[draft.number(-0.3, 0.3) for _ in range(3)] for _ in range(9)]
    return draft.rng.choice(
        [
            {"shape": "box", "size": [0.4, 0.3, 0.3]},
            {"shape": "brick"},
            {"shape": draft.rng.choice(["cube", "die"]), "size": 0.3},
            *({"shape": f"{solid}hedron"} for solid in ("tetra", "octa", "dodeca", "icosa")),
            {"shape": "prism", "sides": 5},
            {"shape": "pyramid", "sides": 4},
            {"shape": "sphere", "radius": 0.15, "bounciness": 0.7},
            {"shape": "hull", "points": points},
        ]
    )


def _body(draft: _Draft, at: list[float]) -> Block:
    rng, shape = draft.rng, _body_shape(draft)
    shape["collide"] = rng.choice(["terrain", "all"])
    if shape["collide"] == "terrain" and rng.random() < 0.2:
        shape["soft"] = 0.1
    member: Block = {"body": shape, "at": at}
    if rng.random() < 0.5:
        member["at"] = [at[0], draft.number(0.5, 2), at[1]]
        member["velocity"] = [draft.number(-2, 2) for _ in range(3)]
        member["spin_deg"] = [draft.number(-200, 200) for _ in range(3)]
    return member


def _many(draft: _Draft, at: list[float]) -> Block:
    shape = draft.rng.choice(["brick", "die", "sphere", "octahedron", "prism"])
    layouts: Sequence[Block] = (
        {"of": "brick", "rows": 3, "columns": 3},
        {"of": {"shape": "box", "size": [0.2, 0.2, 0.2]}, "layout": "pyramid", "rows": 3},
        {"of": "die", "layout": "stack", "count": 4},
        {"of": {"shape": "box", "size": [0.05, 0.3, 0.15]}, "layout": "row", "count": 6},
        {"of": shape, "layout": "heap", "count": 6},
    )
    return {"many": draft.rng.choice(layouts), "at": at}


def _group(draft: _Draft, at: list[float]) -> Block:
    rng = draft.rng
    rule = rng.choice(["flock", "school", "swarm", "rain", "fire", "grass"])
    group: Block = {"rule": rule, "count": rng.randint(3, 30)}
    targets = [m["name"] for m in draft.cast if "group" not in m and "many" not in m]
    if targets and rng.random() < 0.5:
        key = {"flock": "follow", "school": "follow", "swarm": "around"}.get(rule)
        group |= {key: rng.choice(targets)} if key else {}
    return {
        "group": group,
        "at": [at[0], 2.0, at[1]] if rule in ("flock", "school", "swarm") else at,
    }


Maker = Callable[[_Draft, list[float]], Block]

CHEAP_LEADS: Sequence[Maker] = (_walker, _walker, _hopper)
CHEAP: Sequence[Maker] = (_walker, _hopper, _statue, _prop, _prop, _group)
LEADS: Sequence[Maker] = (_walker, _hopper, _person, _person, _person, _dancer)
MEMBERS: Sequence[Maker] = (
    *(_walker, _hopper, _statue, _person, _person, _thing, _thing, _limp),
    *(_dancer, _prop, _prop, _body, _body, _many, _group),
)


# --- orders -----------------------------------------------------------------------------

ON_GROUND = ("go_to", "carry")
"""Verbs whose places are on the ground, [x, z]; those of others are [x, y, z]."""

WHOLE = ("hop_over", "grab", "carry", "throw", "kick", "hug", "grapple", "sit")
"""Keys that name members alone; the others may name a part of one as well."""

TRIES = 8
"""Verbs that are tried for one order until one has a target."""


def _order(draft: _Draft, member: Block, performer: str) -> Any:
    """Return an order that the performer can follow, None if none that is drawn has a target."""
    for _ in range(TRIES):
        verb = draft.rng.choice(verbs_of(performer))
        targets = {key: _target(draft, verb, key, member, performer) for key in VERBS[verb].targets}
        if verb == "sit" and (targets["sit"] is None or draft.rng.random() < 0.5):
            return "sit"
        settings = SETTINGS[verb](draft, member) if verb in SETTINGS else {}
        if None not in targets.values() and settings is not None:
            return {**targets, **settings} or verb
    return None


def _target(draft: _Draft, verb: str, key: str, member: Block, performer: str) -> Any:
    """Return a member, a part of one, or a place that fits; None if there is none."""
    rng, kind = draft.rng, VERBS[verb].targets[key]
    if performer == DANCER and key == "reach":
        x, z = member["at"]
        return [x + 0.35, draft.number(0.9, 1.2), z + draft.number(-0.2, 0.2)]
    others = [other for other in draft.cast if other is not member]
    found: list[Any] = draft.names(kind, others, with_parts=key not in WHOLE)
    if "place" in kind.kinds:
        x, z = draft.point()
        point = [x, z] if verb in ON_GROUND else [x, draft.number(0.2, 2), z]
        found += [rng.choice(list(draft.places)), point]
    return rng.choice(found) if found else None


def _jump(draft: _Draft, member: Block) -> Block:
    jumps = [{}, {"distance": 0.5, "height": 0.3}, {"height": 0.2}, {"land_at": draft.point()}]
    return {"jump": draft.rng.choice(jumps)}


def _urge(draft: _Draft, member: Block) -> Block | None:
    """Return an urge, None of somebody who does only what it is told."""
    if "traits" not in member and "behaviours" not in member:
        return None
    return {"urge": {draft.rng.choice(NAMES): draft.number(-1, 1)}}


def _hand(draft: _Draft, member: Block) -> Block:
    return draft.rng.choice([{}, {"hand": "left"}, {"hand": "both"}])


def _dance(draft: _Draft, member: Block) -> Block:
    return {"dance": member["dance"], **draft.rng.choice([{}, {"bars": 1}, {"tempo_bpm": 100}])}


SETTINGS: dict[str, Callable[[_Draft, Block], Block | None]] = {
    "turn_deg": lambda draft, _: {"turn_deg": draft.number(-180, 180)},
    "speed": lambda draft, _: {"speed": draft.number(0.2, 3)},
    "wait": lambda draft, _: {"wait": draft.number(0.1, 1)},
    "gait": lambda draft, _: {"gait": draft.rng.choice(["trot", "wave"])},
    "mood": lambda draft, _: {"mood": {draft.rng.choice(list(MOODS)): draft.number(0, 1)}},
    "look": lambda *_: {"look": "ahead"},
    "follow": lambda draft, _: {"gap": draft.number(0, 2)},
    "flee": lambda draft, _: {"distance": draft.number(1, 6)},
    "avoid": lambda draft, _: {"distance": draft.number(0.5, 3)},
    "jump": _jump,
    "reach": _hand,
    "grab": _hand,
    "carry": _hand,
    "let_go": lambda draft, _: {"let_go": draft.rng.choice(["left", "right", "both"])},
    "kick": lambda draft, _: {"speed": draft.number(1, 10)},
    "urge": _urge,
    "express": lambda draft, _: {"express": draft.rng.choice(get_args(Shown))},
    "dance": _dance,
}
"""Settings of orders besides their targets, by verb."""


# --- ground, camera and light -----------------------------------------------------------


def _terrain(rng: Random) -> Any:
    """Return a ground; start places are the same on all of them."""
    coarse = {"size": [GROUND, GROUND], "cells": [96, 96]}
    fine = {"size": [GROUND, GROUND], "cells": [240, 240]}
    level = {"start": -2.0}
    of = [{"kind": "stairs", **level}, {"kind": "fractal", "height": 0.1}]
    return rng.choice(
        [
            {"kind": "flat", **coarse},
            {"kind": "flat", **coarse, "footprints": True},
            {"kind": "hills", **coarse},
            {"preset": "dunes", **coarse},
            {"preset": "meadow", **coarse, "polygons": "quads"},
            {"kind": "fractal", "height": 0.8, **coarse},
            {"preset": "rocks", **coarse},
            {"kind": "boulders", **fine},
            {"kind": "stairs", **fine, **level},
            {"kind": "ramp", **fine, **level, "heading_deg": 30},
            {"kind": "ditches", **fine, **level},
            {"kind": "stones", **fine, **level, "diameter": 0.6, "gap": 0.3},
            {"kind": "sum", "of": of, **fine},
        ]
    )


def _camera(draft: _Draft) -> Any:
    """Return one camera, or two cuts."""
    if draft.rng.random() < 0.25:
        return [_cut(draft), {"start": 1.0, **_cut(draft)}]
    return _cut(draft)


def _cut(draft: _Draft) -> Block:
    rng = draft.rng
    name = rng.choice([m["name"] for m in draft.cast])
    views = ["three-quarter", "side", "front", "back", "top"]
    eye = [draft.number(-8, 8), draft.number(2, 5), draft.number(6, 9)]
    return rng.choice(
        [
            {},
            {"follow": name},
            {"follow": [m["name"] for m in draft.cast]},
            {"view": rng.choice(views)},
            {"follow": name, "view": rng.choice(views), "distance": draft.number(1, 8)},
            {"follow": name, "elevation_deg": draft.number(-10, 60), "fov_deg": 50},
            {"orbit": draft.number(-60, 60)},
            {"dolly": draft.number(-1, 1)},
            {"truck": draft.number(-1, 1), "crane": draft.number(0, 1)},
            {"at": eye, "look_at": [0, 0.5, 0]},
            {"at": eye, "follow": name, "aperture": 2.8},
            {"at": [0, 2, 0], "velocity": [0.5, 0, 0], "follow": name},
            {"parent": name, "at": [-2, 1.5, 0], "steady": 0.3},
            {"keyframes": [{"at": 0, "position": eye}, {"at": 2, "position": [6, 2, 6]}]},
        ]
    )


def _light(draft: _Draft) -> Any:
    """Return a preset or an hour, and perhaps a lamp."""
    names = ["day", "noon", "golden hour", "dawn", "dusk", "night", "overcast", "studio"]
    lamp = {"at": [draft.number(-4, 4), draft.number(2, 4), draft.number(-4, 4)]}
    hour = {"sun": {"hour": draft.number(0, 24), "clouds": draft.number(0, 1)}}
    choices = [*names, hour, {"preset": draft.rng.choice(names), "lamps": [lamp]}]
    return draft.rng.choice([*choices, {"lamps": [lamp]}])
