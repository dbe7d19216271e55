"""Material laws written in Python."""

from __future__ import annotations

import numbers
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from . import _native

_Law = TypeVar("_Law", bound=type)


def law(name: str) -> Callable[[_Law], _Law]:
    """Decorator that makes a class a material law, which a case or an element test selects by its name::

        @cl.law("elastic")
        class Elastic:
            state = {"stored_work": 0.0}

            def __init__(self, bulk_modulus, shear_modulus):
                self.bulk, self.shear = bulk_modulus, shear_modulus

            def wave_modulus(self, stress, state):
                return self.bulk + 4 / 3 * self.shear

            def update(self, strain, stress, state, dt):
                volumetric = strain[:3].sum()
                deviator = strain - np.array([1, 1, 1, 0, 0, 0]) * volumetric / 3
                new = stress + 2 * self.shear * deviator
                new[:3] += self.bulk * volumetric
                return new, {"stored_work": state["stored_work"] + new @ strain}

        material = {"model": "external", "law": "elastic", "density": 2000,
                    "parameters": {"bulk_modulus": 1e7, "shear_modulus": 5e6}}

    The class is called with the parameters of the material. ``state`` has the names and initial values of the internal variables, which are
    fields of the results. ``update`` gets the strain increment, the stress before it (Pa), the internal variables and the time step (s). It
    returns the new stress and the new internal variables. Tensors are xx, yy, zz, xy, yz, zx, with tensor shear, tension-positive, in a frame
    that rotates with the material. ``wave_modulus`` returns an upper bound of the stiffness in compression (Pa), which limits the time step.

    An exception in the law ends the run or the test with a ``SolverError``, whose cause it is. A law in Python takes about 10 µs per point
    and step, on one core at a time: it serves element tests and small cases.
    """
    if not isinstance(name, str):
        raise TypeError("a law has a name: write @law('name')")
    if not name or not all(part.isalnum() for part in name.split("-")):
        raise ValueError(f"{name!r} is not a name of letters, digits and hyphens")

    def register(of: _Law) -> _Law:
        for method in ("update", "wave_modulus"):
            if not callable(getattr(of, method, None)):
                raise TypeError(f"the law {name!r} has no method {method}")
        state: Any = getattr(of, "state", {})
        if not isinstance(state, Mapping):
            raise TypeError(f"the state of the law {name!r} is a dictionary of names and numbers, not {type(state).__name__}")
        for key, value in state.items():
            if not isinstance(key, str) or not isinstance(value, numbers.Real):
                raise TypeError(f"the state of the law {name!r} has the entry {key!r}: {value!r}, which is no named number")
        _native.register_law(name, of)
        return of

    return register
