"""Writes `docs/python-api.md` from the docstrings of the package.

    python python/write_api_page.py
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import colluvium as cl

PAGE = Path(__file__).parent.parent / "docs" / "python-api.md"

#: Comment before a block of code, for `cargo xtask pages`.
NOT_RUN = "<!-- not run: the tests of python/ run it -->"

#: Sections of the page with their names.
SECTIONS = {
    "Cases and runs": ["Case", "run", "frames", "safety", "templates", "methods", "schema"],
    "Results": ["RunResult", "Frame", "Points", "Dataset", "Safety", "open_run", "report"],
    "Rasters": ["map", "raster_outline", "read_raster", "write_raster"],
    "Studies": ["sweep", "Sweep", "compare", "Comparison"],
    "Element tests and calibration": ["ElementTest", "ElementPath", "calibrate", "objective", "Objective", "Calibration"],
    "Laws": ["law"],
    "Errors": ["CaseError", "SolverError", "OutputError", "ColluviumWarning"],
}


def text(value: object) -> str:
    """Docstring in Markdown."""
    lines = inspect.getdoc(value) or ""
    lines = re.sub(r"``([^`]+)``", r"`\1`", lines)
    # An indented block after a colon pair, or an example of the interpreter, is code.
    lines = re.sub(r"::\n\n((?:    .*\n|\n)+)", lambda found: f":\n\n{NOT_RUN}\n```python\n" + inspect.cleandoc(found.group(1)) + "\n```\n\n", lines + "\n")
    lines = re.sub(r"(?m)^((?:>>> .*\n(?:(?:\.\.\.|[^>\n]).*\n)*)+)", lambda found: f"{NOT_RUN}\n```pycon\n{found.group(1)}```\n", lines)
    parts = re.split(r"(<!-- .*? -->\n```.*?```)", lines, flags=re.S)
    return "".join(part if part.startswith("<!--") else re.sub(r"(?<=\S)\n(?=\S)", " ", part) for part in parts).strip()


def signature(name: str, value: object) -> str:
    """Call of a function without the annotations of its parameters."""
    parameters = inspect.signature(value).parameters.values()  # type: ignore[arg-type]
    shown = [parameter.replace(annotation=inspect.Parameter.empty) for parameter in parameters if parameter.name not in ("self", "cls")]
    return name + str(inspect.Signature(shown))


def of_class(name: str, value: type) -> str:
    """Description of a class with its members."""
    own = not issubclass(value, BaseException) and name not in ("RunResult", "Frame", "Dataset", "Points", "Safety", "Comparison", "Calibration", "Sweep", "ElementPath", "Objective")
    heading = signature(name, value) if own else name
    lines = [f"### `{heading}`", text(value)]
    for key, member in vars(value).items():
        if key.startswith("_") or key == "of_failure" or key == "of_folder":
            continue
        if isinstance(member, property):
            lines.append(f"- `{key}`: {text(member.fget)}")
        elif isinstance(member, (classmethod, staticmethod)) or inspect.isfunction(member):
            bound = getattr(value, key)
            lines.append(f"- `{signature(key, bound)}`: {text(bound)}")
    body = "\n\n".join(lines[:2])
    return body + ("\n\n" + "\n".join(lines[2:]) if lines[2:] else "")


def page() -> str:
    """The page."""
    parts = ["# Python: names of the package", "Made from the docstrings by `python/write_api_page.py`. [From Python](python.md) shows their use."]
    named = [name for names in SECTIONS.values() for name in names]
    assert sorted([*named, "__version__"]) == sorted(cl.__all__), set(named) ^ set(cl.__all__)
    for section, names in SECTIONS.items():
        parts.append(f"## {section}")
        for name in names:
            value = getattr(cl, name)
            parts.append(of_class(name, value) if inspect.isclass(value) else f"### `{signature(name, value)}`\n\n{text(value)}")
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
