"""Runs: threads, interrupts, callbacks, generators, folders."""

import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings

import colluvium as cl
import numpy as np
import pytest
from conftest import short_case


class Stop(Exception):
    pass


def interrupt_at(monkeypatch, kind):
    """Makes the reader of messages see Ctrl-C at the first message of a kind."""
    from colluvium import running

    original = running.messages

    def interrupted(task):
        for message in original(task):
            if message[0] == kind:
                raise KeyboardInterrupt
            yield message

    monkeypatch.setattr(running, "messages", interrupted)


@pytest.mark.parametrize(("kind", "steps"), [("begin", 50), ("frame", 50), ("progress", 1500)])
def test_an_interrupt_leaves_a_checkpoint_and_the_part_that_is_done(tmp_path, monkeypatch, kind, steps):
    whole = cl.run(short_case(steps=steps), out=tmp_path / "whole")
    with monkeypatch.context() as patch:
        interrupt_at(patch, kind)
        with pytest.raises(KeyboardInterrupt) as stopped:
            cl.run(short_case(steps=steps), out=tmp_path / "part")
    part = stopped.value.result
    assert part.is_interrupted and part.steps < whole.steps and part.folder == tmp_path / "part"
    assert (tmp_path / "part" / "checkpoint.bin").exists()
    resumed = cl.run(short_case(steps=steps), out=tmp_path / "part", resume=True)
    assert resumed.hash == whole.hash and not resumed.is_interrupted
    assert [frame.time for frame in resumed.frames] == [frame.time for frame in whole.frames]
    for name in ("position", "stress"):
        for before, after in zip(whole.frames, resumed.frames):
            assert np.allclose(before.points[name], after.points[name], rtol=1e-6)


def test_a_signal_interrupts_a_run_of_another_process(tmp_path):
    program = textwrap.dedent(
        f"""
        import colluvium as cl, signal, sys
        # A shell starts programs in the background with this signal ignored.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        case = cl.Case.template("column-collapse")
        print("begun", flush=True)
        try:
            cl.run(case, out={str(tmp_path / "run")!r}, on_frame=lambda frame: print("frame", flush=True))
        except KeyboardInterrupt as interrupt:
            print(interrupt.result.is_interrupted, len(interrupt.result.frames) > 0, flush=True)
            sys.exit(7)
        """
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    lines = [process.stdout.readline().strip() for _ in range(2)]
    assert lines == ["begun", "frame"]
    process.send_signal(signal.SIGINT)
    rest = process.communicate(timeout=60)[0].split("\n")
    assert process.returncode == 7 and "True True" in rest
    assert (tmp_path / "run" / "checkpoint.bin").exists()


def test_an_interrupt_without_a_folder_returns_the_part(monkeypatch):
    interrupt_at(monkeypatch, "frame")
    with pytest.raises(KeyboardInterrupt) as stopped:
        cl.run(short_case(steps=2000))
    assert stopped.value.result.is_interrupted and len(stopped.value.result.columns["time"]) >= 1


@pytest.mark.parametrize("callback", ["progress", "on_frame"])
def test_an_exception_in_a_callback_comes_out_unchanged(callback, tmp_path):
    error = Stop("mine")

    def fail(*_):
        raise error

    with pytest.raises(Stop) as found:
        cl.run(short_case(steps=3000), out=tmp_path / "run", **{callback: fail})
    assert found.value is error and found.value.__cause__ is None
    # The folder is free again, and the run can be continued.
    assert cl.open_run(tmp_path / "run").is_interrupted


@pytest.mark.parametrize("callback", ["progress", "on_frame"])
def test_a_callback_that_returns_false_stops_the_run(callback):
    run = cl.run(short_case(steps=3000), **{callback: lambda *_: False})
    assert run.is_interrupted and run.steps < 3000 and len(run.columns["time"]) >= 1
    assert run.frames[-1].time <= run.last.time


def test_wrong_options_are_refused(tmp_path, column):
    for options, text in [
        ({"threads": 0}, "threads"), ({"threads": 10**9}, "1024"), ({"resume": True}, "out="),
        ({"on_frame": 3}, "on_frame"), ({"progress": 3}, "progress"),
    ]:
        with pytest.raises((ValueError, TypeError), match=text):
            cl.run(column, **options)
    with pytest.raises(ValueError, match="jobs"):
        cl.sweep(column, {"a": {"at": "materials.sand.friction_angle", "values": [30]}}, tmp_path / "a", jobs=0)


def test_frames_come_to_a_callback_and_need_not_be_kept():
    seen = []
    run = cl.run(short_case(), on_frame=lambda frame: seen.append(frame.time), keep_frames=False)
    assert len(seen) == 3 and len(run.frames) == 0 and run.last.time == seen[-1]


def test_a_generator_gives_the_frames_of_the_run(column):
    run = cl.run(column)
    frames = list(cl.frames(column))
    assert [frame.time for frame in frames] == [frame.time for frame in run.frames]
    assert np.array_equal(frames[-1].points["velocity"], run.frames[-1].points["velocity"])


def test_a_run_waits_for_the_reader_of_its_frames(column, tmp_path):
    column["output.frames"] = column["stages[0].duration"] / 20
    reader = cl.frames(column, out=tmp_path / "run")
    for taken in (1, 2):
        next(reader)
        time.sleep(0.5)
        # The next frame is made and waits; the run would have made all of them by now.
        assert len(list((tmp_path / "run" / "frames").glob("*.vtu"))) == taken + 1
    assert sum(1 for _ in reader) == 19


@pytest.mark.skipif(not os.path.exists("/proc/self/task"), reason="needs /proc")
def test_a_dropped_generator_stops_its_run(column):
    column["stages[0].duration"] = 100.0
    column["output.frames"] = 1e-3
    before = len(os.listdir("/proc/self/task"))
    for close in (True, False):
        reader = cl.frames(column)
        next(reader)
        assert len(os.listdir("/proc/self/task")) > before
        if close:
            reader.close()
        del reader
        gc.collect()
        time.sleep(0.2)
        assert len(os.listdir("/proc/self/task")) <= before


def test_errors_of_a_generator_come_out():
    with pytest.raises(cl.CaseError):
        list(cl.frames(short_case(), "dem"))


def test_two_runs_at_once_in_two_threads(column):
    found = []

    def work():
        found.append(cl.run(column, threads=1).hash)

    threads = [threading.Thread(target=work) for _ in range(2)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 2 and found[0] == found[1]


def test_the_interpreter_is_free_while_a_run_goes_on():
    counted = []
    thread = threading.Thread(target=lambda: cl.run(short_case(steps=400)))
    thread.start()
    while thread.is_alive():
        counted.append(1)
        time.sleep(0.005)
    assert len(counted) > 5


def test_results_do_not_depend_on_threads(column):
    assert cl.run(column, threads=1).hash == cl.run(column, threads=2).hash
    with pytest.raises(ValueError, match="threads"):
        cl.run(column, threads=0)


def test_a_folder_in_use_is_refused_and_overwritten_on_request(tmp_path, column):
    cl.run(column, out=tmp_path / "run")
    with pytest.raises(cl.OutputError) as refused:
        cl.run(column, out=tmp_path / "run")
    assert refused.value.path == str(tmp_path / "run")
    cl.run(column, out=tmp_path / "run", overwrite=True)
    with pytest.raises(cl.OutputError):
        cl.run(column, out=tmp_path / "other", resume=True)


def test_a_folder_in_which_another_run_writes_is_refused(tmp_path, column):
    refusals = []

    def second(_frame):
        try:
            cl.run(column, out=tmp_path / "run", overwrite=True)
        except cl.OutputError as error:
            refusals.append(error)

    cl.run(column, out=tmp_path / "run", on_frame=second)
    assert refusals


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_is_an_output_error(tmp_path, column):
    out = tmp_path / "run"
    out.mkdir()
    (out / "measures.csv").symlink_to("/dev/full")
    with pytest.raises(cl.OutputError) as full:
        cl.run(column, out=out)
    assert "measures.csv" in str(full.value)


def test_warnings_of_a_run_have_codes_and_nothing_goes_to_standard_error(capfd, column):
    column.update({"materials.sand.density": 1.9})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        cl.run(column)
    found = [one.message for one in caught if isinstance(one.message, cl.ColluviumWarning)]
    assert found and all(one.code for one in found)
    assert os.path.basename(caught[0].filename) == os.path.basename(__file__)
    assert capfd.readouterr().err == ""


def test_a_fork_may_run_but_not_follow_a_run_of_its_parent(column):
    from colluvium import _native

    task = _native.Task.run(column.to_json(), column.folder, None, None, None, False, False, False, False)
    column.plan()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            column.plan()
            own = cl.run(column, threads=1).steps > 0
            try:
                task.wait(0.1)
            except RuntimeError as error:
                code = 0 if own and "forked" in str(error) else 2
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    while not task.is_finished():
        task.wait(0.1)
    assert task.result().steps > 0


def test_a_solver_error_has_step_time_point_and_the_part_of_the_run(column):
    @cl.law("breaks-late")
    class Breaks:
        calls = 0

        def wave_modulus(self, stress, state):
            return 1e6

        def update(self, strain, stress, state, dt):
            Breaks.calls += 1
            if Breaks.calls > 20000:
                raise ArithmeticError("broken")
            return stress + 1e6 * strain, {}

    column.update({"materials.sand": {"model": "external", "law": "breaks-late", "density": 2000}})
    with pytest.raises(cl.SolverError) as failed:
        cl.run(column)
    error = failed.value
    assert error.step > 0 and error.time > 0 and len(error.position) == 3
    assert isinstance(error.__cause__, ArithmeticError) and "broken" in str(error)
    assert len(error.result.frames) >= 1 and error.result.steps > 0 and error.code
    assert "frames/" not in str(error)
