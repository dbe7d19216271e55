"""Case files of the DEM comparison, from the positions that `make.py` has written into the current folder.

The contact law is that of `lammps.in`. Its dashpots are rates (1/s) times the effective mass; here they are damping ratios.
"""
import json
import math

import numpy as np

from make import DENSITY, DIAMETER, SPECIMENS

STIFFNESS = 2e4
TANGENTIAL_RATIO = 2 / 7
NORMAL_RATE = 1000
TANGENTIAL_RATE = 500
FRICTION = 0.5
TIME_STEP = 2e-5
SKIN = 0.001
GRAIN_MASS = DENSITY * math.pi / 6 * DIAMETER**3


def law(between, mass):
    """Contact law of two kinds, for an effective mass (kg)."""
    return {
        "between": between,
        "normal": {
            "law": "linear",
            "stiffness": STIFFNESS,
            "damping_ratio": 0.5 * NORMAL_RATE * math.sqrt(mass / STIFFNESS),
            "clamp": False,
        },
        "tangential": {
            "stiffness_ratio": TANGENTIAL_RATIO,
            "damping_ratio": 0.5 * TANGENTIAL_RATE * math.sqrt(mass / (TANGENTIAL_RATIO * STIFFNESS)),
        },
        **({"friction": {"coefficient": FRICTION}} if between[1] == "grain" else {}),
    }


def case(name):
    """Case of a specimen."""
    positions = np.loadtxt(f"{name}.txt")
    with open(f"{name}.txt") as file:
        size = [float(word) for word in file.readline().strip("# \n").split()]
    np.savetxt(f"{name}.csv", positions, fmt="%.9g", delimiter=",", header="x,y,z", comments="")
    high = 2 * size[2]
    margin = DIAMETER
    places = [("x-min", "left", 0), ("x-max", "right", size[0]), ("y-min", "front", 0), ("y-max", "back", size[1]), ("z-min", "floor", 0)]
    wall = {"kind": "frictional", "friction_coefficient": FRICTION}
    return {
        "title": f"Comparison: {name}",
        "space": "3d",
        "domain": {"min": [-margin] * 3, "max": [size[0] + margin, size[1] + margin, high]},
        "gravity": [0, 0, -9.81],
        "materials": {"grain": {"model": "linear-elastic", "density": DENSITY, "youngs_modulus": 1e6, "poissons_ratio": 0.2}},
        "bodies": [{
            "name": "specimen",
            "material": "grain",
            "shape": {"kind": "box", "min": [0, 0, 0], "max": [size[0], size[1], high]},
            "points": {"file": f"{name}.csv", "spacing": DIAMETER * (math.pi / 6) ** (1 / 3)},
        }],
        "boundaries": [{"side": side, "name": own, "position": at, "wall": wall} for side, own, at in places],
        "stages": [{"name": "run", "duration": 10}],
        "output": {"measures": 1},
        "methods": {"dem": {
            "grains": {"grain": {"density": DENSITY}},
            "pairs": [law(["grain", "grain"], 0.5 * GRAIN_MASS)] + [law(["grain", own], GRAIN_MASS) for _, own, _ in places],
            "lever_arm": "radius",
            "time_step": TIME_STEP,
            "skin": SKIN / DIAMETER,
        }},
    }


if __name__ == "__main__":
    for name in SPECIMENS:
        with open(f"{name}.json", "w") as out:
            json.dump(case(name), out, indent=1)
        print(name)
