"""Golden check: scenes against their goldens, with reports and what differs kept beside them."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import GoldenMissing, ProductionError, PronkError, StoreError
from pipeline.production.goldens.golden_candidate import Candidate
from pipeline.production.goldens.golden_card import RESTORE_HINT, Card, read_card
from pipeline.production.goldens.golden_case import CHECK_FOLDER, Case, GoldenRenderer
from pipeline.production.goldens.golden_content import Content, read_content, write_content
from pipeline.production.goldens.judges import judge_film, judge_frames, judge_motion
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.production.goldens.report import encoded, html_report, junit_report, verdict_facts
from pipeline.production.goldens.verdict import (
    LAYERS,
    Layer,
    LayerVerdict,
    Outcome,
    SceneVerdict,
)
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.progress import Reporter, stage
from pipeline.production.run.workers import worker_pool
from render.backend import Choice

REPORT = "report.html"


def check(
    case: Case,
    renderer: GoldenRenderer,
    reporter: Reporter,
    layers: tuple[Layer, ...] | None = None,
    candidate: Candidate | None = None,
) -> SceneVerdict:
    """Compare a scene with its golden, which is only read.

    Args:
        case: the scene.
        renderer: of its frames.
        reporter: of progress.
        layers: to check; None for those of the golden.
        candidate: present results of the scene, if there are any.
    """
    card, broken = _read_card(case, layers or LAYERS)
    if card is None:
        return broken
    candidate = candidate or Candidate(case.scene)
    made = Content(case.name)
    verdicts = []
    wanted = layers or card.layers
    with stage(reporter, case.name, len(wanted)) as current, compile_progress(reporter, current):
        for done, layer in enumerate(wanted, start=1):
            began = time.monotonic()
            verdict, made = _check_layer(case, card, layer, candidate, renderer, made)
            verdicts.append(replace(verdict, seconds=round(time.monotonic() - began, 3)))
            current.advance(done)
        result = SceneVerdict(case.name, tuple(verdicts))
        current.result = result.outcome.value
    _store_differences(case, card, result, made)
    return result


def _read_card(case: Case, layers: tuple[Layer, ...]) -> tuple[Card | None, SceneVerdict]:
    """Return the card of a golden, or the verdict if there is none that can be read."""
    try:
        card = read_card(case.golden.card)
        if card.scene != case.name:
            raise StoreError(
                f"{case.golden.card}: is of {card.scene!r}, not of {case.name!r}; {RESTORE_HINT}"
            )
        return card, SceneVerdict(case.name, ())
    except GoldenMissing as error:
        outcome, text = Outcome.MISSING, str(error)
    except StoreError as error:
        outcome, text = Outcome.DAMAGED, str(error)
    verdicts = tuple(LayerVerdict(layer, outcome, text) for layer in layers)
    return None, SceneVerdict(case.name, verdicts[:1])


def _check_layer(
    case: Case,
    card: Card,
    layer: Layer,
    candidate: Candidate,
    renderer: GoldenRenderer,
    made: Content,
) -> tuple[LayerVerdict, Content]:
    """Return the verdict on a layer, and `made` with the results for it."""
    if layer not in card.layers:
        text = f"{case.golden.path}: has no such layer; add it with pronk golden record --again"
        return LayerVerdict(layer, Outcome.MISSING, text), made
    try:
        golden = read_content(case.golden, card, (layer,))
    except PronkError as error:
        return LayerVerdict(layer, Outcome.DAMAGED, str(error)), made
    try:
        if layer == "motion":
            verdict = judge_motion(golden, candidate.take, candidate.cues)
            # Packing takes longer than simulating.
            if verdict.outcome is not Outcome.IDENTICAL:
                made = replace(
                    made, motion=golden_of(candidate.take, case.name), cues=candidate.cues
                )
            return verdict, made
        if layer == "film":
            made = replace(made, film=candidate.film)
            return judge_film(golden, candidate.film, float(1 / case.scene.rate)), made
        return _check_frames(golden, candidate, renderer, made)
    except PronkError as error:
        return LayerVerdict(layer, Outcome.FAILED, str(error)), made


def _check_frames(
    golden: Content, candidate: Candidate, renderer: GoldenRenderer, made: Content
) -> tuple[LayerVerdict, Content]:
    framing = golden.framing
    assert framing is not None
    last = candidate.take.header.frames
    if framing.numbers[-1] > last:
        text = f"the scene has frames 1-{last}, and the golden shows {framing.numbers[-1]}"
        return LayerVerdict("frames", Outcome.CHANGED, text), made
    frames = dict(candidate.frames(framing, renderer.loaded))
    made = replace(made, framing=framing, frames=frames, environment=renderer.environment)
    return judge_frames(golden, frames, renderer.environment), made


def _store_differences(case: Case, card: Card, verdict: SceneVerdict, made: Content) -> None:
    """Store layers that differ for `approve`, in place of those of earlier checks."""
    case.compared.unlink(missing_ok=True)
    shutil.rmtree(case.made.path, ignore_errors=True)
    differ = [v.layer for v in verdict.layers if v.outcome is not Outcome.IDENTICAL]
    stored = [layer for layer in differ if layer in made.layers]
    if not stored:
        return
    write_content(made, case.made)
    compared = {"golden": card.seal, "made": read_card(case.made.card).seal, "differ": stored}
    write_if_changed(case.compared, (json.dumps(compared, indent=1) + "\n").encode())


def run_checks(
    cases: Sequence[Case],
    out: Path,
    layers: tuple[Layer, ...] | None,
    backend: Choice,
    jobs: int,
    reporter: Reporter,
) -> list[SceneVerdict]:
    """Check scenes in `jobs` processes, write the reports into `out`, and return the verdicts.

    Raises:
        StoreError: the report cannot be written.
        ProductionError: a process died.
    """
    folder = out / CHECK_FOLDER
    try:
        make_folder(folder)
        verdicts = []
        for verdict in _verdicts(cases, layers, backend, min(jobs, len(cases)), reporter):
            verdicts.append(verdict)
            layers_found = [
                {"layer": found.layer, "outcome": found.outcome.value, "text": found.text}
                for found in verdict.layers
            ]
            reporter.result(
                str(verdict), passed=verdict.passed, scene=verdict.scene, layers=layers_found
            )
        facts = verdict_facts(cases, verdicts)
        write_if_changed(folder / "report.json", encoded(facts).encode())
        write_if_changed(folder / "junit.xml", junit_report(verdicts))
        write_if_changed(folder / REPORT, html_report(cases, verdicts).encode())
    except OSError as error:
        raise StoreError(f"{folder}: could not be written: {error.strerror}") from error
    failed = [verdict for verdict in verdicts if not verdict.passed]
    summary = "all hold" if not failed else f"{len(failed)} do not hold"
    reporter.note(f"{len(verdicts)} goldens, {summary}; {folder / REPORT}")
    return verdicts


def _verdicts(
    cases: Sequence[Case],
    layers: tuple[Layer, ...] | None,
    backend: Choice,
    jobs: int,
    reporter: Reporter,
) -> Iterator[SceneVerdict]:
    """Yield the verdicts on `cases` in their order."""
    if jobs < 2:
        renderer = GoldenRenderer(backend)
        for case in cases:
            yield check(case, renderer, reporter, layers)
        return
    death = ProductionError("a process that checked has died; try fewer --jobs")
    work = partial(_check_in_worker, cases, layers, backend)
    with worker_pool(jobs, death, work, range(len(cases))) as parts:
        for part in parts:
            verdict = part.result()
            if isinstance(verdict, str):
                raise ProductionError(verdict)
            yield verdict


def _check_in_worker(
    cases: Sequence[Case], layers: tuple[Layer, ...] | None, backend: Choice, index: int
) -> SceneVerdict | str:
    """Check one case in a worker; an error is returned as its message."""
    try:
        return check(cases[index], _worker_renderer(backend), Reporter(), layers)
    except PronkError as error:
        return str(error)


@cache
def _worker_renderer(backend: Choice) -> GoldenRenderer:
    """Return the renderer of this worker, kept for all its cases."""
    return GoldenRenderer(backend)
