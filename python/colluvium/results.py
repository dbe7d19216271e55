"""Results of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native

if TYPE_CHECKING:
    import pandas
    import pyvista


def _extra(module: str, extra: str) -> Any:
    """An optional module, or an error that names the extra that brings it."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{module} is not installed: pip install 'colluvium[{extra}]'") from error


class Points(Mapping[str, np.ndarray]):
    """Fields of the points of a frame by name, and ``position`` (m), ``extent`` (m), ``id``, ``body``.

    Vectors have a row of x, y, z per point, stresses xx, yy, zz, xy, yz, xz, tension-positive. Arrays share the memory of the frame
    and cannot be written.
    """

    _OWN = {"position": "positions", "extent": "extents", "id": "ids", "body": "bodies"}

    def __init__(self, frame: _native.Frame) -> None:
        self._frame = frame

    def __getitem__(self, name: str) -> np.ndarray:
        own = self._OWN.get(name)
        return getattr(self._frame, own) if own else self._frame.field(name)

    def __iter__(self) -> Iterator[str]:
        yield from self._OWN
        yield from (name for name, _ in self._frame.fields)

    def __len__(self) -> int:
        return len(self._OWN) + len(self._frame.fields)

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each field."""
        return {"position": "m", "extent": "m", "id": "", "body": ""} | dict(self._frame.fields)


class Frame:
    """State of a run at one time."""

    def __init__(self, frame: _native.Frame) -> None:
        self._frame = frame
        self.points = Points(frame)

    @property
    def time(self) -> float:
        """Time (s)."""
        return self._frame.time

    @property
    def step(self) -> int:
        """Number of steps."""
        return self._frame.step

    def __len__(self) -> int:
        return len(self._frame)

    def to_pyvista(self) -> pyvista.PolyData:
        """Points with their fields for PyVista."""
        cloud = _extra("pyvista", "pyvista").PolyData(np.array(self.points["position"]))
        for name, values in self.points.items():
            if name != "position":
                cloud[name] = np.array(values)
        return cloud

    def __repr__(self) -> str:
        return f"Frame(time={self.time:g}, points={len(self)})"


@dataclass(frozen=True)
class Safety:
    """Outcome of a search for a factor of safety. ``factor`` is ``None`` where it is undecided or outside the range."""

    factor: float | None
    stable: float
    failing: float
    text: str


class RunResult:
    """Results of a run: measures over time, frames, warnings, factors of safety."""

    def __init__(self, data: _native.RunData, method: str) -> None:
        self.method = method
        self.is_interrupted: bool = data.is_interrupted
        self.steps: int = data.steps
        self.wall: float = data.wall
        self.warnings: list[tuple[str, str]] = data.warnings
        self.safety: dict[str, Safety] = {name: Safety(*found) for name, *found in data.safety}
        self._columns, self._rows = data.measures()
        self.frames: list[Frame] = [Frame(frame) for frame in data.take_frames()]
        self.last: Frame = Frame(data.take_last())

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Measures as one array per column."""
        return {name: self._rows[:, number] for number, (name, _) in enumerate(self._columns)}

    @property
    def measures(self) -> pandas.DataFrame:
        """Measures as a table; ``attrs["units"]`` has the unit of each column."""
        table = _extra("pandas", "pandas").DataFrame(self._rows.copy(), columns=[name for name, _ in self._columns])
        table.attrs["units"] = dict(self._columns)
        return table

    def __repr__(self) -> str:
        state = "interrupted" if self.is_interrupted else "completed"
        return f"RunResult({self.method}, {state}, {self.steps} steps, {len(self.frames)} frames)"
