"""Measures the speed and the cost of the package: a run against the command, start of the command, frames of many points, element tests.

    python python/measure_speed.py [COMMAND]

COMMAND is the program to compare with, by default `target/release/colluvium`. Figures are the smallest of several repetitions.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import colluvium as cl

ROOT = Path(__file__).parent.parent


def fastest(work: Callable[[], object], repetitions: int = 5) -> float:
    """Smallest wall-clock time of a call (s)."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    warnings.simplefilter("ignore")
    command = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target" / "release" / "colluvium")
    with tempfile.TemporaryDirectory() as folder:
        case = cl.Case.template("column-collapse")
        file = Path(folder) / "case.json"
        file.write_text(case.to_json(), encoding="utf-8")

        def of_command() -> None:
            subprocess.run([command, "run", str(file), "--out", f"{folder}/command", "--overwrite"], check=True, capture_output=True)

        def of_package() -> None:
            cl.run(file, out=f"{folder}/python", overwrite=True, progress=lambda *_: None, keep_frames=False)

        print(f"column-collapse: command {fastest(of_command):.3f} s, package {fastest(of_package):.3f} s")
    for name, call in (("command", [command]), ("package", [sys.executable, "-m", "colluvium"])):
        print(f"start of the {name}: {1e3 * fastest(lambda call=call: subprocess.run([*call, '--version'], capture_output=True)):.0f} ms")
    case.update({"methods.mpm.cell_size": 1 / 3000, "stages[0].duration": 1e-6, "bodies[0].shape.max": [0.5, 0.075]})
    frame = cl.run(case, progress=False).frames[-1]
    arrays = fastest(lambda: [frame.points[name] for name in frame.points])
    print(f"{len(frame)} points: {len(frame.points)} arrays in {1e3 * arrays:.2f} ms")
    path = {"kind": "triaxial-drained", "axial_compression": 0.03}
    sand = {"model": "mohr-coulomb", "density": 1900, "youngs_modulus": 2e7, "poissons_ratio": 0.3, "friction_angle": 33}
    stages = [{"path": path, "steps": 200}]
    test = cl.ElementTest({"title": "t", "material": sand, "initial_stress": [-1e5] * 3 + [0, 0, 0], "stages": stages})
    print(f"triaxial test of 200 steps: {1e3 * fastest(test.run, 50):.2f} ms")


if __name__ == "__main__":
    main()
