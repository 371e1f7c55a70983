"""Disk cache of the compiled time loop: shared by all processes, also by those that start at the same time."""

import json
import os
import subprocess
import sys

SOLVE = """
import json
import numba
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation
from mpmverify.solvers.mpm import MaterialPoint, loop, solver

def threads_are_started():
    try:
        return bool(numba.threading_layer())
    except ValueError:
        return False

problem, found = axial_vibration().problem, []
for solver.MANY in (10**9, 0):  # in one thread, then in several
    solution = MaterialPoint("USL").solve(problem, Discretisation(problem.lengths[0] / 64, 0.3, 2))
    found.append([str(solution.outcome.status), float(abs(solution.fields["stress"]).sum()).hex(), threads_are_started()])
counts = [(one.from_disk, one.made) for one in (loop.march, loop.march_in_threads)]
print(json.dumps([found, *counts]))
"""


def started(cache):
    command = [sys.executable, "-c", SOLVE]
    settings = {"NUMBA_CACHE_DIR": str(cache)}
    return subprocess.Popen(command, env=os.environ | settings, stdout=subprocess.PIPE, text=True)


def said(process):
    output, _ = process.communicate()
    assert process.returncode == 0
    return json.loads(output)


def test_processes_that_start_together_agree_and_a_later_one_compiles_nothing(tmp_path):
    together = [started(tmp_path) for _ in range(2)]
    found = [said(process) for process in together]
    results, *hits_and_misses = said(started(tmp_path))
    assert [one[0] for one in found] == [results] * 2
    assert [status for status, _, _ in results] == ["completed"] * 2
    assert [threads for _, _, threads in results] == [False, True], (
        "a run in one thread starts no threads, so that the process can still fork"
    )
    assert hits_and_misses == [[1, 0], [1, 0]], "both loops are loaded from the disk and not compiled"
