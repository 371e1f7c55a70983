"""The README and the handbook: what they show runs, what they link is there, what they name exists."""

import ast
import contextlib
import io
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import handbook
import pytest
from handbook import PAGES, ROOT, blocks, prose, text

from mpmverify import cli

NAMES = [page.relative_to(ROOT).as_posix() for page in PAGES]
INSTALLS = re.compile(r"python -m pip install --quiet -e [\"']?\.(?:\[(\w+)\])?[\"']?")


@pytest.fixture(scope="module")
def environment():
    return handbook.environment()


@pytest.fixture(scope="module")
def results(tmp_path_factory, environment):
    """Results of one study, which stand for those of all."""
    folder = tmp_path_factory.mktemp("results")
    subprocess.run(["mpmverify", "run", "gehojerez-deck"], cwd=folder, env=environment, check=True, capture_output=True)
    return folder / "results"


def commands(block: handbook.Block) -> list[list[str]]:
    """Commands of a block, each as its words."""
    lines = (shlex.split(part, comments=True) for line in block.text.splitlines() for part in line.split("&&"))
    return [[word for word in line if not word.startswith("NUMBA_CACHE_DIR=")] for line in lines if line]


def check_mpmverify(words: list[str]) -> None:
    """Parse a command without running it."""
    group: click.Command = cli.cli
    while isinstance(group, click.Group):
        name, *words = words
        group = group.commands[name]
    group.make_context(name, words)


def check(words: list[str]) -> None:
    """See that a command which takes long is there and has the options that it is given."""
    program, *rest = words
    if Path(program).name == "mpmverify":
        check_mpmverify(rest)
    elif Path(program).name == "pytest" or rest[:2] == ["-m", "pytest"]:
        known = subprocess.run([sys.executable, "-m", "pytest", "--help"], cwd=ROOT, capture_output=True, text=True, check=True)
        assert {word for word in rest if word.startswith("--")} <= set(re.findall(r"--[\w-]+", known.stdout))
        assert all((ROOT / word).exists() for word in rest if "/" in word)
    elif rest[:1] == ["-m"] and rest[1].startswith("mpmverify."):
        known = subprocess.run([sys.executable, "-m", rest[1], "--help"], capture_output=True, text=True, check=True)
        assert {word for word in rest if word.startswith("--")} <= set(re.findall(r"--[\w-]+", known.stdout))
    elif program == "cc":
        assert all((ROOT / "mpmverify/adapters/templates" / word).is_file() for word in rest if word.endswith(".c"))
    else:
        assert program == "python"
        (script,) = rest
        ast.parse((ROOT / script).read_text(encoding="utf-8"))


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_every_block_of_a_page_runs_as_a_reader_would_run_it(page, tmp_path, monkeypatch, request, environment):
    """In order, in one folder that has the results of a run; Python blocks in one session.

    Not run are `command` blocks, which .ci/run runs; `sweep` blocks, which tests/sweeps runs; and `parsed` ones, which take minutes
    (self-test, all studies, benchmarks) or need a cluster.
    """
    monkeypatch.chdir(tmp_path)
    shown = blocks(page)
    if any(block.language in ("sh", "python") and "parsed" not in block.marks for block in shown):
        shutil.copytree(request.getfixturevalue("results"), "results")
    names: dict = {}
    printed = io.StringIO()
    for block in shown:
        if name := block.marks.get("file"):
            Path(name).write_text(block.text, encoding="utf-8")
        elif block.language == "python" and "parsed" in block.marks:
            ast.parse(block.text)
        elif block.language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(block.text, names)
        elif "sweep" in block.marks:
            continue
        elif block.language == "sh" and {"command", "parsed"} & block.marks.keys():
            if block.marks.get("command") != "test":
                for words in commands(block):
                    if words[1:3] != ["-m", "venv"] and "pip" not in words:
                        check(words)
        elif block.language == "sh":
            told = "\n".join(line for line in block.text.splitlines() if not INSTALLS.fullmatch(line) and line[:2] != ". ")
            done = subprocess.run(["bash", "-euc", told], env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == int(block.marks.get("status", 0)), f"{block.text}\n{done.stdout[-3000:]}\n{done.stderr}"
        else:
            assert block.language in ("csv", "yaml", "text", ""), "a language that is not run"
            if block.language == "text":
                assert block.text == printed.getvalue(), "what the block before it prints"


def test_extras_that_are_installed_exist():
    with (ROOT / "pyproject.toml").open("rb") as file:
        extras = tomllib.load(file)["project"]["optional-dependencies"]
    found = [match for page in PAGES for match in re.findall(r"pip install [^\n]*(?:\.|mpmverify)\[(\w+)\]", text(page))]
    assert found
    assert set(found) <= extras.keys()


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_commands_in_the_text_have_the_options_that_it_names(page):
    for code in re.findall(r"`(mpmverify [^`]*)`", prose(page).replace("\n", " ")):
        for words in ([word for word in code.split() if word != "time"],):
            if words[1].startswith("-"):
                continue
            command = cli.cli.commands[words[1]]
            if isinstance(command, click.Group) and len(words) > 2:
                command = command.commands[words[2]]
            options = {option for parameter in command.params for option in parameter.opts} | {"--help"}
            assert {word for word in words if word.startswith("--")} <= options, code


def test_the_table_of_options_is_that_of_run():
    studies = text(handbook.FOLDER / "studies.md")
    table = studies[studies.index("| option |") :].partition("\n\n")[0]
    options = {option for parameter in cli.cli.commands["run"].params for option in parameter.opts}
    assert set(re.findall(r"^\| `(--[\w-]+)", table, re.MULTILINE)) <= options


def test_the_table_of_options_is_that_of_the_plugin(pytestconfig):
    table = re.findall(r"^\| `(--mpmverify[\w-]*)", text(handbook.FOLDER / "pytest.md"), re.MULTILINE)
    assert all(hasattr(pytestconfig.option, option.strip("-").replace("-", "_")) for option in table)
    assert len(table) == sum(name.startswith("mpmverify") for name in vars(pytestconfig.option))


def test_every_study_is_explained():
    from mpmverify import studies

    explained = re.findall(r"^\| `([\w-]+)` \| [^|]+ \| [^|]+ \|$", text(handbook.FOLDER / "studies.md"), re.MULTILINE)
    assert set(studies.NAMES) <= set(explained)


# Links.


def anchors(page: Path) -> set[str]:
    """Anchors of the headings of a page, as forges make them."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(page: Path) -> list[str]:
    return re.findall(r"\]\(([^)\s]+)\)", prose(page))


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_links_lead_somewhere(page):
    for link in links(page):
        target, _, anchor = link.partition("#")
        found = (page.parent / target).resolve() if target else page
        assert found.is_relative_to(ROOT), f"{link} is not relative to this project"
        assert found.is_file(), f"{link} leads nowhere"
        assert not anchor or anchor in anchors(found), f"{link} has no such heading"


def test_every_page_and_picture_is_linked_from_the_readme_or_the_index():
    index = handbook.FOLDER / "README.md"
    linked = {(page.parent / link.partition("#")[0]).resolve() for page in PAGES for link in links(page)}
    assert {path for path in handbook.FOLDER.iterdir() if path != index} <= linked
    listed = {(handbook.FOLDER / link.partition("#")[0]).resolve() for link in links(index)}
    assert set(PAGES) - {index} <= listed


# The README.


def test_the_readme_is_short():
    assert len(text(PAGES[0]).split()) <= 1200


@pytest.mark.parametrize("picture", sorted(handbook.FOLDER.glob("*.svg")), ids=lambda path: path.name)
def test_pictures_are_small_and_readable_in_light_and_dark(picture):
    assert picture.stat().st_size < 100_000
    assert "prefers-color-scheme:dark" in picture.read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=NAMES)
def test_a_page_says_the_verdict_that_python_gives(page):
    for call, verdict, reason in re.findall(r'^(verdict\(.*\))  # \((\w+), "(.*)"\)$', text(page), re.MULTILINE):
        names: dict = {}
        exec("\n".join(block.text for block in blocks(page) if call in block.text), names)
        assert eval(call, names) == (verdict, reason)
