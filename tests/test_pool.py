"""Worker processes: a run that crashes, hangs or exits disturbs no other run, and no process is left running."""

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from collections import deque
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from faulty_solvers import Scripted, Unreadable, plan, study

from mpmverify.adapters.bisection import Bisection
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError, UsageError
from mpmverify.execution import processes as pool
from mpmverify.execution.runner import tasks_of
from mpmverify.execution.workers import Crew, Worker

TESTS = Path(__file__).parent
pytestmark = pytest.mark.skipif(not shutil.which("ps"), reason="needs ps to list the processes that are left")


def children() -> set[int]:
    """Child processes of this process, zombies included, without the resource trackers of multiprocessing."""
    listed = subprocess.run(
        ["ps", "-ww", "--ppid", str(os.getpid()), "-o", "pid=,args="], capture_output=True, text=True, check=False
    )
    lines = [line.strip().split(None, 1) for line in listed.stdout.splitlines()]
    return {int(pid) for pid, command in lines if "spawn_main" in command or "<defunct>" in command}


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory):
    """Outcome by solver, over two processes, of runs that exit, hang, raise, cannot be unpickled or succeed."""
    path = tmp_path_factory.mktemp("pool")
    solvers = [Scripted(behaviour) for behaviour in ("dies", "hangs", "raises", "leaves", "good", "unstable")]
    tasks = tasks_of(study(*solvers, Unreadable("nan"), levels=1), plan(path))
    before = children()
    started = time.monotonic()
    found = {task.solver.name: evaluated for task, evaluated in pool.over_processes(tasks, 2, timeout=2.0)}
    return path, tasks, found, time.monotonic() - started, children() - before


def test_every_run_has_an_outcome(outcomes):
    _, tasks, found, elapsed, _ = outcomes
    assert found.keys() == {task.solver.name for task in tasks}
    assert elapsed < 60, "the run that hangs delays no other run"


@pytest.mark.parametrize(
    ("behaviour", "outcome"),
    [
        ("dies", "crashed; the process died with exit status 3; "),
        ("hangs", "timed out; no result within 2 s; the run exceeded its time limit: raise the limit"),
        ("raises", "crashed; ZeroDivisionError: a mass of [/zero] at node 3 ? (faulty_solvers.py:"),
        ("leaves", "crashed; SystemExit: 7 (faulty_solvers.py:"),
        ("nan", "crashed; ModuleNotFoundError: no module named 'nowhere'; "),
        ("unstable", "unstable; at step 3; "),
        ("good", "completed"),
    ],
)
def test_the_outcome_has_the_reason_of_the_failure(outcomes, behaviour, outcome):
    assert outcomes[2][f"scripted-{behaviour}"].level.outcome.startswith(outcome)


def test_every_run_has_its_seconds(outcomes):
    seconds = {name: evaluated.seconds for name, evaluated in outcomes[2].items()}
    assert seconds["scripted-hangs"] == 2.0, "the time limit"
    assert all(0 < seconds[f"scripted-{name}"] < 2 for name in ("raises", "leaves", "good", "unstable"))


def test_only_runs_that_returned_a_solution_are_stored(outcomes):
    path, tasks, found, _, _ = outcomes
    stored = {task.solver.name for task in tasks if Results(path).run(task.key).exists()}
    assert stored == {"scripted-good", "scripted-unstable"}
    assert [file for file in (path / "runs").iterdir() if file.name.startswith(".")] == []
    assert all(evaluated.solved for evaluated in found.values())


def test_no_process_is_left_running(outcomes):
    assert outcomes[4] == set()


def test_a_damaged_file_is_an_error_of_the_caller_and_ends_the_workers(tmp_path):
    before = children()
    tasks = tasks_of(study(Scripted("hangs"), Scripted(), levels=1), plan(tmp_path))
    damaged = Results(tmp_path).run(tasks[1].key)
    damaged.parent.mkdir(parents=True)
    damaged.write_text("notes")
    with pytest.raises(ResultsError, match=damaged.name):
        list(pool.over_processes(tasks, 2, timeout=60.0))
    assert children() == before
    assert damaged.read_text() == "notes"


def test_a_result_that_arrives_while_the_caller_is_busy_is_not_timed_out(tmp_path):
    tasks = tasks_of(study(Scripted("dawdles"), levels=4), plan(tmp_path))
    outcomes = []
    for _, evaluated in pool.over_processes(tasks, 2, timeout=0.9):
        outcomes.append(evaluated.level.outcome)
        time.sleep(1.0)
    assert outcomes == ["completed"] * 4


@pytest.mark.parametrize("script", ["<stdin>", "unguarded.py"])
def test_a_script_that_workers_cannot_import_is_one_error(tmp_path, script):
    text = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from pathlib import Path\nfrom faulty_solvers import plan, study\nfrom mpmverify.execution import processes as pool\n"
        "from mpmverify.execution.runner import tasks_of\n"
        f"list(pool.over_processes(tasks_of(study(), plan(Path({str(tmp_path)!r}))), 1, 60.0))\n"
    )
    command = [sys.executable, "-"]
    if script != "<stdin>":
        (tmp_path / script).write_text(text)
        command = [sys.executable, tmp_path / script]
    done = subprocess.run(command, input=text, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert (
        done.stderr.count("a worker process ended before it began, with exit status 1: a script must keep what it does under")
        == 1
    )
    assert done.stderr.count("Traceback") <= 4


def test_a_time_limit_longer_than_the_system_can_wait_is_no_limit(tmp_path):
    ((_, evaluated),) = pool.over_processes(tasks_of(study(levels=1), plan(tmp_path)), 1, timeout=1e300)
    assert evaluated.level.outcome == "completed"


def test_closing_the_iteration_early_ends_the_workers(tmp_path):
    before = children()
    results = pool.over_processes(tasks_of(study(Scripted(), Scripted("hangs")), plan(tmp_path)), 1, timeout=60.0)
    next(results)
    assert children() > before
    results.close()
    assert children() == before


def test_a_solver_that_cannot_be_pickled_is_an_error_and_ends_the_workers(tmp_path):
    @dataclass(frozen=True)
    class Local(Scripted):
        pass

    before = children()
    tasks = tasks_of(study(Scripted(), levels=1), plan(tmp_path))
    tasks = [tasks[0], replace(tasks[0], solver=Local())]
    with pytest.raises(UsageError, match=r"cannot be sent to a worker process .*: define the class at the top of a module$"):
        list(pool.over_processes(tasks, 1, timeout=60.0))
    assert children() == before


@dataclass(frozen=True)
class Compiling(Scripted):
    """Solver whose `kernel` returns what a test gives it."""

    compiles: object = None

    @property
    def name(self):
        return f"compiling-{self.compiles}-{self.order:g}"

    def kernel(self, problem):
        return self.compiles[problem.dimension - 1] if isinstance(self.compiles, tuple) else self.compiles


def test_a_kernel_that_another_worker_compiles_is_taken_last(tmp_path):
    solvers = [Compiling(compiles=(kernel,), order=order) for kernel in ("b", "a") for order in (1.0, 2.0)]
    tasks = tasks_of(study(*solvers, Scripted(), levels=1), plan(tmp_path))
    waiting = pool.Waiting(replace(task, study=name) for name in ("one", "two") for task in tasks)
    taken = [
        waiting.take(mine, {"one", "two"}, compiling)
        for mine, compiling in (
            ("one", set()),
            ("two", {"b"}),
            ("two", {"b", "a"}),
            ("two", {"b", "a"}),
            ("two", {"b", "a"}),
            ("", set()),
        )
    ]
    assert [(task.study, task.kernel) for task in taken] == [
        ("one", "b"),
        ("two", "a"),
        ("two", None),
        ("one", None),
        ("two", "b"),
        ("one", "b"),
    ]


@pytest.mark.parametrize("compiles", [[], (), [1]], ids=["list", "raises", "unhashable"])
def test_a_kernel_that_raises_or_is_not_hashable_is_an_error(tmp_path, compiles):
    tasks = tasks_of(study(Compiling(compiles=compiles), levels=1), plan(tmp_path))
    with pytest.raises(UsageError, match=r"let kernel\(problem\) return a hashable value"):
        list(pool.over_processes(tasks * 2, 2, timeout=10.0))


def test_an_attribute_kernel_that_is_not_a_method_is_ignored(tmp_path):
    (task,) = tasks_of(study(Scripted(), levels=1), plan(tmp_path))
    smoothed = replace(task, solver=type("Smoothed", (), {"name": "smoothed", "kernel": "gaussian"})())
    assert smoothed.kernel is None
    assert Bisection(smoothed.solver).kernel(task.problem.problem) is None


def test_no_tasks_start_no_process(tmp_path):
    before = children()
    assert list(pool.over_processes([], 4, timeout=1.0)) == []
    assert children() == before


INTERRUPTED = """
import signal
import sys
from pathlib import Path
from types import SimpleNamespace
from faulty_solvers import Scripted, plan, study
from mpmverify.execution.runner import run

def say(study, done, total):
    print(done, flush=True)

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # background processes ignore SIGINT by default
    declared = study(Scripted("hangs", below=0.04), Scripted(below=0.0))
    list(run([declared], plan(Path(sys.argv[1]), jobs=2, timeout=600.0), say))
"""


FIRST = """
import multiprocessing, signal

from mpmverify.execution.workers import no_interrupt

if __name__ == "__main__":
    with no_interrupt():
        first = multiprocessing.get_context("spawn").Process(target=print)
        first.start()
        print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))
    first.join()
"""


def test_an_interrupt_stays_held_back_when_the_first_process_starts(tmp_path):
    """The first process starts the resource tracker of multiprocessing, which lets interrupts through again."""
    script = tmp_path / "first.py"
    script.write_text(FIRST)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True"], done.stderr


def test_an_interrupt_ends_the_workers_and_keeps_what_is_finished(tmp_path):
    """The signal goes to the whole process group, as from a terminal."""
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    process = subprocess.Popen(
        [sys.executable, script, tmp_path / "results"],
        env=os.environ | {"PYTHONPATH": str(TESTS)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if int(line) == 5:  # only the run that hangs is left
            break
    listed = subprocess.run(["ps", "-s", str(process.pid), "-o", "pid="], capture_output=True, text=True, check=True)
    assert len(listed.stdout.split()) >= 3, "the parent and its workers"
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=300)
    assert process.returncode != 0
    assert "KeyboardInterrupt" in errors
    assert errors.count("Traceback") == 1, f"the workers print no traceback: {errors}"
    deadline = time.monotonic() + 300  # the resource tracker of multiprocessing ends shortly after its parent
    while subprocess.run(["ps", "-s", str(process.pid), "-o", "pid="], capture_output=True, check=False).stdout.strip():
        assert time.monotonic() < deadline, "a process is still running"
        time.sleep(0.05)

    declared = study(Scripted("hangs", below=0.04), Scripted(below=0.0))
    tasks = tasks_of(declared, plan(tmp_path / "results"))
    stored = [task for task in tasks if Results(tmp_path / "results").run(task.key).exists()]
    assert len(stored) == 5
    assert not (tmp_path / "results" / "scripted.nc").exists()


def test_no_process_can_solve_nothing(tmp_path):
    with pytest.raises(UsageError, match="0 worker processes can solve nothing"):
        list(pool.over_processes(tasks_of(study(levels=1), plan(tmp_path)), 0, timeout=60.0))


def test_a_process_that_died_while_idle_is_replaced_and_its_next_task_is_done():
    worker = Worker(Crew(abs, lambda task, failure, reason: reason, 60.0))
    try:
        worker.start(-1)
        while (finished := worker.receive()) is None:
            pass
        assert finished == (-1, 1)
        worker.process.kill()
        worker.process.join()
        worker.start(-2)
        while (finished := worker.receive()) is None:
            pass
        assert finished == (-2, 2)
    finally:
        worker.stop()


def test_a_process_that_cannot_start_says_why_and_leaves_the_others_to_be_ended():
    def refuse():
        raise OSError("no more processes")

    refusing = SimpleNamespace(Pipe=multiprocessing.Pipe, Process=lambda **_: SimpleNamespace(start=refuse))
    tasks = iter([1, 2])
    crew = Crew(abs, lambda task, failure, reason: reason, 60.0, context=refusing)
    with pytest.raises(OSError, match="no more processes"):
        list(crew.results(lambda worker, workers: next(tasks, None), 2))


def disturbing(task: str) -> tuple:
    """State of the process as a task finds it, which it then changes."""
    found = (
        os.getcwd(),
        os.environ.get("OF_A_TASK"),
        np.random.get_state()[1].tolist(),  # noqa: NPY002
        np.geterr(),
        len(warnings.filters),
        list(sys.path),
    )
    os.chdir("/")
    os.environ["OF_A_TASK"] = task
    np.random.seed(3)  # noqa: NPY002
    np.seterr(all="ignore")
    warnings.simplefilter("ignore")
    sys.path.insert(0, task)
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, lambda *_: os._exit(9))
        signal.setitimer(signal.ITIMER_REAL, 0.05)
    return found


def test_what_a_task_does_to_its_process_the_next_does_not_see():
    waiting = deque(["first", "second", "third"])
    crew = Crew(disturbing, lambda task, failure, reason: reason, 60.0)
    found = [result for _, result in crew.results(lambda worker, workers: waiting.popleft() if waiting else None, 1)]
    assert len(found) == 3
    assert found[0] == found[1] == found[2], "in one process, one after the other"


@pytest.mark.parametrize("chosen", ["", "7"])
def test_processes_share_the_processors_unless_the_user_has_chosen(chosen, monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    if chosen:
        monkeypatch.setenv("OMP_NUM_THREADS", chosen)
    monkeypatch.setattr(pool, "processors", lambda: 8)
    assert pool._threads(3).get("OMP_NUM_THREADS") == (None if chosen else "2")
    assert pool._threads(16).get("OMP_NUM_THREADS") == (None if chosen else "1")
