"""Signals of programs that tests start."""

from __future__ import annotations

import signal


def heeds_signals() -> None:
    """Let a program heed signals; a shell in the background starts it without SIGINT, nohup without HUP."""
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
