"""Depth-integrated SPH on real avalanche paths, held against AvaFrame's com1DFA.

Needs a folder with AvaFrame's data (avaAlr, avaGar, ...), the Python package `avaframe`, and the program `colluvium`. README.md
beside this file has the commands and the definitions of all numbers. Nothing is downloaded.
"""

import argparse
import csv
import json
import math
import pathlib
import pickle
import resource
import shutil
import subprocess
import sys
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import rasterio
import shapefile  # pyshp, a dependency of avaframe

GRAVITY = 9.81
DENSITY = 200.0  # com1DFA's default (kg/m3)
THIN = 0.05  # thickness of the frictionless layer (m)
SEEDS = (12345, 54321)
FRAMES = 2.0  # time between frames (s)
REACHED = 0.1  # peak thickness, normal to the terrain, of a cell that counts as reached (m)
PRESSURE = 1000.0  # peak dynamic pressure of a cell that counts for run-out (Pa), as in AIMEC
SMALLEST_FALL = 20.0  # nodes that fell less are not judged one by one (m)

# release: the file of the release area where a site has several
SITES = {
    "avaAlr": None,
    "avaGar": "relGar",
    "avaHit": None,
    "avaKot": None,
    "avaMal": None,
    "avaWog": None,
}
# mu, xi (m/s2; None for Coulomb friction), longest time (s)
RUNS = {
    "frictionless": (0.0, None, 40.0),
    "coulomb": (0.40, None, 200.0),
    "voellmy": (0.155, 4000.0, 300.0),
}
JUDGED = {"mean": 0.005, "node": 0.08}


# ---------------------------------------------------------------- site


class Site:
    """Terrain, release area and path of a site."""

    def __init__(self, folder):
        self.name = folder.name
        inputs = folder / "Inputs"
        rasters = sorted(inputs.glob("*.asc")) + sorted(inputs.glob("*.tif"))
        if not rasters:
            raise SystemExit(f"{inputs}: there is no terrain (.asc or .tif)")
        releases = [f for f in sorted((inputs / "REL").glob("*.shp")) if SITES.get(self.name) in (None, f.stem)]
        if not releases:
            raise SystemExit(f"{inputs / 'REL'}: there is no release area")
        self.folder, self.terrain, self.release = folder, rasters[0], releases[0]
        with rasterio.open(self.terrain) as file:
            self.level = np.where(file.read(1) == file.nodata, np.nan, file.read(1)).astype(float)
            self.cell = file.transform.a
            self.left, self.top = file.transform.c, file.transform.f
        down, right = np.gradient(self.level, self.cell)
        self.cosine = 1.0 / np.sqrt(1.0 + down**2 + right**2)
        with shapefile.Reader(str(self.release)) as file:
            self.area = sum(abs(ring_area(s.points)) for s in file.shapes())
        with shapefile.Reader(str(inputs / "LINES" / "path_aimec.shp")) as file:
            self.path = np.array(file.shapes()[0].points)
        if self.level_at(self.path[:1])[0] < self.level_at(self.path[-1:])[0]:
            self.path = self.path[::-1]

    def level_at(self, places):
        """Level of the cell at each place (m)."""
        rows = ((self.top - places[:, 1]) / self.cell).astype(int).clip(0, self.level.shape[0] - 1)
        columns = ((places[:, 0] - self.left) / self.cell).astype(int).clip(0, self.level.shape[1] - 1)
        return self.level[rows, columns]

    def centres(self):
        """Plan coordinates of all cells, row by row from the north."""
        rows, columns = np.indices(self.level.shape)
        return np.column_stack(
            ((self.left + (columns + 0.5) * self.cell).ravel(), (self.top - (rows + 0.5) * self.cell).ravel())
        )

    def along(self, places):
        """Length along the path of the point of it next to each place (m); its ends are prolonged."""
        best = np.full(len(places), np.inf)
        length = np.zeros(len(places))
        passed = 0.0
        last = len(self.path) - 2
        for i, (a, b) in enumerate(zip(self.path[:-1], self.path[1:])):
            size = np.hypot(*(b - a))
            s = (places - a) @ (b - a) / size
            s = np.clip(s, -np.inf if i == 0 else 0.0, np.inf if i == last else size)
            away = np.hypot(*(places - a - np.outer(s, (b - a) / size)).T)
            nearer = away < best
            length[nearer], best[nearer] = passed + s[nearer], away[nearer]
            passed += size
        return length


def ring_area(points):
    x, y = np.array(points).T[:2]
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


# ---------------------------------------------------------------- runs


def run_peer(site, run, seed, folder):
    """com1DFA in a process of its own; kept when it has been run before."""
    if not (folder / "done.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        command = [sys.executable, __file__, "--peer", str(site.folder), run, str(seed), str(folder)]
        with open(folder / "log.txt", "w") as log:
            subprocess.run(command, check=True, stdout=log, stderr=subprocess.STDOUT)
    return Peer(site, folder)


def peer_process(source, run, seed, folder):
    """The run itself: com1DFA's defaults but for friction, release thickness in the thin layer, and the cells of the terrain's own raster."""
    from avaframe.com1DFA import com1DFA
    from avaframe.in3Utils import cfgUtils

    site, folder = Site(pathlib.Path(source)), pathlib.Path(folder)
    avalanche = folder / site.name
    shutil.copytree(site.folder, avalanche, ignore=shutil.ignore_patterns("Outputs", "ENT", "RES", "SECREL", "DAM"))
    for other in (avalanche / "Inputs" / "REL").iterdir():
        if other.stem != site.release.stem:
            other.unlink()
    main = cfgUtils.getGeneralConfig()
    main["MAIN"].update({"avalancheDir": str(avalanche), "nCPU": "1"})
    main["FLAGS"].update({key: "False" for key in ("createReport", "savePlot", "ReportDir", "showPlot")})
    config = cfgUtils.getDefaultModuleConfig(com1DFA, toPrint=False)
    mu, xi, longest = RUNS[run]
    options = {
        "simTypeList": "null", "resType": "ppr|pft|pfv|particles", "tSteps": f"0:{FRAMES:g}", "seed": str(seed),
        "rho": f"{DENSITY:g}", "meshCellSize": repr(site.cell), "tEnd": f"{longest:g}",
    }
    if xi is None:
        options.update({"frictModel": "Coulomb", "mucoulomb": str(mu)})
    else:
        options.update({"frictModel": "Voellmy", "muvoellmy": str(mu), "xsivoellmy": str(xi)})
    if run == "frictionless":
        with shapefile.Reader(str(site.release)) as file:
            thickest = max(float(r["thickness"]) for r in file.records())
        options.update({"relThFromFile": "False", "relTh": str(THIN), "deltaTh": str(0.25 * THIN / thickest), "hmin": "0.001", "stopCrit": "0"})
    config["GENERAL"].update(options)
    before = time.time()
    com1DFA.com1DFAMain(main, cfgInfo=config)
    used = sum(resource.getrusage(who).ru_utime for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    (folder / "done.json").write_text(json.dumps({"user": used, "wall": time.time() - before}))


class Peer:
    """Results of com1DFA: peaks on the cells of the terrain, particles in time."""

    def __init__(self, site, folder):
        results = folder / site.name / "Outputs" / "com1DFA"
        self.user = json.loads((folder / "done.json").read_text())["user"]
        peak = {}
        for kind in ("ppr", "pft", "pfv"):
            (file,) = [f for f in (results / "peakFiles").glob(f"*_{kind}.*") if f.suffix in (".asc", ".tif")]
            peak[kind] = aligned(site, file)
        self.thickness, self.speed = peak["pft"], peak["pfv"]
        self.pressure = 1000.0 * peak["ppr"]
        self.frames = []
        for file in sorted((results / "particles").glob("*.pickle"), key=lambda f: float(f.stem.split("_")[-1])):
            p = pickle.loads(file.read_bytes())
            self.frames.append({
                "time": float(p["t"]), "id": p["ID"].astype(int), "mass": p["m"], "bed": p["z"], "depth": p["h"],
                "place": np.column_stack((p["x"] + p["xllcenter"], p["y"] + p["yllcenter"])),
                "speed": np.sqrt(p["ux"] ** 2 + p["uy"] ** 2 + p["uz"] ** 2),
            })
        self.frames.sort(key=lambda f: f["time"])


def run_ours(site, run, nodes, duration, asked, folder):
    """Colluvium with as many nodes and as long as com1DFA."""
    result = folder / "result"
    if not (folder / "done.json").exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for file in [site.terrain, *site.release.parent.glob(site.release.stem + ".*")]:
            shutil.copy(file, folder)
        case, program = our_case(site, run, nodes, duration, asked.fixed_smoothing), asked.program
        (folder / "case.json").write_text(json.dumps(case, indent=2))
        used = -resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        command = [program, "run", str(folder / "case.json"), "--threads", "1", "--out", str(result)]
        with open(folder / "log.txt", "w") as log:
            code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode
        used += resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        error = ""
        if code == 4:
            raise SystemExit(f"{folder}: interrupted; the same command begins this run anew")
        if code:
            # What there is up to then is judged; the report has the reason.
            error = [line for line in (folder / "log.txt").read_text().splitlines() if line][-1]
            print(f"{' '.join(command)}: code {code}\n{error}", file=sys.stderr)
        subprocess.run([program, "export", str(result)], check=True, stdout=subprocess.DEVNULL)
        (folder / "done.json").write_text(json.dumps({"user": used, "error": error}))
    return Ours(site, folder)


def our_case(site, run, nodes, duration, fixed_smoothing):
    mu, xi, _ = RUNS[run]
    height, width = site.level.shape
    low, high = np.nanmin(site.level), np.nanmax(site.level)
    bottom, right = site.top - height * site.cell, site.left + width * site.cell
    layer = {"kind": "layer", "on": "terrain", "outline": site.release.name, "measured": "normal", "thickness": {"attribute": "thickness"}}
    if run == "frictionless":
        layer["thickness"] = THIN
    options = {"spacing": round(math.sqrt(site.area / nodes), 3)}
    if fixed_smoothing:
        options |= {"variable_smoothing": False, "smoothing": round(site.cell / options["spacing"], 3)}
    if mu > 0.0:
        angle = math.degrees(math.atan(mu))
        options["basal"] = {"model": "voellmy", "friction_angle": angle, "turbulence": "none" if xi is None else xi}
    return {
        "title": f"{site.name}, {run}", "space": "3d", "gravity": [0, 0, -GRAVITY],
        "domain": {"min": [site.left, bottom, math.floor(low) - 10.0], "max": [right, site.top, math.ceil(high) + 50.0]},
        "materials": {"snow": {"model": "mohr-coulomb", "density": DENSITY, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "friction_angle": 20}},
        "bodies": [{"name": "release", "material": "snow", "shape": layer}],
        "obstacles": [{"name": "terrain", "shape": {"kind": "raster", "file": site.terrain.name},
                       "wall": {"kind": "smooth" if mu == 0.0 else "rough"}}],
        "stages": [{"name": "flow", "duration": duration}],
        "output": {"frames": FRAMES, "measures": 1.0, "rasters": {"threshold": 0.01}},
        "methods": {"depth-sph": options},
    }


class Ours:
    """Results of Colluvium, as far as it came: peaks on the cells of the terrain, nodes in time."""

    def __init__(self, site, folder):
        result = folder / "result"
        done = json.loads((folder / "done.json").read_text())
        self.user, self.error = done["user"], done["error"]
        peak = {k: aligned(site, result / "rasters" / f"peak_{k}.asc") for k in ("thickness_vertical", "velocity", "dynamic_pressure")}
        self.thickness = peak["thickness_vertical"] * np.nan_to_num(site.cosine)
        self.speed, self.pressure = peak["velocity"], peak["dynamic_pressure"]
        self.frames = []
        for file in (result / "npz").glob("frame-*.npz"):
            p = np.load(file)
            self.frames.append({
                "time": float(p["time"]), "id": p["id"], "mass": p["mass"], "bed": p["bed"], "depth": p["depth"],
                "place": p["position"][:, :2], "speed": np.linalg.norm(p["velocity"], axis=1),
            })
        self.frames.sort(key=lambda f: f["time"])
        measures = np.load(result / "npz" / "measures.npz")
        self.steps = int(measures["step"][-1])
        # What is left of the balance, of builds that keep one, over the potential energy that the flow has lost.
        self.balance = math.nan
        if "energy_error" in measures:
            lost = np.nanmax(measures["potential_energy"][0] - measures["potential_energy"])
            self.balance = np.nanmax(np.abs(measures["energy_error"])) / lost


def aligned(site, file):
    """A raster on the cells of the terrain, 0 where it has no data; 0 everywhere where there is no file, as after a run that failed."""
    if not file.exists():
        return np.zeros(site.level.shape)
    with rasterio.open(file) as raster:
        values = raster.read(1).astype(float)
        if raster.nodata is not None:
            values[values == raster.nodata] = 0.0
        values = np.nan_to_num(values)
        places = site.centres()
        columns = np.floor((places[:, 0] - raster.transform.c) / raster.transform.a + 1e-6).astype(int)
        rows = np.floor((raster.transform.f - places[:, 1]) / -raster.transform.e + 1e-6).astype(int)
        inside = (rows >= 0) & (rows < raster.height) & (columns >= 0) & (columns < raster.width)
        out = np.zeros(len(places))
        out[inside] = values[rows[inside], columns[inside]]
        return out.reshape(site.level.shape)


# ---------------------------------------------------------------- numbers


def energy(model):
    """Energy over the energy line: the mean of all nodes in the worst frame and the worst node, as a share of the fall; largest speed over that of free fall."""
    first = model.frames[0]
    order = np.argsort(first["id"])
    ids, start = first["id"][order], (first["bed"] + first["depth"])[order]
    top = start.max()
    mean, node, line, history = -1.0, -1.0, -1.0, []
    for frame in model.frames[1:]:
        at = np.searchsorted(ids, frame["id"]).clip(0, len(ids) - 1)
        known = ids[at] == frame["id"]
        fall = (start[at] - frame["bed"])[known]
        kinetic, mass = 0.5 * frame["speed"][known] ** 2 / GRAVITY, frame["mass"][known]
        if not len(fall) or mass @ fall < SMALLEST_FALL * mass.sum():
            continue
        share = (mass @ kinetic) / (mass @ fall)
        history.append((frame["time"], share))
        far = fall > SMALLEST_FALL
        mean = max(mean, share - 1.0)
        node = max(node, (kinetic[far] / fall[far]).max() - 1.0) if far.any() else node
        line = max(line, (kinetic / (top - frame["bed"][known]).clip(SMALLEST_FALL)).max() - 1.0)
    return {"mean": mean, "node": node, "line": line, "history": history}


def runout(site, model, along):
    """Length along the path to the last cell with 1 kPa, and that of 99 % of the mass at the end (m)."""
    cells = (model.pressure >= PRESSURE) & (model.thickness >= REACHED)
    last = model.frames[-1]
    s = site.along(last["place"])
    order = np.argsort(s)
    share = np.cumsum(last["mass"][order]) / last["mass"].sum()
    return along[cells].max(initial=0.0), s[order][np.searchsorted(share, 0.99)]


def station_speeds(model, along, stations, cell):
    """Mean of the peak speeds of the cells reached across the path (m/s)."""
    out = []
    for s in stations:
        cells = (np.abs(along - s) < 2.0 * cell) & (model.thickness >= REACHED)
        out.append(model.speed[cells].mean() if cells.any() else 0.0)
    return out


def overlap(a, b, threshold=REACHED):
    """Cells that both reach over cells that one of them reaches."""
    one, two = a.thickness >= threshold, b.thickness >= threshold
    return (one & two).sum() / max(1, (one | two).sum())


def compare_with(site, model, peer, along):
    """Numbers of a model beside those of com1DFA."""
    begin = site.along(peer.frames[0]["place"]).mean()
    reach, most = runout(site, peer, along)
    stations = begin + (reach - begin) * np.arange(1, 6) / 6.0
    own, theirs = (station_speeds(m, along, stations, site.cell) for m in (model, peer))
    own_reach, own_most = runout(site, model, along)
    return {
        "speeds": own, "peer_speeds": theirs, "stations": list(stations - begin),
        "speed_error": [a / b - 1.0 if b > 0 else math.nan for a, b in zip(own, theirs)],
        "runout": (own_reach - begin) / (reach - begin) - 1.0,
        "runout_mass": (own_most - begin) / (most - begin) - 1.0,
        "overlap": overlap(model, peer), "overlap_deep": overlap(model, peer, 0.5),
    }


# ---------------------------------------------------------------- report


def draw(site, run, models, along, out):
    """Map of peak thickness of each model, and energy over the energy line in time."""
    figure, axes = plt.subplots(1, len(models) + 1, figsize=(5 * len(models) + 5, 6), constrained_layout=True)
    reached = np.any([m.thickness >= 0.01 for m in models.values()], axis=0)
    rows, columns = np.where(reached)
    window = (slice(max(0, rows.min() - 10), rows.max() + 10), slice(max(0, columns.min() - 10), columns.max() + 10))
    shade = np.nan_to_num(site.level)[window]
    east, north = np.gradient(shade)[1], np.gradient(shade)[0]
    first = next(iter(models.values()))
    for axis, (name, model) in zip(axes, models.items()):
        axis.imshow(-east - north, cmap="gray", vmin=-10, vmax=10)
        shown = np.where(model.thickness >= REACHED, model.thickness, np.nan)[window]
        image = axis.imshow(shown, cmap="viridis", vmin=0, vmax=np.percentile(first.thickness[first.thickness > REACHED], 99) if (first.thickness > REACHED).any() else 1)
        axis.contour(first.thickness[window] >= REACHED, [0.5], colors="red", linewidths=0.6)
        axis.set_title(f"{name}: peak thickness (m)")
        axis.set_xticks([]), axis.set_yticks([])
        figure.colorbar(image, ax=axis, shrink=0.6)
        history = np.array(energy(model)["history"])
        if len(history):
            axes[-1].plot(*history.T, label=name)
    axes[-1].axhline(1.0, color="black", linewidth=0.8)
    axes[-1].set(xlabel="time (s)", ylabel="v²/2 over g × fall, mean of nodes", title=f"{site.name}, {run}")
    axes[-1].legend()
    figure.savefig(out / f"{site.name}-{run}.png", dpi=90)
    plt.close(figure)


def percent(value):
    if not np.isfinite(value):
        return ""
    return f"{100 * value:+.1f} %" if abs(value) >= 0.005 else f"{100 * value:+.2g} %"


def row_of(site, run, name, model, numbers):
    e = energy(model)
    frames = model.frames
    row = {
        "site": site.name, "run": run, "program": name, "nodes": len(frames[0]["id"]), "until": round(frames[-1]["time"], 1),
        "left": 1.0 - frames[-1]["mass"].sum() / frames[0]["mass"].sum(), "fastest": max(f["speed"].max() for f in frames if len(f["speed"])),
        "energy_mean": e["mean"], "energy_node": e["node"], "energy_line": e["line"], "user": model.user, "steps": getattr(model, "steps", ""),
        "balance": getattr(model, "balance", math.nan), "error": getattr(model, "error", ""),
    }
    if numbers:
        row.update({f"station_{i + 1}": v for i, v in enumerate(numbers["speed_error"])})
        row.update({k: numbers[k] for k in ("runout", "runout_mass", "overlap", "overlap_deep")})
    return row


COLUMNS = ["site", "run", "program", "nodes", "until", "steps", "user", "left", "fastest", "energy_mean", "energy_node", "energy_line", "balance",
           *[f"station_{i}" for i in range(1, 6)], "runout", "runout_mass", "overlap", "overlap_deep", "error"]
SHARES = {"left", "energy_mean", "energy_node", "energy_line", "balance", "runout", "runout_mass", *[f"station_{i}" for i in range(1, 6)]}


def cell_text(key, value):
    if value == "" or value is None:
        return ""
    if key in SHARES:
        return percent(value)
    return f"{value:.2f}" if key.startswith("overlap") else f"{value:.1f}" if isinstance(value, float) else str(value)


def write_report(rows, out):
    with open(out / "table.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="")
        writer.writeheader()
        writer.writerows(rows)
    lines = ["# Avalanche paths: Colluvium and com1DFA", "", "Definitions stand in the README beside the script.", ""]
    lines += ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(cell_text(k, r.get(k)) for k in COLUMNS) + " |" for r in rows]
    lines += ["", *[f"![{f.stem}]({f.name})" for f in sorted(out.glob("*.png"))], ""]
    (out / "report.md").write_text("\n".join(lines))


def judge(rows):
    """Lines on what lies above the energy line, of Colluvium's runs."""
    wrong = []
    for row in rows:
        if row["program"] != "colluvium":
            continue
        if row["error"]:
            wrong.append(f"{row['site']}, {row['run']}: {row['error']}")
        for key, limit in JUDGED.items():
            if row[f"energy_{key}"] > limit:
                wrong.append(f"{row['site']}, {row['run']}: {key} {percent(row[f'energy_{key}'])} above the energy line, {percent(limit)} allowed")
    return wrong


def one_site(site, options, rows):
    for run in options.runs:
        folder = options.out / site.name
        peer = run_peer(site, run, SEEDS[0], folder / f"{run}-com1DFA")
        again = run_peer(site, run, SEEDS[1], folder / f"{run}-com1DFA-again") if run in options.again else None
        nodes, until = len(peer.frames[0]["id"]), max(f["time"] for f in peer.frames)
        ours = run_ours(site, run, nodes, until, options, folder / f"{run}-{options.label}")
        along = site.along(site.centres()).reshape(site.level.shape)
        stations = run != "frictionless"
        rows.append(row_of(site, run, "com1DFA", peer, None))
        if again:
            rows.append(row_of(site, run, "com1DFA, other seed", again, compare_with(site, again, peer, along) if stations else None))
        rows.append(row_of(site, run, "colluvium", ours, compare_with(site, ours, peer, along) if stations else None))
        draw(site, run, {"com1DFA": peer, **({"com1DFA, other seed": again} if again else {}), "colluvium": ours}, along, options.report)
        write_report(rows, options.report)
        print("\n".join(str({k: cell_text(k, r.get(k)) for k in COLUMNS if r.get(k, "") != ""}) for r in rows[-2:]), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=pathlib.Path, required=True, help="folder with avaAlr, avaGar, ...")
    parser.add_argument("--program", default="colluvium", help="the program `colluvium`")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("avaframe-comparison"), help="folder for runs and report")
    parser.add_argument("--label", default="colluvium", help="name of these runs of Colluvium: those of another build stay beside them")
    parser.add_argument("--sites", nargs="+", default=list(SITES), choices=list(SITES))
    parser.add_argument("--runs", nargs="+", default=list(RUNS), choices=list(RUNS))
    parser.add_argument("--fixed-smoothing", action="store_true", help="smoothing lengths of Colluvium stay at a cell, as com1DFA's kernel does")
    parser.add_argument("--again", nargs="*", default=["coulomb", "voellmy"], help="runs that com1DFA repeats with another seed")
    options = parser.parse_args()
    options.out, options.program = options.out.resolve(), shutil.which(options.program) or options.program
    options.report = options.out / f"report-{options.label}"
    options.report.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in options.sites:
        one_site(Site((options.data / name).resolve()), options, rows)
    wrong = judge(rows)
    print("\n".join(wrong) or "energy: all runs hold")
    print(f"report in {options.report}")
    return 1 if wrong else 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peer"]:
        peer_process(sys.argv[2], sys.argv[3], int(sys.argv[4]), sys.argv[5])
    else:
        sys.exit(main())
