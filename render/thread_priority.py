"""Thread priority: libraries do not raise that of a process above all others."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

_THREADS = Path("/proc/self/task")


@contextlib.contextmanager
def kept_priority() -> Iterator[None]:
    """Take back real-time priority that code inside gives to this thread and to new ones.

    SVT-AV1 does so under Linux where the user is root, as in many containers. A thread of that
    kind starves all others of its processor, also those of its own process that it waits for.
    """
    if not _THREADS.is_dir():
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    others = set(os.listdir(_THREADS)) - {str(threading.get_native_id())}
    try:
        yield
    finally:
        for thread in set(os.listdir(_THREADS)) - others:
            # A thread may have ended meanwhile.
            with contextlib.suppress(OSError):
                os.sched_setscheduler(int(thread), *before)
