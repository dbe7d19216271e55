"""Cases and options of the tests."""

from __future__ import annotations

import os

import colluvium as cl
import pytest

os.environ.setdefault("MPLBACKEND", "Agg")


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run whole templates instead of 50 steps")


@pytest.fixture
def is_long(request):
    return request.config.getoption("--long")


def short_case(name: str = "column-collapse", steps: int = 50) -> cl.Case:
    """A template whose stages have together about so many steps, with three frames."""
    case = cl.Case.template(name)
    values = case.to_dict()
    count = len(values["stages"])
    method = next(iter(values["methods"]))
    duration = case.plan(method)["time_step"] * steps / count
    for stage in values["stages"]:
        stage["duration"] = duration
        stage.pop("equilibrium", None)
        if "gravity_ramp" in stage:
            stage["gravity_ramp"] = duration
    values["measures"] = {
        name: measure for name, measure in values.get("measures", {}).items() if measure["kind"] != "factor-of-safety"
    }
    values.setdefault("output", {})["frames"] = duration * count / 2
    values["output"].pop("measures", None)
    short = case.copy()
    short._value = values
    short.check()
    return short


@pytest.fixture
def column() -> cl.Case:
    return short_case()
