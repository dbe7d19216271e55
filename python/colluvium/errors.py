"""Exceptions of the package."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .element_tests import ElementPath
    from .results import RunResult


class CaseError(ValueError):
    """A case, an element test or a sweep is wrong, or its method does not support it.

    ``problems`` lists each problem as ``(path, text)``; the path is that of the value in the case.
    """

    problems: list[tuple[str, str]]

    def __init__(self, problems: Sequence[tuple[str, str]]) -> None:
        self.problems = [(path, text) for path, text in problems]
        super().__init__("\n".join(f"{path}: {text}" if path else text for path, text in self.problems))

    def __reduce__(self) -> tuple[type[CaseError], tuple[list[tuple[str, str]]]]:
        return CaseError, (self.problems,)


class SolverError(RuntimeError):
    """A solver or an element test has failed. Step, time (s), point and position (m) are ``None`` where they are unknown.

    ``code`` is the stable code of the error, which ``colluvium explain CODE`` explains.

    ``path`` has the rows of an element test before the failure, ``result`` the part of a run. The cause of a failed law in Python is its
    exception.
    """

    step: int | None
    time: float | None
    point: int | None
    position: tuple[float, float, float] | None
    code: str
    path: ElementPath | None
    result: RunResult | None

    def __init__(
        self,
        text: str,
        step: int | None = None,
        time: float | None = None,
        point: int | None = None,
        position: Sequence[float] | None = None,
        code: str = "",
    ) -> None:
        super().__init__(text)
        self.step = step
        self.time = time
        self.point = point
        self.position = None if position is None else (position[0], position[1], position[2])
        self.code = code
        self.path = None
        self.result = None
        self._part: Any = None

    def __reduce__(self) -> tuple[type[SolverError], tuple[Any, ...]]:
        return SolverError, (str(self), self.step, self.time, self.point, self.position, self.code)


class OutputError(OSError):
    """A file or a folder cannot be written, read or used."""

    path: str

    def __init__(self, text: str, path: str | os.PathLike[str]) -> None:
        super().__init__(text)
        self.path = os.fspath(path)

    def __reduce__(self) -> tuple[type[OutputError], tuple[str, str]]:
        return OutputError, (str(self), self.path)


class ColluviumWarning(UserWarning):
    """A warning about a case or its results. ``code`` is its stable code, which ``colluvium explain CODE`` explains.

    Where a filter makes an error of a warning about results, ``result`` has them.
    """

    code: str
    text: str
    result: RunResult | None

    def __init__(self, code: str, text: str = "") -> None:
        super().__init__(f"[{code}] {text}" if code else text)
        self.code = code
        self.text = text
        self.result = None

    def __reduce__(self) -> tuple[type[ColluviumWarning], tuple[str, str]]:
        return ColluviumWarning, (self.code, self.text)
