"""JUnit: the verdicts as XML that the dashboards of build servers read."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from pipeline.production.goldens.verdict import Outcome, SceneVerdict

_ERRORS = (Outcome.MISSING, Outcome.DAMAGED, Outcome.FAILED)
# XML 1.0 knows no other control characters than tab and ends of lines.
_UNSPEAKABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_of(verdicts: Sequence[SceneVerdict]) -> bytes:
    """Return a suite of tests for each scene, a case for each layer.

    What changed is a failure; what is missing, damaged or cannot be made is an error; what
    cannot be judged here is skipped.
    """
    root = ElementTree.Element("testsuites", name="pronk golden check")
    for verdict in verdicts:
        layers = verdict.layers
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=_clean(verdict.scene),
            tests=str(len(layers)),
            failures=str(sum(one.outcome is Outcome.CHANGED for one in layers)),
            errors=str(sum(one.outcome in _ERRORS for one in layers)),
            skipped=str(sum(one.outcome is Outcome.UNJUDGED for one in layers)),
            time=f"{sum(one.seconds for one in layers):.3f}",
        )
        for one in layers:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=f"golden.{_clean(verdict.scene)}",
                name=one.layer,
                time=f"{one.seconds:.3f}",
            )
            if one.passed:
                continue
            kind = {Outcome.CHANGED: "failure", Outcome.UNJUDGED: "skipped"}
            mark = ElementTree.SubElement(
                case, kind.get(one.outcome, "error"), message=_clean(one.text)
            )
            mark.text = _clean("\n".join(one.details))
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _clean(text: str) -> str:
    return _UNSPEAKABLE.sub("\ufffd", text)
