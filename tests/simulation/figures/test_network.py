"""Anatomy of drawings: kinds of appendages, bodies, hints and errors."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from pipeline.errors import SceneError
from pipeline.simulation.figures.drawing import draw
from pipeline.simulation.figures.network import Anatomy, analyse
from pipeline.spec import Figure as Words

RINGS = {
    "nodes": {
        "a": [-1, -3], "b": [1, -3], "c": [0, -2], "d": [0, 0], "e": [0, 2], "f": [1, 3],
        "g": [-1, 3],
    },
    "chains": [["a", "b", "c", "a"], ["c", "d", "e"], ["e", "f", "g", "e"]],
}  # fmt: skip


class Parts:
    """The anatomy of a drawing, by node names."""

    def __init__(self, config: Mapping[str, object]) -> None:
        figure = Words.model_validate(config)
        self.drawing = draw(figure)
        self.anatomy: Anatomy = analyse(self.drawing, figure.parts)

    def names(self, nodes: tuple[int, ...]) -> list[str]:
        """Return the names of nodes."""
        return [self.drawing.names[n] for n in nodes]

    @property
    def body(self) -> str:
        """Names of the body's nodes."""
        return " ".join(self.names(self.anatomy.body))

    @property
    def limbs(self) -> dict[str, str]:
        """Kind and nodes by tip."""
        return {
            self.drawing.names[a.nodes[-1]]: f"{a.kind}: {' '.join(self.names(a.nodes))}"
            for a in self.anatomy.appendages
        }

    @property
    def warnings(self) -> list[str]:
        """Warnings about the drawing."""
        return [str(remark) for remark in self.anatomy.warnings]


def worm(n: int, parts: Mapping[str, str] | None = None, along: str = "y") -> Parts:
    nodes = {f"n{i}": [0, i] if along == "y" else [i, 0] for i in range(n)}
    return Parts({"nodes": nodes, "chains": [list(nodes)], "parts": dict(parts or {})})


def test_body_of_a_chain_is_its_middle() -> None:
    assert worm(2).body == "n0 n1"
    assert worm(2).limbs == {}
    assert worm(3).body == "n1"
    assert worm(4).body == "n1 n2"
    assert worm(5).limbs == {"n0": "head: n2 n1 n0", "n4": "tail: n2 n3 n4"}
    assert worm(5, along="x").limbs == worm(5).limbs
    assert any("one chain without a branch: 'n2' is its body" in w for w in worm(5).warnings)


def test_parts_choose_the_body_of_a_chain() -> None:
    assert worm(5, {"n1": "body"}).limbs == {"n0": "head: n1 n0", "n4": "tail: n1 n2 n3 n4"}
    between = worm(6, {"n1": "body", "n3": "body"})
    assert between.body == "n1 n2 n3"
    at_an_end = worm(4, {"n0": "body"})
    assert at_an_end.body == "n0"
    assert list(at_an_end.limbs) == ["n3"]
    assert worm(3, {"n0": "body", "n2": "body"}).limbs == {}


def test_parts_choose_the_ends_of_a_chain() -> None:
    assert worm(3, {"n0": "leg", "n2": "leg"}).limbs == {"n0": "leg: n1 n0", "n2": "leg: n1 n2"}
    assert worm(3, {"n0": "feeler"}).limbs == {"n0": "feeler: n1 n0"}


def test_parts_extend_the_body_into_an_appendage() -> None:
    fork = {
        "nodes": {"a": [0, 0], "l": [-1, 0], "k": [1, 0], "r": [2, 0], "h": [0, -1]},
        "chains": [["l", "a", "k", "r"], ["a", "h"]],
    }
    assert Parts(fork).body == "a"
    assert Parts(fork).limbs == {"l": "leg: a l", "r": "leg: a k r", "h": "head: a h"}
    whole = Parts({**fork, "parts": {"r": "body"}})
    assert whole.body == "a k r"
    assert list(whole.limbs) == ["l", "h"]
    half = Parts({**fork, "parts": {"k": "body"}})
    assert half.body == "a k"
    assert half.limbs["r"] == "leg: k r"


def test_parts_name_kinds_by_tip() -> None:
    star = {
        "nodes": {"c": [0, 0], "n": [0, -1], "s": [0, 1], "e": [1, 0], "w": [-1, 0]},
        "chains": [["c", tip] for tip in "nsew"],
    }
    assert {tip: text[:3] for tip, text in Parts(star).limbs.items()} == {
        "w": "leg", "e": "leg", "n": "hea", "s": "tai"
    }  # fmt: skip
    parts = Parts({**star, "parts": {"n": "leg", "s": "arm", "e": "head", "w": "feeler"}})
    assert {tip: text.split(":")[0] for tip, text in parts.limbs.items()} == {
        "n": "leg", "s": "arm", "e": "head", "w": "feeler"
    }  # fmt: skip


def test_front_most_base_on_the_midline_carries_the_head() -> None:
    chain = ["s1", "s2", "s3"]
    nodes = {"s1": [0, 0], "s2": [0, 1], "s3": [0, 2], "x": [0, -1], "y": [0.1, 0.2], "z": [0, 3]}
    nodes |= {f"{s}{i}": [side * 1.0, i] for i in range(3) for s, side in (("l", -1), ("r", 1))}
    legs = [[f"l{i}", f"s{i + 1}", f"r{i}"] for i in range(3)]
    built = Parts({"nodes": nodes, "chains": [chain, ["s1", "x"], ["s2", "y"], ["s3", "z"], *legs]})
    kinds = {tip: text.split(":")[0] for tip, text in built.limbs.items()}
    assert kinds.pop("x") == "head"
    assert kinds.pop("z") == "tail"
    assert set(kinds.values()) == {"leg"}


def test_midline_of_a_drawing_beside_the_axis() -> None:
    nodes = {"c": [5, 0], "n": [5, -1], "e": [6, 0], "w": [4, 0]}
    built = Parts({"nodes": nodes, "chains": [["c", tip] for tip in "new"]})
    assert [a.side for a in built.anatomy.appendages] == ["l", "r", "m"]
    assert built.limbs["n"].startswith("head")


def test_loops_and_their_bridge_are_body() -> None:
    built = Parts(RINGS)
    assert built.body == "a b c d e f g"
    (bridge,) = [text for text in built.warnings if "bridge" in text]
    assert "the loops of 'a', 'b', 'c' and of 'e', 'f', 'g' are joined" in bridge
    assert "'c' - 'd' - 'e'" in bridge


@pytest.mark.parametrize("legs", [0, 1, 3, 5])
def test_any_number_of_legs_is_recognised(legs: int) -> None:
    nodes: dict[str, object] = {"a": [0, -1], "b": [0, 1], "c": [0.3, 0]}
    nodes |= {f"f{i}": [2.0 if i % 2 else -2.0, i - 2.0] for i in range(legs)}
    chains = [["a", "b", "c", "a"], *(["a", f"f{i}"] for i in range(legs))]
    built = Parts({"nodes": nodes, "chains": chains})
    assert [a.kind for a in built.anatomy.appendages] == ["leg"] * legs
    assert any("no leg" in text for text in built.warnings) == (legs == 0)


def test_disconnected_nodes_are_ignored_with_a_hint() -> None:
    nodes = {"a": [0, 0], "b": [0, 1], "c": [0, 2], "x": [5, 5], "y": [6, 6]}
    built = Parts({"nodes": nodes, "chains": [["a", "b", "c"], ["x", "y"]]})
    assert built.names(built.anatomy.ignored) == ["x", "y"]
    assert "'x', 'y' are not connected to the rest and ignored" in built.warnings


def test_coincident_nodes_get_a_hint() -> None:
    nodes = {"a": [0, 0], "b": [0, 1], "c": [0, 2], "d": [0, 1]}
    built = Parts({"nodes": nodes, "chains": [["a", "b", "c"], ["a", "d"]]})
    assert any("'b' and 'd' are at the same place" in text for text in built.warnings)


@pytest.mark.parametrize(
    ("config", "path", "phrases"),
    [
        ({**RINGS, "parts": {"a": "leg"}}, "parts.a", ["'a' is on a loop", "'b', 'c'", "leg"]),
        ({**RINGS, "parts": {"d": "tail"}}, "parts.d", ["'d' is no tip", "has none"]),
        ({"nodes": {"a": [0, 0]}}, "chains", ["'a'", "no connections"]),
        (
            {"nodes": {"a": [0, 0], "b": [0, 1], "x": [3, 3]}, "chains": [["a", "b"]],
             "parts": {"x": "leg"}},
            "parts.x", ["'x' is not connected"],
        ),
    ],
)  # fmt: skip
def test_invalid_parts_are_refused(
    config: Mapping[str, object], path: str, phrases: list[str]
) -> None:
    with pytest.raises(SceneError) as caught:
        Parts(config)
    (problem,) = caught.value.problems
    assert problem.path == path
    for text in phrases:
        assert text in problem.message
