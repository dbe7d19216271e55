"""The command in the package."""

import subprocess
import sys

import colluvium as cl
import pytest


def command(*arguments, cwd=None):
    return subprocess.run([sys.executable, "-m", "colluvium", *arguments], capture_output=True, text=True, cwd=cwd)


def test_the_command_makes_checks_and_runs_a_case(tmp_path):
    assert command("new", "column-collapse", "case.json", cwd=tmp_path).returncode == 0
    checked = command("check", "case.json", cwd=tmp_path)
    assert checked.returncode == 0 and "points" in checked.stdout
    assert cl.Case(tmp_path / "case.json") == cl.Case(cl.Case.template("column-collapse").to_dict(), folder=tmp_path)


def test_exit_codes_are_those_of_the_command(tmp_path):
    assert command("--version").stdout.split()[1] == cl.__version__
    assert command("--help").returncode == 0
    assert command("nothing").returncode == 2
    (tmp_path / "case.json").write_text("{}")
    assert command("check", "case.json", cwd=tmp_path).returncode == 3
    assert command("check", "none.json", cwd=tmp_path).returncode == 3


def test_the_command_starts_without_numpy():
    program = (
        "import sys; import colluvium.__main__ as m; sys.argv = ['colluvium', '--version']\n"
        "code = m.main(); heavy = {'numpy', 'pandas', 'xarray', 'json', 'typing_extensions'} & set(sys.modules)\n"
        "sys.exit(code or (3 if heavy else 0))"
    )
    found = subprocess.run([sys.executable, "-S", "-c", program], capture_output=True, text=True, env={"PYTHONPATH": _site()})
    assert found.returncode == 0, found.stderr


def _site():
    import pathlib

    return str(pathlib.Path(cl.__file__).parent.parent)


def test_an_older_processor_is_told_the_cure():
    from colluvium._machine import check_processor, missing_instructions

    flags = "fpu avx avx2 bmi1 bmi2 f16c fma abm movbe"
    assert missing_instructions(f"processor : 0\nflags : {flags}\n") == []
    assert missing_instructions(f"flags : {flags.replace('avx2', '')}") == ["avx2"]
    check_processor("x86-64-v3", f"flags : {flags}")
    check_processor("", "flags : fpu")
    import platform

    if platform.machine() == "x86_64":
        with pytest.raises(ImportError, match="pip install ./python"):
            check_processor("x86-64-v3", "flags : fpu")
