"""Running: checks of several scenes, and the reports of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pipeline.errors import StoreError
from pipeline.production.goldens.case import Case, Lab
from pipeline.production.goldens.checking import check
from pipeline.production.goldens.junit import junit_of
from pipeline.production.goldens.places import MADE
from pipeline.production.goldens.report import encoded, facts_of, html_of
from pipeline.production.goldens.verdict import Layer, exit_code
from pipeline.production.reporting import Reporter
from render.backend import Choice

REPORT = "report.html"


def run_checks(
    cases: Sequence[Case],
    out: Path,
    layers: tuple[Layer, ...] | None,
    backend: Choice,
    reporter: Reporter,
) -> int:
    """Check scenes, report on them in `out`, and return the code to end with."""
    folder = out / MADE
    lab = Lab(backend)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        verdicts = []
        for case in cases:
            verdict = check(case, lab, reporter, layers)
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
