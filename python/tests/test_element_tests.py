"""Element tests and calibration."""

import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import colluvium as cl
import numpy as np
import pytest

SAND = {
    "model": "mohr-coulomb",
    "density": 1900,
    "youngs_modulus": 2e7,
    "poissons_ratio": 0.3,
    "friction_angle": 33.0,
    "dilatancy_angle": 3.0,
}


def triaxial(material=SAND, cell=1e5, drained=True, strain=0.03, steps=60):
    path = {"kind": "triaxial-drained" if drained else "triaxial-undrained", "axial_compression": strain}
    return cl.ElementTest(
        {"title": "triaxial", "material": material, "initial_stress": [-cell] * 3 + [0, 0, 0], "stages": [{"path": path, "steps": steps}]}
    )


def test_strength_of_a_triaxial_test_is_that_of_the_criterion():
    path = triaxial().run()
    sine = np.sin(np.radians(33.0))
    assert path["q"][-1] == pytest.approx(1e5 * 2 * sine / (1 - sine), rel=1e-6)
    assert path.units["q"] == "Pa" and path.stage()["time"].shape == path["time"].shape
    assert triaxial().with_values({"material.friction_angle": 30}).run()["q"][-1] < path["q"][-1]


def test_a_path_is_a_table():
    pytest.importorskip("pandas")
    table = triaxial().run().table
    assert table.attrs["units"]["stress_zz"] == "Pa" and len(table) == 61


def test_a_limit_load_is_an_error_with_the_path_before_it():
    test = triaxial().to_dict()
    test["stages"] = [{"path": {"kind": "stress", "increment": [0, 0, -8e5, 0, 0, 0]}, "steps": 20}]
    with pytest.raises(cl.SolverError, match="limit load") as failed:
        cl.ElementTest(test).run()
    sine = np.sin(np.radians(33.0))
    assert 1e5 < failed.value.path["q"][-1] <= 1e5 * 2 * sine / (1 - sine) * (1 + 1e-6)


def test_wrong_tests_name_their_paths():
    with pytest.raises(cl.CaseError) as wrong:
        triaxial(SAND | {"poissons_ratio": 0.7})
    assert wrong.value.problems[0][0] == "material.poissons_ratio"
    with pytest.raises(cl.CaseError):
        cl.ElementTest('{"title": "a", "title": "b"}')
    with pytest.raises(KeyError, match="there are"):
        triaxial().with_values({"material.friction.angle": 3})


def data_of(test, *columns):
    path = test.run()
    return {"axial_compression": path["axial_compression"], **{name: path[name] for name in columns}}


@pytest.mark.parametrize("start", [25.5, 28.0, 31.0, 36.0, 39.5])
def test_a_friction_angle_is_recovered_from_any_start(start):
    pytest.importorskip("scipy")
    data = data_of(triaxial(), "q")
    start_test = triaxial(SAND | {"friction_angle": 27.0})
    found = cl.calibrate(start_test, data, {"friction_angle": (25, 40)}, {"q": 2e3}, start={"friction_angle": start})
    assert found.values["friction_angle"] == pytest.approx(33.0, abs=0.01)
    assert found.misfit < 0.01 and found.undetermined == []
    assert found.path("test")["q"][-1] == pytest.approx(data["q"][-1], rel=1e-4)


def test_a_parameter_without_effect_is_named():
    pytest.importorskip("scipy")
    data = data_of(triaxial(drained=True), "q")
    free = {"friction_angle": (25, 40), "density": (1500, 2500)}
    with pytest.warns(cl.ColluviumWarning, match="density: the data do not hold it"):
        found = cl.calibrate(triaxial(), data, free, {"q": 2e3})
    assert found.undetermined == ["density"] and found.deviations["density"] > 1000
    assert found.values["friction_angle"] == pytest.approx(33.0, abs=0.01)


def test_deviations_are_those_of_a_linear_regression():
    # Elastic: q = E ε, so that the variance of E is t² / Σ ε².
    pytest.importorskip("scipy")
    elastic = {"model": "linear-elastic", "density": 2000, "youngs_modulus": 2e7, "poissons_ratio": 0.3}
    test = triaxial(elastic, strain=1e-4, steps=20)
    data = data_of(test, "q")
    found = cl.calibrate(test, data, {"youngs_modulus": (1e7, 4e7)}, {"q": 100.0})
    strain = np.array(data["axial_compression"])
    assert found.deviations["youngs_modulus"] == pytest.approx(100.0 / np.sqrt(np.sum(strain**2)), rel=2e-3)


def test_bad_calibrations_are_refused():
    pytest.importorskip("scipy")
    data = data_of(triaxial(), "q")
    for free, tolerances, text in [
        ({"friction_angle": (40, 25)}, {"q": 1e3}, "bounds"),
        ({"friction_angle": (25, 40)}, {}, "tolerances"),
        ({}, {"q": 1e3}, "free parameter"),
    ]:
        with pytest.raises(ValueError, match=text):
            cl.calibrate(triaxial(), data, free, tolerances)
    with pytest.raises(ValueError, match="not a column"):
        cl.calibrate(triaxial(), {"axial_strain": [0, 1], "q": [0, 1]}, {"friction_angle": (25, 40)}, {"q": 1e3})
    with pytest.raises(KeyError, match="frictionangle"):
        cl.calibrate(triaxial(), data, {"material.frictionangle": (25, 40)}, {"q": 1e3})


def test_an_objective_may_run_in_other_processes():
    data = data_of(triaxial(), "q")
    objective = cl.objective(triaxial(), data, {"friction_angle": (25, 40)}, {"q": 2e3})
    assert objective([33.0]) < 1e-12 < objective([34.0]) < objective([36.0])
    assert objective([41.0]) == np.inf and objective.log_likelihood([34.0]) == -objective([34.0])
    assert pickle.loads(pickle.dumps(objective))([34.0]) == objective([34.0])
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(objective, [[33.0], [34.0]])) == [objective([33.0]), objective([34.0])]


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs /proc")
def test_element_tests_leak_no_memory():
    test = triaxial(steps=200)
    for _ in range(200):
        test.run()
    before = resident()
    for _ in range(10_000):
        test.run()
    assert resident() - before <= 1_000_000


def test_strains_count_from_the_beginning_of_the_last_stage():
    pytest.importorskip("scipy")
    consolidated = cl.ElementTest({
        "title": "triaxial after consolidation", "material": SAND, "initial_stress": [-1e4] * 3 + [0, 0, 0],
        "stages": [
            {"path": {"kind": "isotropic", "pressure": 1e5}},
            {"path": {"kind": "triaxial-drained", "axial_compression": 0.03}, "steps": 60},
        ],
    })
    # Data of a test that begins at the cell pressure.
    data = data_of(triaxial(), "q")
    free = {"friction_angle": (25, 40), "youngs_modulus": (5e6, 1e8)}
    found = cl.calibrate(consolidated, data, free, {"q": 2e3})
    assert found.values["friction_angle"] == pytest.approx(33.0, abs=0.05)
    assert found.values["youngs_modulus"] == pytest.approx(2e7, rel=0.01)


def test_bounds_over_decades_are_searched_by_logarithms():
    pytest.importorskip("scipy")
    data = data_of(triaxial(), "q")
    found = cl.calibrate(triaxial(), data, {"friction_angle": (25, 45), "youngs_modulus": (1e6, 1e9)}, 4e3)
    assert found.values["friction_angle"] == pytest.approx(33.0, abs=0.01)
    assert found.values["youngs_modulus"] == pytest.approx(2e7, rel=1e-3)


def test_data_beyond_the_test_are_refused():
    data = data_of(triaxial(), "q")
    percent = {"axial_compression": 100 * np.array(data["axial_compression"]), "q": data["q"]}
    with pytest.raises(ValueError, match="computed from 0 to 0.03"):
        cl.objective(triaxial(), percent, {"friction_angle": (25, 40)}, {"q": 2e3})
    with pytest.raises(ValueError, match="no numbers"):
        cl.objective(triaxial(), {"axial_compression": [0, "x"], "q": [0, 1]}, {"friction_angle": (25, 40)}, {"q": 2e3})


def test_a_poor_fit_is_named():
    pytest.importorskip("scipy")
    data = data_of(triaxial(), "q")
    in_kilopascals = {"axial_compression": data["axial_compression"], "q": np.array(data["q"]) / 1e3}
    with pytest.warns(cl.ColluviumWarning, match="misfit") as found:
        cl.calibrate(triaxial(), in_kilopascals, {"friction_angle": (25, 40)}, {"q": 100.0})
    assert "poor-fit" in {one.message.code for one in found}
    assert {one.filename for one in found if isinstance(one.message, cl.ColluviumWarning)} == {__file__}


def test_parameters_without_effect_keep_their_start():
    pytest.importorskip("scipy")
    free = {"friction_angle": (25, 40), "density": (1500, 2500)}
    with pytest.warns(cl.ColluviumWarning):
        found = cl.calibrate(triaxial(), data_of(triaxial(), "q"), free, 2e3, start={"density": 1800})
    assert found.values["density"] == pytest.approx(1800)
