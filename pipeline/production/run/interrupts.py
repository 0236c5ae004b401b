"""Interrupts: one thread receives Ctrl-C and raises it in the main thread where it is safe.

Compiled libraries handle Ctrl-C badly: Mitsuba installs a handler that gives up a picture half
way, and an exception that surfaces while it works may end the process. So all other threads, and
the processes that they start, block the signal.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

INTERRUPTED = 130
"""Exit code of a command that was stopped by Ctrl-C."""

RESEND_DELAY = 0.05
"""Time after which a lost interrupt is sent again [s]."""

_heard = threading.Event()
_held = threading.Event()


def listen() -> None:
    """Start to receive Ctrl-C; call this before any thread is started."""
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # as under nohup
    if ignored or not hasattr(signal, "sigwait"):
        return
    # Only a signal wakes a main thread that waits, so an unused one stands for Ctrl-C.
    signal.signal(signal.SIGUSR1, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    threading.Thread(target=_wait, name="interrupts", daemon=True).start()
    sys.unraisablehook = _resend_lost


def ignore() -> None:
    """Ignore interrupts from now on: the run is ending, and a resent one would count as another."""
    if hasattr(signal, "sigwait"):
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)


def heard() -> bool:
    """Return whether an interrupt has not been answered."""
    return _heard.is_set()


def is_interrupt(error: BaseException | None) -> bool:
    """Return whether Ctrl-C is behind an error.

    Compiled modules wrap it in an error of their own, some of them as words alone.
    """
    if heard():
        return True
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    return error is not None


def answered() -> None:
    """Mark the interrupt as answered, so that the next one counts as the first."""
    _heard.clear()


@contextmanager
def held_back() -> Iterator[None]:
    """Delay Ctrl-C to the end of the block, unless it is pressed twice."""
    _held.set()
    try:
        yield
    finally:
        _held.clear()
    if _heard.is_set():
        raise KeyboardInterrupt


def _resend_lost(lost: sys.UnraisableHookArgs) -> None:
    """Resend an interrupt that came where Python cannot raise, such as in a finaliser."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        again = threading.Timer(RESEND_DELAY, _interrupt)
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(lost)


@contextmanager
def receiving() -> Iterator[None]:
    """Let `interrupt` reach the main thread inside the block, also where Ctrl-C is ignored.

    Call this in the main thread.
    """
    if not hasattr(signal, "SIGUSR1"):
        yield
        return
    before = signal.getsignal(signal.SIGUSR1)
    if before is not signal.default_int_handler:
        signal.signal(signal.SIGUSR1, signal.default_int_handler)
    try:
        yield
    finally:
        if before is not signal.default_int_handler:
            signal.signal(signal.SIGUSR1, before or signal.SIG_DFL)


def interrupt() -> None:
    """Interrupt the main thread from another one, as Ctrl-C does; see `receiving`."""
    _heard.set()
    if _held.is_set():
        return
    if hasattr(signal, "SIGUSR1"):
        _interrupt()
    else:
        _thread.interrupt_main()


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
