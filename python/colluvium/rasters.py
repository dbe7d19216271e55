"""Rasters in plan, and their maps and outlines."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from . import _native
from ._extras import extra

if TYPE_CHECKING:
    import geopandas
    import xarray

    from .results import RunResult

def to_data_array(raster: _native.RasterData) -> xarray.DataArray:
    """A raster with its coordinates, unit and EPSG number, as rioxarray reads them."""
    xarray = extra("xarray")
    label = _native.raster_label(raster.name) or raster.name
    # Files of results do not have units.
    unit = raster.unit or label.partition(" (")[2].rstrip(")")
    (west, south), (dx, dy) = raster.nodes
    values = raster.values()
    found = xarray.DataArray(
        values,
        dims=("y", "x"),
        coords={
            "y": ("y", south + dy * np.arange(values.shape[0]), {"units": "m"}),
            "x": ("x", west + dx * np.arange(values.shape[1]), {"units": "m"}),
        },
        name=raster.name,
        attrs={"units": unit, "long_name": label},
    )
    crs = f"EPSG:{raster.epsg}" if raster.epsg else raster.crs
    if crs:
        transform = f"{west - dx / 2} {dx} 0 {south - dy / 2} 0 {dy}"
        attributes = {"spatial_ref": crs, "crs_wkt": crs, "GeoTransform": transform}
        found = found.assign_coords(spatial_ref=xarray.Variable((), 0, attributes))
        found.encoding["grid_mapping"] = "spatial_ref"
    if raster.epsg:
        found.attrs["epsg"] = raster.epsg
    return found


def read_raster(file: str | os.PathLike[str]) -> xarray.DataArray:
    """Reads a raster, an ESRI ASCII grid or a GeoTIFF. Raises ``OutputError`` with the reason. Needs the extra ``xarray``."""
    return to_data_array(_native.read_raster(Path(file)))


def _nodes(raster: xarray.DataArray) -> tuple[np.ndarray, tuple[float, float], tuple[float, float]]:
    """Values with rows from the smallest y, first node (m) and distance of the nodes (m)."""
    if not hasattr(raster, "dims"):
        raise TypeError(f"a raster is an xarray.DataArray, not {type(raster).__name__}")
    if set(raster.dims) != {"x", "y"}:
        raise ValueError(f"a raster has the dimensions y and x, not {', '.join(map(str, raster.dims))}")
    sorted_raster = raster.transpose("y", "x").sortby("y").sortby("x")
    x, y = (np.asarray(sorted_raster[name], dtype=float) for name in ("x", "y"))
    if len(x) < 2 or len(y) < 2:
        raise ValueError("a raster has at least two nodes along x and y")
    spacing = ((x[-1] - x[0]) / (len(x) - 1), (y[-1] - y[0]) / (len(y) - 1))
    for axis, step in ((x, spacing[0]), (y, spacing[1])):
        if not np.allclose(np.diff(axis), step, rtol=1e-6):
            raise ValueError("the nodes of a raster have equal distances")
    if not np.issubdtype(sorted_raster.dtype, np.number) or np.iscomplexobj(sorted_raster.values):
        raise ValueError(f"a raster has real numbers, not {sorted_raster.dtype}")
    values = np.ascontiguousarray(sorted_raster.values, dtype=float)
    return values, (float(x[0]), float(y[0])), (float(spacing[0]), float(spacing[1]))


def write_raster(raster: xarray.DataArray, file: str | os.PathLike[str]) -> None:
    """Writes a raster as an ESRI ASCII grid (``.asc``) or a GeoTIFF (``.tif``); its attribute ``epsg`` is written with it."""
    values, origin, spacing = _nodes(raster)
    epsg = raster.attrs.get("epsg")
    if epsg is not None and not 1024 <= int(epsg) <= 32767:
        raise ValueError(f"epsg: {epsg} is not a code from 1024 to 32767, as GeoTIFF has them")
    if (np.abs(values[~np.isnan(values)]) > float(np.finfo(np.float32).max)).any():
        raise ValueError("the raster has values beyond the largest number of a GeoTIFF")
    _native.write_raster(Path(file), values, origin, spacing, None if epsg is None else int(epsg))


def raster_outline(raster: xarray.DataArray, above: float) -> geopandas.GeoDataFrame:
    """Outline of the area in which a raster is above a value, as a table with one row. Needs the extra ``geopandas``.

    The outline follows the sides of the cells around the nodes. ``area`` is in m².
    """
    geopandas, shapely = extra("geopandas"), extra("shapely", "geopandas")
    values, (west, south), (dx, dy) = _nodes(raster)
    inside = np.pad(values > above, ((0, 0), (1, 1)))
    strips = []
    for row in range(values.shape[0]):
        edges = np.flatnonzero(np.diff(inside[row].astype(np.int8)))
        bottom = south + (row - 0.5) * dy
        for first, end in zip(edges[::2], edges[1::2]):
            strips.append(shapely.box(west + (first - 0.5) * dx, bottom, west + (end - 0.5) * dx, bottom + dy))
    area = shapely.union_all(strips, grid_size=1e-6 * min(dx, dy)) if strips else shapely.MultiPolygon()
    table = {"raster": [raster.name], "above": [above], "area": [area.area]}
    return geopandas.GeoDataFrame(table, geometry=[area], crs=raster.attrs.get("epsg"))


def draw_map(
    run: RunResult | str | os.PathLike[str],
    raster: str | xarray.DataArray = "",
    file: str | os.PathLike[str] | None = None,
) -> Path:
    """Draws a raster of a run over its terrain and outlines, as the picture ``file`` (SVG or PNG), and returns its path.

    Without ``file`` the picture is ``RASTER.png`` in the working folder.

    ``raster`` is the name of a raster of the run, by default the first, or an array, such as an exceedance probability.
    """
    from .results import RunResult, open_run

    result = run if isinstance(run, RunResult) else open_run(run)
    if isinstance(raster, str):
        known = result.rasters
        if not len(known):
            raise ValueError("the run has no rasters: give its case output.rasters, and a method with a depth")
        name = raster or ("peak_thickness_vertical" if "peak_thickness_vertical" in known else str(next(iter(known))))
        if name not in known:
            raise ValueError(f"{name!r} is not a raster of the run; there are {', '.join(str(one) for one in known)}")
        raster = known[name]
    if result.case is None:
        raise ValueError("the run has no case")
    target = Path(f"{raster.name or 'raster'}.png" if file is None else file)
    values, origin, spacing = _nodes(raster)
    if not np.isfinite(values).any() or np.isinf(values).any():
        raise ValueError("the raster has no finite value, or infinite ones")
    case = result.case
    low, high = case["domain.min"], case["domain.max"]
    ends = [origin[axis] + spacing[axis] * (values.shape[1 - axis] - 1) for axis in (0, 1)]
    if any(ends[axis] < low[axis] or origin[axis] > high[axis] for axis in (0, 1)):
        raise ValueError(f"the raster from {origin} to {tuple(ends)} m lies outside the domain of the case, from {low} to {high} m")
    label = str(raster.attrs.get("long_name", raster.name or "value"))
    _native.draw_map(
        target, case.to_json(), case.folder, values, origin, spacing, str(case.to_dict().get("title", "")), label
    )
    return target
