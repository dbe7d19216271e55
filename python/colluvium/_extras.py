"""Optional modules."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def extra(module: str, name: str = "") -> Any:
    """An optional module, or an error that names the extra of the package that brings it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"{module} is not installed: pip install 'colluvium[{name or module}]'") from error
