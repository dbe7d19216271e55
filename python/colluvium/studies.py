"""Studies of several runs, and reports."""

from __future__ import annotations

import csv
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._checks import as_folder, as_names, check_count
from ._extras import extra
from .errors import ColluviumWarning, OutputError
from .paths import plain
from .rasters import read_raster
from .results import RunResult, folder_of, open_run
from .running import CaseLike, Progress, ProgressBar, abandon, as_case, messages, warn

if TYPE_CHECKING:
    import pandas
    import xarray


class Sweep:
    """Results of a sweep in its folder. ``failures`` has the reason of each failed run by its number."""

    def __init__(self, folder: Path, rows: Sequence[tuple[str, str | None]]) -> None:
        self.folder = folder
        self.failures: dict[int, str] = {number: reason or "" for number, (status, reason) in enumerate(rows) if status == "failed"}
        self.is_complete: bool = all(status == "completed" for status, _ in rows)

    def __len__(self) -> int:
        return len(self._records()[1])

    def _records(self) -> tuple[list[str], list[list[str]]]:
        with open(self.folder / "runs.csv", encoding="utf-8", newline="") as file:
            lines = [line for line in csv.reader(file) if line and not line[0].startswith("#")]
        return lines[0], lines[1:]

    @property
    def table(self) -> pandas.DataFrame:
        """Parameters, status and measures of each run. Needs the extra ``pandas``."""
        pandas = extra("pandas")
        header, rows = self._records()
        names = [name.split(" (")[0] for name in header]
        table = pandas.DataFrame(rows, columns=names)
        for name in names:
            try:
                table[name] = pandas.to_numeric(table[name].replace("", None))
            except (ValueError, TypeError):
                pass
        table.attrs["units"] = {name: full[len(name) + 2 : -1] if "(" in full else "" for name, full in zip(names, header)}
        return table

    def run(self, number: int) -> RunResult:
        """Run with this number, from zero."""
        count = len(self)
        if not -count <= number < count:
            raise IndexError(f"the sweep has {count} runs")
        return open_run(self.folder / f"run-{number % count + 1:04}")

    @property
    def rasters(self) -> dict[str, xarray.DataArray]:
        """Rasters of exceedance and of intensity classes by name. Needs the extra ``xarray``."""
        found = {file.stem: read_raster(file) for file in sorted(self.folder.glob("rasters/*.tif"))}
        for name, raster in found.items():
            kind, _, rest = name.partition("-")
            if kind == "exceedance":
                quantity, _, threshold = rest.rpartition("-")
                label, _, unit = (_native.raster_label(quantity) or quantity).partition(" (")
                raster.attrs["long_name"] = f"share of runs with {label} of at least {threshold} {unit.rstrip(')')}".strip()
        return found

    def __repr__(self) -> str:
        return f"Sweep({self.folder}, {len(self)} runs, {len(self.failures)} failed)"


def sweep(
    case: CaseLike,
    parameters: Mapping[str, Mapping[str, Any]],
    out: str | os.PathLike[str],
    *,
    plan: Mapping[str, Any] | None = None,
    method: str | None = None,
    title: str = "sweep",
    targets: Mapping[str, Any] | None = None,
    exceedance: Mapping[str, Sequence[float]] | None = None,
    intensities: Sequence[Mapping[str, Any]] = (),
    convergence: Mapping[str, Any] | None = None,
    jobs: int | None = None,
    threads: int = 1,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress = None,
) -> Sweep:
    """Runs a case over values of its parameters, `jobs` runs at a time, and writes tables, pictures and rasters into ``out``.

    ``parameters`` has for each name the path or the list of paths that it sets (``at``), and its ``values`` or its ``range``. ``plan``, ``targets``,
    ``exceedance``, ``intensities`` and ``convergence`` are those of a sweep's file. ``progress`` is as for `run`, in runs.

    Failed runs do not stop the others: a ``ColluviumWarning`` counts them. Ctrl-C leaves checkpoints: continue with ``resume=True``.
    """
    case = as_case(case)
    named = {
        name: {**one, "at": [one["at"]]} if isinstance(one, Mapping) and isinstance(one.get("at"), str) else one
        for name, one in parameters.items()
    }
    value: dict[str, Any] = {"title": title, "case": "case.json", "parameters": named}
    others = {"plan": plan, "targets": targets, "exceedance": exceedance, "intensities": list(intensities), "convergence": convergence}
    value |= {name: other for name, other in others.items() if other}
    text = json.dumps(plain(value, ""), allow_nan=False)
    folder = as_folder(out)
    if jobs is not None:
        check_count(jobs, "jobs")
    check_count(threads, "threads")
    task = _native.Task.sweep(text, case.to_json(), case.folder, method, folder, jobs, threads, resume, overwrite)
    _follow(task, ProgressBar(progress, "runs"))
    result = Sweep(folder, task.result().rows)
    if result.failures:
        number, reason = next(iter(result.failures.items()))
        failed = f"{len(result.failures)} of {len(result)} runs failed; run {number + 1}: {reason}"
        warnings.warn(ColluviumWarning("runs-failed", failed), stacklevel=2)
    return result


def _follow(task: _native.Task, bar: ProgressBar) -> None:
    """Shows the messages of a task, and stops it at an exception."""
    done, end = 0, 0.0
    try:
        for kind, time, _, text, _ in messages(task):
            if kind == "begin":
                end = time
            elif kind == "warning":
                warn(text, 3)
            elif kind == "done":
                done += 1
                bar.show(done, end, done)
    except BaseException:
        abandon(task, bar)
        raise
    bar.close()


@dataclass(frozen=True)
class Comparison:
    """Results of a comparison. ``page`` is its page, ``refusals`` and ``failures`` have reasons by method, ``chosen_options`` those for
    methods without options in the case.
    """

    folder: Path
    page: Path
    completed: list[str]
    refusals: dict[str, str]
    failures: dict[str, str]
    chosen_options: dict[str, str]

    def run(self, method: str) -> RunResult:
        """Run of a method."""
        if method not in self.completed:
            raise KeyError(f"{method!r} has no complete run; there are {', '.join(self.completed)}")
        return open_run(self.folder / method)


def compare(
    case: CaseLike,
    out: str | os.PathLike[str],
    methods: str | Sequence[str] = (),
    *,
    jobs: int = 1,
    threads: int | None = None,
    reference: str | os.PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress = None,
) -> Comparison:
    """Runs a case with several methods, by default all that support it, and writes one page that compares them into ``out``.

    ``reference`` is a CSV file of reference profiles. Failed methods do not stop the others: a ``ColluviumWarning`` names them.
    """
    case = as_case(case)
    folder = as_folder(out)
    check_count(jobs, "jobs")
    path = None if reference is None else Path(reference)
    if path is not None and not path.is_file():
        raise OutputError(f"{path}: no such file of reference profiles", path)
    task = _native.Task.compare(
        case.to_json(), case.folder, as_names(methods), folder, jobs, threads, resume, overwrite, path
    )
    _follow(task, ProgressBar(progress, "methods"))
    data = task.result()
    outcomes = {method: (status, text) for method, status, text, _ in data.methods}
    chosen = {method: options for method, _, _, options in data.methods if options}
    if data.page is None:
        raise KeyboardInterrupt
    result = Comparison(
        folder=folder,
        page=data.page,
        completed=[method for method, (status, _) in outcomes.items() if status == "completed"],
        refusals={method: text for method, (status, text) in outcomes.items() if status == "refused"},
        failures={method: text for method, (status, text) in outcomes.items() if status == "failed"},
        chosen_options={method: options for method, options in chosen.items() if outcomes[method][0] != "refused"},
    )
    for method, reason in result.failures.items():
        warnings.warn(ColluviumWarning("methods-failed", f"{method}: {reason}"), stacklevel=2)
    return result


def report(
    run: RunResult | str | os.PathLike[str],
    *,
    fields: str | Sequence[str] = (),
    frames: int = 4,
    view: str | None = None,
    overwrite: bool = False,
) -> Path:
    """Writes the report of a run in its folder, one page with all its results, and returns the file.

    ``fields`` colour the points, by default displacement and velocity; ``view`` is ``xy``, ``xz`` or ``yz``.
    """
    check_count(frames, "frames")
    file, found = _native.write_report(folder_of(run, "report"), as_names(fields), frames, view, overwrite)
    for code, text in found:
        warnings.warn(ColluviumWarning(code, text), stacklevel=2)
    return Path(file)
