"""Running cases."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import _native
from .case import Case
from .errors import ColluviumWarning
from .results import RunResult

#: Time (s) between two looks at signals while a run goes on.
_SIGNAL_INTERVAL = 0.05


def _bar(time: float, end: float, step: int) -> None:
    """A line with the progress of a run on standard error."""
    share = min(time / end, 1.0) if end > 0 else 0.0
    filled = int(30 * share)
    sys.stderr.write(f"\r[{'#' * filled}{'.' * (30 - filled)}] {time:.4g} of {end:.4g} s, step {step}")
    sys.stderr.flush()


def run(
    case: Case | dict[str, Any] | str | os.PathLike[str],
    method: str | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: bool | Callable[[float, float, int], object] = False,
) -> RunResult:
    """Runs a case with a method, which the case names where it has only one.

    ``out`` is the folder of the files; without it nothing is written. ``threads`` are all cores by default, and results do not depend on
    them. ``progress`` shows a bar, or is called with time (s), end (s) and step.

    Ctrl-C stops the run at the next step, with a checkpoint in ``out``. ``KeyboardInterrupt`` then has the part that is done as ``result``.
    """
    if not isinstance(case, Case):
        case = Case(case)
    task = _native.RunTask(
        case.to_json(), case.folder, method, None if out is None else Path(out), threads, resume, overwrite
    )
    observe = _bar if progress is True else progress or None
    name, end = method or "", 0.0
    try:
        while not task.is_finished():
            message = task.wait(_SIGNAL_INTERVAL)
            if message is None:
                continue
            kind, time, step, text = message
            if kind == "begin":
                name, end = text, time
            elif kind == "warning":
                code, _, rest = text[1:].partition("] ")
                warnings.warn(ColluviumWarning(code, rest), stacklevel=2)
            elif kind in ("progress", "frame") and observe:
                observe(time, end, step)
    except BaseException as error:
        task.stop()
        if isinstance(error, KeyboardInterrupt):
            error.result = RunResult(task.result(), name)  # type: ignore[attr-defined]
        else:
            task.result()
        raise
    finally:
        if observe is _bar:
            sys.stderr.write("\n")
    result = RunResult(task.result(), name)
    for code, text in result.warnings:
        warnings.warn(ColluviumWarning(code, text), stacklevel=2)
    return result
