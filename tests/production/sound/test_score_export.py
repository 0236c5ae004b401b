"""`pronk midi --export`: files for other programs, and their records."""

from __future__ import annotations

import json
from typing import Any

import pytest

from audio.errors import NotationError
from pipeline.errors import PronkError
from pipeline.production.run.production import score_only
from pipeline.production.run.progress import Reporter
from pipeline.production.sound.export_kind import ExportKind


def test_an_export_is_recorded_and_replaces_the_earlier_one(studio: Any) -> None:
    bug = "{name: bug, figure: beetle, walk: {speed: 0.3}}"
    ant = "{name: ant, figure: beetle, at: [1, 1], walk: {speed: 0.3}}"
    two = studio.order("duration=1", f"cast=[{bug}, {ant}]")
    outputs = score_only(two, Reporter(), [ExportKind.reaper])
    folder = outputs.score_folder
    assert {path.name for path in (folder / "performers").iterdir()} == {"ant.mid", "bug.mid"}
    project = (folder / f"{outputs.name}.rpp").read_text(encoding="utf-8")
    for path in (folder / "stems").iterdir():
        assert f'"stems/{path.name}"' in project
    (folder / "stems" / "old.wav").write_bytes(b"")
    one = studio.order("duration=1", f"cast=[{bug}]")
    score_only(one, Reporter(), [ExportKind.performers, ExportKind.stems])
    assert [path.name for path in (folder / "performers").iterdir()] == ["bug.mid"]
    assert {path.name.split("_")[0] for path in (folder / "stems").iterdir()} == {
        "bug",
        "ambience.wav",
    }
    files = json.loads(outputs.manifest.read_text(encoding="utf-8"))["files"]
    assert "score/performers/bug.mid" in files
    assert "score/performers/ant.mid" not in files


def test_what_cannot_be_written_leaves_nothing(
    studio: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "music21", None)
    order = studio.order("cast=[{name: bug, figure: beetle}]")
    with pytest.raises((PronkError, NotationError), match="pip install music21"):
        score_only(order, Reporter(), [ExportKind.musicxml, ExportKind.stems])
    assert not (order.out / order.name / "score").exists()
