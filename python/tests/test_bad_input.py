"""Bad input: each is refused with its path, and nothing panics."""

import json
import math

import colluvium as cl
import numpy as np
import pytest


def places(value, path=""):
    """Paths of all values of a document."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from places(inner, f"{path}[{number}]")
    if path:
        yield path


WRONG = [None, True, "text", 3, -1e300, [], {}, [[]], {"kind": "nothing"}, math.nan, 10**40, b"bytes", object()]


@pytest.mark.parametrize("name", ["column-collapse", "debris-flow"])
def test_wrong_types_at_every_level_are_case_errors_or_accepted(name):
    case = cl.Case.template(name)
    refused = 0
    for path in places(case.to_dict()):
        for wrong in WRONG:
            changed = case.copy()
            try:
                changed[path] = wrong
            except cl.CaseError as error:
                refused += 1
                assert error.problems and all(isinstance(text, str) and text for _, text in error.problems)
                assert changed == case
    assert refused > 500


@pytest.mark.parametrize(
    "source", ["{", "{}", '{"title": 1', '{"title": "a", "title": "b"}', '{"space": NaN}', "[1, 2]", "{" + '"a":{' * 2000]
)
def test_texts_that_are_no_case_are_refused(source, tmp_path):
    file = tmp_path / "case.json"
    file.write_text(source)
    with pytest.raises(cl.CaseError):
        cl.Case(file)


def test_other_sources_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError):
        cl.Case(tmp_path / "none.json")
    for source in (3, None, ["a"], np.zeros(3)):
        with pytest.raises(TypeError):
            cl.Case(source)
    with pytest.raises(cl.CaseError, match="no text"):
        cl.Case({1: 2})
    with pytest.raises(ValueError, match="did you mean 'column-collapse'"):
        cl.Case.template("column-colapse")
    # An element test or a template of another kind is no case.
    with pytest.raises(cl.CaseError):
        cl.Case({"title": "t", "material": {}, "stages": []})


def test_lists_that_contain_themselves_are_refused(column):
    values = column.to_dict()
    values["gravity"] = values
    with pytest.raises(cl.CaseError, match="contains itself"):
        cl.Case(values)
    circle = []
    circle.append(circle)
    with pytest.raises(cl.CaseError, match="contains itself"):
        column["gravity"] = circle


@pytest.mark.parametrize("path", ["", ".", "a..b", "bodies[", "bodies[x]", "bodies[-1]", "[0]", "bodies.0", "gravity.x"])
def test_wrong_paths_are_key_errors(path, column):
    with pytest.raises(KeyError):
        column[path]
    with pytest.raises(KeyError):
        column[path] = 1


def test_methods_that_do_not_exist_are_named(column):
    with pytest.raises(ValueError, match="fem"):
        cl.run(column, "fem")
    with pytest.raises(ValueError, match="fem"):
        column.plan("fem")
    with pytest.raises(cl.CaseError, match="dem"):
        cl.run(column, "dem")


def test_errors_can_be_sent_to_other_processes():
    import pickle

    error = cl.CaseError([("a.b", "is wrong")])
    assert pickle.loads(pickle.dumps(error)).problems == error.problems
    warning = pickle.loads(pickle.dumps(cl.ColluviumWarning("code", "text")))
    assert (warning.code, warning.text, str(warning)) == ("code", "text", "[code] text")


def test_cases_are_json_of_the_command(column, tmp_path):
    assert json.loads(column.to_json()) == column.to_dict() and cl.Case(column.to_json()) == column
    (tmp_path / "case.json").write_text(column.to_json(indent=2))
    assert cl.Case(tmp_path / "case.json").to_dict() == column.to_dict()
