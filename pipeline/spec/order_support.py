"""Order support: which performers can be given which orders by the script.

Performers and orders are read typed or raw (see `partial_scene`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel

from pipeline.spec.behaviour import ANY_CHARACTER, JOINTED_CHARACTER, NAMES, TargetKind
from pipeline.spec.character import PARTS, PEOPLE, Kind
from pipeline.spec.group import DIRECTED
from pipeline.spec.model_base import Fault
from pipeline.spec.partial_scene import (
    Path,
    cast_by_name,
    given_keys,
    items_of,
    kind_of,
    text_keys,
    unknown_name,
    value_at,
)
from pipeline.spec.script import FORMS, PLAIN_ORDERS
from pipeline.spec.suggestions import hint

CHARACTER_ONLY = (
    *("reach", "grab", "carry", "throw", "kick", "let_go", "hug", "grapple"),
    *("sit", "stand", "freeze", "urge"),
)
CHARACTER_ORDERS = (
    *("go_to", "follow", "chase", "flee", "avoid"),
    *("turn_deg", "walk", "stop", "wait", "speed", "look_at", "look"),
    *CHARACTER_ONLY,
)
DANCER_ONLY = ("dance",)
DANCER_ORDERS = ("dance", "stop", "freeze", "wait", "reach", "let_go", "look_at", "look")
JUMP_ORDERS = ("hop_over", "jump")
HOPPER_ORDERS = (
    *("hop", "stop", *JUMP_ORDERS),
    *("go_to", "turn_deg", "speed", "wait", "look_at", "look"),
)
"""Orders of a creature that hops and does not walk."""


def orders_by_performer() -> dict[str, tuple[str, ...]]:
    """Return the orders that each sort of performer can be given."""
    others = {*CHARACTER_ONLY, *DANCER_ONLY, "hop"}
    walker_orders = tuple(order for order in (*PLAIN_ORDERS, *FORMS) if order not in others)
    return {
        "walkers": walker_orders,
        "hoppers": HOPPER_ORDERS,
        "people": CHARACTER_ORDERS,
        "dancers": DANCER_ORDERS,
    }


UNMOVED = ("prop", "body")
"""Kinds of members that follow no script."""

UNKNOWN_KIND = "unknown"
"""A kind of character that does not exist, which is reported where it is named."""

SEAT = TargetKind(("box", "bench"), "a box or a bench")
CHARACTER_OR_PLACE = TargetKind((), "a character, or a place [x, y, z]")

ORDER_TARGETS: Mapping[str, TargetKind] = {
    "hug": JOINTED_CHARACTER,
    "grapple": JOINTED_CHARACTER,
    "sit": SEAT,
    "grab": ANY_CHARACTER,
    "reach": CHARACTER_OR_PLACE,
    "look_at": CHARACTER_OR_PLACE,
}
"""What characters can be ordered to do something to."""

TOUCHABLE = ("character", "prop", "figure", "dancer")
"""Kinds of members that characters feel; of bodies those that collide with all."""

Cast = Mapping[str, object]


def faults_of_script(scene: object) -> Iterator[Fault]:
    """Find orders to performers that do not exist or cannot follow them."""
    cast = cast_by_name(scene)
    dances = text_keys(value_at(scene, "dances"))
    for i, instruction in items_of(value_at(scene, "script")):
        when, path = value_at(instruction, "when"), ("script", i)
        yield from _faults_of_touch(value_at(when, "touch"), (*path, "when", "touch"), cast)
        yield from _faults_of_hug(value_at(when, "hug"), (*path, "when", "hug"), cast)
        name, do = value_at(instruction, "who"), value_at(instruction, "do")
        if isinstance(name, str) and name not in cast:
            yield unknown_name(name, cast, (*path, "who"))
        elif isinstance(name, str):
            yield from _faults_of_order(name, do, path, cast, dances)
        arrived = value_at(when, "arrived")
        if isinstance(arrived, str):
            yield from _faults_of_arrival(arrived, (*path, "when", "arrived"), cast)


def _faults_of_order(
    name: str, do: object, path: Path, cast: Cast, dances: Collection[str]
) -> Iterator[Fault]:
    """Find faults of the order `do` to a member of the cast."""
    member = cast[name]
    who, order = (*path, "who"), (*path, "do")
    kind = kind_of(member)
    if kind == "dancer":
        hangs = value_at(member, "parent") is not None
        yield from _faults_of_dancer(name, do, order, dances, hangs)
    elif kind == "character":
        if (fault := _fault_of_thing(member, name, who)) is not None:
            yield fault
        else:
            yield from _faults_of_character(name, do, order, cast)
        yield from _faults_of_urges(member, name, do, order)
    elif kind in UNMOVED:
        yield Fault(who, f"'{name}' is a {kind}, which no script moves")
    elif kind == "group":
        if value_at(value_at(member, "group"), "rule") not in DIRECTED:
            yield Fault(who, f"'{name}' is a group that no script moves")
        elif value_at(do, "go_to") is None:
            yield Fault(order, f"'{name}' is a group, which can only go_to")
    elif not _walks(member) and not _hops(member):
        yield _fault_of_standing(name, who)
    else:
        yield from _faults_of_creature(member, name, do, order)


def _faults_of_arrival(name: str, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find orders that wait for an arrival that never comes."""
    if name not in cast:
        yield unknown_name(name, cast, path)
        return
    member, kind = cast[name], kind_of(cast[name])
    if kind == "character":
        if (fault := _fault_of_thing(member, name, path)) is not None:
            yield fault
    elif kind in UNMOVED:
        yield Fault(path, f"'{name}' is a {kind}, which no script moves")
    elif kind == "group":
        is_directed = value_at(value_at(member, "group"), "rule") in DIRECTED
        reason = ", which never arrives" if is_directed else " that no script moves"
        yield Fault(path, f"'{name}' is a group{reason}")
    elif kind != "dancer" and not _walks(member) and not _hops(member):
        yield _fault_of_standing(name, path)


def _fault_of_standing(name: str, path: Path) -> Fault:
    return Fault(path, f"'{name}' neither walks nor hops; give it walk: {{}} or pronk: {{}}")


def _walks(member: object) -> bool:
    return _has(member, "walk")


def _hops(member: object) -> bool:
    return _has(member, "pronk")


def _has(member: object, block: str) -> bool:
    """Return whether a member has a block, which may be empty as long as it is raw."""
    return (isinstance(member, Mapping) and block in member) or value_at(member, block) is not None


def _order_of(do: object) -> str | None:
    """Return the order in `do`: its word, or the first of its keys, orders of people first."""
    if isinstance(do, str):
        return do
    keys = given_keys(do)
    if isinstance(do, BaseModel):
        return next(iter(keys), None)
    return next(iter(sorted(keys, key=lambda key: key not in CHARACTER_ORDERS)), None)


def _at_order(do: object, order: str, path: Path, message: str) -> Fault:
    """Return a fault at the key of an order, or at the word that it is."""
    if isinstance(do, str):
        return Fault(path, message)
    return Fault((*path, order), message, at_key=True)


def _faults_of_creature(member: object, name: str, do: object, path: Path) -> Iterator[Fault]:
    order = do if isinstance(do, str) else next((k for k in FORMS if _is_given(do, k)), None)
    if order is None:
        return
    if order in CHARACTER_ONLY:
        message = f"'{name}' is a creature; only a child or an adult can {order}"
        yield _at_order(do, order, path, message)
    elif order in DANCER_ONLY:
        yield _at_order(do, order, path, f"'{name}' is a creature; only a dancer can {order}")
    elif order in JUMP_ORDERS and value_at(member, "pose"):
        yield Fault(path, f"'{name}' has a pose, which conflicts with jumps; remove pose")
    elif order == "hop" and _walks(member):
        yield Fault(path, f"'{name}' walks; order walk or jump")
    elif not _walks(member) and order not in HOPPER_ORDERS:
        instead = "; order hop" if order == "walk" else ""
        message = f"'{name}' hops, and can {', '.join(HOPPER_ORDERS)}{instead}"
        yield _at_order(do, order, path, message)


def _is_given(do: object, key: str) -> bool:
    return value_at(do, key) is not None


def faults_of_hop_targets(scene: object) -> Iterator[Fault]:
    """Find orders to hop over what does not exist or is many things."""
    cast = cast_by_name(scene)
    for i, instruction in items_of(value_at(scene, "script")):
        name = value_at(value_at(instruction, "do"), "hop_over")
        if not isinstance(name, str):
            continue
        path = ("script", i, "do", "hop_over")
        if name not in cast:
            yield unknown_name(name, cast, path)
        elif name == value_at(instruction, "who"):
            yield Fault(path, f"'{name}' cannot jump over itself")
        elif kind_of(cast[name]) == "group" or value_at(cast[name], "many"):
            yield Fault(path, f"'{name}' is many things; name a prop, a body or a creature")


def _faults_of_character(name: str, do: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find orders that a child or an adult cannot carry out."""
    order = _order_of(do)
    if order is not None and order not in CHARACTER_ORDERS:
        message = f"'{name}' is a person, who can {', '.join(CHARACTER_ORDERS)}"
        yield _at_order(do, order, path, message)
    for key, fitting in ORDER_TARGETS.items():
        if isinstance(target := value_at(do, key), str):
            yield from faults_of_target(target, name, fitting, (*path, key), cast)
    part, target = value_at(do, "part"), value_at(do, "grab")
    if isinstance(part, str) and isinstance(target, str) and target in cast:
        if value_at(cast[target], "character") not in JOINTED_CHARACTER.kinds:
            message = f"'{target}' has no named parts; remove this"
            yield Fault((*path, "part"), message, at_key=True)
        elif part not in PARTS:
            message = f"no part of '{target}' is called '{part}', {hint(part, PARTS)}"
            yield Fault((*path, "part"), message)


def _fault_of_thing(member: object, name: str, path: Path) -> Fault | None:
    """Find a character that follows no script: a thing, or a limp person."""
    kind = _character_kind(member)
    if kind not in (*PEOPLE, UNKNOWN_KIND):
        return Fault(path, f"'{name}' is a {kind}, which no script moves")
    if value_at(member, "limp") is True:
        return Fault(path, f"'{name}' is limp, and follows no script")
    return None


def _faults_of_urges(member: object, name: str, do: object, path: Path) -> Iterator[Fault]:
    """Find urges of a character without behaviours, and urges of unknown behaviours."""
    urges = value_at(do, "urge")
    if not isinstance(urges, Mapping):
        return
    if not value_at(member, "behaviours") and value_at(member, "traits") is None:
        message = f"'{name}' does only what it is told; give it traits: {{}} to act by itself"
        yield Fault((*path, "urge"), message, at_key=True)
    for key in urges:
        if key not in NAMES:
            message = f"no behaviour is called '{key}', {hint(str(key), NAMES, 'behaviours')}"
            yield Fault((*path, "urge", str(key)), message, at_key=True)


def _faults_of_dancer(
    name: str, do: object, path: Path, dances: Collection[str], hangs: bool
) -> Iterator[Fault]:
    """Find orders that a dancer cannot carry out.

    Args:
        name: of the dancer.
        do: the order.
        path: of the order.
        dances: names of the dances of the scene.
        hangs: whether the dancer has a parent.
    """
    orders = [do] if isinstance(do, str) else sorted(given_keys(do))
    if orders and not {*orders} & {*DANCER_ORDERS}:
        message = f"'{name}' is a dancer, who can {', '.join(DANCER_ORDERS)}"
        yield _at_order(do, orders[0], path, message)
        return
    dance = value_at(do, "dance")
    if isinstance(dance, str) and dance not in dances:
        yield Fault((*path, "dance"), f"no dance is called '{dance}', {hint(dance, dances)}")
    for key in ("look_at", "reach"):
        target = value_at(do, key)
        if isinstance(target, str):
            message = f"a dancer follows nobody; give the place of '{target}', [x, y, z]"
            yield Fault((*path, key), message)
        elif target is not None and hangs:
            message = f"'{name}' has a parent, and places are those of the world; remove this"
            yield Fault((*path, key), message, at_key=True)


def _faults_of_touch(pair: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that a touch that is waited for never happens."""
    names = pair if isinstance(pair, list | tuple) else ()
    for k, name in enumerate(names):
        if not isinstance(name, str):
            continue
        if name not in cast:
            yield unknown_name(name, cast, (*path, k))
        elif name in names[:k]:
            yield Fault((*path, k), f"'{name}' cannot touch itself; name another")
        elif not _is_touchable(cast[name]):
            yield Fault((*path, k), f"characters do not feel '{name}'; name another")
    known = [name for name in names if isinstance(name, str) and name in cast]
    if len(set(known)) == 2 and all(value_at(cast[n], "character") is None for n in known):
        message = f"neither '{known[0]}' nor '{known[1]}' is a character; name at least one"
        yield Fault(path, message)


def _is_touchable(member: object) -> bool:
    if any(value_at(member, block) is not None for block in TOUCHABLE):
        return True
    return bool(value_at(value_at(member, "body"), "collide") == "all")


def _faults_of_hug(pair: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that a hug that is waited for never happens."""
    names = list(pair) if isinstance(pair, list | tuple) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        return
    hugging, hugged = names
    if hugging not in cast:
        yield unknown_name(hugging, cast, (*path, 0))
    elif (kind := _character_kind(cast[hugging])) not in (*PEOPLE, UNKNOWN_KIND):
        message = f"'{hugging}' is {_with_article(kind)}; name a child or an adult"
        yield Fault((*path, 0), message)
    elif value_at(cast[hugging], "limp") is True:
        yield Fault((*path, 0), f"'{hugging}' is limp, and hugs nobody")
    yield from faults_of_target(hugged, hugging, JOINTED_CHARACTER, (*path, 1), cast)


def faults_of_target(
    target: str, own: str, fitting: TargetKind, path: Path, cast: Cast
) -> Iterator[Fault]:
    """Find a target that does not exist, is the performer itself, or is of another kind."""
    if target not in cast:
        yield unknown_name(target, cast, path)
        return
    kind = _character_kind(cast[target])
    if target == own:
        yield Fault(path, f"'{own}' cannot do that to itself; name {fitting.text}")
    elif kind is None or (fitting.kinds and kind not in (*fitting.kinds, UNKNOWN_KIND)):
        yield Fault(path, f"'{target}' is {_with_article(kind)}; name {fitting.text}")


def _character_kind(member: object) -> Any:
    """Return the kind of a character, None of other members."""
    kind = value_at(member, "character")
    return kind if kind is None or kind in get_args(Kind) else UNKNOWN_KIND


def _with_article(kind: str | None) -> str:
    if kind is None:
        return "no character"
    return f"an {kind}" if kind == "adult" else f"a {kind}"
