"""Cases: descriptions of a problem, which methods solve."""

from __future__ import annotations

import json
import math
import numbers
import os
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _native
from .errors import CaseError

_TOKEN = re.compile(r"([^.\[\]]+)|\[(\d+)\]")
_DEPTH = 64
#: Largest whole number that a floating-point number holds exactly.
_LARGEST = 2**53


def _plain(value: Any, path: str, depth: int = 0) -> Any:
    """Value of a JSON document: numbers of NumPy become Python's, arrays lists, paths texts."""
    if depth > _DEPTH:
        raise CaseError([(path, f"is nested more than {_DEPTH} times, or contains itself")])
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, Mapping):
        plain = {}
        for key, inner in value.items():
            if not isinstance(key, str):
                raise CaseError([(path, f"the key {key!r} is no text")])
            plain[key] = _plain(inner, f"{path}.{key}" if path else key, depth + 1)
        return plain
    if isinstance(value, (list, tuple)):
        return [_plain(inner, f"{path}[{number}]", depth + 1) for number, inner in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist") and not isinstance(value, numbers.Number):
        return _plain(value.tolist(), path, depth + 1)
    if isinstance(value, numbers.Integral):
        if abs(int(value)) > _LARGEST:
            raise CaseError([(path, f"is a whole number beyond ±{_LARGEST}")])
        return int(value)
    if isinstance(value, numbers.Real):
        number = float(value)
        if not math.isfinite(number):
            raise CaseError([(path, f"{number} is not a finite number")])
        return number
    if type(value).__module__ == "numpy" and type(value).__name__ == "bool":
        return bool(value)
    raise CaseError([(path, f"a value of the type {type(value).__name__} has no place in a case")])


def _tokens(path: str) -> list[str | int]:
    """Keys and positions of a path such as ``bodies[1].shape.radius``."""
    tokens: list[str | int] = []
    position = 0
    while position < len(path):
        if path[position] == "." and tokens:
            position += 1
        match = _TOKEN.match(path, position)
        if match is None:
            raise KeyError(f"{path!r} is not a path such as materials.sand.density or bodies[0].shape")
        tokens.append(match.group(1) if match.group(2) is None else int(match.group(2)))
        position = match.end()
    if not tokens:
        raise KeyError("the path is empty")
    return tokens


class Case:
    """A problem, from a dictionary, a file or JSON text. It is checked as a whole.

    Values are read and set by the paths of error messages::

        case["materials.sand.friction_angle"] = 34
        case["bodies[0].shape.max"]
    """

    def __init__(self, source: Mapping[str, Any] | str | os.PathLike[str], *, folder: str | os.PathLike[str] = "") -> None:
        """A mapping, a path, or a text that begins with ``{``. File names in a case start at its folder."""
        self._folder = Path(folder)
        if isinstance(source, Mapping):
            self._value = _plain(source, "")
        elif isinstance(source, str) and source.lstrip().startswith("{"):
            self._value = self._parsed(source)
        elif isinstance(source, (str, os.PathLike)):
            path = Path(source)
            self._folder = path.parent
            self._value = self._parsed(path.read_text(encoding="utf-8"))
        else:
            raise TypeError(f"a case is a mapping, a path or JSON text, not {type(source).__name__}")
        self.check()

    def _parsed(self, text: str) -> Any:
        # The checks of the library find doubled keys and errors of syntax by line and column.
        _native.check(text, self._folder)
        return json.loads(text)

    @classmethod
    def template(cls, name: str, folder: str | os.PathLike[str] | None = None) -> Case:
        """A template of ``colluvium new``. Files that it needs are written into ``folder``, or into a temporary one."""
        text = _native.template(name)
        if not _native.template_files(name):
            return cls(text)
        place = Path(tempfile.mkdtemp(prefix="colluvium-") if folder is None else folder)
        place.mkdir(parents=True, exist_ok=True)
        _native.write_template_files(name, place)
        return cls(text, folder=place)

    def check(self) -> None:
        """Raises ``CaseError`` with all problems of the case."""
        _native.check(self.to_json(), self._folder)

    def plan(self, method: str | None = None) -> dict[str, Any]:
        """Method, number of points and steps, time step (s), memory (bytes) and warnings."""
        return json.loads(_native.plan(self.to_json(), self._folder, method))

    def to_dict(self) -> dict[str, Any]:
        """A copy as a dictionary."""
        return json.loads(self.to_json())

    def to_json(self) -> str:
        """The case as JSON text."""
        return json.dumps(self._value, allow_nan=False)

    @property
    def folder(self) -> Path:
        """Folder at which file names in the case start."""
        return self._folder

    def __getitem__(self, path: str) -> Any:
        value = self._value
        for token in _tokens(path):
            try:
                value = value[token]
            except (KeyError, IndexError, TypeError):
                raise KeyError(f"{path}: {token!r} is not there") from None
        return json.loads(json.dumps(value))

    def __setitem__(self, path: str, value: Any) -> None:
        tokens = _tokens(path)
        changed = self.to_dict()
        place = changed
        for token in tokens[:-1]:
            try:
                place = place[token]
            except (KeyError, IndexError, TypeError):
                raise KeyError(f"{path}: {token!r} is not there") from None
        last = tokens[-1]
        if isinstance(place, list) != isinstance(last, int):
            raise KeyError(f"{path}: {last!r} does not fit there")
        if isinstance(place, list) and last >= len(place):
            raise KeyError(f"{path}: the list has {len(place)} entries")
        place[last] = _plain(value, path)
        _native.check(json.dumps(changed, allow_nan=False), self._folder)
        self._value = changed

    def __repr__(self) -> str:
        return f"Case({self._value.get('title', '')!r})"


def templates() -> dict[str, str]:
    """Names of the templates of cases, each with a line about it."""
    return dict(_native.templates())


def schema() -> dict[str, Any]:
    """JSON Schema of a case."""
    return json.loads(_native.schema())
