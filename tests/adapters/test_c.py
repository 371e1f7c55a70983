"""The program in C that `mpmverify new bench` writes, on a shipped case: it holds what its `bench.toml` declares."""

import shutil
import subprocess
from importlib.resources import files

import pytest
from page_of_codes import agree

from mpmverify.adapters.bench_file import read_bench

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


def test_the_program_in_c_holds_what_its_bench_file_declares(tmp_path, verify):
    start = files("mpmverify.adapters").joinpath("templates")
    for name in ("bench.toml", "mpm.c"):
        (tmp_path / name).write_text(start.joinpath(name).read_text("utf-8"), encoding="utf-8")
    subprocess.run(["cc", "-O2", "-o", "mpm", "mpm.c", "-lm"], cwd=tmp_path, check=True)
    findings = verify(read_bench(tmp_path / "bench.toml"), study="generalised-vortex", case="0.05 rad")
    agree("generalised-vortex, 0.05 rad", "c-mpm", findings)
