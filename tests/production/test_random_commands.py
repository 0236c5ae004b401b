"""Random command lines: each ends with a documented code and a message, and writes where it may."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.production.fuzzing import tried
from tests.production.random_commands import commands, random_command

COUNT = 2000


def test_command_lines_are_drawn_of_all_commands_and_options() -> None:
    lines = [random_command(seed) for seed in range(COUNT)]
    words = {word.split("=")[0] for line in lines for word in line}
    for names, command in commands().items():
        assert any(line[: len(names)] == [*names] for line in lines), names
        for param in command.params:
            if param.param_type_name == "option":
                assert words & {*param.opts, *param.secondary_opts}, (names, param.name)
    assert lines == [random_command(seed) for seed in range(COUNT)]


@pytest.mark.nightly
def test_two_thousand_command_lines_obey_the_laws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = list(tried("tests.production.commanding_process", tmp_path, 0, COUNT))
    codes = Counter(line.get("code") for line in lines)
    faults = [
        f"seed {line['seed']}: {line.get('words')}: {line['text']}"
        for line in lines
        if line["kind"] == "fault"
    ]
    with capsys.disabled():
        print(f"\ncommand lines by exit code: {dict(codes)}")  # noqa: T201
        print(*faults, sep="\n")  # noqa: T201
    assert not faults
    assert len(lines) == COUNT
    assert min(codes[code] for code in (0, 2, 3)) > COUNT / 50
