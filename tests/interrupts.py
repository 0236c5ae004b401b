"""Interrupts: commands that tests start hear Ctrl-C."""

from __future__ import annotations

import signal


def hear_interrupts() -> None:
    """Let a child process hear SIGINT: tests in the background inherit that it is ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
