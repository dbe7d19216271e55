"""Runs of this project and of other programs, measured on one core or two."""

import os
import re
import resource
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent
WORK = Path(os.environ.get("PEERS_WORK", "target/peers")).resolve()
CORE = os.environ.get("CORE", "1")
XTASK = Path("target/release/xtask").resolve()

COUNTED = re.compile(r"points (?P<points>\d+) steps (?P<steps>\d+) user (?P<user>[\d.]+)(?: wall (?P<wall>[\d.]+))?")
END_STATE = re.compile(r"(?P<key>centre|kinetic|time) (?P<values>[-+\d.e]+(?: [-+\d.e]+)*)")


@dataclass
class Run:
    """Points, steps, seconds and end state of a run."""

    points: float
    steps: float
    seconds: float
    end: dict = field(default_factory=dict)

    @property
    def rate(self):
        """Million point updates per second."""
        return self.points * self.steps / self.seconds / 1e6


@dataclass
class Ours:
    """Run of a case of this project: `warm_up` steps, then `steps` that are measured."""

    case: str
    method: str
    steps: int
    warm_up: int = 3

    def measure(self, threads):
        command = [XTASK, "bench", "--case", WORK / "cases" / f"{self.case}.json", "--method", self.method]
        command += ["--threads", threads, "--steps", self.steps, "--warm-up-steps", self.warm_up]
        _, _, text = execute(list(map(str, command)), threads, WORK, {})
        names, row = [line.split(",") for line in text.strip().splitlines()[-2:]]
        values = {name: value if name == "method" else float(value) for name, value in zip(names, row)}
        seconds = values["cpu_seconds"] if threads == 1 else values["seconds"]
        end = {"time": [values["time"]], "kinetic": [values["kinetic_energy"]]}
        end["centre"] = [values["centre_x"], values["centre_y"], values["centre_z"]]
        return Run(values["points"], values["steps"], seconds, end)


@dataclass
class Other:
    """Run of another program.

    `command` has the places {n} for the number of steps and {t} for the number of threads. With one length the program prints `points`,
    `steps` and `user`; with two lengths their difference is measured, and `points` is given or found by a pattern in the output."""

    command: str
    lengths: list
    folder: str = "."
    points: float = None
    environment: dict = field(default_factory=dict)
    pattern: dict = field(default_factory=dict)
    two_threads: dict = None
    # A function of the output that gives the end state; by default the words of END_STATE are looked for.
    end_state: object = None

    def measure(self, threads):
        runs = []
        for length in self.lengths:
            environment = {"STEPS": str(length), **self.environment}
            if threads == 2:
                environment.update(self.two_threads)
            command = ["bash", "-c", self.command.format(n=length, t=threads)]
            user, wall, text = execute(command, threads, WORK / self.folder, environment)
            if self.end_state:
                end = self.end_state(text)
            else:
                end = {m["key"]: list(map(float, m["values"].split())) for m in END_STATE.finditer(text)}
            counted = COUNTED.search(text)
            if counted:
                seconds = float(counted["user" if threads == 1 else "wall"])
                return Run(float(counted["points"]), float(counted["steps"]), seconds, end)
            found = {key: float(re.findall(pattern, text)[-1]) for key, pattern in self.pattern.items()}
            points = found.get("points", self.points)
            runs.append(Run(points, found.get("steps", length), user if threads == 1 else wall, end))
        first, last = runs
        return Run(last.points, last.steps - first.steps, last.seconds - first.seconds, last.end)


@dataclass
class Setting:
    """A setting with a run of this project and one of another program."""

    name: str
    program: str
    aim: float
    ours: Ours
    other: Other
    note: str
    # A function of both end states that gives their relative difference, or None.
    difference: object = None


def execute(command, threads, folder, environment):
    """Processor seconds, wall seconds and output of a command on one core or two."""
    folder.mkdir(parents=True, exist_ok=True)
    cores = CORE if threads == 1 else "0,1"
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    result = subprocess.run(
        ["taskset", "-c", cores, *command],
        cwd=folder,
        env={**os.environ, "OMP_NUM_THREADS": str(threads), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    wall = time.perf_counter() - start
    user = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before.ru_utime
    if result.returncode != 0:
        raise RuntimeError(f"exit status {result.returncode}: {result.stdout[-500:]}")
    return user, wall, result.stdout
