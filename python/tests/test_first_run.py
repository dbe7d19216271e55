"""First runs: cases, runs, results."""

import math

import colluvium as cl
import numpy as np
import pytest


def short_column() -> cl.Case:
    case = cl.Case.template("column-collapse")
    case["stages[0].duration"] = 0.02
    case["output.frames"] = 0.01
    return case


def test_ten_lines_from_a_template_to_arrays():
    case = short_column()
    case["materials.sand.friction_angle"] = 34
    run = cl.run(case, method="mpm")
    assert not run.is_interrupted and run.steps > 100
    assert [frame.time for frame in run.frames] == pytest.approx([0.0, 0.01, 0.02])
    points = run.frames[-1].points
    velocity, stress = points["velocity"], points["stress"]
    assert velocity.shape == (len(run.frames[-1]), 3) and stress.shape == (len(velocity), 6)
    assert points.units["velocity"] == "m/s"
    assert np.all(np.diff(points["id"].astype(np.int64)) > 0)
    front = run.columns["front"]
    assert front[-1] > front[0] and math.isclose(run.columns["mass"][0], run.columns["mass"][-1])


def test_paths_read_and_set_values_and_wrong_ones_change_nothing():
    case = short_column()
    assert case["bodies[0].name"] == "column"
    with pytest.raises(cl.CaseError) as wrong:
        case["materials.sand.friction_angle"] = 95
    assert wrong.value.problems[0][0] == "materials.sand.friction_angle"
    assert case["materials.sand.friction_angle"] != 95
    with pytest.raises(KeyError):
        case["materials.clay.density"]
    with pytest.raises(KeyError):
        case["bodies[7].name"]


@pytest.mark.parametrize(
    ("value", "path"),
    [(float("nan"), "gravity[1]"), (float("inf"), "gravity[1]"), (object(), "gravity[1]"), (10**400, "gravity[1]")],
)
def test_values_that_are_no_json_are_refused_with_their_path(value, path):
    data = short_column().to_dict()
    data["gravity"][1] = value
    with pytest.raises(cl.CaseError) as wrong:
        cl.Case(data)
    assert wrong.value.problems[0][0] == path


def test_numbers_of_numpy_are_numbers():
    case = short_column()
    case["materials.sand.friction_angle"] = np.float32(34)
    case["gravity"] = np.array([0.0, -9.81])
    assert case["materials.sand.friction_angle"] == 34 and case["gravity"] == [0.0, -9.81]


def test_plan_and_templates():
    plan = short_column().plan()
    assert plan["method"] == "mpm" and plan["points"] > 1000
    assert "column-collapse" in cl.templates() and "properties" in cl.schema()
