"""com1DFA of AvaFrame on the helix channel with Coulomb friction: `com1dfa_steps.py STEPS`.

Prints particles, steps, processor seconds, and the end state. Run it in a folder with `src/avaframe/data/avaHelixChannel`. The first steps are
not counted: they contain the start of the program."""

import logging
import os
import resource
import shutil
import sys
import tempfile
import time

STEPS = int(sys.argv[1])
TIME_STEP = 0.1
FRICTION = 0.3
UNCOUNTED = 20

work = os.getcwd()
folder = tempfile.mkdtemp(dir=work)
shutil.copytree(f"{work}/src/avaframe/data/avaHelixChannel", f"{folder}/avaHelixChannel")
os.chdir(folder)

import matplotlib

matplotlib.use("Agg")
logging.disable(logging.CRITICAL)
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils
from avaframe.in3Utils import initializeProject

main = cfgUtils.getGeneralConfig()
main["MAIN"].update({"avalancheDir": f"{folder}/avaHelixChannel", "nCPU": "1"})
main["FLAGS"].update({key: "False" for key in ("createReport", "savePlot", "ReportDir")})
initializeProject.cleanSingleAvaDir(f"{folder}/avaHelixChannel", deleteOutput=False)
config = cfgUtils.getDefaultModuleConfig(com1DFA, toPrint=False)
config["GENERAL"].update(
    {
        "simTypeList": "null",
        "frictModel": "Coulomb",
        "mucoulomb": str(FRICTION),
        "dt": str(TIME_STEP),
        "tEnd": str(STEPS * TIME_STEP),
        "stopCrit": "0",
    }
)
take_step = com1DFA.computeEulerTimeStep


def counted_step(*arguments, **options):
    """A step that appends its particles, times and state to a file, since it runs in a process of its own."""
    result = take_step(*arguments, **options)
    particles = result[0]
    mass = particles["m"].sum()
    centre = [(particles["m"] * particles[c]).sum() / mass for c in "xyz"]
    kinetic = 0.5 * (particles["m"] * sum(particles[c] ** 2 for c in ("ux", "uy", "uz"))).sum()
    centre = [centre[0] + particles["xllcenter"], centre[1] + particles["yllcenter"], centre[2]]
    numbers = [particles["nPart"], resource.getrusage(resource.RUSAGE_SELF).ru_utime, time.time(), *centre, kinetic, mass]
    with open(f"{folder}/steps", "a") as file:
        print(*numbers, file=file)
    return result


com1DFA.computeEulerTimeStep = counted_step
com1DFA.com1DFAMain(main, cfgInfo=config)
rows = [[float(value) for value in line.split()] for line in open(f"{folder}/steps")]
os.chdir(work)
shutil.rmtree(folder, ignore_errors=True)
first, last = rows[UNCOUNTED], rows[-1]
print(
    f"\npoints {int(last[0])} steps {len(rows) - 1 - UNCOUNTED} user {last[1] - first[1]:.3f} wall {last[2] - first[2]:.3f} "
    f"centre {last[3]:.6g} {last[4]:.6g} {last[5]:.6g} kinetic {last[6]:.6g} mass {last[7]:.6g} time {len(rows) * TIME_STEP:.3f}"
)
