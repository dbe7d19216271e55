"""Exceptions of the package."""

from __future__ import annotations

from collections.abc import Sequence


class CaseError(ValueError):
    """A case is wrong, or its method does not support it.

    ``problems`` lists each problem as ``(path, text)``; the path is that of the value in the case.
    """

    def __init__(self, problems: Sequence[tuple[str, str]]) -> None:
        self.problems: list[tuple[str, str]] = [(path, text) for path, text in problems]
        super().__init__("\n".join(f"{path}: {text}" if path else text for path, text in self.problems))


class SolverError(RuntimeError):
    """A solver has failed. Step, time (s), point and position (m) are ``None`` where they are unknown."""

    def __init__(
        self,
        text: str,
        step: int | None = None,
        time: float | None = None,
        point: int | None = None,
        position: Sequence[float] | None = None,
    ) -> None:
        super().__init__(text)
        self.step = step
        self.time = time
        self.point = point
        self.position = position


class OutputError(OSError):
    """A file or a folder cannot be written, read or used."""

    def __init__(self, text: str, path: str) -> None:
        super().__init__(text)
        self.path = path


class ColluviumWarning(UserWarning):
    """A warning about a case or its results. ``code`` is its stable code."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(f"[{code}] {text}")
        self.code = code
        self.text = text
