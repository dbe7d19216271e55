"""Element tests: a single material point on a prescribed path of stress or strain."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from .errors import SolverError
from .paths import parsed, plain, value_at, with_value

if TYPE_CHECKING:
    import pandas


class ElementPath(Mapping[str, np.ndarray]):
    """Path of an element test: one array per column, with a row for the start and one for each step.

    ``stages`` has the row with which each stage begins, ``units`` the unit of each column.
    """

    def __init__(self, columns: list[tuple[str, str]], rows: np.ndarray, stages: list[int]) -> None:
        self.units: dict[str, str] = dict(columns)
        self.stages: list[int] = stages
        self._rows = rows
        self._names = [name for name, _ in columns]

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(f"{name!r} is not a column of the path; there are {', '.join(self._names)}")
        return self._rows[:, self._names.index(name)]

    def __iter__(self) -> Any:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    @property
    def table(self) -> pandas.DataFrame:
        """The path as a table; ``attrs["units"]`` has the unit of each column. Needs the extra ``pandas``."""
        from .results import table

        return table(self._rows, list(self.units.items()))

    def stage(self, number: int = -1) -> ElementPath:
        """Rows of a stage, from its start; by default of the last."""
        count = len(self.stages)
        if not -count <= number < count:
            raise IndexError(f"the path has {count} stages")
        number %= count
        end = self.stages[number + 1] + 1 if number + 1 < count else len(self._rows)
        return ElementPath(list(self.units.items()), self._rows[self.stages[number] : end], [0])

    def __repr__(self) -> str:
        return f"ElementPath({len(self._rows)} rows, {len(self.stages)} stages)"


class ElementTest:
    """A test of a material point, from a dictionary, a file or JSON text, as ``colluvium element-test`` reads it.

    >>> import colluvium as cl
    >>> test = cl.ElementTest({
    ...     "title": "oedometer",
    ...     "material": {"model": "linear-elastic", "density": 2000, "youngs_modulus": 2e7, "poissons_ratio": 0.3},
    ...     "stages": [{"path": {"kind": "oedometer", "axial_compression": 0.01}, "steps": 10}],
    ... })
    >>> round(test.run()["stress_zz"][-1])
    -269231
    """

    def __init__(self, source: Mapping[str, Any] | str | os.PathLike[str]) -> None:
        if isinstance(source, Mapping):
            self._value = plain(source, "")
        elif isinstance(source, str) and source.lstrip().startswith("{"):
            self._value = parsed(source, _native.check_element_test)
        elif isinstance(source, (str, os.PathLike)):
            self._value = parsed(Path(source).read_text(encoding="utf-8"), _native.check_element_test)
        else:
            raise TypeError(f"an element test is a mapping, a path or JSON text, not {type(source).__name__}")
        _native.check_element_test(self.to_json())

    def run(self) -> ElementPath:
        """Runs the test. A failure raises ``SolverError``, which has the rows before it as ``path``."""
        path, error = self.trace()
        if error is not None:
            if isinstance(error, SolverError):
                error.path = path
            raise error
        return path

    def trace(self) -> tuple[ElementPath, BaseException | None]:
        """Runs the test to its end or its first failure, and returns its path with the exception of the failure."""
        (columns, rows), stages, error = _native.run_element_test(self.to_json())
        return ElementPath(columns, rows, stages), error

    def with_values(self, values: Mapping[str, Any]) -> ElementTest:
        """A copy with other values, by their paths, such as ``{"material.friction_angle": 30}``."""
        changed = self._with_values(values)
        _native.check_element_test(changed.to_json())
        return changed

    def _with_values(self, values: Mapping[str, Any]) -> ElementTest:
        """A copy with other values, which are checked when it runs."""
        changed = ElementTest.__new__(ElementTest)
        changed._value = self.to_dict()
        for path, value in values.items():
            with_value(changed._value, path, plain(value, path))
        return changed

    def to_dict(self) -> dict[str, Any]:
        """A copy as a dictionary."""
        return json.loads(self.to_json())

    def to_json(self) -> str:
        """The test as JSON text."""
        return json.dumps(self._value, allow_nan=False)

    def __getitem__(self, path: str) -> Any:
        return value_at(self.to_dict(), path)

    def __repr__(self) -> str:
        return f"ElementTest({self._value.get('title', '')!r})"
