"""A file is written whole or not at all."""

import os
import resource
import signal
import stat
import subprocess
import sys

import numpy as np
import pytest
from stored_results import run_of, solution

from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import write_run

# Atomic writing.


def test_a_writer_that_fails_leaves_nothing(tmp_path):
    def write(temporary):
        temporary.write_text("half")
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_atomic(tmp_path / "new" / "k.nc", write)
    assert list((tmp_path / "new").iterdir()) == []


def test_a_writer_that_fails_leaves_the_existing_file(tmp_path):
    path = tmp_path / "k.nc"
    write_run(path, "k", run_of(solution()), "title")
    before = path.read_bytes()
    with pytest.raises(KeyError):
        write_run(path, "k", run_of(solution(histories={"mass": np.ones(3)})), "title")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_readers_never_see_half_a_file(tmp_path):
    path = tmp_path / "k.nc"

    def write(temporary):
        temporary.write_text("half")
        assert not path.exists()
        assert temporary.parent == path.parent, "a move within one file system is atomic"
        assert Results(tmp_path).studies() == [], "a file that is being written is not listed as a study"
        temporary.write_text("whole")

    write_atomic(path, write)
    assert path.read_text() == "whole"


def test_the_temporary_file_of_a_killed_writer_is_not_listed_as_a_study(tmp_path):
    program = (
        "import sys, time; from pathlib import Path; from mpmverify.atomic import write_atomic\n"
        "def write(temporary):\n    temporary.write_text('half'); print('writing', flush=True); time.sleep(60)\n"
        "write_atomic(Path(sys.argv[1]), write)"
    )
    process = subprocess.Popen([sys.executable, "-c", program, str(tmp_path / "s.nc")], stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not (tmp_path / "s.nc").exists()
    assert Results(tmp_path).studies() == []


def test_a_result_has_the_permissions_of_other_files(tmp_path):
    (tmp_path / "other").write_text("")
    write_run(tmp_path / "k.nc", "k", run_of(solution()), "title")
    assert stat.S_IMODE((tmp_path / "k.nc").stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a limit on the size of files")
def test_a_full_disk_raises_an_error_that_names_the_file(tmp_path):
    large = solution(fields={"u": np.random.default_rng(0).random((5, 8, 20000))})
    path, said = tmp_path / "k.nc", tmp_path / "said"
    said.touch()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))
        try:
            write_run(path, "k", run_of(large), "title")
        except BaseException as error:
            said.write_text(f"{type(error).__name__}: {error}")
        os._exit(0)
    os.waitpid(child, 0)
    assert said.read_text().startswith(f"ResultsError: cannot write '{path}' (")
    assert list(tmp_path.iterdir()) == [said]
