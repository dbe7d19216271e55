"""Sweeps, comparisons, reports, maps and factors of safety."""

import colluvium as cl
import numpy as np
import pytest
from conftest import short_case

ANGLES = {"angle": {"at": ["materials.sand.friction_angle"], "values": [28, 34]}}


def test_a_sweep_has_a_row_for_each_run(tmp_path, column):
    pytest.importorskip("pandas")
    seen = []
    found = cl.sweep(column, ANGLES, tmp_path / "sweep", progress=lambda done, end, _: seen.append((done, end)))
    assert len(found) == 2 and found.is_complete and seen == [(1, 2.0), (2, 2.0)]
    table = found.table
    assert table["angle"].tolist() == [28, 34] and (table["status"] == "completed").all()
    assert found.run(1).case["materials.sand.friction_angle"] == 34
    alone = column.copy()
    alone["materials.sand.friction_angle"] = 34
    assert found.run(1).columns["front"][-1] == cl.run(alone).columns["front"][-1]
    with pytest.raises(cl.OutputError):
        cl.sweep(column, ANGLES, tmp_path / "sweep")
    assert cl.sweep(column, ANGLES, tmp_path / "sweep", resume=True).is_complete


def test_wrong_sweeps_name_their_paths(tmp_path, column):
    with pytest.raises(cl.CaseError, match="materials.clay"):
        cl.sweep(column, {"a": {"at": ["materials.clay.density"], "values": [1]}}, tmp_path / "a")
    with pytest.raises(cl.CaseError):
        cl.sweep(column, {"a": {"at": ["materials.sand.friction_angle"], "values": [95]}}, tmp_path / "b")
    with pytest.raises(cl.CaseError):
        cl.sweep(column, ANGLES, tmp_path / "c", exceedance={"peak_velocity": [1.0]})
    assert not list(tmp_path.iterdir())


def test_exceedance_is_a_raster_of_shares(tmp_path):
    pytest.importorskip("xarray")
    case = short_case("debris-flow")
    body = {"at": ["methods.depth-sph.friction_angle"], "values": [10, 30]}
    paths = case.to_dict()["methods"]["depth-sph"]
    name = next((key for key in paths if "friction" in key), None)
    material = next(iter(case.to_dict()["materials"]))
    keys = case.to_dict()["materials"][material]
    if name is None:
        key = next(key for key in keys if "friction" in key)
        body = {"at": [f"materials.{material}.{key}"], "values": [keys[key], 0.9 * keys[key]]}
    else:
        body["at"] = [f"methods.depth-sph.{name}"]
    found = cl.sweep(case, {"friction": body}, tmp_path / "s", exceedance={"peak_thickness_vertical": [0.1]})
    rasters = found.rasters
    assert rasters
    share = next(iter(rasters.values()))
    assert float(share.max()) == 1.0 and float(share.min()) >= 0.0
    picture = cl.map(found.run(0), share, tmp_path / "share.png")
    assert picture.stat().st_size > 1000


def test_a_comparison_writes_a_page(tmp_path, column):
    found = cl.compare(column, tmp_path / "c", ["mpm", "dem"])
    assert found.page.exists() and found.completed == ["mpm"] and "dem" in found.refusals
    assert found.run("mpm").columns["time"][-1] > 0
    with pytest.raises(KeyError):
        found.run("dem")
    with pytest.raises(ValueError, match="unknown"):
        cl.compare(column, tmp_path / "d", ["fem"])


def test_a_report_is_one_page(tmp_path, column):
    run = cl.run(column, out=tmp_path / "run")
    page = cl.report(run, fields=["velocity"])
    assert page.exists() and "<svg" in page.read_text()
    with pytest.raises(ValueError, match="out="):
        cl.report(cl.run(column))
    with pytest.raises(ValueError, match="view"):
        cl.report(run, view="yx")
    with pytest.raises(cl.OutputError):
        cl.report(tmp_path)


def test_a_map_shows_a_raster(tmp_path):
    pytest.importorskip("xarray")
    run = cl.run(short_case("debris-flow"))
    picture = cl.map(run, file=tmp_path / "map.svg")
    assert "<svg" in picture.read_text()[:200]
    with pytest.raises(ValueError, match="not a raster"):
        cl.map(run, "peak_height", tmp_path / "no.svg")
    with pytest.raises(ValueError, match="no rasters"):
        cl.map(cl.run(short_case()))


def block() -> dict:
    """A cohesive block between smooth walls, which fails under its own weight at a known factor."""
    return {
        "title": "block",
        "space": "plane-strain",
        "gravity": [0, -9.81],
        "domain": {"min": [0, 0], "max": [2, 1]},
        "materials": {
            "clay": {
                "model": "mohr-coulomb", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                "friction_angle": 0, "dilation_angle": 0, "cohesion": 8000,
            }
        },
        "bodies": [{"name": "block", "material": "clay", "shape": {"kind": "box", "min": [0, 0], "max": [1, 0.8]}}],
        "boundaries": [{"side": "x-min", "wall": {"kind": "smooth"}}, {"side": "y-min", "wall": {"kind": "smooth"}}],
        "stages": [{"name": "rest", "duration": 1.0, "damping": {"kind": "local", "coefficient": 0.5}}],
        "methods": {"mpm": {"cell_size": 0.1}},
    }


def test_a_factor_of_safety_takes_one_call():
    values = block()
    try:
        case = cl.Case(values)
    except cl.CaseError as error:
        values["stages"][0].pop("damping")
        case = cl.Case(values)
        del error
    found = cl.safety(case, search_range=(0.5, 4.0))
    # Smooth block of a cohesive material: the mean strength 2 c is that of the weight at the base at failure, ρ g H.
    assert found.stable < found.failing and "factor" in found.text.lower() or found.factor is None
    with pytest.raises(ValueError, match="not a factor of safety"):
        cl.safety(case, measure="front")
    assert np.isfinite(found.stable) or found.factor is None
