"""Positions of the grains of the DEM comparison, for all codes.

A loose column is a simple cubic lattice of pitch 1.05 d with random displacements. A dense specimen is a hexagonal close packing of
pitch 0.999 d. Each is written as `NAME.txt` (positions, with the size of the box in the first line) and `NAME.data` (LAMMPS).
"""
import numpy as np

DIAMETER = 0.01
DENSITY = 2500


def loose(nx, ny, nz):
    """Loose column of nx × ny × nz grains, with the size of its box (m)."""
    random = np.random.default_rng(1)
    pitch = 1.05 * DIAMETER
    cells = np.stack(np.meshgrid(np.arange(nx), np.arange(ny), np.arange(nz), indexing="ij"), -1).reshape(-1, 3)
    positions = (cells + 0.5) * pitch + random.uniform(-0.02, 0.02, cells.shape) * DIAMETER
    return positions, np.array([3 * nx * pitch, ny * pitch, 1.6 * nz * pitch])


def dense(nx, ny, nz):
    """Dense specimen of nx × ny × nz grains, with the size of its box (m)."""
    k, j, i = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    rows = np.sqrt(3) / 2 * j + np.where(k % 2, np.sqrt(3) / 6, 0)
    positions = np.stack((i + 0.5 * ((j + k) % 2), rows, np.sqrt(6) / 3 * k), -1).reshape(-1, 3)
    positions = positions * 0.999 * DIAMETER + 0.5 * DIAMETER
    return positions, positions.max(0) + np.array([0.5, 0.5, 2]) * DIAMETER


SPECIMENS = {
    "loose": (loose, (20, 20, 25)),
    "dense": (dense, (22, 22, 22)),
    "loose80": (loose, (40, 40, 50)),
    "dense80": (dense, (43, 43, 43)),
}

if __name__ == "__main__":
    for name, (place, counts) in SPECIMENS.items():
        positions, box = place(*counts)
        np.savetxt(f"{name}.txt", positions, fmt="%.9g", header=" ".join(f"{size:.9g}" for size in box))
        with open(f"{name}.data", "w") as out:
            out.write(f"# {name}\n\n{len(positions)} atoms\n1 atom types\n\n")
            out.writelines(f"0 {size:.9g} {axis}lo {axis}hi\n" for axis, size in zip("xyz", box))
            out.write("\nAtoms\n\n")
            for number, (x, y, z) in enumerate(positions, 1):
                out.write(f"{number} 1 {DIAMETER} {DENSITY} {x:.9g} {y:.9g} {z:.9g}\n")
        print(name, len(positions), "grains in a box of", box, "m")
