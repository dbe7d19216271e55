"""Every template with each of its methods: the files of Python, of the command, and of an interrupted and resumed run are equal."""

import json
import os
import subprocess
import sys

import colluvium as cl
import pytest
from conftest import short_case


#: The command: that of the repository where the environment names it, or else that of the package.
COMMAND = [os.environ["COLLUVIUM_COMMAND"]] if "COLLUVIUM_COMMAND" in os.environ else [sys.executable, "-m", "colluvium"]


class Stop(Exception):
    pass


def pairs():
    return [(name, method) for name in cl.templates() for method in cl.Case.template(name).to_dict()["methods"]]


def frames(folder):
    """Checksums of the frames of a run, and its measures."""
    summary = json.loads((folder / "summary.json").read_text())
    files = sorted(file for file in folder.glob("frames/*") if file.is_file())
    assert summary["status"] == "completed" and files
    return {file.name: file.read_bytes() for file in files}


@pytest.mark.filterwarnings("ignore::colluvium.ColluviumWarning")
@pytest.mark.parametrize(("name", "method"), pairs())
def test_files_are_equal(name, method, tmp_path, is_long):
    case = cl.Case.template(name, tmp_path) if is_long else short_case(name)
    if not is_long and cl._native.template_files(name):
        cl._native.write_template_files(name, tmp_path)
    (tmp_path / "case.json").write_text(case.to_json())
    program = [*COMMAND, "run", str(tmp_path / "case.json"), "--method", method, "--quiet"]
    done = subprocess.run([*program, "--threads", "2", "--out", str(tmp_path / "command")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    wanted = frames(tmp_path / "command")
    hashes = set()
    for threads in (1, 2):
        run = cl.run(case, method, tmp_path / f"python-{threads}", threads=threads)
        hashes.add(run.hash)
        assert frames(tmp_path / f"python-{threads}") == wanted
    seen = []

    def stop(frame):
        seen.append(frame)
        if len(seen) == 2:
            raise Stop

    with pytest.raises(Stop):
        cl.run(case, method, tmp_path / "resumed", on_frame=stop)
    resumed = cl.run(case, method, tmp_path / "resumed", resume=True)
    hashes.add(resumed.hash)
    assert len(hashes) == 1 and frames(tmp_path / "resumed") == wanted
