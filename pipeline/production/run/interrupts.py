"""Interrupts: Ctrl-C is heard by one thread of ours, and answered where it does no harm.

Compiled libraries take Ctrl-C badly: Mitsuba installs a handler that gives up a picture
half way, and an exception that surfaces while it is at work may end the process. So all
other threads, and the processes they start, are deaf to it.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

AGAIN = 0.05
"""Time after which an interrupt that was lost is sent once more [s]."""

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
    sys.unraisablehook = _heard_in_vain


def ignore() -> None:
    """Hear no more of it: the run is ending, and one that was sent again would be a second one."""
    if hasattr(signal, "sigwait"):
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)


def heard() -> bool:
    """Say whether there was an interrupt that has not been answered."""
    return _heard.is_set()


def answered() -> None:
    """Take an interrupt as answered; the next one is as good as the first."""
    _heard.clear()


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


def _heard_in_vain(lost: sys.UnraisableHookArgs) -> None:
    """Send an interrupt once more that came where Python can raise nothing: in a finaliser, say."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        again = threading.Timer(AGAIN, _interrupt)
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(lost)


def _interrupt() -> None:
    main = threading.main_thread().ident
    if main is not None:
        signal.pthread_kill(main, signal.SIGUSR1)


def _wait() -> None:
    while True:
        signal.sigwait({signal.SIGINT})
        again = _heard.is_set()
        _heard.set()
        if again or not _held.is_set():
            _interrupt()
