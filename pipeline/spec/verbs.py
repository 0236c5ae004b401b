"""Verbs: the orders of the scene language: meaning, who can do them, and to what.

The checks, the messages, `pronk list verbs`, the schema and the table in the documentation follow
from this table; the models of the orders are in `script`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.spec.partial_scene import value_at
from pipeline.spec.targets import (
    ANYBODY,
    ANYTHING,
    CAROUSEL,
    GRASPABLE,
    JOINTED_CHARACTER,
    MOVABLE,
    OBSTACLE,
    RIDEABLE,
    SEAT,
    TargetKind,
)

PERFORMERS: Mapping[str, str] = {
    "walker": "a creature that walks",
    "hopper": "a creature that hops",
    "person": "a child or an adult",
    "dancer": "a dancer",
    "group": "a flock or a school",
}
"""Kinds of performers that follow orders, as messages name them."""

WALKER, HOPPER, PERSON, DANCER, GROUP = PERFORMERS
CREATURES = (WALKER, HOPPER)
ALL_SINGLE = (*CREATURES, PERSON, DANCER)


@dataclass(frozen=True, slots=True)
class Verb:
    """What an order means.

    Attributes:
        meaning: one line.
        performers: keys of `PERFORMERS` that can do it.
        targets: kinds of targets, by the key of the order that names one.
        ends: whether it is done at some moment; the others last until another order.
        is_aside: whether it leaves what the performer does otherwise as it is.
    """

    meaning: str
    performers: tuple[str, ...]
    targets: Mapping[str, TargetKind] = field(default_factory=dict)
    ends: bool = False
    is_aside: bool = False


VERBS: Mapping[str, Verb] = {
    "go_to": Verb(
        "go to a place, or up to a member of the cast, and stop there",
        (*CREATURES, PERSON, GROUP),
        {"go_to": ANYTHING},
        ends=True,
    ),
    "follow": Verb(
        "go after a member of the cast and keep a distance",
        (WALKER, PERSON),
        {"follow": ANYBODY},
    ),
    "chase": Verb(
        "run after a member of the cast until it is touched",
        (WALKER, PERSON),
        {"chase": ANYBODY},
        ends=True,
    ),
    "flee": Verb(
        "run away until far enough from a member of the cast or a place",
        (WALKER, PERSON),
        {"flee": ANYTHING},
        ends=True,
    ),
    "avoid": Verb(
        "keep off a member of the cast or a place from now on",
        (WALKER, PERSON),
        {"avoid": ANYTHING},
        is_aside=True,
    ),
    "look_at": Verb(
        "look at something from now on", ALL_SINGLE, {"look_at": ANYTHING}, is_aside=True
    ),
    "look": Verb("look ahead again", ALL_SINGLE, is_aside=True),
    "stop": Verb("stop here", ALL_SINGLE),
    "walk": Verb("walk straight on, or go on after a wait", (WALKER, PERSON)),
    "hop": Verb("hop straight on", (HOPPER,)),
    "wait": Verb("stop, and go on later", ALL_SINGLE),
    "turn_deg": Verb("turn by an angle", (*CREATURES, PERSON)),
    "gait": Verb("change to another gait", (WALKER,), is_aside=True),
    "mood": Verb("move in another mood", (WALKER,), is_aside=True),
    "hop_over": Verb("jump over something and go on", CREATURES, {"hop_over": OBSTACLE}, ends=True),
    "jump": Verb("make one jump and go on", CREATURES, ends=True),
    "reach": Verb("hold a hand out to something", (PERSON, DANCER), {"reach": ANYTHING}, ends=True),
    "grab": Verb(
        "go to something and take it in the hand", (PERSON,), {"grab": GRASPABLE}, ends=True
    ),
    "carry": Verb(
        "take something, go somewhere with it and put it down",
        (PERSON,),
        {"carry": GRASPABLE, "to": ANYTHING},
        ends=True,
    ),
    "throw": Verb(
        "throw what is in the hand", (PERSON,), {"throw": MOVABLE, "to": ANYTHING}, ends=True
    ),
    "kick": Verb(
        "go up to something and kick it", (PERSON,), {"kick": MOVABLE, "to": ANYTHING}, ends=True
    ),
    "let_go": Verb("let go of what is held, reached for or hugged", (PERSON, DANCER)),
    "hug": Verb(
        "go to somebody and put both arms around them",
        (PERSON,),
        {"hug": JOINTED_CHARACTER},
        ends=True,
    ),
    "grapple": Verb(
        "go to somebody and shove", (PERSON,), {"grapple": JOINTED_CHARACTER}, ends=True
    ),
    "sit": Verb("sit down, on the ground or on something", (PERSON,), {"sit": SEAT}, ends=True),
    "ride": Verb(
        "step onto something that moves and stay on it", (PERSON,), {"ride": RIDEABLE}, ends=True
    ),
    "push": Verb("push a merry-go-round round", (PERSON,), {"push": CAROUSEL}, ends=True),
    "queue": Verb(
        "line up for one's turn, be served, and step aside",
        (PERSON,),
        {"queue": ANYTHING},
        ends=True,
    ),
    "stand": Verb("stand up", (PERSON,), ends=True),
    "freeze": Verb("keep quite still until another order", (PERSON, DANCER)),
    "greet": Verb("wave at something", (PERSON,), {"greet": ANYTHING}, is_aside=True),
    "point": Verb("point at something", (PERSON,), {"point": ANYTHING}, is_aside=True),
    "refuse": Verb(
        "hold up a hand and shake the head", (PERSON,), {"refuse": ANYTHING}, is_aside=True
    ),
    "soothe": Verb(
        "go to somebody and stroke a shoulder", (PERSON,), {"soothe": JOINTED_CHARACTER}, ends=True
    ),
    "urge": Verb("have more or less of a mind to do something by itself", (PERSON,), is_aside=True),
    "express": Verb("show an emotion in the face", (PERSON, DANCER), is_aside=True),
    "dance": Verb(
        "dance something from now on, or some bars of it; of walkers, a `figure: person`",
        (WALKER, PERSON, DANCER),
    ),
    # Last, for gait and kick have a key of this name too.
    "speed": Verb("go faster or slower from now on", (*CREATURES, PERSON), is_aside=True),
}
"""All orders by the word or key that selects them; the first that an order has decides."""


def key_of_order(do: object) -> str | None:
    """Return the order in `do`, typed or raw: its word, or the first of its keys that is a verb."""
    if isinstance(do, str):
        return do if do in VERBS else None
    return next((key for key in VERBS if value_at(do, key) is not None), None)


def targets_of(do: object) -> list[str]:
    """Return the members and places that an order names."""
    key = key_of_order(do)
    fields = VERBS[key].targets if key is not None else ()
    return [name for field in fields if isinstance(name := value_at(do, field), str)]


def verbs_of(performer: str) -> list[str]:
    """Return the orders that a kind of performer can do."""
    return [key for key, verb in VERBS.items() if performer in verb.performers]


def verb_table() -> str:
    """Return all orders as a table in Markdown, as the documentation shows them."""
    rows = [
        f"| `{key}` | {verb.meaning} | {', '.join(verb.performers)} | {_target_text(verb)} |"
        for key, verb in VERBS.items()
    ]
    head = "| order | meaning | who | targets |\n|---|---|---|---|"
    return "\n".join([head, *rows])


def _target_text(verb: Verb) -> str:
    texts = [f"`{key}`: {kind.text.partition(';')[0]}" for key, kind in verb.targets.items()]
    return "; ".join(texts)
