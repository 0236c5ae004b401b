"""Species: the shapes of plants and stones by name, and where they grow or lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Literal

from pipeline.production.scenery import (
    clumps,
    conifers,
    corals,
    grasses,
    herbs,
    mushrooms,
    stones,
    trees,
)
from pipeline.production.scenery.growth import Habitat
from pipeline.production.scenery.prototype import Prototype

Make = Callable[[int, int], Prototype]
"""From a seed and a level of detail, 0 the finest, to a shape."""

CLOSE = 0.9
"""Distance from the camera up to which leaves of herbs bend, in their size [m]."""

Layer = Literal["cover", "solid", "tree"]


@dataclass(frozen=True)
class Species:
    """One species.

    Attributes:
        make: its shapes.
        density: per square metre within its patches, near the camera.
        layer: `cover` bends under feet; `solid` things and trees stay away from performers.
        height: of the largest, about [m].
        radius: of the largest, about [m].
        sizes: least and greatest factor on the shape.
        levels: distances from the camera up to which each level of detail but the last is seen [m].
        near: distance up to which it stands at its full density [m].
        reach: distance at which it ends [m].
        patch: width of its patches [m].
        cover: share of the ground that is in patches.
        edge: how soft the edges of patches are, as half a range of their noise.
        steepest: rise per metre at which it ends.
        upright: 1 if it stands upright on a slope, 0 if it lies along it.
        ground: share of the ground's hue in its colours.
        widens: whether far ones are wider, where there are fewer.
        is_stone: whether its surface is rough stone.
        variants: number of shapes.
        habitat: where it grows; see `growth`.
        family: species of one family have their patches in the same places, the rarer ones in
            their middle; alone by default.
    """

    make: Make
    density: float
    layer: Layer = "cover"
    height: float = 0.2
    radius: float = 0.1
    sizes: tuple[float, float] = (0.75, 1.25)
    levels: tuple[float, ...] = (4.5, 13.0)
    near: float = 4.0
    reach: float = 70.0
    patch: float = 4.0
    cover: float = 0.7
    edge: float = 0.25
    steepest: float = 0.9
    upright: float = 0.8
    ground: float = 0.0
    widens: bool = False
    is_stone: bool = False
    variants: int = 5
    habitat: Habitat = "open"
    family: str = ""

    @property
    def bends(self) -> bool:
        """Whether it gives way to feet and to the wind."""
        return self.layer == "cover" and not self.is_stone


def _grass(
    kind: str, density: float, height: float, **others: float | str | tuple[float, float]
) -> Species:
    values: dict[str, float | str | tuple[float, float]] = {
        "ground": 0.35,
        "habitat": "tufts",
        # A blade of the first level costs five of the next: near ones are few, so that more stand.
        "levels": (1.7, 13.0),
        **others,
    }
    return Species(
        partial(grasses.clump, kind),
        density,
        height=height,
        widens=True,
        **values,  # type: ignore[arg-type]
    )


def _flower(kind: str, density: float, height: float, cover: float) -> Species:
    return Species(
        partial(herbs.flower, kind),
        *(2.2 * density, "cover", height),
        levels=(CLOSE, 3.5, 9.0),
        near=7.0,
        reach=45.0,
        # Drifts of one kind: flowers seed themselves where they stand.
        patch=5.0,
        cover=0.4 * cover,
        edge=0.12,
    )


def _tree(
    make: Make, density: float, height: float, radius: float, clump: int, **others: float | str
) -> Species:
    values: dict[str, float | str] = {"cover": 0.6, "patch": 24.0, "habitat": "grove", **others}
    return Species(
        *(partial(clumps.tree, make, clump), 3.0 * density, "tree", height, radius),
        sizes=(0.45, 1.25),
        levels=(8.0, 28.0, 75.0),
        near=95.0,
        reach=400.0,
        steepest=0.8,
        upright=1.0,
        variants=4,
        **values,  # type: ignore[arg-type]
    )


def _shrub(
    kind: str,
    density: float,
    height: float,
    radius: float,
    **others: float | str | tuple[float, float],
) -> Species:
    values: dict[str, float | str | tuple[float, float]] = {
        "cover": 0.3,
        "patch": 9.0,
        "reach": 130.0,
        "near": 26.0,
        "sizes": (0.55, 1.25),
        **others,
    }
    return Species(
        *(partial(trees.crown_tree, kind), density, "solid", height, radius),
        levels=(7.0, 18.0, 50.0),
        upright=0.9,
        variants=6,
        **values,  # type: ignore[arg-type]
    )


def _boulder(seed: int, level: int) -> Prototype:
    return stones.stone(seed, (4, 3, 2, 1)[level])


def _stone(seed: int, level: int) -> Prototype:
    return stones.stone(seed, (3, 2, 1)[level], edged=0.9)


def _pebbles(seed: int, level: int) -> Prototype:
    return stones.pebbles(seed, (22, 12, 6)[level], (1, 0, 0)[level])


KINDS: dict[str, Species] = {
    "short grass": _grass(
        *("short grass", 270.0, 0.12),
        cover=0.9,
        reach=60.0,
        near=5.5,
        sizes=(0.6, 1.5),
        levels=(1.2, 10.0),
        habitat="turf",
    ),
    "meadow grass": _grass(
        *("meadow grass", 95.0, 0.24), cover=0.55, patch=8.0, near=8.0, family="tall"
    ),
    "tall grass": _grass(
        *("tall grass", 45.0, 0.62),
        cover=0.3,
        edge=0.1,
        patch=8.0,
        reach=110.0,
        near=14.0,
        habitat="untrodden",
        family="tall",
    ),
    "dry grass": _grass(
        *("dry grass", 70.0, 0.34),
        cover=0.5,
        near=9.0,
        reach=110.0,
        patch=6.0,
        ground=0.25,
        sizes=(0.55, 1.3),
        habitat="clumps",
    ),
    "tussock": _grass(
        *("tussock", 26.0, 0.42),
        cover=0.45,
        near=9.0,
        reach=110.0,
        patch=5.0,
        ground=0.2,
        sizes=(0.5, 1.3),
        habitat="clumps",
    ),
    "beach grass": _grass(
        "beach grass", 12.0, 0.7, near=10.0, reach=110.0, cover=0.3, patch=6.0, ground=0.35
    ),
    "sedge": _grass(
        *("sedge", 55.0, 0.15),
        cover=0.5,
        patch=2.2,
        near=6.0,
        ground=0.25,
        sizes=(0.6, 1.4),
        habitat="clumps",
    ),
    "reeds": _grass("reeds", 16.0, 1.9, cover=0.35, patch=3.0, ground=0.1, reach=90.0),
    "water weed": _grass(
        *("water weed", 14.0, 1.1),
        cover=0.3,
        patch=2.2,
        ground=0.0,
        reach=60.0,
        near=9.0,
        sizes=(0.35, 1.0),
    ),
    "wheat": _grass(
        *("wheat", 55.0, 0.95),
        cover=1.0,
        ground=0.0,
        reach=120.0,
        sizes=(0.85, 1.15),
        habitat="open",
    ),
    "maize": Species(
        *(herbs.maize, 4.0, "solid", 2.2, 0.4),
        levels=(6.0, 16.0),
        near=14.0,
        reach=140.0,
        cover=1.0,
    ),
    "daisy": _flower("daisy", 9.0, 0.16, 0.4),
    "buttercup": _flower("buttercup", 7.0, 0.26, 0.35),
    "poppy": _flower("poppy", 5.0, 0.42, 0.22),
    "cornflower": _flower("cornflower", 4.0, 0.44, 0.22),
    "dandelion": _flower("dandelion", 3.0, 0.18, 0.3),
    "clover": Species(
        *(herbs.clover, 9.0, "cover", 0.12, 0.2),
        levels=(CLOSE, 2.5, 7.0),
        near=5.0,
        reach=32.0,
        cover=0.28,
        patch=3.0,
        upright=0.3,
        ground=0.15,
        sizes=(0.7, 1.4),
        habitat="tufts",
    ),
    "fern": Species(
        *(herbs.fern, 1.6, "cover", 0.5, 0.5),
        levels=(2.2, 5.0, 14.0),
        near=8.0,
        reach=70.0,
        cover=0.4,
        sizes=(0.5, 1.2),
    ),
    "heather": Species(
        *(herbs.heather, 11.0, "cover", 0.28, 0.2),
        near=6.0,
        reach=80.0,
        cover=0.6,
        sizes=(0.5, 1.35),
        habitat="clumps",
        widens=True,
    ),
    "moss cushion": Species(
        *(herbs.moss_cushion, 16.0, "cover", 0.05, 0.15),
        levels=(3.0, 8.0),
        near=3.5,
        reach=30.0,
        cover=0.6,
        patch=2.5,
        upright=0.0,
        ground=0.4,
        widens=True,
        sizes=(0.7, 1.6),
    ),
    "succulent": Species(
        *(herbs.succulent, 0.10, "solid", 0.45, 0.4),
        near=16.0,
        reach=90.0,
        cover=0.5,
        patch=8.0,
        sizes=(0.5, 1.3),
    ),
    "mushroom": Species(
        *(mushrooms.mushroom, 0.7, "cover", 0.1, 0.1),
        levels=(CLOSE, 2.5, 7.0),
        reach=24.0,
        cover=0.25,
    ),
    "leaves": Species(
        *(herbs.fallen_leaves, 5.0, "cover", 0.05, 0.4),
        levels=(CLOSE, 4.0, 11.0),
        reach=40.0,
        cover=0.5,
        upright=0.0,
        habitat="shade",
    ),
    "twigs": Species(
        *(herbs.twigs, 1.2, "cover", 0.05, 0.3), levels=(3.0, 9.0), reach=30.0, upright=0.0
    ),
    "bush": _shrub(
        *("bush", 0.16, 1.9, 1.2),
        near=60.0,
        reach=260.0,
        cover=0.5,
        patch=5.0,
        habitat="hedge",
        sizes=(0.35, 1.3),
    ),
    "scrub": _shrub("scrub", 0.4, 0.85, 0.5, cover=0.3, patch=15.0),
    "willow scrub": _shrub("willow scrub", 0.22, 0.6, 0.5, cover=0.35),
    "oak": _tree(partial(trees.crown_tree, "oak"), 0.0035, 9.5, 4.0, 3),
    "birch": _tree(partial(trees.crown_tree, "birch"), 0.005, 11.0, 2.0, 3),
    "acacia": _tree(partial(trees.crown_tree, "acacia"), 0.0022, 7.0, 4.2, 2, cover=0.5),
    "spruce": _tree(conifers.spruce, 0.006, 13.0, 2.6, 4),
    "pebbles": Species(
        *(_pebbles, 6.0, "cover", 0.04, 0.3),
        levels=(2.5, 6.0),
        near=7.0,
        reach=26.0,
        cover=0.45,
        patch=9.0,
        habitat="rubble",
        family="rubble",
        steepest=1.2,
        upright=0.0,
        ground=0.6,
        sizes=(0.6, 1.5),
        is_stone=True,
    ),
    "stone": Species(
        *(_stone, 2.2, "solid", 0.2, 0.22),
        sizes=(0.035, 0.19),
        levels=(4.0, 12.0),
        near=9.0,
        reach=110.0,
        patch=9.0,
        cover=0.28,
        habitat="rubble",
        family="rubble",
        steepest=1.4,
        upright=0.1,
        ground=0.5,
        variants=8,
        is_stone=True,
    ),
    "boulder": Species(
        *(_boulder, 0.07, "solid", 0.9, 0.9),
        sizes=(0.25, 0.85),
        levels=(5.0, 14.0, 45.0),
        near=34.0,
        reach=260.0,
        patch=9.0,
        cover=0.12,
        habitat="rubble",
        family="rubble",
        steepest=1.6,
        upright=0.2,
        ground=0.5,
        variants=6,
        is_stone=True,
    ),
    "coral": Species(
        *(corals.coral, 0.5, "solid", 0.6, 0.35),
        sizes=(0.5, 1.5),
        levels=(5.0, 14.0),
        near=14.0,
        reach=60.0,
        patch=3.5,
        cover=0.3,
        family="rubble",
        variants=15,
    ),
}
"""All species by name."""


@lru_cache(maxsize=1024)
def prototype(name: str, variant: int, level: int) -> Prototype:
    """Return a shape of a species at a level of detail."""
    return KINDS[name].make(101 * variant + 7, level)
