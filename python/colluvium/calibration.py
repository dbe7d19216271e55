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
#: Columns that count from the beginning of the stage of the data.
_FROM_BEGINNING = {
    *(f"strain_{pair}" for pair in ("xx", "yy", "zz", "xy", "yz", "zx")),
    "time", "volumetric_strain", "axial_compression", "work", "dissipated_work", "excess_pore_pressure",
}
#: Misfit above which the law does not follow the data.
_POOR_MISFIT = 3.0
#: Correlation above which only a combination of two parameters is determined.
_LARGEST_CORRELATION = 0.95
#: Ratio of bounds above which a parameter is searched by its logarithm.
_LOGARITHMIC_RATIO = 10.0
#: Share of its bounds above which the standard deviation of a parameter says that the data do not hold it.
_LARGEST_DEVIATION = 0.25


def _numbers(data: Any, name: str, test: str) -> np.ndarray:
    """Numbers of a column."""
    try:
        values = np.asarray(data[name], dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"data of {test!r}: {name!r} has entries that are no numbers: {error}") from None
    if values.ndim != 1 or not len(values):
        raise ValueError(f"data of {test!r}: {name!r} is no list of numbers")
    return values


def _curves(data: Any, test: str) -> tuple[str, np.ndarray, dict[str, np.ndarray]]:
    """Name and values of the first column of a table, and the other columns; NaN where a curve has no value."""
    if not hasattr(data, "__iter__") or not hasattr(data, "__getitem__"):
        raise TypeError(f"data of {test!r} are a DataFrame or a dictionary of lists, not {type(data).__name__}")
    names = [str(name) for name in data]
    if len(names) < 2:
        raise ValueError(f"data of {test!r}: need a column for the abscissa and at least one curve, in this order")
    columns = {name: _numbers(data, name, test) for name in names}
    abscissa = columns.pop(names[0])
    for name, values in columns.items():
        if values.shape != abscissa.shape:
            raise ValueError(f"data of {test!r}: {name!r} and {names[0]!r} do not have the same length")
        if not np.isfinite(values).any():
            raise ValueError(f"data of {test!r}: {name!r} has no number")
        if np.isinf(values).any():
            raise ValueError(f"data of {test!r}: {name!r} has values that are not finite")
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
        for name, bounds in free.items():
            try:
                low, high = (float(bound) for bound in bounds)
            except (TypeError, ValueError):
                raise ValueError(f"free[{name!r}]: {bounds!r} are not two bounds") from None
            if not (math.isfinite(low) and math.isfinite(high) and low < high):
                raise ValueError(f"free[{name!r}]: {low} and {high} are not bounds, the lower one first")
            self.bounds.append((low, high))
        self._tests: dict[str, ElementTest] = dict(tests)
        self._data = {name: _curves(data[name], name) for name in tests}
        self._tolerances = dict(tolerances)
        middle = [0.5 * (low + high) for low, high in self.bounds]
        for name, (over, abscissa, curves) in self._data.items():
            known = self.path(name, middle)
            for column in [over, *curves]:
                if column not in known:
                    raise ValueError(f"data of {name!r}: {column!r} is not a column of a path; there are {', '.join(known)}")
            reached = self._stage(name, middle)[over]
            low, high = min(reached.min(), 0.0), max(reached.max(), 0.0)
            margin = 1e-6 * (high - low)
            outside = (abscissa < low - margin) | (abscissa > high + margin)
            # A test that fails on its way says nothing about its range.
            if outside.any() and self._tests[name].with_values(self._changes(middle)).trace()[1] is None:
                row = int(np.argmax(outside))
                raise ValueError(
                    f"data of {name!r}: row {row} has {over} = {abscissa[row]:g}, but the test is computed from {low:g} to {high:g}: "
                    "make its last stage longer, or check the unit"
                )
            for column in curves:
                if not self._tolerances.get(column, 0.0) > 0.0:
                    raise ValueError(f"tolerances[{column!r}]: give the positive deviation that you accept, in the unit of the column")

    def values(self, x: Sequence[float] | np.ndarray) -> dict[str, float]:
        """Parameters by name."""
        if len(x) != len(self.names):
            raise ValueError(f"{len(x)} values for the parameters {', '.join(self.names)}")
        return {name: float(value) for name, value in zip(self.names, x)}

    def _changes(self, x: Sequence[float] | np.ndarray) -> dict[str, float]:
        return {f"material.{name}": value for name, value in self.values(x).items()}

    def _stage(self, test: str, x: Sequence[float] | np.ndarray) -> dict[str, np.ndarray]:
        """Columns of the last stage of a test. Strains, work, excess pore pressure and time count from its beginning."""
        path = self.path(test, x)
        if not path.stages:
            return dict(path)
        stage = path.stage()
        columns = {name: stage[name] - stage[name][0] if name in _FROM_BEGINNING else stage[name] for name in stage}
        normal = np.array([columns[f"strain_{pair}"] for pair in ("xx", "yy", "zz")])
        shear = np.array([columns[f"strain_{pair}"] for pair in ("xy", "yz", "zx")])
        deviator = normal - normal.mean(axis=0)
        columns["deviatoric_strain"] = np.sqrt(2 / 3 * (np.sum(deviator**2, axis=0) + 2 * np.sum(shear**2, axis=0)))
        return columns

    def path(self, test: str, x: Sequence[float] | np.ndarray) -> ElementPath:
        """Path of a test up to its end or its first failure."""
        if test not in self._tests:
            raise KeyError(f"{test!r} is not a test; there are {', '.join(self._tests)}")
        path, error = self._tests[test]._with_values(self._changes(x)).trace()
        if error is not None and (not isinstance(error, SolverError) or error.__cause__ is not None):
            # An exception of a law in Python is a mistake of the law, not a test that does not come so far.
            raise error
        return path

    def residuals(self, x: Sequence[float] | np.ndarray) -> np.ndarray:
        """Differences of computed and measured values over the tolerances; a large value where a test does not come so far."""
        found = []
        for name, (over, abscissa, curves) in self._data.items():
            path = self._stage(name, x)
            reached = path[over]
            order = np.argsort(reached, kind="stable")
            inside = (abscissa >= reached.min() - 1e-9) & (abscissa <= reached.max() + 1e-9)
            for column, measured in curves.items():
                computed = np.interp(abscissa, reached[order], path[column][order])
                residual = np.where(inside, (computed - measured) / self._tolerances[column], _FAILED_RESIDUAL)
                found.append(residual[np.isfinite(measured)])
        return np.concatenate(found)

    def __call__(self, x: Sequence[float] | np.ndarray) -> float:
        """Half the sum of the squared residuals; infinite outside the bounds and for parameters that the law refuses."""
        self.values(x)
        if any(not low <= value <= high for value, (low, high) in zip(x, self.bounds)):
            return math.inf
        try:
            return 0.5 * float(np.sum(self.residuals(x) ** 2))
        except CaseError:
            return math.inf

    def log_likelihood(self, x: Sequence[float] | np.ndarray) -> float:
        """Logarithm of the likelihood for independent errors of the size of the tolerances, without its constant."""
        return -self(x)


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.6g} ± {self.deviations[name]:.2g}" for name, value in self.values.items())
        return f"Calibration({values}, misfit={self.misfit:.3g})"

    @property
    def table(self) -> pandas.DataFrame:
        """Values, standard deviations and bounds. Needs the extra ``pandas``."""
        rows = [(self.values[name], self.deviations[name], *bounds) for name, bounds in zip(self.names, self.objective.bounds)]
        return extra("pandas").DataFrame(rows, index=self.names, columns=["value", "deviation", "lowest", "highest"])


def objective(
    tests: Mapping[str, ElementTest] | ElementTest,
    data: Mapping[str, Any],
    free: Mapping[str, tuple[float, float]],
    tolerances: Mapping[str, float] | float,
) -> Objective:
    """Misfit of tests as a function of the free parameters, for an optimiser of your own. Arguments are those of `calibrate`."""
    if isinstance(tests, ElementTest):
        tests, data = {"test": tests}, {"test": data}
    if isinstance(tolerances, (int, float)):
        names = {str(name) for table in data.values() for name in list(table)[1:]}
        if len(names) != 1:
            raise ValueError(f"tolerances: give one for each of the curves {', '.join(sorted(names))}")
        tolerances = {names.pop(): float(tolerances)}
    return Objective(tests, data, free, tolerances)


def calibrate(
    tests: Mapping[str, ElementTest] | ElementTest,
    data: Mapping[str, Any],
    free: Mapping[str, tuple[float, float]],
    tolerances: Mapping[str, float] | float,
    *,
    start: Mapping[str, float] | None = None,
    starts: int = 3,
    seed: int = 1,
) -> Calibration:
    """Finds the material parameters with which tests agree best with data. Needs the extra ``scipy``.

    ``tests`` are element tests by name, or one test. ``data`` has a table for each, a DataFrame or a dictionary of lists. Its first column is
    the abscissa, such as ``axial_compression``; the others are curves, such as ``q``: columns of the path of the test's last stage. Strains,
    work, excess pore pressure and time count from the beginning of that stage. ``free`` has the bounds of each parameter of the material, by
    its name; one whose bounds differ by a factor of ten or more is searched by its logarithm. ``tolerances`` has the accepted deviation of
    each curve, in its unit; residuals are scaled by it.

    Least squares continue from ``start``, by default the middle of the bounds, and from the best ``starts - 1`` of 16 Sobol points per
    parameter. A ``ColluviumWarning`` names parameters that the data do not hold, that are at a bound or correlated, other minima, and a poor
    fit.
    """
    optimize, qmc = extra("scipy.optimize", "scipy"), extra("scipy.stats", "scipy").qmc
    if starts < 1:
        raise ValueError(f"starts: {starts} is less than 1")
    problem = objective(tests, data, free, tolerances)
    scale = _Scale(problem.bounds)
    first = _start(problem, scale, dict(start or {}))
    places = [first]
    if starts > 1:
        count = len(problem.names)
        samples = qmc.Sobol(count, seed=seed).random_base2(math.ceil(math.log2(16 * count)))
        samples = samples[np.argsort([problem(scale.values(sample)) for sample in samples], kind="stable")]
        places += list(samples[: starts - 1])

    # Parameters between 1 and 2, so that steps of the differences are relative to the bounds.
    def residuals(scaled: np.ndarray) -> np.ndarray:
        return problem.residuals(scale.values(np.clip(scaled - 1.0, 0.0, 1.0)))

    solutions = []
    for place in places:
        scaled = 1.0 + np.clip(place, 1e-3, 1.0 - 1e-3)
        options = {"diff_step": 1e-4, "xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-12}
        solutions.append(optimize.least_squares(residuals, scaled, bounds=(1.0, 2.0), **options))
    best = min(solutions, key=lambda found: found.cost)
    evaluations = sum(found.nfev for found in solutions)
    result = _calibration(problem, scale, best, first, evaluations)
    others = [found for found in solutions if found.cost < 1.1 * best.cost + 1e-6 and np.abs(found.x - best.x).max() > 0.1]
    _warn_of(result, scale.values(others[0].x - 1.0) if others and not result.undetermined else None)
    return result


class _Scale:
    """Shares of the bounds of parameters, along logarithms where the bounds differ much."""

    def __init__(self, bounds: Sequence[tuple[float, float]]) -> None:
        self.low, self.high = np.array(bounds).T
        self._is_logarithmic = (self.low > 0) & (self.high >= _LOGARITHMIC_RATIO * np.maximum(self.low, 1e-300))

    def values(self, share: np.ndarray) -> np.ndarray:
        """Values at shares of the bounds."""
        low = np.where(self._is_logarithmic, self.low, 1.0)
        linear = self.low + share * (self.high - self.low)
        return np.where(self._is_logarithmic, low * (np.abs(self.high) / low) ** share, linear)

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Shares of the bounds at values."""
        low = np.where(self._is_logarithmic, self.low, 1.0)
        ratio = np.where(self._is_logarithmic, np.abs(values) / low, 1.0)
        logarithmic = np.log(ratio) / np.log(np.where(self._is_logarithmic, self.high / low, 2.0))
        return np.where(self._is_logarithmic, logarithmic, (values - self.low) / (self.high - self.low))

    def slopes(self, share: np.ndarray) -> np.ndarray:
        """Change of the values with their shares."""
        low = np.where(self._is_logarithmic, self.low, 1.0)
        growth = np.log(np.where(self._is_logarithmic, self.high / low, 2.0))
        return np.where(self._is_logarithmic, self.values(share) * growth, self.high - self.low)


def _start(problem: Objective, scale: _Scale, start: dict[str, float]) -> np.ndarray:
    """Shares of the bounds at which the search begins."""
    for name, value in start.items():
        if name not in problem.names:
            raise ValueError(f"start[{name!r}] is not a free parameter; there are {', '.join(problem.names)}")
        low, high = problem.bounds[problem.names.index(name)]
        if not isinstance(value, (int, float)) or not low <= value <= high:
            raise ValueError(f"start[{name!r}]: {value} is outside the bounds {low} and {high}")
    middle = scale.values(np.full(len(problem.names), 0.5))
    return scale.shares(np.array([start.get(name, value) for name, value in zip(problem.names, middle)]))


def _calibration(problem: Objective, scale: _Scale, found: Any, first: np.ndarray, evaluations: int) -> Calibration:
    """Result with the uncertainties of its parameters."""
    _, singular, directions = np.linalg.svd(found.jac, full_matrices=False)
    freedom = max(len(found.fun) - len(singular), 1)
    scatter = max(float(np.sum(found.fun**2)) / freedom, 1.0)
    # Directions without effect have a large variance, not the small one of a pseudo-inverse.
    floor = max(1e-6 * singular[0], 1e-12)
    covariance = (directions.T * (scatter / np.maximum(singular, floor) ** 2)) @ directions
    deviations = np.sqrt(np.diag(covariance))
    correlations = np.clip(covariance / np.outer(deviations, deviations), -1.0, 1.0)
    share, fun, names = found.x - 1.0, found.fun, problem.names
    undetermined = [name for name, deviation in zip(names, deviations) if deviation > _LARGEST_DEVIATION]
    for name in undetermined:
        # The start value is kept where it fits equally well.
        kept = share.copy()
        kept[names.index(name)] = first[names.index(name)]
        residuals = problem.residuals(scale.values(kept))
        if np.sum(residuals**2) <= np.sum(fun**2) * (1 + 1e-6) + 1e-9:
            share, fun = kept, residuals
    slopes = scale.slopes(share)
    return Calibration(
        names=names,
        values=problem.values([float(value) for value in scale.values(share)]),
        deviations=dict(zip(names, (deviations * slopes).tolist())),
        covariance=covariance * np.outer(slopes, slopes),
        correlations=correlations,
        residuals=fun,
        misfit=float(np.sqrt(np.mean(fun**2))),
        evaluations=evaluations,
        undetermined=undetermined,
        objective=problem,
    )


def _warn_of(result: Calibration, other: np.ndarray | None) -> None:
    """Warns of a result that the data do not determine, or with which the law does not follow them."""

    def issue(code: str, text: str) -> None:
        warnings.warn(ColluviumWarning(code, text), stacklevel=4)

    names = result.names
    for name in result.undetermined:
        text = "the data do not hold it (its standard deviation is more than a quarter of its bounds): add a test that depends on it, or fix it"
        issue("undetermined-parameter", f"{name}: {text}")
    for number, name in enumerate(names):
        low, high = result.objective.bounds[number]
        value = result.values[name]
        if min(value - low, high - value) < 1e-3 * (high - low) and name not in result.undetermined:
            issue("parameter-at-end", f"{name}: {value:.4g} is at a bound: widen the bounds if values beyond it are possible")
        for before in range(number):
            correlation = result.correlations[before, number]
            if abs(correlation) > _LARGEST_CORRELATION and not {name, names[before]} & set(result.undetermined):
                text = f"{names[before]} and {name}: correlation {correlation:.2f}: the data hold a combination of them: add another test"
                issue("correlated-parameters", text)
    if other is not None:
        values = ", ".join(f"{name} = {value:.4g}" for name, value in zip(names, other))
        issue("several-minima", f"the data agree about as well with {values}: add another test")
    if result.misfit > _POOR_MISFIT:
        text = f"the misfit is {result.misfit:.3g} tolerances: compare the curves; choose another law, larger tolerances, or check the units"
        issue("poor-fit", text)
