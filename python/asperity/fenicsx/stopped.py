"""The error of a driver that stops before its end."""

from __future__ import annotations


class Stopped(RuntimeError):
    """A path or a run in time ends before its end; the message says where and why."""
