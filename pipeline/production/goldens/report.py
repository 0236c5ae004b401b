"""Report: one page that says what differs and shows it, without asking any network."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib.resources import files
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.production.goldens.flip_palette import painted
from pipeline.production.goldens.golden_case import Case
from pipeline.production.goldens.metric_plot import metric_plot
from pipeline.production.goldens.verdict import (
    FrameVerdict,
    LayerVerdict,
    Outcome,
    SceneVerdict,
    exit_code,
)
from render.comparison.flip_metric import flip
from render.errors import RenderError
from render.image_files import read_png

SHOWN = (Outcome.CHANGED, Outcome.UNJUDGED, Outcome.WITHIN)
"""Outcomes of frames that are shown."""

_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def facts_of(cases: Sequence[Case], verdicts: Sequence[SceneVerdict]) -> dict[str, Any]:
    """Return the verdicts as plain values."""
    scenes = []
    for case, verdict in zip(cases, verdicts, strict=True):
        words = asdict(verdict, dict_factory=_plain)
        told = {"passed": verdict.passed, "outcome": verdict.outcome.value}
        scenes.append({**words, **told, "golden": str(case.golden.path), "approve": command(case)})
    return {"report": 1, "exit_code": exit_code(verdicts), "scenes": scenes}


def encoded(facts: dict[str, Any]) -> str:
    """Return facts as JSON."""
    return json.dumps(facts, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    # JSON has no infinity: the ratio of equal pictures is null.
    plain = {key: value.value if isinstance(value, Outcome) else value for key, value in pairs}
    if plain.get("psnr") == float("inf"):
        plain["psnr"] = None
    return plain


def command(case: Case) -> str:
    """Return the command that makes what was found the golden."""
    return f"pronk golden approve {case.words}"


def html_of(cases: Sequence[Case], verdicts: Sequence[SceneVerdict]) -> str:
    """Return the page; what failed stands first."""
    pairs = sorted(zip(cases, verdicts, strict=True), key=lambda pair: pair[1].passed)
    failed = sum(not verdict.passed for verdict in verdicts)
    head = f"{failed} of {len(verdicts)} do not hold" if failed else f"all {len(verdicts)} hold"
    body = "\n".join(_scene(case, verdict) for case, verdict in pairs)
    kit = files("pipeline.production.goldens")
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Goldens: {head}</title>
<style>{kit.joinpath("report.css").read_text(encoding="utf-8")}</style></head>
<body>
<header><h1>Goldens: {head}</h1>
<label><input type="checkbox" id="failures"> failures only</label>
<label>blink every <input type="range" id="pace" min="100" max="1500" step="50" value="500">
<output id="pace-told">500 ms</output></label>
<label>zoom <select id="zoom"><option>1</option><option selected>2</option><option>4</option>
</select></label></header>
<main>
{body}
</main>
<script>{kit.joinpath("report.js").read_text(encoding="utf-8")}</script>
</body></html>
"""


def _scene(case: Case, verdict: SceneVerdict) -> str:
    fate = "holds" if verdict.passed else "fails"
    layers = "\n".join(_layer(case, layer) for layer in verdict.layers)
    approve = ""
    if any(layer.outcome in (Outcome.CHANGED, Outcome.UNJUDGED) for layer in verdict.layers):
        words = html.escape(command(case))
        approve = (
            f'<p class="approve">If that is meant: <code>{words}</code> '
            f'<button type="button" class="copy" data-words="{words}">copy</button></p>'
        )
    opened = "" if verdict.passed else " open"
    return f"""<details class="scene {fate}"{opened}>
<summary><b>{html.escape(verdict.scene)}</b>
<span class="fate">{verdict.outcome.value}</span></summary>
{approve}
{layers}
</details>"""


def _layer(case: Case, layer: LayerVerdict) -> str:
    details = "".join(f"<li>{html.escape(detail)}</li>" for detail in layer.details)
    fate = "holds" if layer.passed else "fails"
    plot = metric_plot(layer.frames) if len(layer.frames) > 1 else ""
    views = "\n".join(_view(case, one) for one in layer.frames if one.outcome in SHOWN)
    return f"""<section class="layer {fate}"><h2>{layer.layer}
<span class="fate">{layer.outcome.value}</span> <small>{layer.seconds:.1f} s</small></h2>
<p>{html.escape(layer.text)}</p>
<ul>{details}</ul>
{plot}
{views}
</section>"""


def _view(case: Case, frame: FrameVerdict) -> str:
    try:
        golden = read_png(case.golden.frame(frame.frame))
        new = read_png(case.made.frame(frame.frame))
    except RenderError as error:
        return f"<p>frame {frame.frame}: {html.escape(str(error))}</p>"
    heat = painted(flip(golden, new)) if golden.shape == new.shape else np.zeros_like(golden)
    height, width = golden.shape[:2]
    boxes = "".join(
        f'<rect x="{b.left}" y="{b.top}" width="{b.width}" height="{b.height}">'
        f"<title>{b.value:.4f}</title></rect>"
        for b in frame.boxes
    )
    modes = "".join(
        f'<button type="button" data-mode="{mode}">{told}</button>'
        for mode, told in (
            ("golden", "golden"),
            ("new", "new"),
            ("map", "FLIP map"),
            ("blink", "blink"),
            ("swipe", "swipe"),
            ("side", "side by side"),
        )
    )
    return f"""<figure class="view" data-mode="side" data-width="{width}" data-height="{height}"
 id="{html.escape(case.name)}-{frame.frame}" style="--w:{width};--h:{height}">
<figcaption>frame {frame.frame}: {html.escape(frame.text)}
<small>({html.escape(frame.rule)})</small></figcaption>
<div class="modes">{modes}<label><input type="checkbox" class="boxed" checked> worst tiles</label>
<input type="range" class="edge" min="0" max="100" value="50" aria-label="edge of the swipe"></div>
<div class="stage">
<div class="layer-golden"><img alt="golden" src="{_data(golden)}"></div>
<div class="layer-new"><img alt="new" src="{_data(new)}"></div>
<div class="layer-map"><img alt="FLIP map" src="{_data(heat)}"></div>
<svg class="boxes" viewBox="0 0 {width} {height}">{boxes}</svg>
<div class="handle"></div></div></figure>"""


def _data(picture: NDArray[np.uint8]) -> str:
    out = BytesIO()
    Image.fromarray(picture).save(out, "PNG", compress_level=9)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")
