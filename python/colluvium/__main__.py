"""The command ``colluvium``, as ``python -m colluvium``."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Runs the command line with the arguments of the process, and returns its exit code."""
    from ._native import main as command

    # The command handles Ctrl-C by itself: Python would notice it only after the command has returned.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(["colluvium", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
