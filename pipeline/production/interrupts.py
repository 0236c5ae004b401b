"""Interrupts: Ctrl-C is heard by one thread of ours, and answered where it does no harm.

Compiled libraries take Ctrl-C badly: Mitsuba installs a handler that gives up a picture
half way, and an exception that surfaces while it is at work may end the process. So all
other threads, and the processes they start, are deaf to it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_heard = threading.Event()
_held = threading.Event()


def listen() -> None:
    """Hear Ctrl-C from now on; to be called before any thread is started."""
    deaf = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as under nohup
    if deaf or not hasattr(signal, "sigwait"):
        return
    # A signal that nobody else sends stands for it: only a signal wakes a main thread that waits.
    signal.signal(signal.SIGUSR1, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    threading.Thread(target=_wait, name="interrupts", daemon=True).start()


@contextmanager
def held_back() -> Iterator[None]:
    """Hold Ctrl-C back until the end of the block; pressed twice it is not held."""
    _held.set()
    try:
        yield
    finally:
        _held.clear()
    if _heard.is_set():
        raise KeyboardInterrupt


def _wait() -> None:
    main = threading.main_thread().ident
    while main is not None:
        signal.sigwait({signal.SIGINT})
        again = _heard.is_set()
        _heard.set()
        if again or not _held.is_set():
            signal.pthread_kill(main, signal.SIGUSR1)
