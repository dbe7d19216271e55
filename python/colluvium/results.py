"""Results of a run."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from . import _native
from ._checks import as_folder
from ._extras import extra
from .errors import OutputError
from .rasters import to_data_array

if TYPE_CHECKING:
    import meshio
    import pandas
    import pyvista
    import xarray

    from .case import Case


#: Dimensions of the components of vectors and tensors for xarray, with their labels.
_COMPONENTS = {3: ("axis", ["x", "y", "z"]), 6: ("component", ["xx", "yy", "zz", "xy", "yz", "zx"])}


class Points(Mapping[str, np.ndarray]):
    """Fields of a dataset by name; for points also ``position`` (m), ``extent`` (m), ``id`` and ``body``.

    Vectors have a row of x, y, z per point, stresses xx, yy, zz, xy, yz, zx, tension-positive. Arrays share the memory of the frame, keep
    it alive and cannot be written: change a copy.
    """

    _OWN = {"position": "positions", "extent": "extents", "id": "ids", "body": "bodies"}

    def __init__(self, data: _native.DatasetData) -> None:
        self._data = data
        self._own = self._OWN if data.kind == "points" else {}

    def __reduce__(self) -> tuple[type[Points], tuple[Any]]:
        return Points, (_DatasetArrays.of(self._data),)

    def __getitem__(self, name: str) -> np.ndarray:
        own = self._own.get(name)
        return getattr(self._data, own) if own else self._data.field(name)

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        yield from (name for name, _ in self._data.fields)

    def __len__(self) -> int:
        return len(self._own) + len(self._data.fields)

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each field."""
        own = {"position": "m", "extent": "m", "id": "", "body": ""} if self._own else {}
        return own | dict(self._data.fields)

    def __repr__(self) -> str:
        return f"Points({', '.join(self)})"


class _DatasetArrays:
    """Data of a dataset in arrays of their own, as a process sends them to another."""

    def __init__(self, data: _native.DatasetData) -> None:
        self.name, self.kind, self.fields = data.name, data.kind, data.fields
        own = {"points": ["ids", "bodies", "positions", "extents"], "mesh": ["positions", "corners", "ends"], "lattice": ["nodes", "mask"]}
        for name in own.get(self.kind, ["nodes"]):
            value = getattr(data, name)
            setattr(self, name, np.array(value) if isinstance(value, np.ndarray) else value)
        self._values = {name: np.array(data.field(name)) for name, _ in data.fields}

    @classmethod
    def of(cls, data: Any) -> _DatasetArrays:
        """Arrays of a dataset, which may have been sent already."""
        return data if isinstance(data, cls) else cls(data)

    def field(self, name: str) -> np.ndarray:
        """Values of a field."""
        if name not in self._values:
            raise KeyError(f"{name!r} is not a field of {self.name!r}; there are {', '.join(self._values)}")
        return self._values[name]


class Dataset:
    """Fields on points, on the nodes of a lattice or a raster, or on the cells of a mesh, as ``kind`` says."""

    def __init__(self, data: _native.DatasetData) -> None:
        self._data = data
        self.name: str = data.name
        self.kind: str = data.kind
        self.fields: Points = Points(data)

    def __reduce__(self) -> tuple[type[Dataset], tuple[Any]]:
        return Dataset, (_DatasetArrays.of(self._data),)

    @property
    def vertices(self) -> np.ndarray:
        """Positions of points, or of the vertices of a mesh (m)."""
        return self._data.positions

    @property
    def cells(self) -> list[np.ndarray]:
        """Numbers of the vertices of each cell of a mesh."""
        return np.split(self._data.corners.astype(np.int64), self._data.ends[:-1].astype(np.int64))

    def to_pyvista(self) -> pyvista.DataSet:
        """The dataset for PyVista: points, lines and polygons, or nodes of an image. Needs the extra ``pyvista``."""
        pyvista = extra("pyvista")
        if self.kind == "points":
            shape = pyvista.PolyData(np.array(self.vertices))
            target = shape.point_data
        elif self.kind == "mesh":
            cells = self.cells
            shape = pyvista.PolyData()
            shape.points = np.array(self.vertices)
            lines = [cell for cell in cells if len(cell) == 2]
            faces = [cell for cell in cells if len(cell) > 2]
            if lines:
                shape.lines = np.concatenate([np.r_[len(cell), cell] for cell in lines])
            if faces:
                shape.faces = np.concatenate([np.r_[len(cell), cell] for cell in faces])
            target = shape.cell_data
        else:
            low, spacing, count = self._data.nodes
            shape = pyvista.ImageData(dimensions=count, spacing=[step or 1.0 for step in spacing], origin=low)
            target = shape.point_data
        for name, values in self.fields.items():
            if name != "position":
                target[name] = np.array(values)
        return shape

    def to_meshio(self) -> meshio.Mesh:
        """Points or a mesh for meshio. Needs the extra ``meshio``."""
        meshio = extra("meshio")
        if self.kind not in ("points", "mesh"):
            raise ValueError(f"the dataset {self.name!r} is on a {self.kind}: use to_xarray()")
        values = {name: np.array(value) for name, value in self.fields.items() if name != "position"}
        if self.kind == "points":
            vertices = np.arange(len(self.vertices)).reshape(-1, 1)
            return meshio.Mesh(np.array(self.vertices), [("vertex", vertices)], point_data=values)
        sizes = np.diff(self._data.ends.astype(np.int64), prepend=0)
        names = {2: "line", 3: "triangle", 4: "quad"}
        blocks: list[tuple[str, np.ndarray]] = []
        data: dict[str, list[np.ndarray]] = {name: [] for name in values}
        cells = self.cells
        for size in np.unique(sizes):
            chosen = np.flatnonzero(sizes == size)
            blocks.append((names.get(int(size), "polygon"), np.array([cells[number] for number in chosen])))
            for name, value in values.items():
                data[name].append(value[chosen])
        return meshio.Mesh(np.array(self.vertices), blocks, cell_data=data)

    def to_xarray(self) -> xarray.Dataset:
        """Nodes of a lattice or a raster with their fields. Needs the extra ``xarray``."""
        xarray = extra("xarray")
        low, spacing, count = self._data.nodes
        axes = [axis for axis in range(3) if count[axis] > 1] or [0]
        coordinates: dict[str, Any] = {"xyz"[axis]: low[axis] + spacing[axis] * np.arange(count[axis]) for axis in axes}
        names = [name for name in "zyx" if name in coordinates]
        mask = np.array(self._data.mask if self.kind == "lattice" else [], dtype=bool)
        shape = [len(coordinates[name]) for name in names]
        if not len(mask) and "density" in self.fields and self.kind == "lattice":
            # Nodes without material have no values.
            mask = self.fields["density"] > 0.0
        variables = {}
        for name, values in self.fields.items():
            tail = [] if values.ndim == 1 else [_COMPONENTS[values.shape[1]][0]]
            unit = {"units": self.fields.units[name]}
            kept = np.array(values)
            if kept.dtype.kind == "f" and len(mask):
                kept[~mask] = np.nan
            variables[name] = (names + tail, kept.reshape(shape + list(values.shape[1:])), unit)
            coordinates |= dict([_COMPONENTS[values.shape[1]]]) if tail else {}
        return xarray.Dataset(variables, coordinates)

    def __repr__(self) -> str:
        return f"Dataset({self.name!r}, {self.kind}, fields: {', '.join(self.fields)})"


class Frame:
    """State of a run at ``time`` (s) after ``step`` steps. ``datasets`` has all data by name; points are the first.

    Positions are on the map where the case has an origin.
    """

    def __init__(self, data: _native.FrameData) -> None:
        self.time: float = data.time
        self.step: int = data.step
        self.datasets: dict[str, Dataset] = {one.name: Dataset(one) for one in data.datasets}

    @property
    def points(self) -> Points:
        """Fields of the points."""
        return self._of_points().fields

    def __len__(self) -> int:
        return len(self.points["id"])

    def to_pyvista(self) -> pyvista.DataSet:
        """Points with their fields for PyVista. Needs the extra ``pyvista``."""
        return self._of_points().to_pyvista()

    def to_meshio(self) -> meshio.Mesh:
        """Points with their fields for meshio. Needs the extra ``meshio``."""
        return self._of_points().to_meshio()

    def to_pandas(self) -> pandas.DataFrame:
        """Points with a column for each component of each field; ``attrs["units"]`` has the units. Needs the extra ``pandas``."""
        columns: dict[str, np.ndarray] = {}
        units: dict[str, str] = {}
        for name, values in self.points.items():
            suffixes = [""] if values.ndim == 1 else [f".{own}" for own in _COMPONENTS[values.shape[1]][1]]
            for suffix, column in zip(suffixes, values.reshape(len(values), -1).T):
                columns[name + suffix] = column
                units[name + suffix] = self.points.units[name]
        table = extra("pandas").DataFrame(columns)
        table.attrs["units"] = units
        return table

    def _of_points(self) -> Dataset:
        for dataset in self.datasets.values():
            if dataset.kind == "points":
                return dataset
        raise ValueError(f"the method has no points; the frame has the datasets {', '.join(self.datasets)}")

    def __repr__(self) -> str:
        return f"Frame(time={self.time:g}, datasets: {', '.join(self.datasets)})"


@dataclass(frozen=True)
class Safety:
    """Outcome of a search for a factor of safety. ``factor`` is ``None`` where it is undecided or outside the range.

    ``stable`` is the largest factor of a stable trial, ``failing`` the smallest of a failing one, ``text`` the outcome in words.
    """

    factor: float | None
    stable: float
    failing: float
    text: str


def _recorded_safety(found: dict[str, Any]) -> Safety:
    """Factor of safety in the summary of a run."""
    stable, failing = found.get("stable"), found.get("failed")
    return Safety(
        factor=found.get("factor"),
        stable=0.0 if stable is None else stable,
        failing=float("inf") if failing is None else failing,
        text=found.get("told", ""),
    )


def table(rows: np.ndarray, columns: Sequence[tuple[str, str]]) -> pandas.DataFrame:
    """A table with the units of its columns in ``attrs``."""
    found = extra("pandas").DataFrame(rows.copy(), columns=[name for name, _ in columns])
    found.attrs["units"] = dict(columns)
    return found


class RunResult:
    """Results of a run: measures over time, frames, rasters, warnings, factors of safety.

    ``method``, ``case`` and ``folder`` are those of the run; ``error`` is the reason of a failure, ``is_interrupted`` says whether the run was
    stopped. ``steps`` is the number of steps, ``wall`` the wall-clock time (s). ``frames`` are in the order of time, ``last`` is the state at
    the end and ``hash`` its hash (empty for an opened run on a map). ``warnings`` and ``notes`` have codes and texts, ``safety`` the factors
    of safety by name.
    """

    def __init__(
        self, data: _native.RunData, method: str, kept: list[Frame], case: Case | None, folder: Path | None
    ) -> None:
        self.method = method
        self.case = case
        self.folder = folder
        self.error: str | None = None
        self.is_interrupted: bool = data.is_interrupted
        self.steps: int = data.steps
        self.wall: float = data.wall
        self.warnings: list[tuple[str, str]] = data.warnings
        self.notes: list[tuple[str, str]] = data.notes
        self.safety: dict[str, Safety] = {
            name: Safety(factor, stable, failing, text) for name, factor, stable, failing, text in data.safety
        }
        self.hash: str = data.hash
        self._columns, self._rows = data.measures()
        self._rasters: list[_native.RasterData] = data.rasters
        self.frames: Sequence[Frame] = [Frame(frame) for frame in data.take_earlier_frames()] + kept
        self.last: Frame | None = Frame(data.take_last())

    @classmethod
    def of_failure(
        cls, method: str, kept: list[Frame], case: Case | None, folder: Path | None, part: Any = None
    ) -> RunResult:
        """Frames of a run that failed, and its measures and steps before the failure."""
        result = cls.__new__(cls)
        result.method, result.case, result.folder, result.error = method, case, folder, "the run failed"
        result.is_interrupted, result.steps, result.wall, result.hash = False, 0, float("nan"), ""
        result.warnings, result.notes, result.safety = [], [], {}
        result._columns, result._rows, result._rasters = [], np.zeros((0, 0)), []
        if part is not None:
            (result._columns, result._rows), result.steps = part
        result.frames, result.last = kept, kept[-1] if kept else None
        return result

    @classmethod
    def of_folder(cls, folder: Path) -> RunResult:
        """The run in a folder."""
        from .case import Case

        if not (folder / "summary.json").exists():
            raise OutputError(f"{folder}: contains no run (summary.json is missing)", folder)
        data = _native.open_run(folder)
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        result = cls.of_failure(data.method, [], Case(folder / "case.json", check=False), folder)
        status, reason = data.status
        result.error = reason
        result.is_interrupted = status in ("running", "interrupted")
        result.warnings = data.warnings
        result._columns, result._rows = data.measures()
        last = summary.get("measures", {}).get("time")
        times = result.columns.get("time")
        if status == "completed" and last is not None and (times is None or not len(times) or times[-1] != last):
            raise OutputError(f"{folder / 'measures.csv'}: does not end at t = {last} s as the run did: its rows are not complete", folder)
        # The hash in a summary is that of positions relative to the origin of the domain.
        has_origin = "domain.origin" in result.case if result.case is not None else True
        result.hash = "" if has_origin else summary.get("snapshot_hash", "")
        result.safety = {name: _recorded_safety(found) for name, found in summary.get("factors_of_safety", {}).items()}
        steps = result.columns.get("step")
        result.steps = int(steps[-1]) if steps is not None and len(steps) else 0
        result.frames = _FolderFrames(data)
        result.last = result.frames[-1] if len(result.frames) else None
        rasters = sorted((folder / "rasters").glob("*.tif"))
        result._rasters = [_native.read_raster(file) for file in rasters]
        return result

    def __getstate__(self) -> dict[str, Any]:
        rasters = [one if isinstance(one, _RasterValues) else _RasterValues(one) for one in self._rasters]
        return self.__dict__ | {"_rasters": rasters, "frames": list(self.frames)}

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Measures as one array per column."""
        return {name: self._rows[:, number] for number, (name, _) in enumerate(self._columns)}

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each column of the measures."""
        return dict(self._columns)

    @property
    def measures(self) -> pandas.DataFrame:
        """Measures as a table; ``attrs["units"]`` has the unit of each column. Needs the extra ``pandas``."""
        return table(self._rows, self._columns)

    @property
    def rasters(self) -> xarray.Dataset:
        """Rasters at the end by name, with the coordinates of the map and the EPSG number. Needs the extra ``xarray``."""
        return extra("xarray").Dataset({one.name: to_data_array(one) for one in self._rasters})

    def __repr__(self) -> str:
        state = "failed" if self.error else "interrupted" if self.is_interrupted else "completed"
        return f"RunResult({self.method}, {state}, {self.steps} steps, {len(self.frames)} frames)"


class _RasterValues:
    """Data of a raster in arrays of their own, as a process sends them to another."""

    def __init__(self, raster: _native.RasterData) -> None:
        self.name, self.unit, self.nodes, self.epsg, self.crs = raster.name, raster.unit, raster.nodes, raster.epsg, raster.crs
        self._values = raster.values()

    def values(self) -> np.ndarray:
        """Values, one row per y from the smallest."""
        return self._values.copy()


class _FolderFrames(Sequence[Frame]):
    """Frames of a folder, each read when it is asked for."""

    def __init__(self, data: _native.RecordedData) -> None:
        self._data = data
        self._count = len(data.frame_times)

    def __len__(self) -> int:
        return self._count

    def __repr__(self) -> str:
        return f"{self._count} frames, read from their files when they are asked for"

    @overload
    def __getitem__(self, number: int) -> Frame: ...
    @overload
    def __getitem__(self, number: slice) -> list[Frame]: ...
    def __getitem__(self, number: int | slice) -> Frame | list[Frame]:
        if isinstance(number, slice):
            return [self[one] for one in range(*number.indices(self._count))]
        position = number + self._count if number < 0 else number
        if not 0 <= position < self._count:
            raise IndexError(f"the run has {self._count} frames")
        return Frame(self._data.frame(position))


def open_run(folder: str | os.PathLike[str]) -> RunResult:
    """The run in a folder, which this package or the command has written. Frames are read from their files when they are asked for."""
    return RunResult.of_folder(as_folder(folder, "folder"))


def folder_of(run: RunResult | str | os.PathLike[str], function: str) -> Path:
    """Folder of a run."""
    if isinstance(run, RunResult):
        if run.folder is None:
            raise ValueError(f"{function} reads the files of a run: give run() a folder with out=")
        return run.folder
    return as_folder(run, "run")


__all__: list[Any] = ["Dataset", "Frame", "Points", "RunResult", "Safety", "open_run"]
