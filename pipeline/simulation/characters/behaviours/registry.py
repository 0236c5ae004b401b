"""Registry: what each behaviour is made of; a new one is a model, a file and a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pipeline.simulation.characters.behaviours.approach import GoTo
from pipeline.simulation.characters.behaviours.attachment import HugBack, SafeBase
from pipeline.simulation.characters.behaviours.carry import CarryAlong
from pipeline.simulation.characters.behaviours.fight import FightIt
from pipeline.simulation.characters.behaviours.keeping_away import HoldStill, KeepOff, RunAway
from pipeline.simulation.characters.behaviours.leisure import SitAWhile, Stroll
from pipeline.simulation.characters.behaviours.motor import Behaviour
from pipeline.simulation.characters.behaviours.play import PlayBall
from pipeline.simulation.characters.behaviours.push import PushRound
from pipeline.simulation.characters.behaviours.withdraw import Withdraw
from pipeline.simulation.characters.mind.mind import Mind
from pipeline.spec import behaviour as words

MAKERS: Mapping[str, tuple[type[words.Urge], Callable[[Any, Mind], Behaviour]]] = {
    "attachment": (words.Attachment, SafeBase),
    "comfort": (words.Comfort, HugBack),
    "play": (words.Play, PlayBall),
    "carry": (words.Carry, CarryAlong),
    "push": (words.Push, PushRound),
    "fight": (words.Fight, FightIt),
    "approach": (words.Approach, GoTo),
    "flee": (words.Flee, RunAway),
    "keep_off": (words.Shyness, KeepOff),
    "wander": (words.Wander, Stroll),
    "rest": (words.SitDown, SitAWhile),
    "freeze": (words.Freeze, HoldStill),
}
"""Name -> words and what they make."""


def behaviours_of(asked: Sequence[words.Urge], mind: Mind) -> dict[str, Behaviour]:
    """Return the behaviours of a mind by name, in the order of the registry.

    Two of one kind, such as two to comfort, are numbered from the second on.
    """
    made: dict[str, Behaviour] = {words.WITHDRAWAL: Withdraw()}
    for name, (kind, make) in MAKERS.items():
        same = [one for one in asked if isinstance(one, kind)]
        for k, one in enumerate(same):
            made[name if k == 0 else f"{name} {k + 1}"] = make(one, mind)
    return made


def kind_of(name: str) -> int:
    """Return the number of a behaviour by its name, -1 for none."""
    stem = name.split(" ")[0]
    return words.NAMES.index(stem) if stem else -1
