"""The pages of the documentation about Python, where the repository is there, and the examples of docstrings."""

import doctest
import importlib
import importlib.util
import pkgutil
import re
import warnings
from pathlib import Path

import colluvium as cl
import pytest

ROOT = Path(__file__).parent.parent.parent


def blocks(page):
    """Python blocks of a page."""
    return re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.S)


def test_the_blocks_of_the_page_run_one_after_another(tmp_path, monkeypatch):
    for module in ("pandas", "matplotlib", "scipy"):
        pytest.importorskip(module)
    monkeypatch.chdir(tmp_path)
    space = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number, block in enumerate(blocks(ROOT / "docs" / "python.md")):
            exec(compile(block, f"python.md[{number}]", "exec"), space)
    assert space["result"].values["friction_angle"] == pytest.approx(33, abs=1.5)


def test_the_page_of_names_is_made_from_the_docstrings():
    spec = importlib.util.spec_from_file_location("write_api_page", ROOT / "python" / "write_api_page.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    written = (ROOT / "docs" / "python-api.md").read_text(encoding="utf-8")
    assert written == module.page(), "run python/write_api_page.py"


@pytest.mark.parametrize("name", [module.name for module in pkgutil.iter_modules(cl.__path__) if module.name not in ("_native", "__main__")])
def test_examples_of_docstrings(name):
    assert doctest.testmod(importlib.import_module(f"colluvium.{name}")).failed == 0


def test_the_example_of_the_package():
    assert doctest.testmod(cl).failed == 0


def test_every_name_has_a_docstring():
    for name in cl.__all__:
        assert name == "__version__" or (getattr(cl, name).__doc__ or "").strip(), name
