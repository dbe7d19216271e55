"""Running cases."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _native
from ._checks import as_folder, check_count
from .case import Case
from .errors import ColluviumWarning, SolverError
from .results import Frame, RunResult, Safety

#: Time (s) between two looks at signals while a run goes on.
_SIGNAL_INTERVAL = 0.05

#: Result of a callback that stops the run.
_STOP = False

CaseLike = Case | Mapping[str, Any] | str | os.PathLike[str]
Progress = bool | Callable[[float, float, int], object] | None


def as_case(case: CaseLike) -> Case:
    """A case from all that describes one."""
    return case if isinstance(case, Case) else Case(case)


def warn(text: str, level: int) -> None:
    """Issues a warning of the library, ``[code] text``, at the call ``level`` above."""
    code, _, rest = text[1:].partition("] ")
    warnings.warn(ColluviumWarning(code, rest), stacklevel=level + 1)


class ProgressBar:
    """A line on standard error, or calls of a function, while work goes on."""

    def __init__(self, progress: Progress, unit: str = "s") -> None:
        if not (progress is None or isinstance(progress, bool) or callable(progress)):
            raise TypeError("progress is True, False, or a function of time, end and step")
        self._unit = unit
        self._is_drawn = False
        self._call: Callable[[float, float, int], object] | None
        if callable(progress):
            self._call = progress
        elif progress is None:
            self._call = self._draw if sys.stderr is not None and sys.stderr.isatty() or "ipykernel" in sys.modules else None
        else:
            self._call = self._draw if progress else None

    def _draw(self, done: float, end: float, step: int) -> None:
        share = min(max(done / end, 0.0), 1.0) if end > 0 else 0.0
        filled = int(30 * share)
        count = f", step {step}" if self._unit == "s" else ""
        sys.stderr.write(f"\r[{'#' * filled}{'.' * (30 - filled)}] {done:.4g} of {end:.4g} {self._unit}{count}  ")
        sys.stderr.flush()
        self._is_drawn = True

    def show(self, done: float, end: float, step: int) -> object:
        """Shows how far the work is, and returns the result of the function."""
        return None if self._call is None else self._call(done, end, step)

    def say(self, line: str) -> None:
        """Prints a line above the bar."""
        if self._call == self._draw:
            sys.stderr.write(f"\r{line}\n")

    def close(self) -> None:
        """Ends the line."""
        if self._is_drawn:
            sys.stderr.write("\n")
            sys.stderr.flush()


def _take_frames(task: _native.Task, kept: list[Frame] | None) -> None:
    """Takes the frames of a task that has been told to stop."""
    while not task.is_finished():
        message = task.wait(_SIGNAL_INTERVAL)
        if message is not None and message[4] is not None and kept is not None:
            kept.append(Frame(message[4]))


def abandon(task: _native.Task, bar: ProgressBar | None = None) -> None:
    """Stops a task and waits for its end; its results and its errors are dropped, since an exception of the caller comes out."""
    task.stop()
    if bar is not None:
        bar.close()
    try:
        task.result()
    except Exception:
        pass


def messages(task: _native.Task) -> Iterator[tuple[str, float, int, str, _native.FrameData | None]]:
    """Messages of a task until its end; signals are looked at between them."""
    while not task.is_finished():
        message = task.wait(_SIGNAL_INTERVAL)
        if message is not None:
            yield message


def _folder(path: str | os.PathLike[str] | None) -> Path | None:
    return None if path is None else as_folder(path)


def run(
    case: CaseLike,
    method: str | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress = None,
    on_frame: Callable[[Frame], object] | None = None,
    keep_frames: bool = True,
) -> RunResult:
    """Runs a case with a method, which need not be named where the case has options for only one.

    ``out`` is the folder of the files; without it nothing is written. ``resume`` continues the interrupted run in it, ``overwrite`` replaces
    it. ``threads`` are all cores by default, and results do not depend on them. ``progress`` shows a bar (by default in a terminal or a
    notebook), or is called with time (s), end (s) and step. ``on_frame`` is called with each frame. A callback that returns ``False`` stops
    the run, whose result is then that of an interrupted run; an exception in it stops the run and comes out. Frames are in the result unless
    ``keep_frames`` is false.

    Ctrl-C stops the run at the next step, with a checkpoint in ``out``. ``KeyboardInterrupt`` then has the part that is done as ``result``.

    Raises ``CaseError`` for the case, ``SolverError`` for the method, ``OutputError`` for files and folders.
    """
    options = _RunOptions(threads, resume, overwrite, progress, on_frame, keep_frames)
    return _run(as_case(case), method, _folder(out), options, 3)


@dataclass(frozen=True)
class _RunOptions:
    threads: int | None = None
    resume: bool = False
    overwrite: bool = False
    progress: Progress = None
    on_frame: Callable[[Frame], object] | None = None
    keep_frames: bool = True


def _run(case: Case, method: str | None, folder: Path | None, options: _RunOptions, level: int) -> RunResult:
    """Runs a case; warnings name the line that is ``level`` calls above."""
    keep_frames, on_frame = options.keep_frames, options.on_frame
    if options.threads is not None:
        check_count(options.threads, "threads")
    if options.resume and folder is None:
        raise ValueError("resume: continues the run in a folder; give out=")
    if on_frame is not None and not callable(on_frame):
        raise TypeError("on_frame is no function of a frame")
    wants_frames = keep_frames or on_frame is not None
    bar = ProgressBar(options.progress)
    task = _native.Task.run(
        case.to_json(), case.folder, method, folder, options.threads, options.resume, options.overwrite, wants_frames, False
    )
    name, end = method or "", 0.0
    kept: list[Frame] = []
    try:
        for kind, time, step, text, data in messages(task):
            if kind == "begin":
                name, end = text, time
            elif kind == "warning":
                warn(text, level)
            elif kind == "search":
                bar.say(text)
            elif data is not None:
                frame = Frame(data)
                if keep_frames:
                    kept.append(frame)
                if on_frame is not None and on_frame(frame) is _STOP:
                    task.stop()
                if bar.show(time, end, step) is _STOP:
                    task.stop()
            elif bar.show(time, end, step) is _STOP:
                task.stop()
    except KeyboardInterrupt as interrupt:
        task.stop()
        bar.close()
        try:
            _take_frames(task, kept if keep_frames else None)
            interrupt.result = RunResult(task.result(), name, kept, case, folder)  # type: ignore[attr-defined]
        except Exception as error:
            interrupt.result = None  # type: ignore[attr-defined]
            interrupt.add_note(f"the run had failed: {error}")
        raise
    except BaseException:
        abandon(task, bar)
        raise
    bar.close()
    try:
        found = task.result()
    except SolverError as error:
        error.result = RunResult.of_failure(name, kept, case, folder, error._part)
        error._part = None
        raise
    result = RunResult(found, name, kept, case, folder)
    try:
        for code, text in result.warnings:
            warnings.warn(ColluviumWarning(code, text), stacklevel=level)
    except ColluviumWarning as warning:
        # A filter has made an error of the warning: the results are not lost.
        warning.result = result
        raise
    return result


def frames(
    case: CaseLike,
    method: str | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
) -> Iterator[Frame]:
    """Frames of a run one by one. The run waits for its reader, with two frames in memory at most; dropping the iterator stops it.

    Arguments and exceptions are those of `run`.
    """
    case = as_case(case)
    if resume and out is None:
        raise ValueError("resume: continues the run in a folder; give out=")
    if threads is not None:
        check_count(threads, "threads")
    task = _native.Task.run(case.to_json(), case.folder, method, _folder(out), threads, resume, overwrite, True, True)
    return _frames(task)


def _frames(task: _native.Task) -> Iterator[Frame]:
    is_complete = False
    try:
        while not task.is_finished():
            message = task.wait(_SIGNAL_INTERVAL)
            if message is None:
                continue
            kind, text, data = message[0], message[3], message[4]
            del message
            if kind == "warning":
                warn(text, 2)
            if data is not None:
                frame = Frame(data)
                del data
                yield frame
                del frame
        is_complete = True
    finally:
        if not is_complete:
            abandon(task)
    for code, text in task.result().warnings:
        warnings.warn(ColluviumWarning(code, text), stacklevel=2)


def safety(
    case: CaseLike,
    method: str | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    measure: str | None = None,
    search_range: tuple[float, float] | None = None,
    threads: int | None = None,
    overwrite: bool = False,
    progress: Progress = None,
) -> Safety:
    """Factor of safety of a case by reduction of strength: its measure of the kind ``factor-of-safety``, or one after its last stage.

    ``measure`` chooses among several, ``search_range`` replaces the range of the search. Other arguments and exceptions are those of `run`.
    """
    case = as_case(case).copy()
    kind = "factor-of-safety"
    known = {name: value for name, value in case.to_dict().get("measures", {}).items() if value.get("kind") == kind}
    if measure is None:
        if len(known) > 1:
            raise ValueError(f"the case has several factors of safety: give measure= one of {', '.join(sorted(known))}")
        measure = next(iter(known), "factor_of_safety")
    elif measure not in known:
        raise ValueError(f"{measure!r} is not a factor of safety of the case; there is {', '.join(sorted(known)) or 'none'}")
    search = known.get(measure) or {"kind": kind, "after": case["stages"][-1]["name"]}
    if search_range is not None:
        search["range"] = list(search_range)
    case.update({"measures": {**case.to_dict().get("measures", {}), measure: search}})
    options = _RunOptions(threads=threads, overwrite=overwrite, progress=progress, keep_frames=False)
    return _run(case, method, _folder(out), options, 3).safety[measure]
