"""Checks of the arguments of functions."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path


def check_count(value: object, name: str) -> None:
    """Raises an error where a number of threads, runs or frames is not a whole number of at least one."""
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{name} is a whole number, not {type(value).__name__}")
    if value < 1:
        raise ValueError(f"{name}: {value} is less than 1")


def as_folder(path: str | os.PathLike[str], name: str = "out") -> Path:
    """Absolute path of a folder, so that a change of the working folder does not move it."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"{name} is the path of a folder, not {type(path).__name__}")
    if not os.fspath(path):
        raise ValueError(f"{name}: the path is empty; write '.' for the working folder")
    return Path(path).absolute()


def as_names(names: str | Sequence[str]) -> list[str]:
    """List of names, of which one may be given alone."""
    return [names] if isinstance(names, str) else list(names)
