"""Budget guard: stops a run that goes on beyond its budget.

A thread looks at the clock and at the memory of this process and all that it has started. At a
limit it interrupts the main thread as Ctrl-C does, so what is finished stays. Where the main thread
does not answer, since a compiled library holds it, all processes of the run are ended: every file
is written under another name and renamed, so that is safe at any moment.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from pipeline.production.run import interrupts
from pipeline.production.run.available_memory import descendants, tree_memory
from pipeline.production.run.budget import Budget, BudgetReached
from pipeline.production.run.quantities import duration_text, size_text

INTERVAL = 0.2
"""Time between two looks [s]."""

GRACE = 10.0
"""Time that an interrupted run has to stop by itself [s]."""

FINISHED_STAYS = "what is finished stays; the same command goes on there"


class _Guard:
    """Watches one run.

    Attributes:
        reached: the error that tells which limit was reached; None before that.
    """

    def __init__(self, budget: Budget, say: Callable[[BudgetReached], None]) -> None:
        self.reached: BudgetReached | None = None
        self._budget, self._say = budget, say
        self._start = time.monotonic()
        self._done = threading.Event()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._watch, name="budget", daemon=True)

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def close(self) -> None:
        """Stop watching."""
        # The thread may be about to interrupt, which then happens here.
        with self._lock:
            self._done.set()

    def _watch(self) -> None:
        while not self._done.wait(INTERVAL):
            message = self._excess()
            if message is None:
                continue
            with self._lock:
                if self._done.is_set():
                    return
                self.reached = BudgetReached(f"{message}; {FINISHED_STAYS}")
                interrupts.interrupt()
            if not self._done.wait(GRACE):
                self._end_all()
            return

    def _excess(self) -> str | None:
        """Return what is exceeded, None if nothing is."""
        memory, seconds = self._budget.memory, self._budget.seconds
        if seconds is not None and time.monotonic() - self._start > seconds:
            return f"stopped after {duration_text(seconds)}, the limit of --max-time"
        taken = tree_memory() if memory is not None else 0
        if memory is not None and taken > memory:
            limit = f"{size_text(memory)}, the limit of --max-memory"
            return f"stopped at {size_text(taken)} of memory, more than {limit}"
        return None

    def _end_all(self) -> None:
        """End this process and all that it has started."""
        assert self.reached is not None
        self._say(self.reached)
        for process in descendants(os.getpid()):
            with suppress(OSError):
                os.kill(process, signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
        os._exit(BudgetReached.exit_code)


@contextmanager
def guarded(budget: Budget, say: Callable[[BudgetReached], None]) -> Iterator[None]:
    """Keep a budget inside the block.

    Args:
        budget: that is kept.
        say: tells what was reached, where the run has to be ended at once.

    Raises:
        BudgetReached: the run went on beyond it and was stopped.
    """
    if budget.memory is None and budget.seconds is None:
        yield
        return
    with interrupts.receiving():
        guard = _Guard(budget, say)
        try:
            try:
                # It may interrupt at once.
                guard.start()
                yield
            finally:
                guard.close()
        except BaseException as error:
            if guard.reached is None or not interrupts.is_interrupt(error):
                raise
            interrupts.answered()
            # Without the interrupt behind it, which would make it count as Ctrl-C.
            raise guard.reached from None
