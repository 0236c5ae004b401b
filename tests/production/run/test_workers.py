"""Pools of workers end when they are told to, however much their work carries."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

# The pipe of a pool holds 64 KiB; what each item carried once filled it, and a pool whose workers
# were ended then waited for ever.
STOPPED = """
import time
from functools import partial
from pipeline.errors import PronkError
from pipeline.production.run.workers import worker_pool

def work(load, item):
    time.sleep(item)
    return len(load) + item

if __name__ == "__main__":
    with worker_pool(2, PronkError("died"), partial(work, bytes(500_000)), [0] * 4) as results:
        print([result.result() for result in results])
    try:
        with worker_pool(2, PronkError("died"), partial(work, bytes(500_000)), [60] * 20):
            raise KeyboardInterrupt
    except KeyboardInterrupt:
        print("stopped")
"""


@pytest.mark.nightly
def test_a_pool_that_is_stopped_ends(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(STOPPED)
    # The limit is there for a pool that hangs.
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, timeout=50, cwd=ROOT
    )
    assert done.stdout.splitlines() == [str([500_000] * 4), "stopped"]
