"""Kills at random moments: no finished run is lost or damaged, and the study that is finished at last is that of an undisturbed run.

`KILLS=200 pytest tests/sweeps/test_kills.py` kills 200 times each way.
"""

import contextlib
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from faulty_solvers import Scripted, plan, study

from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import read_run
from mpmverify.execution.runner import tasks_of

KILLS = int(os.environ.get("KILLS", "8"))
TESTS = Path(__file__).parent.parent
SOURCE = "from faulty_solvers import Scripted, study\n\nSTUDY = study(Scripted('dawdles'), Scripted('good'), levels=8)\n"
PASSING = ("date_created", "history", "id", "checksum", "run_started", "run_before_started")
"""Attributes that say when a file was written, and the checksum over them."""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "killed_study.py").write_text(SOURCE)
    return tmp_path


def command(folder: Path, out: str, *options: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "mpmverify", "run", "killed_study.py:STUDY", "--out", out, *options],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(TESTS)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )


def session(leader: int) -> list[int]:
    """Processes of a session, those that work first."""
    listed = subprocess.run(["ps", "-s", str(leader), "-o", "pid="], capture_output=True, text=True, check=False).stdout
    return sorted(map(int, listed.split()), reverse=True)


def checksums(out: Path) -> dict[str, str]:
    """Checksum of each stored run by key; a run that cannot be read raises."""
    keys = (task.key for task in tasks_of(study(Scripted("dawdles"), Scripted("good"), levels=8), plan(out)))
    return {key: read_run(Results(out).run(key), key).checksum(key) for key in keys if Results(out).run(key).exists()}


def content(path: Path) -> dict[str, xr.Dataset]:
    """Everything that a file of a study holds, but when it was written, and what changed since the run before: it may have been killed."""
    with xr.open_datatree(path) as tree:
        found = {node.path: node.to_dataset().drop_dims("change", errors="ignore").load() for node in tree.subtree}
    for dataset in found.values():
        dataset.attrs = {name: value for name, value in dataset.attrs.items() if name not in PASSING}
    return found


def own_lines(said: str) -> list[str]:
    """Lines of tracebacks that are in the package. A process that multiprocessing was starting when its parent was killed prints others."""
    lines = [line for line in said.splitlines() if line.lstrip().startswith('File "')]
    return [line for line in lines if "/mpmverify/" in line and "/multiprocessing/" not in line]


def finished(folder: Path, out: str, *options: str) -> None:
    process = command(folder, out, *options)
    said, _ = process.communicate()
    assert process.returncode == 0, said


def disturbed(folder: Path, victims, *options: str) -> int:
    """Run until it is finished, with kills meanwhile; return how many processes were killed."""
    chance, kills, before = random.Random(KILLS), 0, {}
    finished(folder, "undisturbed")
    expected, whole = checksums(folder / "undisturbed"), content(folder / "undisturbed" / "scripted.nc")
    while kills < KILLS:
        out = f"killed-{kills}"
        while kills < KILLS:
            process = command(folder, out, *options)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(chance.uniform(0.3, 3.5))
            if process.poll() is not None:
                break
            victim = chance.choice(victims(process))
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
                kills += 1
            if victim == process.pid or chance.random() < 0.5:
                process.kill()
            said, _ = process.communicate()
            assert not own_lines(said), said
            after = checksums(folder / out)
            assert before.items() <= after.items(), "a finished run is lost"
            assert after.items() <= expected.items(), "a stored run differs from that of an undisturbed run"
            before = after
        victims(process)  # whoever is dead is brought back
        finished(folder, out, *options)
        before = {}
        assert checksums(folder / out) == expected
        found = content(folder / out / "scripted.nc")
        assert found.keys() == whole.keys()
        for path, dataset in found.items():
            xr.testing.assert_identical(dataset, whole[path])
    return kills


def test_kills_of_processes_lose_nothing_that_is_finished(folder):
    assert disturbed(folder, lambda process: session(process.pid), "--jobs", "2") >= KILLS


class Workers:
    """Workers of a dask scheduler without guardians, which give up after some kills: this class starts a new one for each that is dead."""

    def __init__(self, address: str, folder: Path, count: int = 2) -> None:
        self.address, self.folder = address, folder
        self.processes = [self.start() for _ in range(count)]

    def start(self) -> subprocess.Popen:
        options = ["--no-nanny", "--nthreads", "1", "--no-dashboard", "--local-directory", str(self.folder)]
        command = [sys.executable, "-m", "distributed.cli.dask_worker", self.address, *options]
        return subprocess.Popen(command, stderr=subprocess.DEVNULL)

    def pids(self) -> list[int]:
        self.processes = [one if one.poll() is None else self.start() for one in self.processes]
        return [one.pid for one in self.processes]

    def stop(self) -> None:
        for one in self.processes:
            one.kill()
            one.wait()


def test_kills_over_dask_lose_nothing_that_is_finished(folder, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setenv("PYTHONPATH", str(folder))
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as cluster:
        workers = Workers(cluster.scheduler_address, folder)
        try:
            found = disturbed(folder, lambda process: [process.pid, *workers.pids()], "--scheduler", cluster.scheduler_address)
        finally:
            workers.stop()
    assert found >= KILLS
