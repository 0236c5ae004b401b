"""Other bits of a take that keep its film."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.simulation.take import Take
from tests.production.goldens.harmless_films import Harmless


def rounded(name: str, alter: Callable[[Take], dict[str, Any]]) -> Harmless:
    """Return a take with other bits."""
    return Harmless(f"take: {name}", lambda base: base.moved(**alter(base.take)))


def noisy(values: NDArray[np.float64], amount: float) -> NDArray[np.float64]:
    """Return values with noise of this size."""
    return values + amount * np.random.default_rng(7).uniform(-1, 1, values.shape)


def each(table: str, **changes: Callable[[Any, float], Any]) -> Callable[[Take], dict[str, Any]]:
    """Return a change of members of all rows of a table, by a number from -1 to 1 for each."""

    def alter(take: Take) -> dict[str, Any]:
        draw = np.random.default_rng(8)
        return {
            table: tuple(
                replace(
                    row,
                    **{
                        name: change(getattr(row, name), float(draw.uniform(-1, 1)))
                        for name, change in changes.items()
                    },
                )
                for row in getattr(take, table)
            )
        }

    return alter


def shifted_place(by: float) -> Callable[[Any, float], Any]:
    """Return a shift of a place [m]."""
    return lambda place, u: tuple(x + by * u for x in place)


def times(by: float) -> Callable[[Any, float], Any]:
    """Return a change by a fraction."""
    return lambda value, u: value * (1 + by * u)


def versions(**others: str) -> Callable[[Take], dict[str, Any]]:
    """Return a take of another environment, whose last bits differ."""
    return lambda take: {
        "header": replace(take.header, versions={**take.header.versions, **others}),
        "positions": noisy(take.positions, 1e-12),
    }


def in_another_order(take: Take) -> dict[str, Any]:
    """Return the nodes in another order."""
    last = [*range(1, len(take.nodes)), 0]
    at = {old: new for new, old in enumerate(last)}
    meshes = tuple(
        replace(mesh, nodes=np.vectorize(at.get)(mesh.nodes).astype(mesh.nodes.dtype))
        for mesh in take.meshes
    )
    return {
        "nodes": tuple(take.nodes[j] for j in last),
        "positions": take.positions[:, last],
        "rotations": take.rotations[:, last],
        "alive": take.alive[:, last],
        "meshes": meshes,
    }


def turns(take: Take) -> dict[str, Any]:
    """Return angles a full turn and phases a whole cycle further."""
    values = take.values.copy()
    for c, channel in enumerate(take.channels):
        if channel.unit == "rad":
            values[:, c] += 2 * np.pi
        elif channel.name.endswith("phase"):
            values[:, c] += 1.0
    return {"values": values}


def larger_meshes(take: Take) -> dict[str, Any]:
    """Return meshes with other last bits."""
    return {
        "meshes": tuple(
            replace(mesh, vertices=mesh.vertices * np.float32(1 + 1e-6)) for mesh in take.meshes
        )
    }


def header(**changes: Any) -> Callable[[Take], dict[str, Any]]:
    """Return another header."""
    return lambda take: {"header": replace(take.header, **changes)}


TAKE = (
    rounded("places off by a nanometre", lambda t: {"positions": noisy(t.positions, 1e-9)}),
    rounded(
        "places off by a tenth of a millimetre", lambda t: {"positions": noisy(t.positions, 1e-4)}
    ),
    rounded("rotations off by a nanoradian", lambda t: {"rotations": noisy(t.rotations, 1e-9)}),
    rounded(
        "rotations off by a tenth of a milliradian",
        lambda t: {"rotations": noisy(t.rotations, 1e-4)},
    ),
    rounded("rotations of the other sign", lambda t: {"rotations": -t.rotations}),
    rounded("channels off in the last bits", lambda t: {"values": noisy(t.values, 1e-12)}),
    rounded("channels off by half a thousandth", lambda t: {"values": noisy(t.values, 1e-4)}),
    rounded("angles a turn further", turns),
    rounded("nodes in another order", in_another_order),
    rounded("moments off in the last bit", each("events", fraction=times(1e-13))),
    rounded(
        "moments off by a thousandth of a step", each("events", fraction=lambda f, u: f + 1e-3 * u)
    ),
    rounded("moments off by a tenth of a step", each("events", fraction=lambda f, u: f + 0.07 * u)),
    rounded("strengths off in the last bit", each("events", strength=times(1e-15))),
    rounded("strengths off by a percent", each("events", strength=times(0.01))),
    rounded("energies off in the last bit", each("events", energy=times(1e-15))),
    rounded("energies off by a percent", each("events", energy=times(0.01))),
    rounded("sizes off in the last bit", each("events", size=times(1e-15))),
    rounded("places of sounds off by a nanometre", each("events", place=shifted_place(1e-9))),
    rounded("places of sounds off by two millimetres", each("events", place=shifted_place(2e-3))),
    rounded("moments of contacts off", each("contacts", fraction=lambda f, u: f + 0.07 * u)),
    rounded("speeds of contacts off by a percent", each("contacts", speed=times(0.01))),
    rounded(
        "places of contacts off by two millimetres", each("contacts", place=shifted_place(2e-3))
    ),
    rounded("normals off", each("contacts", normal=shifted_place(1e-9))),
    rounded("energies of contacts off", each("contacts", energy=times(0.01))),
    rounded("meshes off in the last bits", larger_meshes),
    rounded(
        "ground off by a nanometre",
        lambda t: {"terrain": replace(t.terrain, vertices=noisy(t.terrain.vertices, 1e-9))},
    ),
    rounded("another class of processor", versions(machine="another")),
    rounded("another numpy", versions(numpy="9.9")),
    rounded("another pronk", versions(pronk="9.9", simulation="0123", language="2")),
    rounded("another Python", versions(python="3.99")),
    rounded("another key", header(key="another")),
    rounded("another title", header(title="Another")),
    rounded("another format of the take", header(format=9)),
    rounded(
        "without the tables of reports", lambda t: {"mechanisms": (), "legs": (), "aliases": ()}
    ),
    rounded(
        "events of one moment in another order",
        lambda t: {"events": (t.events[1], t.events[0], *t.events[2:])},
    ),
)
