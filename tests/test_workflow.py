"""The workflow that the handbook offers: its shape, and that the command line takes what it calls."""

import re
import shlex
from pathlib import Path

import click
import pytest
import yaml
from handbook import FOLDER, blocks

from mpmverify import cli

(WORKFLOW,) = (block.text for block in blocks(FOLDER / "ci.md") if "workflow" in block.marks)
COMMANDS = [shlex.split(line) for line in re.findall(r"^ *(?:- )?run: (mpmverify .*)$", WORKFLOW, re.MULTILINE)]


def steps():
    """Keys and values of each step, as far as they stand on its own level."""
    return [
        dict(re.findall(r"^(?: {6}- | {8})([\w-]+): ?(.*?)(?:  #.*)?$", step, re.MULTILINE))
        for step in re.split(r"(?=^ {6}- )", WORKFLOW, flags=re.MULTILINE)[1:]
    ]


def parsed(arguments: list[str]) -> click.Context:
    """Context of a command that is parsed and not run."""
    name, *rest = arguments
    return cli.cli.commands[name].make_context(name, rest)


def test_the_workflow_is_yaml():
    body = yaml.safe_load(WORKFLOW)
    assert set(body) == {"name", True, "permissions", "jobs"}, "YAML takes `on` for true, and GitHub does not"
    (job,) = body["jobs"].values()
    assert [{key: str(value) for key, value in step.items() if key not in ("with",)} for step in job["steps"]] == [
        {key: value for key, value in step.items() if key != "with"} for step in steps()
    ]


def test_the_workflow_is_indented_by_spaces_in_twos():
    for line in WORKFLOW.splitlines():
        assert "\t" not in line
        assert (len(line) - len(line.lstrip(" "))) % 2 == 0, line
        assert re.match(r" *(- )?[\w-]+:|[ ]+!?results", line), line


def test_the_workflow_solves_then_gates_even_after_a_failure_and_uploads():
    done = steps()
    assert all(("uses" in step) is not ("run" in step) for step in done)
    order = [(step.get("uses") or step["run"]).split("@")[0].split(" --")[0] for step in done]
    assert order == [
        "actions/checkout",
        "actions/setup-python",
        "python -m pip install -e .",
        "actions/cache",
        "mpmverify run",
        "mpmverify gate",
        "actions/upload-artifact",
    ]
    assert [step.get("if", "") for step in done[-2:]] == ["${{ !cancelled() }}"] * 2
    assert not any("continue-on-error" in step or "|| true" in step.get("run", "") for step in done)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_the_command_line_takes_every_command_of_the_workflow(command):
    program, *arguments = command
    assert program == "mpmverify"
    assert parsed(arguments).params["out"] == Path("results")
    with pytest.raises(click.ClickException):
        parsed([*arguments, "--no-such-option"])


def test_the_workflow_runs_and_gates():
    assert [command[1] for command in COMMANDS] == ["run", "gate"]
