"""Outdoors summary: where the sun of a scene stands and what grows on its ground, in words."""

from __future__ import annotations

import math

from pipeline.production.scenery.scatter_choice import ScatterChoice
from pipeline.production.scenery.scenery import TRIANGLE_BYTES, budget, scenery_detail
from pipeline.production.scenery.scenery_tally import SceneryTally
from pipeline.production.surroundings.choice import Choice
from pipeline.spec import Scene
from render.config import Light
from render.lights.sun_position import sun_direction, sun_elevation_deg

NAMED = 3
"""Species that are named; of the others their number is told."""


def sun_text(light: Light) -> str:
    """Return where the sun stands, "" in a light without one.

    The azimuth is that of a compass; the direction is along the x and z of the scene.
    """
    sun = light.sun
    if sun is None:
        return ""
    x, _, z = sun_direction(sun)
    heading = math.degrees(math.atan2(-z, x))
    # `north_deg` is the heading of north, and headings turn to the left.
    azimuth = (sun.north_deg - heading) % 360.0
    minutes = round(60.0 * sun.hour)
    clock = f"{minutes // 60}:{minutes % 60:02d}"
    high = sun_elevation_deg(sun)
    height = f"{high:.0f}° high" if high >= 0 else f"{-high:.0f}° below the horizon"
    level = max(math.hypot(x, z), 1e-9)
    return (
        f"sun at {clock} on day {sun.day}: {height}, azimuth {azimuth:.0f}°, "
        f"towards [{x / level:.2f}, {z / level:.2f}]"
    )


def scatter_text(scene: Scene, tally: SceneryTally | None = None) -> str:
    """Return what is scattered over the ground and what it costs, "" where nothing is.

    Args:
        scene: with its terrain.
        tally: of what is placed, known after simulation; what it may cost at most otherwise.
    """
    choice = ScatterChoice.of(scene, Choice.of(scene))
    if not choice.wanted:
        return ""
    if tally is not None:
        most = sorted(tally.counts, key=lambda name: -tally.counts[name])
        named = ", ".join(f"{tally.counts[name]:,} {name}" for name in most[:NAMED])
        rest = sum(tally.counts[name] for name in most[NAMED:])
        others = f" and {rest:,} others" if rest else ""
        total, memory = tally.triangles / 1e6, tally.triangles * TRIANGLE_BYTES / 2**20
        return f"scattered: {named}{others}, {total:.2f} million triangles, {memory:.0f} MiB"
    width, _ = scene.film.resolved().size
    most_triangles = choice.factor * budget(scenery_detail(width))
    names = list(dict.fromkeys(one.name for one in choice.fitted))
    told = f"{len(names)} species of presets, up to {most_triangles / 1e6:.2f} million triangles"
    own = ", ".join(one.name for one in choice.asked)
    parts = [told if names else "", f"{own} as dense as asked" if own else ""]
    return f"scattered: {' and '.join(filter(None, parts))} (--simulate counts them)"
