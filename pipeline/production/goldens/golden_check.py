"""Checking: a scene against its golden; what differs is kept beside, to be looked at."""

from __future__ import annotations

import json
import shutil
import time
from dataclasses import replace

from pipeline.errors import GoldenMissing, PronkError, StoreError
from pipeline.production.goldens.golden_card import AGAIN, Card, read_card
from pipeline.production.goldens.golden_case import Case, Lab
from pipeline.production.goldens.golden_content import Content, read_content, write_content
from pipeline.production.goldens.judges import judge_film, judge_frames, judge_motion
from pipeline.production.goldens.motion_golden import golden_of
from pipeline.production.goldens.sampling_proof import Proof
from pipeline.production.goldens.verdict import (
    LAYERS,
    Layer,
    LayerVerdict,
    Outcome,
    SceneVerdict,
)
from pipeline.production.run.progress import Reporter, stage


def check(
    case: Case,
    lab: Lab,
    reporter: Reporter,
    layers: tuple[Layer, ...] | None = None,
    proof: Proof | None = None,
) -> SceneVerdict:
    """Compare a scene with its golden, which is only read.

    Args:
        case: the scene.
        lab: renders its frames.
        reporter: is told of it.
        layers: to check; those that the golden has if none are named.
        proof: what the scene gives now, if that is known.
    """
    card, broken = _card(case, layers or LAYERS)
    if card is None:
        return broken
    proof = proof or Proof(case.scene)
    made = Content(case.name)
    verdicts = []
    wanted = layers or card.layers
    with stage(reporter, case.name, len(wanted)) as current:
        for done, layer in enumerate(wanted, start=1):
            began = time.monotonic()
            verdict, made = _layer(case, card, layer, proof, lab, made)
            verdicts.append(replace(verdict, seconds=round(time.monotonic() - began, 3)))
            current.advance(done)
        result = SceneVerdict(case.name, tuple(verdicts))
        current.result = result.outcome.value
    _keep(case, card, result, made)
    return result


def _card(case: Case, layers: tuple[Layer, ...]) -> tuple[Card | None, SceneVerdict]:
    """Return the card of a golden, or the verdict where it has none that can be read."""
    try:
        card = read_card(case.golden.card)
        if card.scene != case.name:
            raise StoreError(
                f"{case.golden.card}: is of {card.scene!r}, not of {case.name!r}; {AGAIN}"
            )
        return card, SceneVerdict(case.name, ())
    except GoldenMissing as error:
        outcome, text = Outcome.MISSING, str(error)
    except StoreError as error:
        outcome, text = Outcome.DAMAGED, str(error)
    verdicts = tuple(LayerVerdict(layer, outcome, text) for layer in layers)
    return None, SceneVerdict(case.name, verdicts[:1])


def _layer(
    case: Case, card: Card, layer: Layer, proof: Proof, lab: Lab, made: Content
) -> tuple[LayerVerdict, Content]:
    """Return the verdict on a layer, and `made` with what was made for it."""
    if layer not in card.layers:
        text = f"{case.golden.path}: has no such layer; add it with pronk golden record --again"
        return LayerVerdict(layer, Outcome.MISSING, text), made
    try:
        golden = read_content(case.golden, card, (layer,))
    except PronkError as error:
        return LayerVerdict(layer, Outcome.DAMAGED, str(error)), made
    try:
        if layer == "motion":
            verdict = judge_motion(golden, proof.take, proof.cues)
            if verdict.outcome is not Outcome.IDENTICAL:  # packing takes longer than simulating
                made = replace(made, motion=golden_of(proof.take, case.name), cues=proof.cues)
            return verdict, made
        if layer == "film":
            made = replace(made, film=proof.film)
            return judge_film(golden, proof.film, float(1 / case.scene.rate)), made
        return _frames(case, golden, proof, lab, made)
    except PronkError as error:
        return LayerVerdict(layer, Outcome.FAILED, str(error)), made


def _frames(
    case: Case, golden: Content, proof: Proof, lab: Lab, made: Content
) -> tuple[LayerVerdict, Content]:
    framing = golden.framing
    assert framing is not None
    last = proof.take.header.frames
    if framing.numbers[-1] > last:
        text = f"the scene has frames 1-{last}, and the golden shows {framing.numbers[-1]}"
        return LayerVerdict("frames", Outcome.CHANGED, text), made
    frames = dict(proof.frames(framing, lab.renderer))
    made = replace(made, framing=framing, frames=frames, environment=lab.environment)
    return judge_frames(golden, frames, lab.environment), made


def _keep(case: Case, card: Card, verdict: SceneVerdict, made: Content) -> None:
    """Keep what differs from the golden where `approve` finds it, nothing if nothing does."""
    case.compared.unlink(missing_ok=True)
    shutil.rmtree(case.made.path, ignore_errors=True)
    differ = [v.layer for v in verdict.layers if v.outcome is not Outcome.IDENTICAL]
    there = [layer for layer in differ if layer in made.layers]
    if not there:
        return
    write_content(made, case.made)
    words = {"golden": card.seal, "made": read_card(case.made.card).seal, "differ": there}
    case.compared.write_text(json.dumps(words, indent=1) + "\n", encoding="utf-8", newline="\n")
