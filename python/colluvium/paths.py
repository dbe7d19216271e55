"""Values of JSON documents, and the paths to them in error messages."""

from __future__ import annotations

import json
import math
import numbers
import os
import re
from collections.abc import Callable, Mapping
from typing import Any

from .errors import CaseError

_TOKEN = re.compile(r"([^.\[\]]+)|\[(\d+)\]")
_DEPTH = 64
#: Largest whole number that a floating-point number holds exactly.
_LARGEST = 2**53


def plain(value: Any, path: str, depth: int = 0) -> Any:
    """Value of a JSON document: numbers of NumPy become Python's, arrays lists, paths texts."""
    if depth > _DEPTH:
        raise CaseError([(path, f"is nested more than {_DEPTH} times, or contains itself")])
    if isinstance(value, str):
        try:
            value.encode()
        except UnicodeEncodeError:
            raise CaseError([(path, f"{value!r} is no text of Unicode characters")]) from None
        return value
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, Mapping):
        found = {}
        for key, inner in value.items():
            if not isinstance(key, str):
                raise CaseError([(path, f"the key {key!r} is no text")])
            found[key] = plain(inner, f"{path}.{key}" if path else key, depth + 1)
        return found
    if isinstance(value, (list, tuple)):
        return [plain(inner, f"{path}[{number}]", depth + 1) for number, inner in enumerate(value)]
    if isinstance(value, os.PathLike):
        return plain(os.fspath(value), path, depth + 1)
    if hasattr(value, "tolist") and not isinstance(value, numbers.Number):
        return plain(value.tolist(), path, depth + 1)
    if isinstance(value, numbers.Integral):
        if abs(int(value)) > _LARGEST:
            raise CaseError([(path, f"is a whole number beyond ±{_LARGEST}")])
        return int(value)
    if isinstance(value, numbers.Real):
        number = float(value)
        if not math.isfinite(number):
            raise CaseError([(path, f"{number} is not a finite number")])
        return number
    raise CaseError([(path, f"a value of the type {type(value).__name__} has no place in a case")])


def parsed(text: str, check: Callable[[str], object]) -> Any:
    """Value of a JSON text; ``check`` finds doubled keys and errors of syntax by line and column."""
    check(text)
    return json.loads(text)


def tokens(path: str) -> list[str | int]:
    """Keys and positions of a path such as ``bodies[1].shape.radius``."""
    if not isinstance(path, str):
        raise TypeError(f"a path is a text such as 'bodies[0].shape', not {type(path).__name__}")
    found: list[str | int] = []
    position = 0
    while position < len(path):
        if path[position] == "." and found:
            position += 1
        match = _TOKEN.match(path, position)
        if match is None:
            raise KeyError(f"{path!r} is not a path such as materials.sand.density or bodies[0].shape")
        found.append(match.group(1) if match.group(2) is None else int(match.group(2)))
        position = match.end()
    if not found:
        raise KeyError("the path is empty")
    return found


def _inner(place: Any, token: str | int, path: str) -> Any:
    try:
        return place[token]
    except (KeyError, IndexError, TypeError):
        known = f"; there are {', '.join(place)}" if isinstance(place, dict) and isinstance(token, str) else ""
        raise KeyError(f"{path}: {token!r} is not there{known}") from None


def value_at(document: Any, path: str) -> Any:
    """Value at a path of a document."""
    place = document
    for token in tokens(path):
        place = _inner(place, token, path)
    return place


def with_value(document: Any, path: str, value: Any) -> None:
    """Sets the value at a path of a document, whose parent must exist."""
    *parents, last = tokens(path)
    place = document
    for token in parents:
        place = _inner(place, token, path)
    if isinstance(place, list) != isinstance(last, int) or not isinstance(place, (list, dict)):
        raise KeyError(f"{path}: {last!r} does not fit there")
    if isinstance(place, list) and isinstance(last, int) and last >= len(place):
        raise KeyError(f"{path}: the list has {len(place)} entries")
    place[last] = value  # type: ignore[index]
