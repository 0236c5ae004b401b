"""Terminal text: no control character of a scene or a file name reaches the terminal."""

from __future__ import annotations

import io
import json
import os
import re
import unicodedata
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import Problem, SceneError, StoreError
from pipeline.production.run.notes import Note
from pipeline.production.run.progress import Reporter, SceneRow, stage
from pipeline.production.run.reporters import JsonReporter, LogReporter, TerminalReporter
from pipeline.terminal_text import escaped, escaped_line, json_line
from pipeline.text_stream import print_text

ODD = "a\x1b[31mb\x07\x9b2Jc\u202ed\x7f\re\ud8ff\u2028f"
SHOWN = r"a\x1b[31mb\x07\x9b2Jc\u202ed\x7f\re\ud8ff\u2028f"
BIDI = ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")


def is_control(character: str) -> bool:
    kind = unicodedata.category(character)
    return kind in ("Cc", "Cs", "Zl", "Zp") or unicodedata.bidirectional(character) in BIDI


def test_control_characters_are_shown_as_escapes() -> None:
    assert escaped(ODD) == SHOWN
    assert escaped(f"{ODD}\n\t{ODD}") == f"{SHOWN}\n\t{SHOWN}"
    assert escaped_line(f"{ODD}\n{ODD}") == rf"{SHOWN}\n{SHOWN}"


@given(st.text(st.characters(exclude_categories=())))
def test_all_text_is_printable_and_json_reads_back(text: str) -> None:
    assert not any(map(is_control, escaped(text).replace("\n", "").replace("\t", "")))
    assert not any(map(is_control, escaped_line(text).replace("\t", "")))
    escaped(text).encode()
    line = json_line({"text": text, text: [text]})
    assert not any(map(is_control, line))
    line.encode()
    assert json.loads(line) == {"text": text, text: [text]}


@given(st.text(st.characters(exclude_categories=("C", "Zl", "Zp"))))
def test_letters_of_all_scripts_stay_as_they_are(text: str) -> None:
    assert escaped_line(text) == text


def test_a_problem_is_one_line_whatever_its_names_hold() -> None:
    problem = Problem(
        "cast[0].a\nb", "no 'c\nd.yaml:1:1: fine'", "e\nf.yaml", 3, 3, "\u202ex: \x1b"
    )
    head, source, caret = str(problem).splitlines()
    assert head == r"e\nf.yaml:3:3: cast[0].a\nb: no 'c\nd.yaml:1:1: fine'"
    # The caret stands below the column that it points to.
    assert (source, caret) == ("    \\u202ex: \\x1b", "           ^")


def reported(reporter: Reporter) -> None:
    """Report odd text by every method of a reporter."""
    reporter.scene(ODD, 1, 2)
    with stage(reporter, ODD, 2, ODD, label=ODD) as current:
        current.advance(1)
        current.result = ODD
    with stage(reporter, "[bold]b[/]", 1) as current:
        current.result = "[/red]"
    reporter.note(ODD)
    note = Note(ODD, "simulation", ODD, 0.1, 1, f"{ODD}\n{ODD}", ODD)
    reporter.notes(ODD, [note] * 3, Path(ODD))
    reporter.notes(ODD, [Note(ODD, "scene", f"{ODD}{n}", 0, 1, f"{n}") for n in range(20)], None)
    reporter.table([SceneRow(f"{ODD}\n{ODD}", "failed", error=ODD)], 3)
    reporter.result(ODD, name=ODD)


@pytest.mark.parametrize(
    "make",
    [LogReporter, lambda stream: LogReporter(stream, True), TerminalReporter, JsonReporter],
    ids=["log", "verbose", "terminal", "json"],
)
def test_reporters_print_no_control_characters(
    make: Callable[[io.StringIO], Reporter], capsys: pytest.CaptureFixture[str]
) -> None:
    stream = io.StringIO()
    reported(make(stream))
    printed = (stream.getvalue() + capsys.readouterr().out).replace("\n", "").replace("\r", "")
    # What the bar of a terminal is made of.
    printed = re.sub(r"\x1b\[[?0-9;]*[A-Za-z]", "", printed)
    assert not any(map(is_control, printed))
    assert r"\x1b[31mb" in printed or r"\u001b[31mb" in printed
    if make is not JsonReporter:
        assert "[/red]" in printed


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
def test_a_stream_that_cannot_be_written_is_one_error() -> None:
    with (
        open("/dev/full", "w", encoding="utf-8") as stream,
        pytest.raises(StoreError, match=r"^/dev/full cannot be written to: No space left"),
    ):
        print_text(stream, "text")


def test_scene_errors_escape_what_they_quote() -> None:
    error = SceneError([Problem("", "one\ntwo"), Problem("", "three")])
    assert str(error).splitlines() == [r"one\ntwo", "three"]
