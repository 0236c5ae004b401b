"""Killed sessions: the same command and the same messages leave the same bytes in the end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pipeline.production.direct.scene_recorder import SceneRecorder
from pipeline.production.run.progress import Reporter
from tests.production.direct.direct_client import STAGE, request, served, session_in
from tests.production.killed_runs import contents_of, kill_repeatedly

if TYPE_CHECKING:
    from tests.production.conftest import Running

LEFT = [
    ".stage_directed.4711.partial.yaml",
    ".stage_directed.4711.partial.token",
    ".take.zarr.partial/zarr.json",
    ".take.zarr.old.partial/positions/zarr.json",
    ".manifest.4711.partial.json",
    ".events.4711.partial.jsonl",
]


def _messages(end: str) -> list[bytes]:
    """Return what a director says."""
    return [
        request("hello", 0),
        request("subscribe", 1, events=["*"]),
        request("command", 2, who="bug", do={"turn_deg": 40}),
        request("step", 3, until=0.5),
        request("command", 4, who="roo", do={"jump": {"height": 0.15}}),
        request("step", 5, frames=12),
        request("end", 6, at=end),
    ]


@pytest.mark.nightly
@pytest.mark.parametrize(("end", "seed"), [("end", 1), ("now", 2)])
def test_a_take_is_equal_after_killed_sessions(
    end: str, seed: int, tmp_path: Path, start: Callable[..., Running]
) -> None:
    (tmp_path / "stage.yaml").write_text(STAGE)
    messages = tmp_path / "messages"
    messages.write_bytes(b"\n".join(_messages(end)) + b"\n")
    kill_repeatedly(
        lambda: start("direct", "stage.yaml", cwd=tmp_path, messages=messages),
        tmp_path / "out",
        times=25,
        seed=seed,
    )


@pytest.mark.nightly
def test_unfinished_files_of_a_killed_session_are_removed(tmp_path: Path) -> None:
    made = [tmp_path / name / "stage_directed" for name in ("whole", "torn")]
    for name in LEFT:
        (made[1] / name).parent.mkdir(parents=True, exist_ok=True)
        (made[1] / name).write_bytes(b"torn")
    for folder in made:
        SceneRecorder("stage_directed", folder.parent, Reporter()).check()
        assert "result" in served(session_in(folder.parent), [request("end", at="now")])[0]
    assert contents_of(made[0]) == contents_of(made[1])
