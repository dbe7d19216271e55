"""Our case of the helix channel with as many nodes as com1DFA has particles: `helix_case.py DATA FOLDER`, with AvaFrame's folder
`avaHelixChannel`. It copies terrain and release outline beside the case."""

import json
import math
import shutil
import sys
from pathlib import Path

FRICTION = 0.3
# Distance of nodes that makes as many as com1DFA has particles (m).
SPACING = 2.15

data, folder = Path(sys.argv[1]), Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
terrain = data / "Inputs" / "DEM_HX_Topo.asc"
outline = data / "Inputs" / "REL" / "release1HX.shp"
for file in [terrain, *outline.parent.glob(outline.stem + ".*")]:
    shutil.copy(file, folder)
header = dict(line.lower().split() for line in terrain.read_text().splitlines()[:6])
cell = float(header["cellsize"])
low = [float(header["xllcenter"]) - cell / 2, float(header["yllcenter"]) - cell / 2]
high = [low[0] + int(header["ncols"]) * cell, low[1] + int(header["nrows"]) * cell]
layer = {"kind": "layer", "on": "terrain", "outline": outline.name, "measured": "normal", "thickness": {"attribute": "thickness"}}
soil = {"model": "mohr-coulomb", "density": 200, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "friction_angle": 20}
angle = math.degrees(math.atan(FRICTION))
case = {
    "title": "helix channel",
    "space": "3d",
    "gravity": [0, 0, -9.81],
    "domain": {"min": [*low, -100], "max": [*high, 2000]},
    "materials": {"snow": soil},
    "bodies": [{"name": "release", "material": "snow", "shape": layer}],
    "obstacles": [{"name": "terrain", "shape": {"kind": "raster", "file": terrain.name}, "wall": {"kind": "rough"}}],
    "stages": [{"name": "flow", "duration": 100}],
    "methods": {
        "depth-sph": {
            "spacing": SPACING,
            "basal": {"model": "voellmy", "friction_angle": angle, "turbulence": "none"},
        }
    },
}
(folder / "helix.json").write_text(json.dumps(case, indent=1))
