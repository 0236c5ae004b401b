"""Walk: a drawn figure simulated on level ground, for the page to show it from all sides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pipeline.production.gltf.take_file import take_glb
from pipeline.production.reports.figure_walk import walk_or_stand
from pipeline.production.reports.gait_plot import creature_stances
from pipeline.simulation.figure_analysis import build_figure
from pipeline.simulation.take import Take
from pipeline.spec import Figure as FigureConfig
from pipeline.spec import Scene
from pipeline.studio.figure_analysis import NAME
from pipeline.studio.newest import simulated
from render.config import Material

SECONDS = 3.0
"""Length of the walk: two cycles of most animals [s]."""


@dataclass(frozen=True, slots=True)
class FigureWalk:
    """A walk as the page shows it.

    Attributes:
        glb: the take.
        facts: length, gait and what the figure does, as plain values.
    """

    glb: bytes
    facts: dict[str, Any]


def figure_walk(
    config: FigureConfig,
    materials: Mapping[str, Material],
    still_wanted: Callable[[], None],
) -> FigureWalk:
    """Return the walk of a figure; one that cannot walk stands.

    Raises:
        SceneError: the drawing is no figure.
        Superseded: it is not wanted any more.
    """
    figure = build_figure(NAME, config, 1.0)
    scene, take, reason = walk_or_stand(
        figure, config, materials, lambda scene: simulated(scene, still_wanted), SECONDS
    )
    text = "walks" if figure.skeleton.legs else "crawls"
    if reason:
        text = f"stands: {_of_the_drawing(reason)}"
    still_wanted()
    facts = {
        "text": text,
        "seconds": take.header.frames / float(take.header.rate),
        "scale": scene.creatures[0][1].scale,
        "gait": gait_bars(scene, take),
    }
    return FigureWalk(take_glb(take, materials, ground=False), facts)


def _of_the_drawing(reason: str) -> str:
    """Return a reason as it is told beside a drawing, which has no name and no scene to change."""
    told = reason.replace(f"figure '{NAME}'", "the figure").replace(f"'{NAME}'", "the figure")
    head, _, advice = told.rpartition("; ")
    return head if head and "`walk`" in advice else told


def gait_bars(scene: Scene, take: Take) -> list[dict[str, Any]]:
    """Return the planned and actual stances of all creatures that walk, in seconds."""
    channels = {channel.name for channel in take.channels}
    legged = {leg.performer for leg in take.legs}
    found = []
    for _, member in scene.creatures:
        if member.name not in legged or f"{member.name}.gait_phase" not in channels:
            continue
        stances = creature_stances(scene, member.name, take)
        legs = [
            {
                "name": leg.name,
                "color": color,
                "planned": leg.planned.round(4).tolist(),
                "actual": leg.actual.round(4).tolist(),
            }
            for leg, color in zip(stances.legs, stances.colors, strict=True)
        ]
        found.append({"who": member.name, "gait": stances.gait, "legs": legs})
    return found
