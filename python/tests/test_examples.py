"""The notebooks of `examples`, run cell by cell."""

import json
import os
import warnings
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"

#: Modules that a notebook needs beside those of the tests.
NEEDS = {"exceedance": ["geopandas", "matplotlib"], "first-run": ["matplotlib"], "calibration": ["matplotlib", "scipy"], "law": []}

os.environ.setdefault("MPLBACKEND", "Agg")


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.ipynb")))
def test_a_notebook_runs(name, tmp_path, monkeypatch):
    for module in ["pandas", *NEEDS[name]]:
        pytest.importorskip(module)
    monkeypatch.chdir(tmp_path)
    document = json.loads((EXAMPLES / f"{name}.ipynb").read_text(encoding="utf-8"))
    space = {"__name__": "__main__"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number, cell in enumerate(document["cells"]):
            if cell["cell_type"] == "code":
                assert not cell["outputs"], "notebooks are kept without their outputs"
                exec(compile("".join(cell["source"]), f"{name}.ipynb[{number}]", "exec"), space)


def test_the_exceedance_takes_thirty_lines():
    document = json.loads((EXAMPLES / "exceedance.ipynb").read_text(encoding="utf-8"))
    lines = [line for cell in document["cells"] if cell["cell_type"] == "code" for line in cell["source"] if line.strip()]
    assert len(lines) <= 30
