"""Running: checks of several scenes, and the reports of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path

from pipeline.errors import ProductionError, PronkError, StoreError
from pipeline.production.goldens.golden_case import Case, Lab
from pipeline.production.goldens.golden_check import check
from pipeline.production.goldens.golden_files import MADE
from pipeline.production.goldens.junit import junit_of
from pipeline.production.goldens.report import encoded, facts_of, html_of
from pipeline.production.goldens.verdict import Layer, SceneVerdict, exit_code
from pipeline.production.run.progress import Reporter
from pipeline.production.run.workers import children_ignore_interrupts, worker_pool
from render.backend import Choice

REPORT = "report.html"


def run_checks(
    cases: Sequence[Case],
    out: Path,
    layers: tuple[Layer, ...] | None,
    backend: Choice,
    jobs: int,
    reporter: Reporter,
) -> int:
    """Check scenes in `jobs` processes, report on them in `out`, and return the code to end with.

    Raises:
        StoreError: the report cannot be written.
        ProductionError: a process died.
    """
    folder = out / MADE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        verdicts = []
        for verdict in _verdicts(cases, layers, backend, min(jobs, len(cases)), reporter):
            verdicts.append(verdict)
            facts = asdict(verdict)
            reporter.result(
                str(verdict),
                passed=verdict.passed,
                scene=verdict.scene,
                layers=[
                    {"layer": one["layer"], "outcome": one["outcome"].value, "text": one["text"]}
                    for one in facts["layers"]
                ],
            )
        facts = facts_of(cases, verdicts)
        (folder / "report.json").write_text(encoded(facts), encoding="utf-8", newline="\n")
        (folder / "junit.xml").write_bytes(junit_of(verdicts))
        (folder / REPORT).write_text(html_of(cases, verdicts), encoding="utf-8", newline="\n")
    except OSError as error:
        raise StoreError(f"{folder}: could not be written: {error.strerror}") from error
    failed = [verdict for verdict in verdicts if not verdict.passed]
    told = "all hold" if not failed else f"{len(failed)} do not hold"
    reporter.note(f"{len(verdicts)} goldens, {told}; {folder / REPORT}")
    return exit_code(verdicts)


def _verdicts(
    cases: Sequence[Case],
    layers: tuple[Layer, ...] | None,
    backend: Choice,
    jobs: int,
    reporter: Reporter,
) -> Iterator[SceneVerdict]:
    """Yield the verdicts on `cases` in their order."""
    if jobs < 2:
        lab = Lab(backend)
        for case in cases:
            yield check(case, lab, reporter, layers)
        return
    death = ProductionError("a process that checked has died; try fewer --jobs")
    with worker_pool(jobs, death) as pool:
        with children_ignore_interrupts():
            parts = [pool.submit(_checked, case, layers, backend) for case in cases]
        for part in parts:
            verdict = part.result()
            if isinstance(verdict, str):
                raise ProductionError(verdict)
            yield verdict


def _checked(case: Case, layers: tuple[Layer, ...] | None, backend: Choice) -> SceneVerdict | str:
    """Check one case in a worker; an error comes back as its message."""
    try:
        return check(case, _lab(backend), Reporter(), layers)
    except PronkError as error:
        return str(error)


@cache
def _lab(backend: Choice) -> Lab:
    """Return what this worker renders with, kept for all its cases."""
    return Lab(backend)
