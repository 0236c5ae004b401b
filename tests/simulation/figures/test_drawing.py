"""Every drawing becomes a figure, or gets an error with the path of a node or an operation."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import yaml

from pipeline.errors import SceneError
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.figure import build_figure
from pipeline.spec import Figure as FigureConfig
from pipeline.spec import read_scene

KINDS = ("leg", "head", "tail", "feeler", "arm", "body")


def place(rng: np.random.Generator) -> list[float]:
    # Coarse on purpose: nodes then coincide, lie on axes and stand in lines.
    return [float(v) for v in np.round(rng.normal(0.0, 1.5, 2), int(rng.integers(0, 3)))]


def operation(rng: np.random.Generator, names: list[str]) -> dict[str, object]:
    """Return a random operation; its names may be unknown."""
    some = [str(name) for name in rng.choice(names, size=int(rng.integers(1, 4)))]
    chosen = [some, "selected", "all"][int(rng.choice(3, p=[0.7, 0.2, 0.1]))]
    moves = {
        "translate": place(rng),
        "rotate_deg": float(rng.integers(-12, 12) * 15),
        "rotate_abs_deg": float(rng.integers(-4, 4) * 90),
        "scale": float(rng.choice([0.001, 0.5, 2.0, 1000.0])),
        "scale_xy": [0.5, 2.0],
        "mirror": str(rng.choice(["x", "y"])),
    }
    keys = rng.choice(list(moves), size=int(rng.integers(0, 3)), replace=False)
    way = {str(key): moves[str(key)] for key in keys}
    outline = [place(rng) for _ in range(int(rng.integers(3, 7)))]
    forms: list[dict[str, object]] = [
        {"mirror": str(rng.choice(["x", "y"]))},
        {"mirror": "x", "nodes": chosen if chosen != "all" else some},
        {"copy": chosen, **way, "repeat": int(rng.integers(1, 4))},
        {"copy": some, **way, "join": [[some[0], some[-1]]]},
        {"move": chosen, **way},
        {"select": outline if rng.random() < 0.6 else "all"},
        {"select": some},
        {"delete": some},
        {"connect": some},
    ]
    return forms[int(rng.integers(len(forms)))]


def drawing(rng: np.random.Generator) -> dict[str, object]:
    """Return the config of a random drawing."""
    n = int(rng.integers(1, 12))
    names = [f"n{i}" + str(rng.choice(["", "_l", "_r"])) for i in range(n)]
    known = [*names, *(["nobody"] if rng.random() < 0.05 else [])]
    longest = int(rng.integers(2, 6))
    chains = [
        [str(name) for name in rng.choice(known, size=int(rng.integers(2, longest + 1)))]
        for _ in range(int(rng.integers(0, n + 1)))
    ]
    return {
        "style": str(rng.choice(["insect", "mammal"])),
        "pitch_deg": float(rng.choice([0.0, 0.0, 40.0, 90.0, -90.0])),
        "nodes": {name: place(rng) for name in names},
        "chains": [c for c in chains if all(a != b for a, b in itertools.pairwise(c))],
        "then": [operation(rng, known) for _ in range(int(rng.choice([0, 0, 1, 2, 4])))],
        "parts": {
            str(rng.choice(known)): str(rng.choice(KINDS))
            for _ in range(int(rng.choice([0, 0, 1, 3])))
        },
    }


def build_random_figures(seed: int, count: int) -> tuple[int, set[str]]:
    """Build random drawings; return the number of figures, and the heads of all error messages."""
    rng = np.random.default_rng(seed)
    figures, messages = 0, set()
    for _ in range(count):
        config = drawing(rng)
        scene = {"pronk": 1, "frames": 1, "figures": {"it": config}, "cast": [{"figure": "it"}]}
        text = yaml.safe_dump(scene, sort_keys=False)
        try:
            read = read_scene(text, "it.yaml")
            try:
                figure = build_figure("it", read.figures["it"], 1.0)
            except SceneError as error:
                raise read.source_map.with_locations(error) from None
        except SceneError as error:
            for problem in error.problems:
                assert problem.path.startswith("figures.it."), problem
                assert problem.line > 0, problem
                assert problem.column > 0, problem
                is_about = problem.path.startswith(("figures.it.then", "figures.it.chains"))
                assert is_about or problem.path.startswith("figures.it.parts."), problem
                messages.add(" ".join(problem.message.split("'")[0::2])[:24])
            continue
        figures += 1
        skeleton = figure.skeleton
        for numbers in (figure.points, skeleton.places, skeleton.axes, skeleton.preferred):
            assert np.isfinite(numbers).all(), text
        assert np.allclose(np.linalg.norm(skeleton.axes, axis=-1), 1.0), text
        assert len({limb.name for limb in skeleton.limbs}) == len(skeleton.limbs), text
        assert figure.anatomy.body
        shared = [n for a in figure.anatomy.appendages for n in a.nodes[1:]]
        parts = [*figure.anatomy.body, *figure.anatomy.ignored, *shared]
        assert sorted(parts) == list(range(len(figure.drawing.names))), text
    return figures, messages


@pytest.mark.parametrize(
    ("seed", "count", "kinds_of_messages"),
    [
        pytest.param(1, 100, 3, marks=pytest.mark.slow),
        pytest.param(2, 1_000, 8, marks=pytest.mark.nightly),
        pytest.param(3, 10_000, 12, marks=pytest.mark.nightly),
    ],
)
def test_random_drawings_give_figures_or_located_errors(
    seed: int, count: int, kinds_of_messages: int
) -> None:
    figures, messages = build_random_figures(seed, count)
    assert figures > count // 5
    assert len(messages) > kinds_of_messages


def test_copies_keep_radius_and_material() -> None:
    drawn = draw(
        FigureConfig.model_validate(
            {
                "nodes": {"a": [0, 0], "b": {"at": [1, 0], "radius": 0.1, "material": "brass"}},
                "chains": [["a", "b"]],
                "then": [{"copy": ["b"], "scale": 3, "about": "a"}, {"mirror": "x"}],
            }
        )
    )
    assert drawn.names == ("a", "b", "b_2", "b_m", "b_2_m")
    assert drawn.radii[1:].tolist() == pytest.approx([0.1, 0.3, 0.1, 0.3])
    assert drawn.materials[1:] == ("brass",) * 4
    assert drawn.made_by == (-1, -1, 0, 1, 1)
    assert [drawn.path_of(name) for name in ("b", "b_2_m")] == ["nodes.b", "then[1]"]


def test_default_radius_follows_the_extent() -> None:
    config = {"nodes": {"a": [0, 0], "b": [0, 4]}, "chains": [["a", "b"]]}
    assert draw(FigureConfig.model_validate(config)).radii.tolist() == [0.1, 0.1]
    assert draw(FigureConfig.model_validate({**config, "radius": 0.3})).radii.tolist() == [0.3, 0.3]
