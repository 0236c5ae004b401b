"""Mutated scenes: whatever a file holds, `pronk check` finds it right or names a line of it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.production.checking_process import outcome
from tests.production.fuzzing import tried
from tests.production.mutated_scenes import Corpus, mutated_scene

SMALL = ("dice", "pass_by", "ramp")
"""Scenes that are built at once."""

COUNT = 10_000


@pytest.mark.parametrize("first", [0, 10])
def test_some_mutated_scenes_are_right_or_refused(tmp_path: Path, first: int) -> None:
    corpus, file = Corpus.shipped(*SMALL), tmp_path / "scene.yaml"
    for seed in range(first, first + 10):
        file.write_bytes(mutated_scene(corpus, seed))
        kind, text = outcome(file)
        assert kind in ("right", "refused"), f"seed {seed}: {text}"


def test_a_scene_is_mutated_the_same_every_time() -> None:
    corpus = Corpus.shipped(*SMALL)
    scenes = [mutated_scene(corpus, seed) for seed in range(20)]
    assert scenes == [mutated_scene(corpus, seed) for seed in range(20)]
    assert len({*scenes}) > 15


@pytest.mark.nightly
def test_ten_thousand_mutated_scenes_are_right_or_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = list(tried("tests.production.checking_process", tmp_path, 0, COUNT))
    kinds = Counter(line["kind"] for line in lines)
    slowest = max((line["seconds"], line["seed"]) for line in lines)
    faults = [f"seed {line['seed']}: {line['text']}" for line in lines if line["kind"] == "fault"]
    with capsys.disabled():
        print(f"\nmutated scenes: {dict(kinds)}, slowest {slowest[0]} s (seed {slowest[1]})")  # noqa: T201
        print(*faults, sep="\n")  # noqa: T201
    assert not faults
    assert len(lines) == COUNT
    # Otherwise the mutations would test nothing, or break everything at once.
    assert min(kinds["right"], kinds["refused"]) > COUNT / 20
    assert kinds["simulated"] > COUNT / 200
