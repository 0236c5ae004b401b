"""Interpenetration of people with minds and things."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.simulation.characters.character_plans import LINK_NAMES
from pipeline.simulation.characters.characters import Characters
from pipeline.simulation.characters.playthings import CORNERS
from pipeline.simulation.spatial import Array
from tests.simulation.characters.character_yard import character_overlap
from tests.simulation.characters.mind_scenes import simulation, steps, troupe

pytestmark = pytest.mark.slow

WALKERS, BOXES = 6, ("box", "crate", "bench")

THINGS = """
- {name: box, character: box, at: [0, 0]}
- {name: crate, character: box, at: [2, -1.4], heading_deg: 30}
- {name: bench, character: bench, at: [-1.8, 1.4], heading_deg: 50}
- {name: carousel, character: merry-go-round, at: [-1.2, -1.8]}
- {name: ball, character: ball, at: [1.2, 1.5]}
"""

RESTS, DEEPEST = 0.005, 0.025
"""Overlap of resting contacts, and of collisions [m]."""


def yard_cast() -> str:
    """Return a cast of six wanderers of different speeds, the first by name, in a yard."""
    people = [
        f"- {{name: a{k}, character: {'adult' if k % 3 == 0 else 'child'}, "
        f"at: [{5.0 * math.cos(k):.2f}, {5.0 * math.sin(k):.2f}], "
        f"traits: {{curiosity: 0.9, speed: {0.2 + 0.12 * k:.2f}}}, behaviours: [{{wander: 9}}]}}"
        for k in range(WALKERS)
    ]
    return "\n".join(people) + THINGS


def depth_in_box(characters: Characters, name: str) -> float:
    """Return the deepest penetration of people into a box [m], at most 0 without any."""
    arrays = characters.arrays
    owner = [member.name for member in characters.cast].index(name)
    first = int(arrays.owners["nodes"][owner, 0])
    corners = arrays.p[first : first + 8]
    middle = corners.mean(axis=0)
    # From one side to the other, along Y, X and Z of the box at rest.
    ways = np.array(
        [
            corners[CORNERS[:, k] == top].mean(axis=0) - corners[CORNERS[:, k] != top].mean(axis=0)
            for k, top in ((1, 1.0), (0, 0.5), (2, 0.5))
        ]
    )
    sizes = np.linalg.norm(ways, axis=1)
    own = arrays.owners["links"][:WALKERS, 0][:, None] + np.arange(len(LINK_NAMES))
    links = arrays.links[own.ravel()]
    a, b = (arrays.p[links["ends"][:, k]] for k in range(2))
    along = np.linspace(0.0, 1.0, 9)[:, None, None]
    at = (a + along * (b - a) - middle) @ (ways / sizes[:, None]).T
    over = np.abs(at) - 0.5 * sizes
    gap = np.linalg.norm(np.maximum(over, 0.0), axis=-1) + np.minimum(over.max(axis=-1), 0.0)
    return float((links["radius"] + arrays.owners["edge_radius"][owner] - gap).max())


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [3, 1, 4])
def test_wanderers_do_not_interpenetrate_in_a_minute(seed: int) -> None:
    depths, gone = [], np.zeros(WALKERS)
    before: Array | None = None
    for n, characters in enumerate(steps(simulation(yard_cast(), 60, f"seed: {seed}"))):
        if n % 4:
            continue
        in_boxes = [depth_in_box(characters, name) for name in BOXES]
        depths.append(
            max(character_overlap(characters.arrays.nodes, characters.arrays.links), *in_boxes)
        )
        at = characters.persons["at"].copy()
        gone += 0.0 if before is None else np.linalg.norm(at - before, axis=1)
        before = at
    assert max(depths) < DEEPEST
    assert np.mean(np.array(depths) > RESTS) < 0.005
    # All people walk most of the time.
    assert gone.min() > 12.0


def test_depth_in_a_box_is_measured_in_its_own_frame() -> None:
    characters = troupe(simulation(yard_cast(), 1))
    arrays = characters.arrays
    assert depth_in_box(characters, "box") < -2.0
    # The radius of the edges is not part of the box.
    owner = [member.name for member in characters.cast].index("box")
    middle = arrays.p[arrays.owners["nodes"][owner, 0] :][:8].mean(axis=0)
    arrays.nodes["p"][:16] += middle - arrays.p[0]
    assert 0.25 < depth_in_box(characters, "box") < 0.45
