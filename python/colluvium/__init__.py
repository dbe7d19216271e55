"""Point-based numerical methods for geomechanics.

>>> import colluvium as cl
>>> case = cl.Case.template("column-collapse")
>>> case["stages[0].duration"] = 0.01
>>> run = cl.run(case, method="mpm", progress=False)
>>> run.frames[-1].points["velocity"].shape[1]
3
"""

from __future__ import annotations

from typing import Any

from ._machine import check_processor

check_processor()

from ._native import __version__  # noqa: E402

#: Module of each name. Modules are imported when a name of theirs is asked for, so that the command starts without NumPy.
_MODULES = {
    "Calibration": "calibration",
    "Case": "case",
    "CaseError": "errors",
    "ColluviumWarning": "errors",
    "Comparison": "studies",
    "Dataset": "results",
    "ElementPath": "element_tests",
    "ElementTest": "element_tests",
    "Frame": "results",
    "Objective": "calibration",
    "OutputError": "errors",
    "Points": "results",
    "RunResult": "results",
    "Safety": "results",
    "SolverError": "errors",
    "Sweep": "studies",
    "calibrate": "calibration",
    "compare": "studies",
    "frames": "running",
    "law": "laws",
    "map": "rasters",
    "methods": "case",
    "objective": "calibration",
    "open_run": "results",
    "raster_outline": "rasters",
    "read_raster": "rasters",
    "report": "studies",
    "run": "running",
    "safety": "running",
    "schema": "case",
    "sweep": "studies",
    "templates": "case",
    "write_raster": "rasters",
}

__all__ = ["__version__", *sorted(_MODULES)]


def __getattr__(name: str) -> Any:
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module 'colluvium' has no attribute {name!r}")
    from importlib import import_module

    # Inside its module the name would hide the function of the language.
    value = getattr(import_module(f".{module}", __name__), "draw_map" if name == "map" else name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
