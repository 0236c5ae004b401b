"""Order support: which performers can be given which orders by the script, and to what.

`verbs` says who can do what. Performers and orders are read typed or raw (see `partial_scene`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from pipeline.spec.behaviour import NAMES
from pipeline.spec.body import body_count
from pipeline.spec.character_kinds import PARTS, PEOPLE
from pipeline.spec.group import DIRECTED
from pipeline.spec.model_base import Fault
from pipeline.spec.partial_scene import (
    Path,
    cast_by_name,
    items_of,
    kind_of,
    located_instructions,
    text_keys,
    unknown_name,
    value_at,
)
from pipeline.spec.relations import people_with_minds
from pipeline.spec.script import When
from pipeline.spec.suggestions import hint
from pipeline.spec.targets import (
    EVENT_MEMBER,
    EVENT_PLACE,
    FALLING,
    GRASPABLE,
    JOINTED_CHARACTER,
    MEMBER_TEXTS,
    MOVABLE,
    UNKNOWN,
    Cast,
    faults_of_target,
    kind_of_target,
)
from pipeline.spec.verbs import (
    CREATURES,
    DANCER,
    GROUP,
    HOPPER,
    PERFORMERS,
    PERSON,
    VERBS,
    WALKER,
    key_of_order,
    verbs_of,
)

NEAR_DISTANCE = When.model_fields["within"].default
"""Distance that counts as near if an author gives none [m]."""

HAND_ORDERS = ("reach", "grab", "carry", "throw", "let_go")
"""Orders to hands, which creatures have poses for."""

WHOLE_BODY = {"hop_over": "jumps", "jump": "jumps", "dance": "dances"}
"""Orders that move limbs which poses of creatures would move too."""


@dataclass(frozen=True, slots=True)
class NamedThings:
    """What a script can name.

    Attributes:
        cast: members by name, bodies of `many` by their own names as well.
        places: places of the scene by name.
        dances: names of dances.
        minds: names of the people that act by themselves.
        persons: names of the figures that are seen as dressed persons.
    """

    cast: Cast
    places: Cast
    dances: Collection[str]
    minds: Collection[str] = ()
    persons: Collection[str] = ()

    @staticmethod
    def of(scene: object) -> NamedThings:
        """Return the names of a scene."""
        cast = cast_by_name(scene)
        bodies: dict[str, object] = {
            f"{name}_{n + 1}": {"body": {}}
            for name, member in cast.items()
            if (many := value_at(member, "many")) is not None
            for n in range(body_count(many))
        }
        places = value_at(scene, "places")
        return NamedThings(
            bodies | cast,
            places if isinstance(places, Mapping) else {},
            text_keys(value_at(scene, "dances")),
            people_with_minds(scene),
            _persons(value_at(scene, "figures")),
        )


def _persons(figures: object) -> Collection[str]:
    """Return the names of the figures of a scene whose skin is a person's."""
    skins = {name: value_at(value_at(figures, name), "skin") for name in text_keys(figures)}
    return {name for name, skin in skins.items() if value_at(skin, "form") == "person"}


def faults_of_script(scene: object) -> Iterator[Fault]:
    """Find orders to performers that do not exist or cannot follow them."""
    named = NamedThings.of(scene)
    for path, instruction in located_instructions(scene):
        yield from faults_of_event(value_at(instruction, "when"), (*path, "when"), named)
        name, do = value_at(instruction, "who"), value_at(instruction, "do")
        if isinstance(name, str) and name not in named.cast:
            yield unknown_name(name, named.cast, (*path, "who"))
        elif isinstance(name, str):
            yield from _faults_of_order(name, do, path, named)


# --- orders -----------------------------------------------------------------------------


def performer_kind(member: object) -> str | None:
    """Return the kind of a performer that follows orders, None of one that does not."""
    kind = kind_of(member)
    if kind == "figure":
        return WALKER if _has(member, "walk") else HOPPER if _has(member, "pronk") else None
    if kind == "character":
        own = kind_of_target(member)
        acts = own == UNKNOWN or (own in PEOPLE and value_at(member, "limp") is not True)
        return PERSON if acts else None
    if kind == "group":
        is_directed = value_at(value_at(member, "group"), "rule") in DIRECTED
        return GROUP if is_directed else None
    return DANCER if kind == "dancer" else None


def _faults_of_performer(name: str, member: object, path: Path, do: object) -> Iterator[Fault]:
    """Find a member that follows no orders; one that is itself wrong is told where it stands."""
    if kind_of(member) is not None:
        yield _fault_of_performer(name, member, path, do)


def _fault_of_performer(name: str, member: object, path: Path, do: object = None) -> Fault:
    """Return why a member follows no orders, such as the order `do`."""
    kind = kind_of(member)
    if kind == "figure" and key_of_order(do) in HAND_ORDERS:
        message = f"'{name}' is a creature, and no order moves its limbs; {_pose_instead(member)}"
    elif kind == "figure":
        message = f"'{name}' neither walks nor hops; give it walk: {{}} or pronk: {{}}"
    elif value_at(member, "limp") is True:
        message = f"'{name}' is limp, and follows no script"
    elif kind == "group":
        message = f"'{name}' is a group that no script moves"
    else:
        text = MEMBER_TEXTS.get(kind_of_target(member), "a body")
        message = f"'{name}' is {text}, which no script moves; people can carry, throw or kick it"
    return Fault(path, message)


def _faults_of_order(name: str, do: object, path: Path, named: NamedThings) -> Iterator[Fault]:
    """Find what is wrong with the order `do` to a member of the cast."""
    member = named.cast[name]
    performer = performer_kind(member)
    if performer is None:
        yield from _faults_of_performer(name, member, (*path, "who"), do)
        return
    key, order = key_of_order(do), (*path, "do")
    if key is None:
        return
    if performer not in VERBS[key].performers:
        posed = key in HAND_ORDERS and kind_of(member) == "figure"
        can = _pose_instead(member) if posed else f"write {', '.join(verbs_of(performer))}"
        message = f"'{name}' is {PERFORMERS[performer]}, for which {key} is no order; {can}"
        yield _at_order(do, key, order, message)
        return
    for field, fitting in VERBS[key].targets.items():
        target = value_at(do, field)
        yield from faults_of_target(
            target, name, fitting, (*order, field), named.cast, named.places
        )
        if fitting in (GRASPABLE, MOVABLE) and isinstance(target, str):
            yield from _faults_of_scale(target, (*order, field), named.cast)
    if performer in CREATURES and key in WHOLE_BODY and value_at(member, "pose"):
        message = f"'{name}' has a pose, which conflicts with {WHOLE_BODY[key]}; remove pose"
        yield Fault(order, message)
    if key == "urge":
        yield from _faults_of_urges(name, do, order, named)
    yield from _faults_of_part(do, order, named.cast)
    if performer == DANCER or key == "dance":
        yield from _faults_of_dancer(name, member, do, order, named)


def _pose_instead(member: object) -> str:
    """Return what moves the limbs of a creature."""
    return (
        "write `pose: [{at: 1, limb: ..., reach: [x, y, z]}]` beside its figure, and `held` at "
        f"what it takes (`pronk figure {value_at(member, 'figure')}` lists its limbs)"
    )


def _at_order(do: object, key: str, path: Path, message: str) -> Fault:
    """Return a fault at the key of an order, or at the word that it is."""
    if isinstance(do, str):
        return Fault(path, message)
    return Fault((*path, key), message, at_key=True)


def _has(member: object, block: str) -> bool:
    """Return whether a member has a block, which may be empty as long as it is raw."""
    return (isinstance(member, Mapping) and block in member) or value_at(member, block) is not None


def _faults_of_part(do: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find a part to grab that the target does not have."""
    part, target = value_at(do, "part"), value_at(do, "grab")
    if not (isinstance(part, str) and isinstance(target, str) and target in cast):
        return
    if kind_of_target(cast[target]) not in JOINTED_CHARACTER.kinds:
        message = f"'{target}' has no named parts; remove this"
        yield Fault((*path, "part"), message, at_key=True)
    elif part not in PARTS:
        message = f"no part of '{target}' is called '{part}', {hint(part, PARTS)}"
        yield Fault((*path, "part"), message)


def _faults_of_scale(target: str, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find a prop for hands or feet whose size changes."""
    keys = items_of(value_at(cast.get(target), "keyframes"))
    if any(value_at(key, "scale") is not None for _, key in keys):
        message = f"keyframes change the scale of '{target}', and hands hold what has one size"
        yield Fault(path, f"{message}; remove scale there")


def _faults_of_urges(name: str, do: object, path: Path, named: NamedThings) -> Iterator[Fault]:
    """Find urges of a character without behaviours, and urges of unknown behaviours."""
    urges = value_at(do, "urge")
    if not isinstance(urges, Mapping):
        return
    if name not in named.minds:
        message = f"'{name}' does only what it is told; give it traits: {{}} to act by itself"
        yield Fault((*path, "urge"), message, at_key=True)
    for key in urges:
        if key not in NAMES:
            message = f"no behaviour is called '{key}', {hint(str(key), NAMES, 'behaviours')}"
            yield Fault((*path, "urge", str(key)), message, at_key=True)


def _faults_of_dancer(
    name: str, member: object, do: object, path: Path, named: NamedThings
) -> Iterator[Fault]:
    """Find dances that do not exist, and orders that who dances cannot follow."""
    dance = value_at(do, "dance")
    figure = value_at(member, "figure")
    if figure is not None and figure not in named.persons:
        message = (
            f"'{name}' is a {figure}, and dances are for the trunk and arms of a person; name a "
            "`figure: person`, a child, an adult or a dancer"
        )
        yield _at_order(do, "dance", path, message)
        return
    if isinstance(dance, str) and dance not in named.dances:
        message = f"no dance is called '{dance}', {hint(dance, named.dances, 'dances')}"
        yield Fault((*path, "dance"), message)
    if performer_kind(member) != DANCER:
        if isinstance(do, str):
            yield Fault(path, f"'{name}' has no dance of its own; write {{dance: NAME, bars: 2}}")
        return
    for key in ("look_at", "reach"):
        target = value_at(do, key)
        if target is not None and value_at(member, "parent") is not None:
            message = f"'{name}' has a parent, and places are those of the world; remove this"
            yield Fault((*path, key), message, at_key=True)
        elif isinstance(target, str) and key == "reach" and target not in named.places:
            message = (
                f"a dancer practises where it reaches; give the place of '{target}', [x, y, z]"
            )
            yield Fault((*path, key), message)


# --- events -----------------------------------------------------------------------------


def faults_of_event(when: object, path: Path, named: NamedThings) -> Iterator[Fault]:
    """Find events that never happen."""
    arrived = value_at(when, "arrived")
    if isinstance(arrived, str):
        yield from _faults_of_arrival(arrived, (*path, "arrived"), named.cast)
    for key in ("touch", "near"):
        pair = value_at(when, key)
        names = pair if isinstance(pair, list | tuple) else ()
        for k, name in enumerate(names):
            if isinstance(name, str) and name in names[:k]:
                message = f"'{name}' cannot {'touch' if key == 'touch' else 'come near'} itself"
                yield Fault((*path, key, k), f"{message}; name another")
            else:
                fitting = EVENT_PLACE if key == "near" else EVENT_MEMBER
                yield from faults_of_target(
                    name, "", fitting, (*path, key, k), named.cast, named.places
                )
    for key in ("fell", "at_rest"):
        yield from faults_of_target(value_at(when, key), "", FALLING, (*path, key), named.cast)
    # A scene that is written in full has the default beside other events.
    is_given = value_at(when, "within") not in (None, NEAR_DISTANCE)
    if is_given and value_at(when, "near") is None:
        yield Fault((*path, "within"), "belongs to near; remove this", at_key=True)
    yield from _faults_of_hug(value_at(when, "hug"), (*path, "hug"), named.cast)
    yield from _faults_of_service(value_at(when, "served"), (*path, "served"), named.cast)
    yield from _faults_of_failure(when, path, named.cast)


def _faults_of_service(name: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that somebody is never served, who is no person that acts."""
    if not isinstance(name, str):
        return
    if name not in cast:
        yield unknown_name(name, cast, path)
        return
    performer = performer_kind(cast[name])
    if performer is None:
        yield _fault_of_performer(name, cast[name], path)
    elif performer != PERSON:
        message = f"'{name}' is {PERFORMERS[performer]}, which nobody serves"
        yield Fault(path, f"{message}; name a child or an adult")


def _faults_of_failure(when: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that an order whose failure is waited for is never given up."""
    name, act = value_at(when, "failed"), value_at(when, "act")
    if act is not None and name is None:
        yield Fault((*path, "act"), "belongs to failed; remove this", at_key=True)
        return
    if not isinstance(name, str):
        return
    if name not in cast:
        yield unknown_name(name, cast, (*path, "failed"))
        return
    performer = performer_kind(cast[name])
    if performer is None:
        yield _fault_of_performer(name, cast[name], (*path, "failed"))
    elif performer == GROUP:
        yield Fault((*path, "failed"), f"'{name}' is a group, which gives up nothing")
    elif isinstance(act, str) and act not in verbs_of(performer):
        known = verbs_of(performer)
        message = f"'{name}' is {PERFORMERS[performer]}, for which {act} is no order"
        yield Fault((*path, "act"), f"{message}, {hint(act, known, 'orders')}")


def _faults_of_arrival(name: str, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that a member whose arrival is waited for never arrives."""
    if name not in cast:
        yield unknown_name(name, cast, path)
        return
    performer = performer_kind(cast[name])
    if performer is None:
        yield _fault_of_performer(name, cast[name], path)
    elif performer == GROUP:
        yield Fault(path, f"'{name}' is a group, which never arrives")


def _faults_of_hug(pair: object, path: Path, cast: Cast) -> Iterator[Fault]:
    """Find that a hug that is waited for never happens."""
    names = list(pair) if isinstance(pair, list | tuple) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        return
    hugging, hugged = names
    if hugging not in cast:
        yield unknown_name(hugging, cast, (*path, 0))
    elif (kind := kind_of_target(cast[hugging])) not in (*PEOPLE, UNKNOWN):
        message = f"'{hugging}' is {MEMBER_TEXTS[kind]}; name a child or an adult"
        yield Fault((*path, 0), message)
    elif value_at(cast[hugging], "limp") is True:
        yield Fault((*path, 0), f"'{hugging}' is limp, and hugs nobody")
    yield from faults_of_target(hugged, hugging, JOINTED_CHARACTER, (*path, 1), cast)
