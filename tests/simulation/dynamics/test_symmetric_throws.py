"""Symmetric throws: bodies of all shapes stay in a common plane of symmetry with the ground."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pipeline.simulation.dynamics.body_record import (
    BODY,
    MAX_CONTACTS,
    clear_contacts,
    drop_equal_contacts,
    insert_contact,
)
from pipeline.simulation.dynamics.compiled import Record, entry
from pipeline.simulation.dynamics.record_array import zero_records
from pipeline.simulation.dynamics.rigid_body import Bodies, State
from pipeline.simulation.dynamics.terrain_bodies import TerrainBodies
from pipeline.simulation.spatial import Array
from tests.simulation.dynamics.symmetric_throws import (
    ENGINES,
    GROUNDS,
    KINDS,
    MIRROR,
    TOLERANCE,
    Kind,
    colliders,
    deviations,
    symmetric_ground,
    throws,
)

CHAOTIC = {"terrain": 0.1, "all": 0.4, "character": 0.1}
"""Largest share of chaotic throws that may leave the plane, by engine: where each impact multiplies
a deviation by ten, rounding becomes visible after a dozen. MuJoCo's solver starts from larger
rounding errors, and a tetrahedron that lands on a ridge with an edge balances on it."""


@pytest.mark.nightly
@pytest.mark.parametrize("ground", GROUNDS)
def test_balls_of_characters_stay_in_the_plane(ground: str) -> None:
    field, count = symmetric_ground(ground), 1000
    thrown = throws(KINDS["ball"], field, np.random.default_rng(count), count, in_plane=True)
    paths = ENGINES["character"](field, thrown, 96)
    assert np.mean(deviations(paths, paths) > TOLERANCE) <= (
        CHAOTIC["character"] if ground in ROUGH else 0.0
    )


ROUGH = ("rough", "crags")
"""Grounds of sharp points, on which balls are thrown about."""


@pytest.mark.nightly
@pytest.mark.parametrize("engine", ["terrain", "all"])
@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("kind", KINDS)
def test_throws_of_any_shape_stay_in_the_plane(kind: str, ground: str, engine: str) -> None:
    """1,000 throws on each ground, spread over the shapes.

    Balls have no exception but on rough ground. Polyhedra spin and tumble, and some of these
    motions are unstable.
    """
    field, count = symmetric_ground(ground), 1000 // len(KINDS)
    thrown = throws(KINDS[kind], field, np.random.default_rng(count), count, in_plane=True)
    paths = ENGINES[engine](field, thrown, 192)
    off = deviations(paths, paths)
    exact = kind == "ball" and ground not in ROUGH
    assert np.mean(off > TOLERANCE) <= (0.0 if exact else CHAOTIC[engine])
    assert np.median(off) < 1e-3 * TOLERANCE


@pytest.mark.nightly
@pytest.mark.parametrize("engine", ["terrain", "all"])
@pytest.mark.parametrize("ground", GROUNDS)
def test_mirrored_throws_of_any_shape_take_mirrored_paths(ground: str, engine: str) -> None:
    field = symmetric_ground(ground)
    for kind in KINDS.values():
        thrown = throws(kind, field, np.random.default_rng(3), 40, in_plane=False)
        paths, mirrored = (ENGINES[engine](field, t, 48) for t in (thrown, thrown.mirrored()))
        off = deviations(paths, mirrored)
        assert np.mean(off > TOLERANCE) <= CHAOTIC[engine]


def test_prisms_that_land_flat_stay_in_the_plane() -> None:
    """All corners of the base touch at once, and those of the stones below it."""
    kind, field = (
        Kind(({"shape": "prism", "sides": 48},), KINDS["prism"].q),
        symmetric_ground("stones"),
    )
    thrown = throws(kind, field, np.random.default_rng(1), 2, in_plane=True)
    thrown.state.q[:], thrown.state.w[:] = kind.q, 0.0
    thrown.state.v[:, 0] = 0.0
    paths = ENGINES["terrain"](field, thrown, 96)
    assert (deviations(paths, paths) < TOLERANCE).all()


def _contacts(x: Array, y: Array, radius: float, name: str) -> list[Array]:
    """Return the contacts of balls above z = 0: gap, normal and lever (n, 7) of each."""
    count, ground = len(x), symmetric_ground(name)
    body = colliders(Kind(({"shape": "sphere", "radius": radius},)), [0] * count)
    p = np.column_stack([x, y, np.zeros(count)])
    q, v = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))
    found = TerrainBodies(Bodies.of([b.build for b in body]), State(p, q, v, v.copy()), ground)
    records = found._records
    return [
        np.column_stack([r["gap"][:, None], r["normal"], r["lever"]])[: r["count"]] for r in records
    ]


@pytest.mark.parametrize("name", ["crags", "stones"])
def test_contacts_of_a_ball_are_symmetric_where_the_ground_is(name: str) -> None:
    """Contacts hide one another by their distance alone, whatever the order of the triangles."""
    rng, radius = np.random.default_rng(6), 0.1
    x = rng.uniform(-3.5, 3.5, 400)
    height = symmetric_ground(name).height(x, np.zeros(400))
    several = 0
    for contacts in _contacts(x, height + rng.uniform(0.3, 1.0, 400) * radius, radius, name):
        mirrored = contacts * [1.0, *MIRROR, *MIRROR]
        apart = np.abs(contacts[:, None] - mirrored).max(axis=-1)
        assert (apart.min(axis=1, initial=np.inf) < 1e-9).all()
        several += len(contacts) > 2
    assert several > 20


@entry
def _insert(body: Record, gaps: Array, order: NDArray[np.int64]) -> None:
    """Insert contacts of given gaps in some order, their numbers as levers."""
    clear_contacts(body)
    for k in order:
        insert_contact(body, gaps[k], (0.0, 1.0, 0.0), (float(k), 0.0, 0.0))
    drop_equal_contacts(body)


def test_which_contacts_are_kept_is_no_matter_of_their_order() -> None:
    rng, body = np.random.default_rng(8), zero_records(1, BODY)[0]
    body["size"] = 0.2
    # Five of each gap: more than there is room for, and the last five do not fit.
    gaps = 1e-3 * np.repeat(np.arange(MAX_CONTACTS // 4), 5)
    for _ in range(20):
        _insert(body, gaps, rng.permutation(len(gaps)))
        count = int(body["count"])
        assert count == MAX_CONTACTS // 5 * 5
        assert set(body["lever"][:count, 0]) == set(range(count))
    _insert(body, 0.0 * gaps, rng.permutation(len(gaps)))
    assert body["count"] == MAX_CONTACTS
