"""Material laws in Python."""

import colluvium as cl
import numpy as np
import pytest
from conftest import short_case

ONES = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


@cl.law("python-elastic")
class Elastic:
    state = {"stored_work": 0.0}

    def __init__(self, youngs_modulus, poissons_ratio):
        self.bulk = youngs_modulus / (3 * (1 - 2 * poissons_ratio))
        self.shear = youngs_modulus / (2 * (1 + poissons_ratio))

    def wave_modulus(self, stress, state):
        return self.bulk + 4 / 3 * self.shear

    def update(self, strain, stress, state, dt):
        volumetric = strain[:3].sum()
        new = stress + self.bulk * volumetric * ONES + 2 * self.shear * (strain - volumetric / 3 * ONES)
        mean = 0.5 * (new + stress)
        return new, {"stored_work": state["stored_work"] + mean[:3] @ strain[:3] + 2 * mean[3:] @ strain[3:]}


ELASTIC = {"youngs_modulus": 2e7, "poissons_ratio": 0.3}
OWN = {"model": "external", "law": "python-elastic", "density": 2000, "parameters": ELASTIC}
BUILT_IN = {"model": "linear-elastic", "density": 2000, **ELASTIC}


def oedometer(material):
    path = {"kind": "oedometer", "axial_compression": 0.01}
    return cl.ElementTest({"title": "t", "material": material, "stages": [{"path": path, "steps": 20}]})


def test_a_law_agrees_with_the_same_law_of_the_library():
    own, built_in = oedometer(OWN).run(), oedometer(BUILT_IN).run()
    assert np.allclose(own["stress_zz"], built_in["stress_zz"], rtol=1e-9)
    # The state is a column of the path: the work is that of the driver.
    assert own["stored_work"][-1] == pytest.approx(built_in["work"][-1], rel=1e-6)


def test_a_law_runs_in_a_case_and_resumes(tmp_path):
    case = short_case(steps=20)
    case.update({"materials.sand": BUILT_IN})
    built_in = cl.run(case)
    case.update({"materials.sand": OWN})
    own = cl.run(case, out=tmp_path / "run")
    assert own.steps == built_in.steps
    scale = np.abs(built_in.last.points["stress"]).max()
    assert np.allclose(own.last.points["stress"], built_in.last.points["stress"], atol=1e-9 * scale)
    assert own.last.points["stored_work"].shape == (len(own.last),)


def test_an_exception_ends_the_test_with_its_traceback():
    @cl.law("python-broken")
    class Broken(Elastic):
        def __init__(self):
            super().__init__(**ELASTIC)

        def update(self, strain, stress, state, dt):
            raise ZeroDivisionError("own mistake")

    with pytest.raises(cl.SolverError, match="own mistake") as failed:
        oedometer({"model": "external", "law": "python-broken", "density": 2000}).run()
    assert isinstance(failed.value.__cause__, ZeroDivisionError)
    assert failed.value.__cause__.__traceback__.tb_frame.f_code.co_name == "update"
    assert "exception " not in str(failed.value)


@pytest.mark.parametrize(
    ("returned", "text"),
    [(None, "returns"), ((np.zeros(5), {"stored_work": 0.0}), "six numbers"), ((np.zeros(6), {}), "without"), ((np.full(6, np.nan), {"stored_work": 0.0}), "finite")],
)
def test_wrong_returns_are_named(returned, text):
    @cl.law("python-wrong")
    class Wrong(Elastic):
        def __init__(self):
            super().__init__(**ELASTIC)

        def update(self, strain, stress, state, dt):
            return returned

    with pytest.raises(cl.SolverError, match=text):
        oedometer({"model": "external", "law": "python-wrong", "density": 2000}).run()


def test_wrong_laws_are_refused():
    with pytest.raises(TypeError, match="update"):
        cl.law("python-none")(type("Without", (), {"wave_modulus": lambda self, stress, state: 1.0}))
    with pytest.raises(TypeError, match="no named number"):
        cl.law("python-state")(type("State", (Elastic,), {"state": {"a": "text"}}))
    cl.law("python-name")(type("Name", (Elastic,), {"state": {"work": 0.0}}))
    with pytest.raises(cl.CaseError, match="rename"):
        oedometer(OWN | {"law": "python-name"}).run()
    with pytest.raises(cl.CaseError, match="python-missing"):
        oedometer({"model": "external", "law": "python-missing", "density": 2000})
    with pytest.raises(cl.CaseError, match="youngs_modulus") as wrong:
        oedometer({"model": "external", "law": "python-elastic", "density": 2000, "parameters": {"poissons_ratio": 0.3}}).run()
    assert wrong.value.problems[0][0] == "material.parameters" and isinstance(wrong.value.__cause__, TypeError)
