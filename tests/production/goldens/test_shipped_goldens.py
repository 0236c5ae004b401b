"""The project's own goldens of frames and films, in `tests/goldens/films`, still hold.

They are written by `pronk golden record SCENE --goldens tests/goldens/films`, and approved
likewise. Where the processor or the renderer's libraries are others than theirs, variances
decide; where these are missing, nobody can tell.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.production.goldens.golden_case import GoldenRenderer, cases_of, goldens_in
from pipeline.production.goldens.golden_check import check
from pipeline.production.goldens.verdict import Outcome
from pipeline.production.run.progress import Reporter

FILMS = Path(__file__).parents[2] / "goldens" / "films"
MOST_BYTES = 600_000
"""Of a golden: version control keeps every one that ever was."""

pytestmark = pytest.mark.slow

LONG = ("dice", "stacking", "toy")
"""Goldens that take the longest."""


@pytest.fixture(scope="module")
def lab() -> GoldenRenderer:
    return GoldenRenderer()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.nightly if name in LONG else ())
        for name in sorted(golden.path.name for golden in goldens_in(FILMS))
    ],
)
def test_a_shipped_scene_matches_its_golden(name: str, lab: GoldenRenderer, tmp_path: Path) -> None:
    (case,) = cases_of([name], FILMS, tmp_path)
    (tmp_path / "golden").mkdir()
    verdict = check(case, lab, Reporter())
    if verdict.outcome is Outcome.UNJUDGED:
        pytest.skip(str(verdict))
    assert verdict.passed, str(verdict)
    assert sum(path.stat().st_size for path in case.golden.path.iterdir()) < MOST_BYTES
