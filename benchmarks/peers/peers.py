#!/usr/bin/env python3
"""Speed of this project and of other programs at equal settings.

  peers.py list                          settings with their aims and notes
  peers.py run PROGRAM [THREADS] [TEXT]  runs of one program (`ours` for this project) whose setting contains TEXT
  peers.py table [REPEATS] [TEXT]        ours, other, ours, other … for each setting, then a table in Markdown

Run it from the root of the repository after `cargo build --release -p xtask`. Environments, builds, cases and outputs are in `target/peers`,
or in the folder PEERS_WORK. A rate is points × steps over processor seconds of one thread, bound to the core CORE (1 by default);
with two threads over wall seconds. The start of a program is not counted: it measures its steps itself, or two runs of different
lengths are subtracted.
"""

import json
import sys
from statistics import median

from runs import WORK
from settings import SETTINGS, write_cases


def verdict(ratio):
    """Word for a ratio: differences below a tenth are not told apart."""
    return "ahead" if ratio > 1.1 else "behind" if ratio < 0.9 else "equal"


def spread(values):
    """Range of values over their largest one, in per cent."""
    return f"{100 * (max(values) - min(values)) / max(values):.0f} %"


def table(settings, repeats, text):
    """Measures all settings in turn and prints the table."""
    print("| setting | other program | ours | spread | ratio | aim | end states differ by | |")
    print("|---|---|---|---|---|---|---|---|")
    for setting in settings:
        if text not in f"{setting.program} {setting.name}":
            continue
        try:
            runs = [(setting.ours.measure(1), setting.other.measure(1)) for _ in range(repeats)]
        except (OSError, RuntimeError, ValueError) as error:
            print(f"| {setting.name} | {setting.program}: not measured ({str(error)[:200]!r}) | | | | {setting.aim} | | |", flush=True)
            continue
        ours, others = [[run.rate for run in side] for side in zip(*runs)]
        ratio = median(ours) / median(others)
        apart = setting.difference(runs[-1][0].end, runs[-1][1].end) if setting.difference else None
        apart = "" if apart is None else f"{100 * apart:.2f} %"
        print(
            f"| {setting.name} | {setting.program} {median(others):.3g} | {median(ours):.3g} | {spread(ours)}, {spread(others)} | "
            f"{ratio:.2f} | {setting.aim} | {apart} | {verdict(ratio)} |",
            flush=True,
        )


def run(settings, program, threads, text):
    """Measures one program at all settings and prints a line for each."""
    for setting in settings:
        if program not in ("ours", setting.program) or text not in setting.name:
            continue
        job = setting.ours if program == "ours" else setting.other
        if threads == 2 and program != "ours" and job.two_threads is None:
            continue
        try:
            result = job.measure(threads)
            print(f"{program} {setting.name} {result.points:.0f} {result.steps:.0f} {result.seconds:.3f} {result.rate:.3f} {json.dumps(result.end)}", flush=True)
        except (OSError, RuntimeError, ValueError) as error:
            print(f"# {program} {setting.name} failed: {str(error)[-400:]}", flush=True)


def main(arguments):
    task = arguments[0] if arguments else "list"
    if task == "list":
        for setting in SETTINGS:
            print(f"{setting.program}: {setting.name} (aim {setting.aim}): {setting.note}")
        return
    write_cases(WORK / "cases")
    if task == "run":
        threads = int(arguments[2]) if len(arguments) > 2 else 1
        run(SETTINGS, arguments[1], threads, arguments[3] if len(arguments) > 3 else "")
    elif task == "table":
        repeats = int(arguments[1]) if len(arguments) > 1 else 3
        table(SETTINGS, repeats, arguments[2] if len(arguments) > 2 else "")
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
