"""Sweeps, comparisons, reports, maps and factors of safety."""

import colluvium as cl
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


def test_a_parameter_without_effect_is_named(tmp_path):
    # The law of the bed replaces the friction of the material.
    case = short_case("debris-flow")
    with pytest.warns(cl.ColluviumWarning, match="angle: has no effect"):
        cl.sweep(case, {"angle": {"at": "materials.debris.friction_angle", "values": [20, 30]}}, tmp_path / "s")


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
    friction = {"at": "methods.depth-sph.basal.friction_angle", "values": [5, 9]}
    found = cl.sweep(case, {"friction": friction}, tmp_path / "s", exceedance={"peak_thickness_vertical": [0.1]})
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
    with pytest.raises(ValueError, match="fem"):
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
                "friction_angle": 0, "dilatancy_angle": 0, "cohesion": 8000,
            }
        },
        "bodies": [{"name": "block", "material": "clay", "shape": {"kind": "box", "min": [0, 0], "max": [1, 0.8]}}],
        "boundaries": [{"side": "x-min", "wall": {"kind": "smooth"}}, {"side": "y-min", "wall": {"kind": "smooth"}}],
        "stages": [{"name": "rest", "duration": 1.0, "damping": 0.5}],
        "methods": {"mpm": {"cell_size": 0.1}},
    }


@pytest.mark.filterwarnings("ignore::colluvium.ColluviumWarning")
def test_a_factor_of_safety_is_between_the_bounds_of_limit_analysis():
    found = cl.safety(cl.Case(block()), search_range=(1.0, 3.0))
    # Lower bound: a column of the height fails at its base, at 2 c. Upper bound: a wedge at 45° through the toe, at 4 c.
    load = 2000 * 9.81 * 0.8
    assert 2 * 8000 / load < found.stable < found.factor < found.failing < 4 * 8000 / load
    with pytest.raises(ValueError, match="not a factor of safety"):
        cl.safety(cl.Case(block()), measure="front")


@pytest.mark.filterwarnings("ignore::colluvium.ColluviumWarning")
def test_a_factor_of_safety_is_read_from_its_folder(tmp_path):
    found = cl.safety(cl.Case(block()), out=tmp_path / "run", search_range=(1.5, 1.8))
    assert cl.open_run(tmp_path / "run").safety["factor_of_safety"] == found


def test_warnings_of_a_search_name_the_line_of_the_call():
    with pytest.warns(cl.ColluviumWarning) as found:
        cl.safety(cl.Case(block()), search_range=(1.5, 1.8))
    assert all(one.filename == __file__ for one in found if isinstance(one.message, cl.ColluviumWarning))
