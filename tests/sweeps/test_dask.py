"""Dask workers: runs have the limits and safeguards of processes, and the loss of a worker or a scheduler loses nothing finished."""

import logging
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from faulty_solvers import Scripted, plan, study

from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import read_run
from mpmverify.errors import UsageError
from mpmverify.execution import dask
from mpmverify.execution import processes as pool
from mpmverify.execution.dask import Distributed
from mpmverify.execution.runner import run, tasks_of

distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
TESTS = Path(__file__).parent.parent
BEHAVIOURS = ("dies", "hangs", "raises", "leaves", "good", "unstable")


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


def test_outcomes_are_those_of_processes(cluster, tmp_path):
    declared = study(*map(Scripted, BEHAVIOURS), levels=1)
    there, here = (tasks_of(declared, plan(tmp_path / name)) for name in ("dask", "processes"))
    by_dask = {task.key: evaluated for task, evaluated in Distributed(cluster.scheduler_address, 2.0).evaluate(there)}
    by_processes = {task.key: evaluated for task, evaluated in pool.over_processes(here, 2, 2.0)}
    assert len(by_dask) == len(BEHAVIOURS)
    for task in here:
        one, other = by_dask[task.key], by_processes[task.key]
        assert (repr(one.level), one.solved, one.run) == (repr(other.level), other.solved, None)
        files = [Results(tmp_path / name).run(task.key) for name in ("dask", "processes")]
        assert len({file.exists() for file in files}) == 1
        if files[0].exists():
            assert len({read_run(file, task.key).checksum(task.key) for file in files}) == 1


def test_a_study_has_the_same_verdicts_and_a_second_run_sends_nothing(cluster, tmp_path):
    there = plan(tmp_path / "dask", scheduler=cluster.scheduler_address)
    (by_dask,), (by_processes,) = run([study()], there), run([study()], plan(tmp_path / "processes"))
    assert by_dask.findings == by_processes.findings
    assert by_dask.solved == by_processes.solved > 0
    (tmp_path / "dask" / "verdicts.json").unlink(missing_ok=True)
    tasks = tasks_of(study(), there)
    assert all(not evaluated.solved for _, evaluated in Distributed("tcp://127.0.0.1:1", 2.0).evaluate(tasks)), (
        "nobody is asked"
    )


def test_a_scheduler_without_workers_is_said_and_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(dask, "ALONE", 2)
    said = []
    with distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=None) as alone:
        monkeypatch.setattr(
            logging.getLogger("mpmverify"), "warning", lambda text, *parts: (said.append(text % parts), alone.scale(1))
        )
        found = list(Distributed(alone.scheduler_address, 20.0).evaluate(tasks_of(study(), plan(tmp_path))))
    assert found
    assert all(evaluated.level.outcome == "completed" for _, evaluated in found)
    assert said == [
        f"The dask scheduler at '{alone.scheduler_address}' has no worker: the runs wait for one. "
        f"Start it with `dask worker {alone.scheduler_address}`."
    ]


def test_a_worker_sees_no_results_folder(tmp_path):
    (task, *_) = tasks_of(study(Scripted()), plan(tmp_path))
    sent = dask.pickle.loads(dask._packed(task))
    assert (task.results, sent.results) == (tmp_path, None)


def test_a_lost_worker_loses_no_run(cluster, tmp_path):
    """Both processes of dask are killed while they work: their runs are done by the processes that take their place."""
    declared = study(Scripted("dawdles"), levels=8)
    tasks = tasks_of(declared, plan(tmp_path))
    with distributed.Client(cluster.scheduler_address) as client:
        before = set(client.run(os.getpid).values())
    evaluated = []
    for task, result in Distributed(cluster.scheduler_address, 20.0).evaluate(tasks):
        if not evaluated:
            for process in before:
                os.kill(process, signal.SIGKILL)
        evaluated.append((task.index, result.level.outcome))
    assert sorted(evaluated) == [(k, "completed") for k in range(len(tasks))]
    assert all(Results(tmp_path).run(task.key).exists() for task in tasks)


def test_a_killed_worker_leaves_no_run_behind(cluster, tmp_path):
    """The process of a run that hangs ends when its dask worker is killed."""
    journal = tmp_path / "journal"
    tasks = tasks_of(study(Scripted("hangs", journal=str(journal)), levels=1), plan(tmp_path))
    with distributed.Client(cluster.scheduler_address) as client:
        future = client.submit(dask.solve_apart, dask._packed(tasks[0]), sys.path, 60.0, "killed", pure=False)
        while not journal.exists():
            assert not future.done(), future.exception()
            time.sleep(0.05)
        parents = set(client.run(os.getpid).values())
        left = children(parents)
        assert left
        future.cancel()
        for parent in parents:
            os.kill(parent, signal.SIGKILL)
    deadline = time.monotonic() + 60
    while any(map(running, left)):
        assert time.monotonic() < deadline, "the run goes on"
        time.sleep(0.05)


def children(parents: set[int]) -> set[int]:
    """Processes that solve runs for some dask workers."""
    listed = subprocess.run(["ps", "-eww", "-o", "ppid=,pid=,args="], capture_output=True, text=True, check=True)
    rows = [line.split(None, 2) for line in listed.stdout.splitlines()]
    return {int(pid) for parent, pid, command in rows if int(parent) in parents and "spawn_main" in command}


def running(process: int) -> bool:
    """Whether a process is there, and is no zombie."""
    shown = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True, check=False).stdout
    return bool(shown) and not shown.startswith("Z")


def scheduler(port: int) -> subprocess.Popen:
    return started("scheduler", "--port", str(port), "--no-dashboard", "--host", "127.0.0.1")


def worker(port: int, folder: Path) -> subprocess.Popen:
    return started("worker", f"tcp://127.0.0.1:{port}", "--nthreads", "1", "--no-dashboard", "--local-directory", str(folder))


def started(*command: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_" + command[0], *command[1:]],
        env=os.environ | {"PYTHONPATH": str(TESTS)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.fixture
def processes():
    """Processes that are ended at last."""
    running: list[subprocess.Popen] = []
    yield running
    for process in running:
        process.terminate()
    for process in running:
        process.wait()


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_a_scheduler_that_starts_again_loses_no_run(processes, tmp_path):
    port = free_port()
    processes += [scheduler(port), worker(port, tmp_path)]
    tasks = tasks_of(study(Scripted("dawdles"), levels=8), plan(tmp_path))
    evaluated = []
    for task, result in Distributed(f"tcp://127.0.0.1:{port}", 20.0).evaluate(tasks):
        evaluated.append((task.index, result.level.outcome))
        if len(evaluated) == 2:
            processes[0].kill()
            processes[0].wait()
            processes += [scheduler(port), worker(port, tmp_path)]
    assert sorted(evaluated) == [(k, "completed") for k in range(len(tasks))]


def test_a_scheduler_that_is_gone_keeps_what_is_finished(processes, tmp_path, monkeypatch):
    monkeypatch.setattr(dask, "PATIENCE", 5)
    port = free_port()
    processes += [scheduler(port), worker(port, tmp_path)]
    tasks = tasks_of(study(Scripted("dawdles"), levels=8), plan(tmp_path))
    finished = []

    def until_it_is_gone():
        for task, _ in Distributed(f"tcp://127.0.0.1:{port}", 20.0).evaluate(tasks):
            finished.append(task)
            processes[0].kill()

    with pytest.raises(UsageError, match="does not answer any more: start it and run the same command again"):
        until_it_is_gone()
    assert finished
    assert all(Results(tmp_path).run(task.key).exists() for task in finished)


def test_a_scheduler_that_never_was_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(dask, "PATIENCE", 0.5)
    with pytest.raises(UsageError, match=r"no dask scheduler answers at 'tcp://127\.0\.0\.1:1'"):
        list(run([study()], plan(tmp_path, scheduler="tcp://127.0.0.1:1")))


def test_a_scheduler_without_dask_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"--scheduler needs dask\.distributed: pip install 'mpmverify\[distributed\]'"):
        list(run([study()], plan(tmp_path, scheduler="tcp://nowhere:1")))


def test_a_worker_with_other_code_is_refused(cluster, tmp_path):
    """Its results would be stored as those of the code here."""
    tasks = [replace(task, key="0" * 64) for task in tasks_of(study(), plan(tmp_path))]
    with pytest.raises(UsageError, match="a dask worker has another version of the solver"):
        list(Distributed(cluster.scheduler_address, 20.0).evaluate(tasks))
    assert not list((tmp_path / "runs").glob("*"))


def test_a_worker_that_cannot_import_the_solver_says_what_to_do(cluster, tmp_path, monkeypatch):
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "owncode.py").write_text("from faulty_solvers import Scripted\n\n\nclass Own(Scripted):\n    pass\n")
    monkeypatch.syspath_prepend(folder)
    import owncode

    tasks = tasks_of(study(owncode.Own()), plan(tmp_path))
    there = Distributed(cluster.scheduler_address, 20.0)
    assert all(result.level.outcome == "completed" for _, result in there.evaluate(tasks[:1])), (
        "the folder is named to the worker"
    )
    shutil.rmtree(folder)
    with distributed.Client(cluster.scheduler_address) as client:
        client.restart()
    with pytest.raises(UsageError, match="a dask worker cannot import what it must run"):
        list(there.evaluate(tasks[1:]))


class Unsendable(Scripted):
    def __reduce__(self):
        raise TypeError("it holds an open file")


def test_a_solver_that_cannot_be_pickled_is_named(cluster, tmp_path):
    with pytest.raises(
        UsageError, match=r"cannot be sent to a worker .it holds an open file.: define the class at the top of a"
    ):
        list(Distributed(cluster.scheduler_address, 20.0).evaluate(tasks_of(study(Unsendable()), plan(tmp_path))))


@pytest.mark.parametrize(
    ("raised", "outcome"), [(CancelledError(), None), (OSError(), None), (ValueError("torn"), "crashed; ValueError: torn")]
)
def test_a_result_that_cannot_be_read_fails_and_one_that_was_lost_is_sent_again(tmp_path, raised, outcome):
    def result():
        raise raised

    (task, *_) = tasks_of(study(), plan(tmp_path))
    future = SimpleNamespace(cancelled=lambda: False, exception=lambda: None, result=result)
    found = Distributed("", 1.0)._evaluated(task, future)
    assert found is None if outcome is None else found.level.outcome.startswith(outcome)
