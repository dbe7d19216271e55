"""Cases: descriptions of a problem, which methods solve."""

from __future__ import annotations

import difflib
import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._extras import extra
from .paths import parsed, plain, value_at, with_value

if TYPE_CHECKING:
    import geopandas


def _cache(name: str) -> Path:
    """Folder of the files of a template, which is the same for all cases of it: runs that are opened later find it."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    place = Path(base) / "colluvium" / _native.__version__ / name
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError:
        return Path(tempfile.mkdtemp(prefix="colluvium-"))
    return place if os.access(place, os.W_OK) else Path(tempfile.mkdtemp(prefix="colluvium-"))


class Case:
    """A problem, from a dictionary, a file or JSON text. It is checked as a whole; a wrong one raises ``CaseError``.

    The options of a method are checked by `plan` and `run`.

    Values are read and set by the paths of error messages::

        case["materials.sand.friction_angle"] = 34
        case["bodies[0].shape.max"]
    """

    def __init__(
        self,
        source: Mapping[str, Any] | str | os.PathLike[str],
        *,
        folder: str | os.PathLike[str] = "",
        check: bool = True,
    ) -> None:
        """A mapping, a path, or a text that begins with ``{``. File names in a case start at its folder."""
        self._folder = Path(folder).absolute()
        if isinstance(source, Mapping):
            self._value = plain(source, "")
        elif isinstance(source, str) and source.lstrip().startswith("{"):
            self._value = self._parsed(source, check)
        elif isinstance(source, (str, os.PathLike)):
            path = Path(source)
            self._folder = path.parent.absolute()
            self._value = self._parsed(path.read_text(encoding="utf-8"), check)
        else:
            raise TypeError(f"a case is a mapping, a path or JSON text, not {type(source).__name__}")
        if check and isinstance(source, Mapping):
            self.check()

    def _parsed(self, text: str, check: bool) -> Any:
        return parsed(text, lambda text: _native.check(text, self._folder)) if check else json.loads(text)

    @classmethod
    def template(cls, name: str, folder: str | os.PathLike[str] | None = None) -> Case:
        """A template of ``colluvium new``. Files that it needs are written into ``folder``, or into one of the user's cache."""
        if name not in templates():
            near = difflib.get_close_matches(str(name), templates(), 1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise ValueError(f"{name!r} is not a template of a case; {hint}there are {', '.join(templates())}")
        text = _native.template(name)
        if not _native.template_files(name):
            return cls(text)
        place = _cache(name) if folder is None else Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        _native.write_template_files(name, place)
        return cls(text, folder=place)

    def check(self) -> None:
        """Raises ``CaseError`` with all problems of the case."""
        _native.check(self.to_json(), self._folder)

    @property
    def warnings(self) -> list[tuple[str, str]]:
        """Codes and texts of the warnings about the case, which hold for every method."""
        return [(one["code"], one["text"]) for one in json.loads(_native.case_warnings(self.to_json(), self._folder))]

    def plan(self, method: str | None = None) -> dict[str, Any]:
        """Method, number of points and steps, time step (s), memory (bytes) and warnings."""
        return json.loads(_native.plan(self.to_json(), self._folder, method))

    def copy(self) -> Case:
        """A copy."""
        copied = Case.__new__(Case)
        copied._folder, copied._value = self._folder, self.to_dict()
        return copied

    def to_dict(self) -> dict[str, Any]:
        """A copy as a dictionary."""
        return json.loads(self.to_json())

    def to_json(self, indent: int | None = None) -> str:
        """The case as JSON text."""
        return json.dumps(self._value, allow_nan=False, indent=indent)

    def to_geopandas(self, epsg: int | None = None) -> geopandas.GeoDataFrame:
        """Outlines of the layers of the bodies and of the observed event, with the column ``kind``. Needs the extra ``geopandas``."""
        geopandas, shapely = extra("geopandas"), extra("shapely", "geopandas")
        layers, observed = _native.outlines(self.to_json(), self._folder)
        rings = [("layer", ring) for ring in layers] + [("observed", ring) for ring in observed]
        shapes = [shapely.Polygon(ring) for _, ring in rings]
        return geopandas.GeoDataFrame({"kind": [kind for kind, _ in rings]}, geometry=shapes, crs=epsg)

    @property
    def folder(self) -> Path:
        """Folder at which file names in the case start."""
        return self._folder

    def __getitem__(self, path: str) -> Any:
        return json.loads(json.dumps(value_at(self._value, path)))

    def __setitem__(self, path: str, value: Any) -> None:
        self.update({path: value})

    def update(self, values: Mapping[str, Any]) -> None:
        """Sets several values by their paths at once. A wrong one changes nothing."""
        changed = self.to_dict()
        for path, value in values.items():
            with_value(changed, path, plain(value, path))
        _native.check(json.dumps(changed, allow_nan=False), self._folder)
        self._value = changed

    def __contains__(self, path: object) -> bool:
        try:
            value_at(self._value, path)  # type: ignore[arg-type]
        except KeyError:
            return False
        return True

    __iter__: None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self._value == other._value and self._folder == other._folder

    def __repr__(self) -> str:
        return f"Case({self._value.get('title', '')!r})"


def methods() -> list[str]:
    """Names of the methods."""
    return _native.methods()


def templates() -> dict[str, str]:
    """Names of the templates of cases, each with a line about it."""
    return dict(_native.templates())


def schema() -> dict[str, Any]:
    """JSON Schema of a case."""
    return json.loads(_native.schema())
