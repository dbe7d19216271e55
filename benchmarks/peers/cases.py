"""Cases of this project at the settings of the other programs: `cases.py FOLDER` writes them as JSON files."""

import json
import sys
from pathlib import Path

ELASTIC = {"model": "linear-elastic", "density": 2000.0, "youngs_modulus": 1e6, "poissons_ratio": 0.3}
DRUCKER_PRAGER = {**ELASTIC, "model": "drucker-prager", "friction_angle": 20.0, "cohesion": 0.1}
LAWS = {
    "elastic": ELASTIC,
    "corotated": {**ELASTIC, "model": "fixed-corotated"},
    "dphencky": {**DRUCKER_PRAGER, "strain_measure": "hencky"},
}

# P-wave speed of the elastic soil (m/s): the time step of the block is 0.4 times the cell size over it.
MODULUS = 1e6 * 0.7 / (1.3 * 0.4)
WAVE_SPEED = (MODULUS / 2000.0) ** 0.5


def space(dimension):
    """Value of the key `space`."""
    return "plane-strain" if dimension == 2 else "3d"


def stretching(dimension):
    """Gradient of the velocity at the start (1/s): the block shortens along x and lengthens along y, with some shear."""
    return [row[:dimension] for row in [[-0.06, 0.02, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.01]][:dimension]]


def block(dimension, material, cell):
    """Block of edge 1 m that oscillates freely, without a method."""
    centre = [0.5] * dimension
    stretch = {"kind": "linear", "value": [0.0] * dimension, "origin": centre, "gradient": stretching(dimension)}
    box = {"kind": "box", "min": [0.0] * dimension, "max": [1.0] * dimension}
    return {
        "title": "block",
        "space": space(dimension),
        "domain": {"min": [-6 * cell] * dimension, "max": [1 + 6 * cell] * dimension},
        "gravity": [0.0] * dimension,
        "materials": {"soil": material},
        "bodies": [{"name": "block", "material": "soil", "shape": box, "velocity": stretch}],
        "stages": [{"name": "oscillate", "duration": 100.0}],
    }


def mpm_blocks():
    """Blocks of the material point method with quadratic functions, APIC and USL: name and case."""
    for dimension, cells in [(2, 100), (2, 500), (3, 20), (3, 50)]:
        cell = 1 / cells
        for law, material in LAWS.items():
            method = {
                "cell_size": cell,
                "shape": "quadratic",
                "stress_update": "usl",
                "transfer": "apic",
                "time_step": 0.4 * cell / WAVE_SPEED,
            }
            case = {**block(dimension, material, cell), "methods": {"mpm": method}}
            yield f"block-{dimension}d-quadratic-{law}-apic-usl-{cells}", case


def beams():
    """Elastic cantilevers of smoothed particle hydrodynamics that swing from an initial velocity."""
    # A twentieth of the sound speed of the bulk modulus.
    tip = 0.05 * (2e6 / (3 * (1 - 2 * 0.3975)) / 1000) ** 0.5
    laws = {"updated": "linear-elastic", "total-lagrangian": "st-venant-kirchhoff"}
    for rows, formulation in [(40, "updated"), (40, "total-lagrangian")]:
        spacing = 0.02 / rows
        swing = {"kind": "bending", "along": 0, "across": 1, "clamp": 0, "length": 0.2, "tip": tip}
        method = {
            "spacing": spacing,
            "kernel": "cubic-spline",
            "smoothing": 1.3,
            "viscosity_linear": 0.2,
            "held": ["clamp"],
            "formulation": formulation,
        }
        if formulation == "updated":
            method["tensile"] = {"kind": "artificial-stress", "strength": 0.3, "exponent": 4}
        rubber = {"model": laws[formulation], "density": 1000, "youngs_modulus": 2e6, "poissons_ratio": 0.3975}
        beam = {"kind": "box", "min": [0, 0], "max": [0.2, 0.02]}
        clamp = {"kind": "box", "min": [-0.06, 0], "max": [0, 0.02]}
        yield f"sph-beam-{formulation}-{rows}", {
            "title": "beam",
            "space": "plane-strain",
            "domain": {"min": [-0.08, -0.08], "max": [0.26, 0.1]},
            "gravity": [0, 0],
            "materials": {"m": rubber},
            "bodies": [
                {"name": "beam", "material": "m", "shape": beam, "velocity": swing},
                {"name": "clamp", "material": "m", "shape": clamp},
            ],
            "stages": [{"name": "swing", "duration": 1.0}],
            "methods": {"sph": method},
        }


def soil_columns():
    """Columns of aluminium bars of smoothed particle hydrodynamics that collapse."""
    bars = {
        "model": "drucker-prager",
        "density": 2040,
        "youngs_modulus": 5.84e6,
        "poissons_ratio": 0.3,
        "friction_angle": 21.9,
        "matching": "plane-strain-associated",
    }
    for rows in [50, 150]:
        method = {"spacing": 0.1 / rows, "kernel": "wendland-c2", "smoothing": 1.3, "viscosity_linear": 0.1}
        column = {"kind": "box", "min": [0, 0], "max": [0.2, 0.1]}
        yield f"sph-column-{rows}", {
            "title": "bars",
            "space": "plane-strain",
            "domain": {"min": [0, 0], "max": [0.5, 0.15]},
            "gravity": [0, -9.8],
            "materials": {"s": bars},
            "bodies": [{"name": "column", "material": "s", "shape": column}],
            "boundaries": [{"side": side, "wall": {"kind": "rough"}} for side in ("x-min", "x-max", "y-min")],
            "stages": [{"name": "collapse", "duration": 0.8}],
            "methods": {"sph": method},
        }


def disks():
    """Two elastic disks that collide, with linear functions."""
    rubber = {"model": "linear-elastic", "density": 1000, "youngs_modulus": 1000, "poissons_ratio": 0.3}
    for scheme in ["usl", "musl"]:
        method = {"cell_size": 0.005, "points_per_cell": 2, "shape": "linear"}
        method.update({"stress_update": scheme, "time_step": 1e-3})
        bodies = [
            {
                "name": name,
                "material": "r",
                "shape": {"kind": "ball", "centre": [place, place], "radius": 0.2},
                "velocity": {"kind": "uniform", "value": [speed, speed]},
            }
            for name, place, speed in [("a", 0.2, 0.1), ("b", 0.8, -0.1)]
        ]
        yield f"disks-{scheme}", {
            "title": "disks",
            "space": "plane-strain",
            "domain": {"min": [-0.1, -0.1], "max": [1.1, 1.1]},
            "gravity": [0, 0],
            "materials": {"r": rubber},
            "bodies": bodies,
            "stages": [{"name": "collide", "duration": 3.6}],
            "methods": {"mpm": method},
        }


def write(folder):
    """Writes all cases to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for family in [mpm_blocks, beams, soil_columns, disks]:
        for name, case in family():
            (folder / f"{name}.json").write_text(json.dumps(case, indent=1))


if __name__ == "__main__":
    write(Path(sys.argv[1]))
