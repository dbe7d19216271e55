"""Point-based numerical methods for geomechanics.

>>> import colluvium as cl
>>> case = cl.Case.template("column-collapse")
>>> case["stages[0].duration"] = 0.01
>>> run = cl.run(case)
>>> run.frames[-1].points["velocity"].shape[1]
3
"""

from ._native import __version__
from .case import Case, schema, templates
from .errors import CaseError, ColluviumWarning, OutputError, SolverError
from .results import Frame, Points, RunResult
from .running import run

__all__ = [
    "Case",
    "CaseError",
    "ColluviumWarning",
    "Frame",
    "OutputError",
    "Points",
    "RunResult",
    "SolverError",
    "__version__",
    "run",
    "schema",
    "templates",
]
