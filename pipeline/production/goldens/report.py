"""Reports of a check: a page that needs no network, plain values, and JUnit for build servers."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from importlib.resources import files
from io import BytesIO
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.production.goldens.golden_case import Case
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

_STOPS: Final = (
    (0.0, (0, 0, 4)),
    (0.15, (42, 17, 92)),
    (0.35, (130, 36, 128)),
    (0.55, (213, 70, 107)),
    (0.75, (250, 137, 96)),
    (1.0, (252, 253, 191)),
)
"""Lightness rises evenly, so that the map is readable in grey."""


def heat_map(errors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) of errors (H, W) from 0 to 1."""
    at = [place for place, _ in _STOPS]
    channels = [np.interp(errors, at, [color[c] for _, color in _STOPS]) for c in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


_WIDTH: Final = 640
_HEIGHT: Final = 120
_LEFT: Final = 48
_BOTTOM: Final = 22


def metric_plot(frames: Sequence[FrameVerdict]) -> str:
    """Return FLIP of the worst tile and of the whole picture over the frames, as SVG."""
    first, last = frames[0].frame, frames[-1].frame
    top = max([0.05, *(frame.tile for frame in frames)])

    def place(frame: int, value: float) -> tuple[float, float]:
        x = _LEFT + (frame - first) / max(last - first, 1) * (_WIDTH - _LEFT - 12)
        return round(x, 1), round(8 + (1 - value / top) * (_HEIGHT - _BOTTOM - 8), 1)

    lines = []
    for name, values in (
        ("tile", [(f.frame, f.tile) for f in frames]),
        ("mean", [(f.frame, f.mean) for f in frames]),
    ):
        points = " ".join(f"{x},{y}" for x, y in (place(*value) for value in values))
        lines.append(f'<polyline class="{name}" points="{points}"/>')
    for frame in frames:
        x, y = place(frame.frame, frame.tile)
        fate = "fails" if frame.outcome is Outcome.CHANGED else "holds"
        lines.append(
            f'<circle class="{fate}" cx="{x}" cy="{y}" r="4"><title>frame {frame.frame}: '
            f"tile {frame.tile:.4f}, mean {frame.mean:.4f}</title></circle>"
            f'<text x="{x}" y="{_HEIGHT - 6}" text-anchor="middle">{frame.frame}</text>'
        )
    base = _HEIGHT - _BOTTOM
    return (
        f'<svg class="plot" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="FLIP over the frames">'
        f'<path class="axis" d="M{_LEFT} 8V{base}H{_WIDTH - 8}"/>'
        f'<text x="{_LEFT - 6}" y="14" text-anchor="end">{top:.2f}</text>'
        f'<text x="{_LEFT - 6}" y="{base}" text-anchor="end">0</text>'
        f"{''.join(lines)}"
        f'<text class="key" x="{_WIDTH - 8}" y="14" text-anchor="end">'
        f'<tspan class="tile">worst tile</tspan> <tspan class="mean">mean</tspan></text></svg>'
    )


SHOWN_OUTCOMES = (Outcome.CHANGED, Outcome.UNJUDGED, Outcome.WITHIN)
"""Outcomes of frames whose pictures are shown."""

_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


def verdict_facts(cases: Sequence[Case], verdicts: Sequence[SceneVerdict]) -> dict[str, Any]:
    """Return verdicts as plain values."""
    scenes = []
    for case, verdict in zip(cases, verdicts, strict=True):
        facts = asdict(verdict, dict_factory=_plain)
        facts |= {"passed": verdict.passed, "outcome": verdict.outcome.value}
        facts |= {"golden": str(case.golden.path), "approve": approve_command(case)}
        scenes.append(facts)
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


def approve_command(case: Case) -> str:
    """Return the command that approves the results of a check."""
    return f"pronk golden approve {case.arguments}"


def html_report(cases: Sequence[Case], verdicts: Sequence[SceneVerdict]) -> str:
    """Return the page, failures first."""
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
        approve_text = html.escape(approve_command(case))
        approve = (
            f'<p class="approve">If that is meant: <code>{approve_text}</code> '
            f'<button type="button" class="copy" data-words="{approve_text}">copy</button></p>'
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
    views = "\n".join(
        _view(case, frame) for frame in layer.frames if frame.outcome in SHOWN_OUTCOMES
    )
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
    heat = heat_map(flip(golden, new)) if golden.shape == new.shape else np.zeros_like(golden)
    height, width = golden.shape[:2]
    boxes = "".join(
        f'<rect x="{b.left}" y="{b.top}" width="{b.width}" height="{b.height}">'
        f"<title>{b.value:.4f}</title></rect>"
        for b in frame.boxes
    )
    modes = "".join(
        f'<button type="button" data-mode="{mode}">{label}</button>'
        for mode, label in (
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


_ERROR_OUTCOMES = (Outcome.MISSING, Outcome.DAMAGED, Outcome.FAILED)
# XML 1.0 knows no other control characters than tab and ends of lines.
_INVALID_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_report(verdicts: Sequence[SceneVerdict]) -> bytes:
    """Return JUnit XML with a suite per scene and a case per layer.

    Changes are failures; missing or damaged goldens and failed runs are errors; layers that cannot
    be judged here are skipped.
    """
    root = ElementTree.Element("testsuites", name="pronk golden check")
    for verdict in verdicts:
        layers = verdict.layers
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=_clean(verdict.scene),
            tests=str(len(layers)),
            failures=str(sum(layer.outcome is Outcome.CHANGED for layer in layers)),
            errors=str(sum(layer.outcome in _ERROR_OUTCOMES for layer in layers)),
            skipped=str(sum(layer.outcome is Outcome.UNJUDGED for layer in layers)),
            time=f"{sum(layer.seconds for layer in layers):.3f}",
        )
        for layer in layers:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=f"golden.{_clean(verdict.scene)}",
                name=layer.layer,
                time=f"{layer.seconds:.3f}",
            )
            if layer.passed:
                continue
            kind = {Outcome.CHANGED: "failure", Outcome.UNJUDGED: "skipped"}
            mark = ElementTree.SubElement(
                case, kind.get(layer.outcome, "error"), message=_clean(layer.text)
            )
            mark.text = _clean("\n".join(layer.details))
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _clean(text: str) -> str:
    return _INVALID_XML.sub("\ufffd", text)
