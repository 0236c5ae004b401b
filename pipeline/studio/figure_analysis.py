"""Figure analysis: what a drawing becomes, as the page shows it while it is drawn."""

from __future__ import annotations

import itertools
from dataclasses import asdict, replace
from typing import Any

from pipeline.errors import Problem, SceneError
from pipeline.production.reports.figure_report import headline
from pipeline.production.reports.plot_colors import BODY_COLOR, FAINT, limb_colors
from pipeline.simulation.figure_analysis import Figure, FigureMass, build_figure, check_figure
from pipeline.spec import Figure as FigureConfig
from pipeline.spec.validation import check
from pipeline.spec.yaml_tree import tree_of
from pipeline.studio.drawing import MAPPINGS, MIRRORED, DrawnFigure
from pipeline.studio.figure_text import NEW_FIGURE, read_figure
from pipeline.studio.joint_facts import posed_facts

NAME = "it"
"""Of the figure in scenes of the studio and in paths of problems."""


def with_drawing(config: FigureConfig | None, drawing: DrawnFigure) -> FigureConfig:
    """Return a figure that is drawn otherwise.

    Args:
        config: as the file has it; None for a new one.
        drawing: its nodes, chains and other values.

    Raises:
        SceneError: the drawing is no figure.
    """
    plain: dict[str, Any] = {}
    if config is not None:
        plain = config.model_dump(exclude_unset=True, by_alias=True)
    kept = plain.get("nodes", {})
    plain["nodes"] = {
        name: {
            **kept.get(name, {}),
            "at": node.at,
            **({} if node.radius is None else {"radius": node.radius}),
        }
        for name, node in drawing.nodes.items()
    }
    plain["chains"] = drawing.chains
    if drawing.is_mirrored is not None:
        plain["then"] = MIRRORED if drawing.is_mirrored else ()
    for key in MAPPINGS:
        plain[key] = getattr(drawing, key)
    plain |= drawing.settings
    made, problems = check(FigureConfig, tree_of(plain))
    if made is None:
        raise SceneError(problems)
    return made


def drawn_text(text: str, file: str) -> tuple[DrawnFigure | None, SceneError | None]:
    """Return the drawing of a text, and what is wrong with it, at its lines.

    A text that is no figure has no drawing; one whose drawing cannot be built has both.

    Args:
        text: of a figure file.
        file: its name, in problems.
    """
    if text == NEW_FIGURE:
        return DrawnFigure(settings={"style": "insect"}), None
    try:
        config, source_map = read_figure(text, file)
    except SceneError as error:
        return None, error
    drawing = DrawnFigure.of(config)
    try:
        build_figure(NAME, config, 1.0)
    except SceneError as error:
        problems = [replace(one, path=f"figure.{_own_path(one)}") for one in error.problems]
        return drawing, source_map.with_locations(SceneError(problems))
    return drawing, None


def analysed(config: FigureConfig, is_whole: bool = True) -> dict[str, Any]:
    """Return the nodes, parts, warnings and masses of a figure as plain values.

    Args:
        config: the figure.
        is_whole: whether its mass and how it stands are found too, for which its solids are made;
            in the middle of a drag there is no time for that.

    Raises:
        SceneError: the drawing is no figure.
    """
    figure = build_figure(NAME, config, 1.0)
    colors = limb_colors([(limb.kind, limb.side) for limb in figure.skeleton.limbs])
    limbs = [
        {
            "name": limb.name,
            "kind": limb.kind,
            "nodes": [figure.drawing.names[n] for n in appendage.nodes],
            "reason": appendage.reason,
            "length": limb.length,
            "color": color,
        }
        for limb, appendage, color in zip(
            figure.skeleton.limbs, figure.anatomy.appendages, colors, strict=True
        )
    ]
    remarks = check_figure(figure) if is_whole else figure.anatomy.warnings
    return {
        "headline": headline(figure),
        "mass": FigureMass(figure).at_rest.mass if is_whole else None,
        "limbs": limbs,
        "warnings": [asdict(remark) for remark in remarks],
        **_drawn(config, figure, colors),
        **(posed_facts(figure) if is_whole else {}),
    }


def _drawn(config: FigureConfig, figure: Figure, colors: list[str]) -> dict[str, Any]:
    """Return the nodes and connections after all operations, each with the color of its part."""
    drawing, anatomy = figure.drawing, figure.anatomy
    marks = config.sheet().marks
    node_colors = [BODY_COLOR if n in anatomy.body else FAINT for n in range(len(drawing.names))]
    pair_colors = dict.fromkeys(anatomy.bones, BODY_COLOR)
    for appendage, color in zip(anatomy.appendages, colors, strict=True):
        for a, b in itertools.pairwise(appendage.nodes):
            pair_colors[min(a, b), max(a, b)] = node_colors[b] = color
    nodes = [
        {
            "name": name,
            "at": drawing.places[n].tolist(),
            "radius": float(drawing.radii[n]),
            "source": marks[name].drawn,
            "is_drawn": name in config.nodes,
            "color": node_colors[n],
        }
        for n, name in enumerate(drawing.names)
    ]
    pairs = [
        [drawing.names[a], drawing.names[b], pair_colors.get((a, b), FAINT)]
        for a, b in drawing.connections
    ]
    return {"nodes": nodes, "connections": pairs}


def problem_facts(problem: Problem) -> dict[str, Any]:
    """Return a problem as the page marks it: its place, its node if there is one, its message."""
    facts = asdict(problem)
    head, _, rest = _own_path(problem).partition("nodes.")
    facts["node"] = rest.split(".")[0].split("[")[0].strip("'") if not head and rest else ""
    return facts


def _own_path(problem: Problem) -> str:
    """Return the path of a problem within its figure."""
    return problem.path.removeprefix(f"figures.{NAME}.")
