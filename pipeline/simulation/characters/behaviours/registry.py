"""Behaviour registry: implementations of behaviours by model of the scene language.

A new behaviour is a model in `pipeline.spec.behaviour` and a class decorated with `implements`
in any module of this package.

Source: Horswill 2008, "High-level Control".
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from typing import Generic, TypeVar

from pipeline.simulation.characters.mind.mind import Behaviour, Mind
from pipeline.spec import behaviour as spec

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


@cache
def behaviour_number(name: str) -> int:
    """Return the number of a behaviour in takes by its name, -1 for none."""
    stem = name.split(" ")[0]
    return spec.NAMES.index(stem) if stem else -1
