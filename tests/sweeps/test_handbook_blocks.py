"""Blocks of the handbook that start a cluster run as a reader would run them."""

import subprocess

import pytest
from handbook import PAGES, blocks, environment

BLOCKS = [block for page in PAGES for block in blocks(page) if "sweep" in block.marks]


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.marks["sweep"])
def test_a_block_runs(block, tmp_path):
    done = subprocess.run(["bash", "-euc", block.text], cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, f"{block.text}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


def test_there_is_such_a_block():
    assert BLOCKS
