"""Results: arrays without a copy, tables, rasters, meshes, folders."""

import gc

import colluvium as cl
import numpy as np
import pytest
from conftest import short_case


def test_no_array_is_a_copy_and_arrays_outlive_the_run():
    run = cl.run(short_case())
    frame = run.frames[-1]
    kept = {}
    for name in frame.points:
        first, again = frame.points[name], frame.points[name]
        assert first.ctypes.data == again.ctypes.data and not first.flags.writeable and not first.flags.owndata
        kept[name] = (first, first.copy())
    assert frame.points["stress"].shape == (len(frame), 6)
    del run, frame
    gc.collect()
    for first, copy in kept.values():
        assert np.array_equal(first, copy, equal_nan=copy.dtype.kind == "f")
    with pytest.raises(ValueError):
        kept["velocity"][0][0] = 1.0


def test_stresses_are_in_the_order_xx_yy_zz_xy_yz_zx():
    points = cl.run(short_case()).last.points
    assert np.allclose(points["pressure"], -points["stress"][:, :3].mean(axis=1))
    deviator = points["stress"].copy()
    deviator[:, :3] += points["pressure"][:, None]
    q = np.sqrt(1.5 * (np.sum(deviator[:, :3] ** 2, axis=1) + 2 * np.sum(deviator[:, 3:] ** 2, axis=1)))
    assert np.allclose(points["deviatoric_stress"], q)


def test_tables_have_units(column):
    pytest.importorskip("pandas")
    run = cl.run(column)
    assert run.measures.attrs["units"]["front"] == "m" and len(run.measures) == len(run.columns["time"])
    points = run.last.to_pandas()
    assert points.attrs["units"]["velocity.x"] == "m/s" and len(points) == len(run.last)
    assert np.array_equal(points["stress.zx"], run.last.points["stress"][:, 5])


def test_rasters_have_the_coordinates_of_the_map():
    pytest.importorskip("xarray")
    case = short_case("debris-flow")
    run = cl.run(case)
    raster = run.rasters["peak_thickness_vertical"]
    assert raster.dims == ("y", "x") and raster.attrs["units"] == "m"
    assert raster.x[1] > raster.x[0] and raster.y[1] > raster.y[0]
    terrain = cl.read_raster(case.folder / case["obstacles[0].shape.file"])
    assert float(terrain.x.min()) <= float(raster.x.min()) and float(raster.y.max()) <= float(terrain.y.max())
    # The mass of the flow is the integral of the final thickness.
    final = run.rasters["final_thickness_vertical"]
    volume = float(final.sum()) * float(final.x[1] - final.x[0]) * float(final.y[1] - final.y[0])
    assert volume == pytest.approx(float(np.sum(run.last.points["volume"])), rel=0.05)


def test_a_written_raster_is_read_again(tmp_path):
    xarray = pytest.importorskip("xarray")
    values = np.arange(12.0).reshape(3, 4)
    values[1, 1] = np.nan
    raster = xarray.DataArray(
        values, dims=("y", "x"), coords={"y": [30.0, 20.0, 10.0], "x": [5.0, 15.0, 25.0, 35.0]}, attrs={"epsg": 2056}
    )
    for name in ("a.tif", "a.asc"):
        cl.write_raster(raster, tmp_path / name)
        again = cl.read_raster(tmp_path / name)
        assert np.array_equal(again.sortby("y", ascending=False).values, values, equal_nan=True)
        assert again.x.values.tolist() == [5.0, 15.0, 25.0, 35.0]
    assert cl.read_raster(tmp_path / "a.tif").attrs["epsg"] == 2056
    with pytest.raises(cl.OutputError):
        cl.read_raster(tmp_path / "none.tif")
    with pytest.raises(ValueError, match="equal distances"):
        cl.write_raster(raster.assign_coords(x=[0.0, 1.0, 3.0, 4.0]), tmp_path / "b.tif")


def test_rioxarray_reads_the_epsg_number(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("rioxarray")
    raster = xarray.DataArray(
        np.ones((3, 4)), dims=("y", "x"), coords={"y": [10.0, 20.0, 30.0], "x": [5.0, 15.0, 25.0, 35.0]}, attrs={"epsg": 2056}
    )
    cl.write_raster(raster, tmp_path / "a.tif")
    assert cl.read_raster(tmp_path / "a.tif").rio.crs.to_epsg() == 2056


def test_outlines_follow_the_cells_above_a_value():
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("geopandas")
    values = np.zeros((4, 5))
    values[1:3, 1:4] = 2.0
    values[1, 2] = np.nan
    raster = xarray.DataArray(
        values, dims=("y", "x"), coords={"y": 10.0 * np.arange(4), "x": 100 + 10.0 * np.arange(5)}, attrs={"epsg": 2056}
    )
    outline = cl.raster_outline(raster, above=1.0)
    assert outline.area[0] == pytest.approx(500.0) and outline.crs.to_epsg() == 2056
    assert outline.total_bounds == pytest.approx([105.0, 5.0, 135.0, 25.0])
    assert cl.raster_outline(raster, above=5.0).geometry[0].is_empty


def test_points_and_meshes_for_meshio(tmp_path):
    pytest.importorskip("meshio")
    run = cl.run(short_case())
    mesh = run.last.to_meshio()
    assert np.array_equal(mesh.points, run.last.points["position"]) and mesh.point_data["velocity"].shape[1] == 3
    mesh.write(tmp_path / "points.vtu")
    case = short_case("landslide")
    case["output.contacts"] = True
    frame = cl.run(case, "dem").frames[-1]
    contacts = frame.datasets["contacts"]
    assert contacts.kind == "mesh"
    lines = contacts.to_meshio()
    assert all(block.type == "line" for block in lines.cells)
    assert sum(len(block.data) for block in lines.cells) == len(contacts.cells)


def test_points_for_pyvista():
    pytest.importorskip("pyvista")
    run = cl.run(short_case())
    cloud = run.frames[-1].to_pyvista()
    assert cloud.n_points == len(run.last) and "velocity" in cloud.array_names


def test_nodes_for_xarray():
    pytest.importorskip("xarray")
    case = short_case()
    case["output.grid"] = 0.05
    frame = cl.run(case).frames[-1]
    grid = frame.datasets["grid"]
    nodes = grid.to_xarray()
    assert nodes.axis.values.tolist() == ["x", "y", "z"] and bool(np.isnan(nodes.density).any())
    assert grid.kind == "lattice" and set(nodes.dims) >= {"x", "y"} and float(nodes.x[1] - nodes.x[0]) == pytest.approx(0.05)


def test_a_run_is_read_from_its_folder(tmp_path, column):
    run = cl.run(column, out=tmp_path / "run")
    read = cl.open_run(tmp_path / "run")
    assert read.method == "mpm" and read.steps == run.steps and len(read.frames) == len(run.frames)
    assert read.columns["front"][-1] == run.columns["front"][-1]
    assert np.array_equal(read.frames[-1].points["id"], run.last.points["id"])
    assert [frame.time for frame in read.frames[:2]] == [frame.time for frame in run.frames[:2]]
    with pytest.raises(IndexError):
        read.frames[99]
    with pytest.raises(cl.OutputError):
        cl.open_run(tmp_path)


def test_results_can_be_sent_to_other_processes(column):
    import copy
    import pickle

    run = cl.run(column)
    for again in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
        assert again.hash == run.hash and again.case == run.case
        assert np.array_equal(again.frames[-1].points["stress"], run.frames[-1].points["stress"])
        assert again.columns["front"][-1] == run.columns["front"][-1]
    assert pickle.loads(pickle.dumps(run.last.points))["velocity"].shape == (len(run.last), 3)


def test_missing_extras_are_named(monkeypatch, column):
    import builtins

    run = cl.run(column)
    real = builtins.__import__
    import importlib

    def missing(name, *rest):
        if name.split(".")[0] in ("pandas", "pyvista"):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr("colluvium._extras.import_module", lambda name: missing(name) or importlib.import_module(name))
    with pytest.raises(ImportError, match=r"colluvium\[pandas\]"):
        run.measures
    with pytest.raises(ImportError, match=r"colluvium\[pyvista\]"):
        run.last.to_pyvista()
