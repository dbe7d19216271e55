"""Changes three examples of SPHinXsys for measurements: `sphinxsys_examples.py FOLDER`, the folder of its sources.

They then take the particles across the beam or up the column from the variable RES, the threads from THREADS and the steps from STEPS,
leave out the output within the loop, and print points, steps, processor seconds of the loop and the end state."""

import re
import sys
from pathlib import Path

HEAD = """using namespace SPH;
#include <sys/resource.h>
#include <tbb/global_control.h>
static double cpuSeconds()
{
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_utime.tv_sec + 1e-6 * usage.ru_utime.tv_usec;
}
template <class Body> void printEnd(Body &body, long steps, double user, double time)
{
    auto &particles = body.getBaseParticles();
    auto *v = particles.template getVariableDataByName<Vecd>("Velocity");
    auto *x = particles.template getVariableDataByName<Vecd>("Position");
    auto *m = particles.template getVariableDataByName<Real>("Mass");
    double kinetic = 0, mass = 0;
    Vecd centre = Vecd::Zero();
    size_t n = particles.TotalRealParticles();
    for (size_t i = 0; i < n; ++i)
    {
        kinetic += 0.5 * m[i] * v[i].squaredNorm();
        mass += m[i];
        centre += m[i] * x[i];
    }
    centre /= mass;
    printf("points %zu steps %ld user %.4f\\ncentre %.9g %.9g kinetic %.6g time %.6g\\n", n, steps, user, centre[0], centre[1], kinetic, time);
}
"""

THREADS = """    tbb::global_control threads(tbb::global_control::max_allowed_parallelism, atoi(getenv("THREADS")));
    const long wanted = atol(getenv("STEPS"));
    long steps = 0;
"""

TOTAL = """    while (steps < wanted)
    {
        stress_relaxation_first_half.exec(dt);
        constraint_beam_base.exec();
        stress_relaxation_second_half.exec(dt);
        dt = computing_time_step_size.exec();
        physical_time += dt;
        steps++;
    }
"""

UPDATED = """    while (steps < wanted)
    {
        Real relaxation_time = 0.0;
        Real advection_dt = advection_time_step.exec();
        beam_volume_update.exec();
        while (relaxation_time < advection_dt && steps < wanted)
        {
            Real acoustic_dt = acoustic_time_step.exec();
            beam_pressure_relaxation.exec(acoustic_dt);
            constraint_beam_base.exec();
            beam_shear_stress.exec(acoustic_dt);
            beam_shear_acceleration.exec(acoustic_dt);
            beam_density_relaxation.exec(acoustic_dt);
            relaxation_time += acoustic_dt;
            physical_time += acoustic_dt;
            steps++;
        }
        beam_body.updateCellLinkedList();
        beam_body_inner.updateConfiguration();
        correction_matrix.exec();
    }
"""

SOIL = """    while (steps < wanted)
    {
        soil_density_by_summation.exec();
        Real relaxation_time = 0.0;
        while (relaxation_time < Dt && steps < wanted)
        {
            Real dt = soil_acoustic_time_step.exec();
            stress_diffusion.exec();
            granular_stress_relaxation.exec(dt);
            granular_density_relaxation.exec(dt);
            relaxation_time += dt;
            physical_time += dt;
            soil_block.updateCellLinkedList();
            soil_block_complex.updateConfiguration();
            steps++;
        }
    }
"""

EXAMPLES = [
    ("test_2d_oscillating_beam", r"PH / 10(\.0)?", "PH", TOTAL, "beam_body"),
    ("test_2d_oscillating_beam_UL", r"PH / 10(\.0)?", "PH", UPDATED, "beam_body"),
    ("test_2d_column_collapse", r"LH / 50", "LH", SOIL, "soil_block"),
]


def change(file, spacing, size, loop, body):
    """Changes the main file of an example; a second call changes nothing."""
    text = file.read_text()
    if "cpuSeconds" in text:
        return
    text, count = re.subn(spacing, f'{size} / atof(getenv("RES"))', text)
    if count != 1:
        raise SystemExit(f"{file}: expected one spacing, found {count}; this script is for commit 9f33297")
    text = text.replace("using namespace SPH;", HEAD, 1)
    text = re.sub(r"(int main\(int ac, char \*av\[\]\)\n{\n)", lambda found: found[1] + THREADS, text, count=1)
    at = text.index("    while (physical_time <")
    end = f"    printEnd({body}, steps, cpuSeconds() - start, physical_time);\n    return 0;\n"
    file.write_text(text[:at] + "    const double start = cpuSeconds();\n" + loop + end + text[at:])


for name, spacing, size, loop, body in EXAMPLES:
    folder = Path(sys.argv[1]) / "tests" / "2d_examples" / name
    change(next(folder.glob("*.cpp")), spacing, size, loop, body)
