"""The workflow that the README offers: its shape, and that the command line takes what it calls."""

import re
import shlex
from pathlib import Path

import click
import pytest
import yaml

from mpmverify import cli, studies
from mpmverify.execution.verify import verify

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")
(WORKFLOW,) = re.findall(r"<!-- workflow -->\n```yaml\n(.*?)```", README, re.DOTALL)
COMMANDS = [shlex.split(line) for line in re.findall(r"^ *(?:- )?run: (mpmverify .*)$", WORKFLOW, re.MULTILINE)]


PYTHON = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
ALONE = [block for block in PYTHON if "results/" not in block and "(verify)" not in block]
"""What needs neither the results of a run nor a solver of the reader's own."""


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


(NAME, FILE) = re.search(r"<!-- file: (\S+) -->\n```python\n(.*?)```", README, re.DOTALL).groups()


def test_the_solver_that_the_readme_shows_passes_by_the_command_that_it_gives(pytester):
    (command,) = re.findall(rf"`(pytest {NAME})`", README)
    pytester.path.joinpath(NAME).write_text(FILE, encoding="utf-8")
    pytester.runpytest_subprocess(*command.split()[1:]).assert_outcomes(passed=1)
    assert len(FILE.splitlines()) <= 40


@pytest.mark.parametrize(
    ("right", "wrong", "verdict"),
    [
        ("bend / 2", "bend / 2", "PASS"),
        ("dt / discretisation.h) ** 2", "dt / discretisation.h) ** 2 * 1.01", "FAIL"),
        ("bend if n", "bend / 2 if n", "FAIL"),
        ("gained = dt", "gained = 0.99 * dt", "FAIL"),
        ('"displacement": 2}', '"displacement": 3}', "FAIL"),
        ("reference=x,", "reference=x * np.nan,", "ERROR"),
    ],
)
def test_a_fault_in_the_solver_that_the_readme_shows_does_not_pass(right, wrong, verdict):
    assert FILE.count(right) == 1
    names: dict = {}
    exec(FILE.replace(right, wrong), names)
    found: list = []
    names["test_leapfrog"](lambda solver, study, case: found.extend(verify(solver, studies.get(study), case)))
    assert [finding.verdict for finding in found] == [verdict]


@pytest.mark.parametrize("block", ALONE, ids=lambda block: block.splitlines()[0])
def test_what_the_readme_shows_in_python_runs(block):
    exec(block, {})


def test_only_what_needs_results_or_a_solver_of_ones_own_is_not_run():
    assert len(ALONE) >= 2
    assert len(PYTHON) - len(ALONE) <= 2


def test_the_readme_says_the_verdict_that_it_gets():
    (call, verdict, reason) = re.search(r'^(verdict\(.*\))  # \((\w+), "(.*)"\)$', README, re.MULTILINE).groups()
    (block,) = (block for block in ALONE if call in block)
    names: dict = {}
    exec(block, names)
    assert eval(call, names) == (verdict, reason)
