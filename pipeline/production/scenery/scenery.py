"""Scenery: the plants and stones of a film: what stands still, and what bends under feet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from pipeline.production.edging.plot import Plot
from pipeline.production.scenery.clearings import Clearings
from pipeline.production.scenery.expansion import meshes, triangle_counts
from pipeline.production.scenery.film_view import FilmView
from pipeline.production.scenery.ground_surface import GroundSurface
from pipeline.production.scenery.growth import Growth
from pipeline.production.scenery.placement import Placed, Placement
from pipeline.production.scenery.scatter_choice import ScatterChoice
from pipeline.production.scenery.species import KINDS
from pipeline.production.scenery.treads import Treads
from pipeline.production.scenery.tree_feet import at_feet
from pipeline.production.scenery.trodden_cover import TroddenCover, split_trodden
from pipeline.simulation.spatial import Array
from render.shot import Mesh

BUDGET = 1_500_000
"""Triangles of a wide frame's scenery; beyond it the cover of presets is thinned out."""

SPARED, FAR_FIRST = 4.0, 0.8
"""Distance up to which cover is spared when it is thinned out [m], for frames 1280 pixels wide,
and the power of the distance with which more is left out beyond."""

RARE = 0.4
"""The place of cover other than grass in the order in which it is left out, relative to grass:
flowers and leaves are few, and seen."""

LEAST_REST = 0.3
"""Share of the budget that is left to presets, whatever else stands there."""

LEAST_COVER = 0.55
"""Share of the budget kept for cover: trees near the cameras would otherwise leave bare ground."""

FULL_PATH, MAX_PATH_FACTOR = 25.0, 1.3
"""Length of a camera's path for which the budget doubles [m], and its greatest factor."""

MAX_TRIANGLES = 7_000_000
"""Triangles beyond which an author's own densities are refused."""

TRIANGLE_BYTES = 215
"""Memory that a triangle takes while frames are rendered, measured [bytes]."""


TRUNK = 2.0
"""Distance of trees from built ground [m]."""


class TooManyTriangles(Exception):
    """An author's own densities take too much memory."""


FULL_WIDTH = 1280
"""Width of the frame for which scenery has all its density [pixels]."""


def scenery_detail(width: int) -> float:
    """Return the detail of scenery in frames of a width [pixels]."""
    return float(min((width / FULL_WIDTH) ** 0.6, 1.5))


def budget(detail: float, path_length: float = 0.0) -> int:
    """Return the number of triangles of scenery.

    Args:
        detail: see `scenery_detail`.
        path_length: of the camera [m]; along a long one more is seen, less of it at a time.
    """
    longer = min(1.0 + path_length / FULL_PATH, MAX_PATH_FACTOR)
    return round(BUDGET * detail**1.5 * longer)


def placed_scenery(
    ground: GroundSurface,
    view: FilmView,
    clearings: Clearings | None,
    scatter: ScatterChoice,
    growth: Growth,
    detail: float,
    also: Sequence[Placed] = (),
    plots: Sequence[Plot] = (),
) -> list[Placed]:
    """Return the plants and stones that the cameras of a film see.

    Args:
        ground: on which they stand.
        view: of the film.
        clearings: of the performers, None without any.
        scatter: the species.
        growth: where plants thrive in the scene.
        detail: 1 for frames 1280 pixels wide.
        also: what stands there besides.
        plots: built ground, on which nothing grows.

    Raises:
        TooManyTriangles: the densities that the author asks for take too much memory.
    """
    placement = Placement(ground, view, clearings, growth.seed, growth, detail)
    fitted = [_off(placement.placed(one), plots) for one in scatter.fitted]
    asked = [_off(placement.placed(one), plots) for one in scatter.asked]
    trees = [placed for placed in (*fitted, *asked) if KINDS[placed.name].layer == "tree"]
    feet = [_off(placed, plots) for placed in at_feet(placement, trees, scatter.wanted)]
    most = round(scatter.factor * budget(detail, view.path_length))
    # What stands along a floor takes the place of some of the cover around it.
    along = sum(int(triangle_counts(placed, detail).sum()) for placed in also)
    rest = max(most - along, round(LEAST_REST * most))
    every = [*thinned([*fitted, *feet], rest, detail), *asked, *also]
    _check_size(every, detail)
    return every


def scenery_meshes(
    every: Sequence[Placed], treads: Treads, wind: tuple[float, float], detail: float
) -> tuple[tuple[Mesh, ...], TroddenCover | None]:
    """Return the meshes of placed plants and stones, still and trodden ones.

    Args:
        every: what is placed.
        treads: of the performers.
        wind: near the ground, along x and z [m/s].
        detail: 1 for frames 1280 pixels wide.
    """
    still, trodden = split_trodden(every, treads, detail)
    return meshes(still, detail, wind), TroddenCover.of(trodden, treads, wind, detail)


def _off(placed: Placed, plots: Sequence[Plot]) -> Placed:
    """Return what does not stand on built ground."""
    margin = TRUNK if KINDS[placed.name].layer == "tree" else KINDS[placed.name].radius
    for plot in plots:
        placed = placed.taken(~plot.holds(placed.points[:, [0, 2]], margin))
    return placed


def _check_size(every: Sequence[Placed], detail: float) -> None:
    counts: Counter[str] = Counter()
    for placed in every:
        counts[placed.name] += int(triangle_counts(placed, detail).sum())
    total = sum(counts.values())
    if total <= MAX_TRIANGLES:
        return
    largest = max(counts, key=lambda name: counts[name])
    memory = total * TRIANGLE_BYTES / 2**30
    raise TooManyTriangles(
        f"makes {total / 1e6:.1f} million triangles, which take {memory:.1f} GiB; at most "
        f"{MAX_TRIANGLES / 1e6:g} million are allowed. '{largest}' has most of them, "
        f"{counts[largest] / 1e6:.1f} million: lower its density, or the factor `density`"
    )


def thinned(every: Sequence[Placed], most: int, detail: float) -> list[Placed]:
    """Return placed things within a number of triangles: of cover the highest ranks are left out.

    Ranks are shares of the wanted density, so that all species are thinned out alike, and plants
    far from the cameras first: single blades are seen near them alone. Trees and solid things are
    all kept: where they take more than `1 - LEAST_COVER` of the number, the total exceeds it.
    """
    counts = [triangle_counts(placed, detail) for placed in every]
    is_cover = [KINDS[placed.name].layer == "cover" for placed in every]
    fixed = sum(int(n.sum()) for n, cover in zip(counts, is_cover, strict=True) if not cover)
    ranks = [_costs(p, detail) for p, cover in zip(every, is_cover, strict=True) if cover]
    if not ranks:
        return list(every)
    rank = np.concatenate(ranks)
    weight = np.concatenate([n for n, cover in zip(counts, is_cover, strict=True) if cover])
    order = np.argsort(rank, kind="stable")
    total = min(fixed, round((1.0 - LEAST_COVER) * most)) + np.cumsum(weight[order])
    within = int(np.searchsorted(total, most, side="right"))
    if within == len(order):
        return list(every)
    limit = float(rank[order[within]])
    return [
        placed.taken(_costs(placed, detail) < limit) if cover else placed
        for placed, cover in zip(every, is_cover, strict=True)
    ]


def _costs(placed: Placed, detail: float) -> Array:
    """Return the order (N,) in which things are left out, the highest first."""
    beyond = np.maximum(placed.distances / (SPARED * detail), 1.0)
    rare = 1.0 if KINDS[placed.name].widens else RARE
    return np.asarray(rare * placed.rank * beyond**FAR_FIRST)
