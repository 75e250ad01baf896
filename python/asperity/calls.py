"""Texts and handles of the library, whose functions f2py wraps (_core.pyf)."""

from __future__ import annotations

import ctypes
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import InputError, Record

_pause = getattr(ctypes.CDLL(_core.__file__), "omp_pause_resource_all", None)
if _pause is not None and hasattr(os, "register_at_fork"):
    # the child of a fork does not have OpenMP's threads and would wait for them: end them before (1: soft)
    os.register_at_fork(before=partial(_pause, 1))

ROOM = 32768
"""Bytes of a message: 64 listed planes, all bad, take 28 000."""


def message_room(size: int = ROOM) -> NDArray[np.int8]:
    """Array of bytes to which a function of the library writes a text."""
    return np.empty(size, np.int8)


def text_of(message: NDArray[np.int8]) -> str:
    """Text that a function of the library has written; a zero ends it."""
    return message.tobytes().partition(b"\0")[0].decode("utf-8", "replace")


def document(write: Callable[[NDArray[np.int8]], int]) -> Any:
    """Content of a JSON text that a function of the library writes; the function returns its length."""
    text = message_room(write(message_room(1)) + 1)
    write(text)
    return json.loads(text_of(text), strict=False)


@contextmanager
def cases(
    text: bytes,
    props: NDArray[np.float64] | None = None,
    path: bytes = b"",
    take: Callable[[int], None] | None = None,
) -> Iterator[int]:
    """Handle of a case file; with a path that of a file.

    props: PROPS in place of material and pattern.  take: sets the steps of a handle.  Raises InputError with
    all errors.
    """
    if b"\0" in text + path:
        raise InputError([Record("byte 0: expected a text file")])
    constants = np.zeros(1) if props is None else props
    handle = _core.asperity_read_cases(path, not path, text, props is not None, constants)
    try:
        if take is not None:
            take(handle)
        if _core.asperity_case_errors(handle, message_room(1)) > 0:
            errors = document(partial(_core.asperity_case_content, handle))
            raise InputError([Record(**error) for error in errors])
        yield handle
    finally:
        _core.asperity_free_cases(handle)


def content(text: bytes, props: NDArray[np.float64] | None = None, path: bytes = b"") -> dict[str, Any]:
    """Content of a case file by names (case_json of asperity_json); arguments and errors as of `cases`."""
    with cases(text, props, path) as handle:
        by_name: dict[str, Any] = document(partial(_core.asperity_case_content, handle))
        return by_name
