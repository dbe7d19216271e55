"""Check of the processor, before the native part of the package is loaded."""

from __future__ import annotations

import platform

#: Instructions of x86-64-v3 by their names in ``/proc/cpuinfo``; ``abm`` stands for LZCNT.
_FLAGS = ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe")


def _target() -> str:
    """Processor for which the package was built; empty where it was built on the machine itself."""
    try:
        from ._target import TARGET_CPU
    except ImportError:
        return ""
    return TARGET_CPU


def missing_instructions(cpuinfo: str) -> list[str]:
    """Instructions of x86-64-v3 that a text of ``/proc/cpuinfo`` lacks."""
    for line in cpuinfo.splitlines():
        name, _, flags = line.partition(":")
        if name.strip() == "flags":
            own = set(flags.split())
            return [flag for flag in _FLAGS if flag not in own]
    return []


def check_processor(target: str | None = None, cpuinfo: str | None = None) -> None:
    """Raises ``ImportError`` with the cure where the processor lacks instructions for which the package was built."""
    if (_target() if target is None else target) != "x86-64-v3" or platform.machine() not in ("x86_64", "AMD64"):
        return
    if cpuinfo is None:
        try:
            with open("/proc/cpuinfo", encoding="utf-8") as file:
                cpuinfo = file.read()
        except OSError:
            return
    missing = missing_instructions(cpuinfo)
    if missing:
        raise ImportError(
            "this build of colluvium is for processors with x86-64-v3 (Intel Haswell of 2013, AMD Excavator of 2015, or later), and "
            f"this one lacks {', '.join(missing)}: build the package on this machine with "
            "`pip install --no-binary colluvium colluvium`, or `pip install ./python` in the repository"
        )
