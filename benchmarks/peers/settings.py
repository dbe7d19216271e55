"""Settings that are measured: a run of this project, a run of another program, and the aim for their ratio."""

import re
import subprocess
import sys

import cases
from runs import ROOT, WORK, Other, Ours, Setting

PYTHON = WORK / "venv" / "bin" / "python"
HELIX = WORK / "avaframe" / "src" / "avaframe" / "data" / "avaHelixChannel"


def write_cases(folder):
    """Writes the cases of this project, with those that need data of another program if the data are there."""
    cases.write(folder)
    if HELIX.exists():
        subprocess.run([sys.executable, ROOT / "avaframe" / "helix_case.py", HELIX, folder / "helix"], check=True)
    packings = WORK / "dem"
    if PYTHON.exists() and not (packings / "dense80.json").exists():
        packings.mkdir(parents=True, exist_ok=True)
        for script in ["make.py", "cases.py"]:
            subprocess.run([PYTHON, ROOT / "dem" / script], cwd=packings, check=True)


def last_row_of_lammps(text):
    """End state of LAMMPS: the last row of its table of step, number, kinetic energy, mean height and contacts."""
    numbers = "[-+0-9.e]+"
    rows = re.findall(rf"^ *(\d+) +\d+ +({numbers}) +({numbers}) +{numbers} *$", text, re.MULTILINE)
    return {"kinetic": [float(rows[-1][1])], "height": [float(rows[-1][2])]}


def relative(a, b):
    """Relative difference of two numbers."""
    return abs(a - b) / max(abs(a), abs(b), 1e-300)


def same_energy(ours, other):
    """Difference of the kinetic energies."""
    return relative(ours["kinetic"][0], other["kinetic"][0])


def same_energy_of_start(dimension):
    """Difference of the kinetic energies over that of the block at the start (J)."""
    squares = sum(rate**2 for row in cases.stretching(dimension) for rate in row)
    start = 0.5 * 2000 * squares / 12
    return lambda ours, other: abs(ours["kinetic"][0] - other["kinetic"][0]) / start


def same_shift(start):
    """Difference of the shifts of the centre in plan from `start` (m), over the larger shift."""

    def difference(ours, other):
        shifts = [[end["centre"][c] - start[c] for c in range(2)] for end in (ours, other)]
        size = max(sum(s**2 for s in shift) ** 0.5 for shift in shifts)
        return sum((a - b) ** 2 for a, b in zip(*shifts)) ** 0.5 / size

    return difference


TAICHI_NOTE = "the other: bare kernel, fused multiply-add, points in lattice order, no checks; both: double precision, fixed time step"


def taichi(dimension, law, cells, steps, aim):
    """Block of the material point method beside the kernel in Taichi."""
    points = (2 * cells) ** dimension
    case = f"block-{dimension}d-quadratic-{law}-apic-usl-{cells}"
    command = f"{PYTHON} {ROOT}/taichi_mpm.py {dimension} {law} {cells} {{n}} {{t}}"
    return Setting(
        name=f"MPM {dimension}D quadratic APIC, {law}, {points}",
        program="Taichi",
        aim=aim,
        ours=Ours(case, "mpm", steps),
        other=Other(command, [steps], two_threads={}),
        note=TAICHI_NOTE,
        difference=same_energy_of_start(dimension),
    )


def lammps(packing, points, first, last, aim):
    """Packing of spheres beside LAMMPS: steps `first` to `last`."""
    command = f"lmp -in {ROOT}/dem/lammps.in -var FILE {packing} -var N {{n}} -log none"
    return Setting(
        name=f"DEM 3D {packing}, {points}, steps {first} to {last}",
        program="LAMMPS",
        aim=aim,
        ours=Ours(f"../dem/{packing}", "dem", last - first, warm_up=first),
        other=Other(command, [first, last], folder="dem", points=points, end_state=last_row_of_lammps),
        note="linear springs with history, walls likewise, fixed time step, skin of 0.001 m",
        difference=lambda ours, other: relative(ours["centre"][2], other["height"][0]),
    )


def sphinxsys(name, program, resolution, steps, case, ours_steps, aim):
    """Case of smoothed particle hydrodynamics beside an example of SPHinXsys, changed as README.md says."""
    folder = f"sphinxsys/build/tests/2d_examples/{program}/bin"
    return Setting(
        name=name,
        program="SPHinXsys",
        aim=aim,
        ours=Ours(case, "sph", ours_steps),
        other=Other(
            f"./{program}",
            [steps],
            folder=folder,
            environment={"RES": str(resolution), "THREADS": "1"},
            two_threads={"THREADS": "2"},
        ),
        note="Riemann solver in the other for soil; wall particles not counted; equal time, not equal steps",
        difference=same_energy,
    )


def karamelo(scheme):
    """Colliding disks beside Karamelo."""
    command = f"sed s/@N@/{{n}}/ {ROOT}/disks-{scheme}.mpm > run.mpm && exec {WORK}/karamelo/build/karamelo -i run.mpm"
    return Setting(
        name=f"MPM 2D disks, linear, {scheme.upper()}",
        program="Karamelo",
        aim=None,
        ours=Ours(f"disks-{scheme}", "mpm", 1000),
        other=Other(command, [50, 350], folder="karamelo", points=40216),
        note="FLIP, linear elastic, two points per cell and direction, fixed time step",
    )


SETTINGS = [
    taichi(2, "corotated", 100, 1000, 1.3),
    taichi(2, "elastic", 100, 1000, 1.3),
    taichi(2, "dphencky", 100, 700, 1.5),
    taichi(2, "elastic", 500, 60, None),
    taichi(3, "corotated", 20, 200, 4),
    taichi(3, "elastic", 20, 300, 2.2),
    taichi(3, "dphencky", 20, 200, 5),
    taichi(3, "elastic", 50, 20, None),
    lammps("loose", 10000, 0, 2000, 2.5),
    lammps("loose", 10000, 2000, 10000, 2),
    lammps("dense", 10648, 500, 2500, 2),
    lammps("loose80", 80000, 500, 1500, None),
    lammps("dense80", 79507, 100, 400, 2),
    Setting(
        name="depth-integrated, helix channel",
        program="AvaFrame",
        aim=3,
        ours=Ours("helix/helix", "depth-sph", 103, warm_up=20),
        other=Other(
            f"{WORK}/venv-avaframe/bin/python {ROOT}/avaframe/com1dfa_steps.py {{n}}", [120], folder="avaframe"
        ),
        note="rates are per node and step, to equal kinetic energy: 12 s of the other, 10.9 s of ours",
        difference=same_shift([2006.8, -4651.8]),
    ),
    sphinxsys("SPH 2D soil column, 5000", "test_2d_column_collapse", 50, 1000, "sph-column-50", 2035, None),
    sphinxsys("SPH 2D soil column, 45000", "test_2d_column_collapse", 150, 120, "sph-column-150", 241, 10),
    sphinxsys("SPH 2D elastic beam, total-Lagrangian", "test_2d_oscillating_beam", 40, 300, "sph-beam-total-lagrangian-40", 719, 2),
    sphinxsys("SPH 2D elastic beam, updated", "test_2d_oscillating_beam_UL", 40, 150, "sph-beam-updated-40", 269, None),
    karamelo("musl"),
    karamelo("usl"),
]
