"""Uses that lose results or exceptions in a careless package."""

import copy
import os
import pickle
import warnings

import colluvium as cl
import numpy as np
import pytest
from conftest import short_case


def oedometer(law):
    material = {"model": "external", "law": law, "density": 1900}
    path = {"kind": "oedometer", "axial_compression": 0.01}
    return cl.ElementTest({"title": "t", "material": material, "stages": [{"path": path, "steps": 5}]})


class Linear:
    calls = 0
    fails_at = 0
    error = ZeroDivisionError

    def wave_modulus(self, stress, state):
        return 1e6

    def update(self, strain, stress, state, dt):
        Linear.calls += 1
        if Linear.calls == Linear.fails_at:
            raise Linear.error
        return stress + 1e6 * strain, {}


cl.law("python-linear")(Linear)


def test_every_exception_of_a_law_ends_the_element_test():
    Linear.calls, Linear.fails_at = 0, 0
    oedometer("python-linear").run()
    count = Linear.calls
    for number in (1, count // 3, count // 2, count):
        Linear.calls, Linear.fails_at = 0, number
        with pytest.raises(cl.SolverError) as failed:
            oedometer("python-linear").run()
        assert isinstance(failed.value.__cause__, ZeroDivisionError) and Linear.calls == number
    for error in (KeyboardInterrupt, SystemExit):
        Linear.calls, Linear.fails_at, Linear.error = 0, count // 2, error
        with pytest.raises(error):
            oedometer("python-linear").run()
    Linear.fails_at, Linear.error = 0, ZeroDivisionError


def test_a_mistake_in_a_law_is_no_misfit():
    pytest.importorskip("scipy")
    Linear.calls, Linear.fails_at = 0, 0
    data = {"axial_compression": [0.005, 0.01], "q": [1e3, 2e3]}
    Linear.fails_at = 200
    with pytest.raises(cl.SolverError) as failed:
        cl.calibrate(oedometer("python-linear"), data, {"density": (1000, 2000)}, 1e2)
    assert isinstance(failed.value.__cause__, ZeroDivisionError)
    Linear.fails_at = 0


def test_a_change_of_the_working_folder_does_not_move_a_run(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    run = cl.run(short_case(), out="run", on_frame=lambda _: os.chdir(tmp_path / "there"))
    assert run.folder == tmp_path / "here" / "run" and cl.report(run).exists()
    assert not list((tmp_path / "there").iterdir())


def test_a_warning_as_error_keeps_the_results():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(cl.ColluviumWarning) as raised:
            cl.run(short_case(), progress=False)
    assert raised.value.result.steps > 10


def test_files_of_a_template_stay_for_copies_generators_and_later_processes(tmp_path):
    assert next(iter(cl.frames(short_case("debris-flow")))).time == 0.0
    case = short_case("debris-flow")
    copies = [copy.deepcopy(case), pickle.loads(pickle.dumps(case)), case.copy()]
    del case
    [one.check() for one in copies]


def test_rows_that_are_cut_off_are_noticed(tmp_path):
    cl.run(short_case(), out=tmp_path / "run")
    table = tmp_path / "run" / "measures.csv"
    table.write_bytes(table.read_bytes()[:-4])
    with pytest.raises(cl.OutputError, match="not complete"):
        cl.open_run(tmp_path / "run")


def test_an_opened_run_has_its_hash_and_its_units(tmp_path):
    run = cl.run(short_case("debris-flow"), out=tmp_path / "run")
    again = cl.open_run(tmp_path / "run")
    assert again.hash == "" and cl.run(short_case(), out=tmp_path / "column").hash == cl.open_run(tmp_path / "column").hash
    pytest.importorskip("xarray")
    for name, raster in run.rasters.items():
        assert again.rasters[name].attrs["units"] == raster.attrs["units"] != ""


def test_rasters_that_a_map_or_a_file_cannot_show_are_refused(tmp_path):
    xarray = pytest.importorskip("xarray")
    run = cl.run(short_case("debris-flow"))
    far = xarray.DataArray(np.ones((3, 3)), dims=("y", "x"), coords={"y": [5.0, 6.0, 7.0], "x": [0.0, 1.0, 2.0]})
    with pytest.raises(ValueError, match="outside the domain"):
        cl.map(run, far, tmp_path / "far.png")
    own = run.rasters["peak_velocity"]
    with pytest.raises(ValueError, match="finite"):
        cl.map(run, own * np.nan, tmp_path / "nan.png")
    for raster, text in [(own * 1e300 + 1e300, "largest"), (own + 1j, "real"), (own.assign_attrs(epsg=70000), "epsg")]:
        with pytest.raises(ValueError, match=text):
            cl.write_raster(raster, tmp_path / "a.tif")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("out", ["", 3])
def test_wrong_folders_are_refused(out, column):
    with pytest.raises((TypeError, ValueError), match="out"):
        cl.run(column, out=out)


def test_paths_in_a_case(column):
    assert "materials.sand.density" in column and "materials.clay" not in column
    with pytest.raises(TypeError, match="path"):
        column[3]
    with pytest.raises(TypeError):
        iter(column)
    with pytest.raises(cl.CaseError, match="Unicode") as wrong:
        column["title"] = "\ud800"
    assert wrong.value.problems[0][0] == "title"


def test_bad_arguments_of_a_calibration():
    data = {"axial_compression": [0.005, 0.01], "q": [1e3, 2e3]}
    test = oedometer("python-linear")
    nothing = {"axial_compression": [0.005, 0.01], "q": [np.nan, np.nan]}
    for free, values, text in [
        ({"density": 3}, data, "two bounds"), ({"density": (1, 2)}, nothing, "no number"),
        ({"density": (1, 2)}, {"axial_compression": [0.0, 0.01], "q": [np.inf, 1.0]}, "not finite"),
    ]:
        with pytest.raises(ValueError, match=text):
            cl.objective(test, values, free, 1.0)
    with pytest.raises(TypeError, match="DataFrame"):
        cl.objective(test, 3, {"density": (1, 2)}, {"q": 1.0})
    with pytest.raises(ValueError, match="2 values"):
        cl.objective(test, data, {"density": (1000, 2000)}, 1.0)([1, 2])


def test_references_and_numbers_of_runs(tmp_path, column):
    with pytest.raises(cl.OutputError):
        cl.compare(column, tmp_path / "c", "mpm", reference=tmp_path / "none.csv")
    for wrong in (0, -1):
        with pytest.raises(ValueError):
            cl.compare(column, tmp_path / "c", "mpm", jobs=wrong)
        with pytest.raises(ValueError):
            cl.run(column, threads=wrong)
    with pytest.raises(TypeError):
        cl.run(column, threads=True)


def test_the_cause_is_the_exception_of_this_run_and_texts_are_clean(column, tmp_path):
    # Exceptions in element tests leave nothing behind that a later run could take for its own.
    for number in range(40):
        Linear.calls, Linear.fails_at = 0, 1
        with pytest.raises(cl.SolverError):
            oedometer("python-linear").run()
    Linear.fails_at = 0

    @cl.law("python-fails-at-once")
    class Fails(Linear):
        def update(self, strain, stress, state, dt):
            raise LookupError("mine")

    column.update({"materials.sand": {"model": "external", "law": "python-fails-at-once", "density": 2000}})
    with pytest.raises(cl.SolverError) as failed:
        cl.run(column)
    assert isinstance(failed.value.__cause__, LookupError)
    with pytest.warns(cl.ColluviumWarning, match="mine"):
        found = cl.sweep(column, {"density": {"at": "materials.sand.density", "values": [1900]}}, tmp_path / "s")
    assert found.failures[0].isprintable()
