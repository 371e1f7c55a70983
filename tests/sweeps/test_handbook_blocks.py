"""Blocks of the handbook that start a cluster run as a reader would run them."""

import contextlib
import os
import signal
import subprocess

import pytest
from handbook import PAGES, blocks, environment

BLOCKS = [block for page in PAGES for block in blocks(page) if "sweep" in block.marks]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.marks["sweep"])
def test_a_block_runs(block, tmp_path):
    """What a block that fails has started, and what writes to its output, ends with it."""
    with (tmp_path / "said").open("w") as said:
        shell = subprocess.Popen(
            ["bash", "-euc", block.text], cwd=tmp_path, env=environment(), stdout=said, stderr=said, start_new_session=True
        )
        status = shell.wait()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(shell.pid, signal.SIGKILL)
    assert status == 0, f"{block.text}\n{(tmp_path / 'said').read_text(encoding='utf-8')[-3000:]}"


def test_there_is_such_a_block():
    assert BLOCKS
