"""Builds the wheel for processors with x86-64-v3, and the source distribution for all, into `python/dist`.

    python python/build_wheel.py [--native]

`--native` builds for the processor of this machine. Needs maturin and the Rust toolchain.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent


def build_wheel(target: str, out: Path) -> None:
    """Builds the wheel for a processor, which the package checks before it loads its native part."""
    # RUSTFLAGS take the place of those in `.cargo/config.toml`, which are for this machine.
    environment = os.environ | {"RUSTFLAGS": f"-C target-cpu={target}"}
    marker = HERE / "colluvium" / "_target.py"
    marker.write_text(f'"""Processor for which the package was built."""\n\nTARGET_CPU = "{target}"\n', encoding="utf-8")
    try:
        command = ["maturin", "build", "--release", "--locked", "--out", str(out)]
        subprocess.run(command, cwd=HERE, env=environment, check=True)
    finally:
        marker.unlink()


def main() -> None:
    out = HERE / "dist"
    is_x86 = platform.machine() in ("x86_64", "AMD64")
    target = "native" if "--native" in sys.argv[1:] else "x86-64-v3" if is_x86 else "generic"
    build_wheel(target, out)
    subprocess.run(["maturin", "sdist", "--out", str(out)], cwd=HERE, check=True)


if __name__ == "__main__":
    main()
