"""Behaviour registry: motor commands, the interface of a behaviour, and its implementations.

A new behaviour is a model in `pipeline.spec.behaviour` and a class decorated with `implements`
in any module of this package.

Source: Horswill 2008, "High-level Control".
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from pipeline.simulation.characters.body_arrays import NOBODY
from pipeline.simulation.characters.person_tasks import Task
from pipeline.spec import behaviour as spec

if TYPE_CHECKING:
    from pipeline.simulation.characters.mind.mind import Mind


@dataclass(frozen=True, slots=True)
class MotorCommand:
    """The motor vector of a behaviour.

    Attributes:
        goal: x and z to walk to [m]; None stands.
        pace: walking speed [m/s].
        target: number of the character approached and glanced at, or NOBODY.
        touching: whether the target is approached closely and not stepped aside for.
        facing: heading to stand or step back in [rad]; None faces the goal.
        reaching: whether both arms are held out ahead.
        task: done in place of all this, such as a hug.
        sits: whether to sit down.
        frozen: whether to keep quite still.
    """

    goal: tuple[float, float] | None = None
    pace: float = 1.0
    target: int = NOBODY
    touching: bool = False
    facing: float | None = None
    reaching: bool = False
    task: Task | None = None
    sits: bool = False
    frozen: bool = False


class Behaviour(Protocol):
    """An activity that a mind may choose."""

    def activation(self, mind: Mind) -> float:
        """Return the usefulness of the behaviour now, from 0 to about 1."""

    def motor(self, mind: Mind) -> MotorCommand:
        """Return the motor command while the behaviour is chosen."""

    def end(self, mind: Mind) -> None:
        """Reset when another behaviour is chosen."""


Config = TypeVar("Config", bound=spec.Urge)


class ConfiguredBehaviour(Generic[Config]):
    """A behaviour with a model of the scene language and nothing to reset."""

    def __init__(self, config: Config, mind: Mind) -> None:
        self.config = config

    def end(self, mind: Mind) -> None:
        """See `Behaviour`."""


Implementation = TypeVar("Implementation", bound=Callable[..., Behaviour])

IMPLEMENTATIONS: dict[type[spec.Urge], Callable[..., Behaviour]] = {}
"""Model of the scene language -> its implementation."""


def implements(model: type[spec.Urge]) -> Callable[[Implementation], Implementation]:
    """Register a class as the implementation of a model."""

    def register(implementation: Implementation) -> Implementation:
        IMPLEMENTATIONS[model] = implementation
        return implementation

    return register


@cache
def load_implementations() -> None:
    """Import all modules of this package, which registers their classes."""
    package = __name__.rpartition(".")[0]
    for module in pkgutil.iter_modules(import_module(package).__path__):
        import_module(f"{package}.{module.name}")


def behaviours_of(configs: Sequence[spec.Urge], mind: Mind) -> dict[str, Behaviour]:
    """Return the behaviours of a mind by name: withdrawal, then the order of the scene language.

    Two of one kind, such as two to comfort, are numbered from the second on.
    """
    load_implementations()
    made: dict[str, Behaviour] = {spec.WITHDRAWAL: IMPLEMENTATIONS[spec.Urge](spec.Urge(), mind)}
    for name, model in spec.FORMS.items():
        same = [config for config in configs if isinstance(config, model)]
        for k, config in enumerate(same):
            key = name if k == 0 else f"{name} {k + 1}"
            made[key] = IMPLEMENTATIONS[model](config, mind)
    return made


def behaviour_number(name: str) -> int:
    """Return the number of a behaviour in takes by its name, -1 for none."""
    stem = name.split(" ")[0]
    return spec.NAMES.index(stem) if stem else -1
