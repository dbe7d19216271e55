"""First runs: cases, runs, results."""

import math
import threading
import time

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


def test_measures_are_a_table_with_units():
    pytest.importorskip("pandas")
    table = cl.run(short_column()).measures
    assert table["time"].iloc[-1] == pytest.approx(0.02) and table.attrs["units"]["front"] == "m"


def test_arrays_share_the_memory_of_a_frame_and_outlive_the_run():
    run = cl.run(short_column())
    frame = run.frames[-1]
    first, again = frame.points["velocity"], frame.points["velocity"]
    assert first.ctypes.data == again.ctypes.data and not first.flags.writeable
    kept = first.copy()
    del run, frame
    assert np.array_equal(first, kept)


def test_results_do_not_depend_on_threads():
    one, two = (cl.run(short_column(), threads=count) for count in (1, 2))
    for name in ("position", "velocity", "stress"):
        assert np.array_equal(one.last.points[name], two.last.points[name])


def test_files_resume_and_overwrite(tmp_path):
    out = tmp_path / "run"
    cl.run(short_column(), out=out)
    assert (out / "summary.json").exists()
    with pytest.raises(cl.OutputError) as refused:
        cl.run(short_column(), out=out)
    assert refused.value.path == str(out)
    cl.run(short_column(), out=out, overwrite=True)


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


def test_keys_that_are_no_text_and_cycles_are_refused():
    data = short_column().to_dict()
    data["materials"][3] = {}
    with pytest.raises(cl.CaseError, match="no text"):
        cl.Case(data)
    data = short_column().to_dict()
    data["measures"]["self"] = data
    with pytest.raises(cl.CaseError, match="contains itself"):
        cl.Case(data)


def test_numbers_of_numpy_are_numbers():
    case = short_column()
    case["materials.sand.friction_angle"] = np.float32(34)
    case["gravity"] = np.array([0.0, -9.81])
    assert case["materials.sand.friction_angle"] == 34 and case["gravity"] == [0.0, -9.81]


def test_progress_is_called_and_its_exception_stops_the_run():
    class Stop(Exception):
        pass

    case = cl.Case.template("column-collapse")

    def stop(now: float, end: float, step: int) -> None:
        assert 0 <= now <= end
        raise Stop

    begin = time.monotonic()
    with pytest.raises(Stop):
        cl.run(case, progress=stop)
    assert time.monotonic() - begin < 60


def test_two_runs_in_two_threads():
    found = []

    def work() -> None:
        found.append(cl.run(short_column(), threads=1).last.points["position"].copy())

    threads = [threading.Thread(target=work) for _ in range(2)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 2 and np.array_equal(*found)


def test_what_a_method_does_not_support_is_a_case_error():
    with pytest.raises(cl.CaseError) as refused:
        short_column().plan("dem")
    assert "dem" in str(refused.value)


def test_plan_and_templates():
    plan = short_column().plan()
    assert plan["method"] == "mpm" and plan["points"] > 1000
    assert "column-collapse" in cl.templates() and "properties" in cl.schema()
