"""Calibration: parameters of a material from laboratory tests."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ._extras import extra
from .element_tests import ElementPath, ElementTest
from .errors import CaseError, ColluviumWarning, SolverError

if TYPE_CHECKING:
    import pandas

#: Residual (tolerances) of a value that a test did not reach.
_FAILED_RESIDUAL = 1e3
#: Share of its bounds above which the standard deviation of a parameter says that the data do not hold it.
_LARGEST_DEVIATION = 0.25


def _curves(data: Any, test: str) -> tuple[str, np.ndarray, dict[str, np.ndarray]]:
    """Name and values of the first column of a table, and the other columns."""
    names = [str(name) for name in data]
    if len(names) < 2:
        raise ValueError(f"data of {test!r}: need a column for the abscissa and at least one curve, in this order")
    columns = {name: np.asarray(data[name], dtype=float) for name in names}
    abscissa = columns.pop(names[0])
    for name, values in columns.items():
        if values.shape != abscissa.shape or values.ndim != 1:
            raise ValueError(f"data of {test!r}: {name!r} and {names[0]!r} do not have the same length")
    if not np.isfinite(abscissa).all():
        raise ValueError(f"data of {test!r}: {names[0]!r} has values that are not finite")
    return names[0], abscissa, columns


class Objective:
    """Misfit of laboratory tests as a function of material parameters: half the sum of squared residuals.

    It can be sent to other processes. ``bounds`` has the lowest and the highest value of each parameter, in the order of ``names``.
    """

    def __init__(
        self,
        tests: Mapping[str, ElementTest],
        data: Mapping[str, Any],
        free: Mapping[str, tuple[float, float]],
        tolerances: Mapping[str, float],
    ) -> None:
        if set(tests) != set(data):
            raise ValueError(f"tests ({', '.join(tests)}) and data ({', '.join(data)}) have different names")
        if not tests or not free:
            raise ValueError("a calibration needs at least one test and one free parameter")
        self.names: list[str] = list(free)
        self.bounds: list[tuple[float, float]] = []
        for name, (low, high) in free.items():
            if not (math.isfinite(low) and math.isfinite(high) and low < high):
                raise ValueError(f"free[{name!r}]: {low} and {high} are not bounds, the lower one first")
            self.bounds.append((float(low), float(high)))
        self._tests: dict[str, ElementTest] = dict(tests)
        self._data = {name: _curves(data[name], name) for name in tests}
        self._tolerances = dict(tolerances)
        for name, (over, _, curves) in self._data.items():
            known = self.path(name, [low for low, _ in self.bounds])
            for column in [over, *curves]:
                if column not in known:
                    raise ValueError(f"data of {name!r}: {column!r} is not a column of a path; there are {', '.join(known)}")
            for column in curves:
                if not self._tolerances.get(column, 0.0) > 0.0:
                    raise ValueError(f"tolerances[{column!r}]: give the positive deviation that you accept, in the unit of the column")

    def values(self, x: Sequence[float]) -> dict[str, float]:
        """Parameters by name."""
        if len(x) != len(self.names):
            raise ValueError(f"{len(x)} values for the parameters {', '.join(self.names)}")
        return {name: float(value) for name, value in zip(self.names, x)}

    def path(self, test: str, x: Sequence[float]) -> ElementPath:
        """Path of a test up to its end or its first failure."""
        changes = {f"material.{name}": value for name, value in self.values(x).items()}
        path, error = self._tests[test].with_values(changes).trace()
        if error is not None and not isinstance(error, SolverError):
            raise error
        return path

    def residuals(self, x: Sequence[float]) -> np.ndarray:
        """Differences of computed and measured values over the tolerances; a large value where a test does not come so far."""
        found = []
        for name, (over, abscissa, curves) in self._data.items():
            path = self.path(name, x).stage()
            reached = path[over]
            order = np.argsort(reached, kind="stable")
            inside = (abscissa >= reached.min() - 1e-9) & (abscissa <= reached.max() + 1e-9)
            for column, measured in curves.items():
                computed = np.interp(abscissa, reached[order], path[column][order])
                residual = np.where(inside, (computed - measured) / self._tolerances[column], _FAILED_RESIDUAL)
                found.append(residual[np.isfinite(measured)])
        return np.concatenate(found)

    def __call__(self, x: Sequence[float]) -> float:
        """Half the sum of the squared residuals; infinite outside the bounds and for parameters that the law refuses."""
        if any(not low <= value <= high for value, (low, high) in zip(x, self.bounds)):
            return math.inf
        try:
            return 0.5 * float(np.sum(self.residuals(x) ** 2))
        except CaseError:
            return math.inf

    def log_likelihood(self, x: Sequence[float]) -> float:
        """Logarithm of the likelihood for independent errors of the size of the tolerances, without its constant."""
        return -self(x)


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    ``values`` has the parameters, ``deviations`` their standard deviations, ``covariance`` and ``correlations`` their matrices in the order
    of ``names``: s² (JᵀJ)⁻¹ with s² = max(1, Σr²/(n - m)) for n data and m parameters. ``residuals`` has the differences over the
    tolerances, ``misfit`` their root mean square, ``undetermined`` the parameters that the data do not hold.
    """

    names: list[str]
    values: dict[str, float]
    deviations: dict[str, float]
    covariance: np.ndarray
    correlations: np.ndarray
    residuals: np.ndarray
    misfit: float
    evaluations: int
    undetermined: list[str]
    objective: Objective

    def path(self, test: str) -> ElementPath:
        """Path of a test with the calibrated values."""
        return self.objective.path(test, [self.values[name] for name in self.names])

    @property
    def table(self) -> pandas.DataFrame:
        """Values, standard deviations and bounds. Needs the extra ``pandas``."""
        rows = [(self.values[name], self.deviations[name], *bounds) for name, bounds in zip(self.names, self.objective.bounds)]
        return extra("pandas").DataFrame(rows, index=self.names, columns=["value", "deviation", "lowest", "highest"])


def objective(
    tests: Mapping[str, ElementTest] | ElementTest,
    data: Mapping[str, Any],
    free: Mapping[str, tuple[float, float]],
    tolerances: Mapping[str, float],
) -> Objective:
    """Misfit of tests as a function of the free parameters, for an optimiser of your own. Arguments are those of `calibrate`."""
    if isinstance(tests, ElementTest):
        tests, data = {"test": tests}, {"test": data}
    return Objective(tests, data, free, tolerances)


def calibrate(
    tests: Mapping[str, ElementTest] | ElementTest,
    data: Mapping[str, Any],
    free: Mapping[str, tuple[float, float]],
    tolerances: Mapping[str, float],
    *,
    start: Mapping[str, float] | None = None,
    starts: int = 1,
    seed: int = 1,
) -> Calibration:
    """Finds the material parameters with which tests agree best with data. Needs the extra ``scipy``.

    ``tests`` are element tests by name, or one test. ``data`` has a table for each, a DataFrame or a dictionary of lists. Its first column is
    the abscissa, such as ``axial_compression``; the others are curves, such as ``q``: columns of the path of the test's last stage. ``free`` has the bounds of each parameter of the material, by its name. ``tolerances`` has the accepted deviation of each curve,
    in its unit; residuals are scaled by it. The search begins at ``start``, by default in the middle of the bounds, and at ``starts - 1``
    other places.

    A ``ColluviumWarning`` names parameters that the data do not hold.
    """
    optimize = extra("scipy.optimize", "scipy")
    problem = objective(tests, data, free, tolerances)
    low, high = np.array(problem.bounds).T
    places = [np.array([dict(start or {}).get(name, middle) for name, middle in zip(problem.names, 0.5 * (low + high))])]
    for name in start or {}:
        if name not in problem.names:
            raise ValueError(f"start[{name!r}] is not a free parameter")
    if (places[0] < low).any() or (places[0] > high).any():
        raise ValueError("start is outside the bounds")
    random = np.random.default_rng(seed)
    places += [low + (high - low) * random.random(len(low)) for _ in range(starts - 1)]

    # Parameters between 1 and 2, so that steps of the differences are relative to the bounds.
    def residuals(scaled: np.ndarray) -> np.ndarray:
        return problem.residuals(low + (high - low) * (np.clip(scaled, 1.0, 2.0) - 1.0))

    best, evaluations = None, 0
    for place in places:
        scaled = 1.0 + np.clip((place - low) / (high - low), 1e-3, 1.0 - 1e-3)
        found = optimize.least_squares(residuals, scaled, bounds=(1.0, 2.0), diff_step=1e-4, xtol=1e-10, ftol=1e-12, gtol=1e-12)
        evaluations += found.nfev
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return _calibration(problem, best, evaluations)


def _calibration(problem: Objective, found: Any, evaluations: int) -> Calibration:
    """Result with the uncertainties of its parameters."""
    low, high = np.array(problem.bounds).T
    jacobian = found.jac / (high - low)
    # Directions without effect have an infinite variance, not the small one of a pseudo-inverse.
    _, singular, directions = np.linalg.svd(jacobian * (high - low), full_matrices=False)
    freedom = max(len(found.fun) - len(singular), 1)
    scatter = max(float(np.sum(found.fun**2)) / freedom, 1.0)
    variances = scatter / np.maximum(singular, 1e-6 * max(singular[0], 1e-300)) ** 2
    covariance = (directions.T * variances) @ directions * np.outer(high - low, high - low)
    deviations = np.sqrt(np.diag(covariance))
    correlations = covariance / np.outer(deviations, deviations)
    x = low + (high - low) * (found.x - 1.0)
    names = problem.names
    undetermined = [name for name, deviation, width in zip(names, deviations, high - low) if deviation > _LARGEST_DEVIATION * width]
    result = Calibration(
        names=names,
        values=problem.values(x),
        deviations=dict(zip(names, deviations.tolist())),
        covariance=covariance,
        correlations=correlations,
        residuals=found.fun,
        misfit=float(np.sqrt(np.mean(found.fun**2))),
        evaluations=evaluations,
        undetermined=undetermined,
        objective=problem,
    )
    for name in undetermined:
        text = (
            f"{name}: the data do not hold it (standard deviation {result.deviations[name]:.3g}, more than a quarter of its bounds): add a "
            "test that depends on it, or fix its value"
        )
        warnings.warn(ColluviumWarning("undetermined-parameter", text), stacklevel=3)
    for name, value, lowest, highest in zip(names, x, low, high):
        if min(value - lowest, highest - value) < 1e-3 * (highest - lowest):
            text = f"{name}: {value:.4g} is at a bound: widen the bounds if the value is possible"
            warnings.warn(ColluviumWarning("parameter-at-end", text), stacklevel=3)
    return result
