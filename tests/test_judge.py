"""The command that judges a table of errors: one verdict for each column, and one sentence for a table that is not one."""

import csv
import io
import json
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner

from mpmverify.cli import cli

SECOND = "h,error\n0.1,4.1e-3\n0.05,1.0e-3\n0.025,2.6e-4\n0.0125,6.4e-5\n"
BAND = ("--low", "1.8", "--high", "2.2")


@pytest.fixture
def judge(tmp_path):
    def call(content, *options):
        path = tmp_path / "errors.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return CliRunner().invoke(cli, ["judge", str(path), *options])

    return call


def verdicts(result):
    """Verdict by column."""
    words = ("PASS", "FAIL", "INCONCLUSIVE", "ERROR")
    lines = (line.partition(":")[0].split(" ", 1) for line in result.output.splitlines() if line.startswith(words))
    return {name: word for word, name in lines}


def powers(h, *orders):
    """Text of a CSV table with a column for each order."""
    names = ",".join(f"e{order:g}" for order in orders)
    return "\n".join([f"h,{names}", *(",".join([repr(size), *(repr(size**order) for order in orders)]) for size in h)]) + "\n"


LADDER = (0.2, 0.1, 0.05, 0.025)
DESIGN = "h,dt,u\n" + "".join(f"{h},{dt},{3 * h**2 + dt!r}\n" for h in LADDER for dt in LADDER)


@pytest.mark.parametrize(
    ("content", "options", "status", "verdict"),
    [
        (SECOND, BAND, 0, "PASS"),
        (SECOND, ("--low", "1.8"), 0, "PASS"),
        (SECOND, ("--high", "2.2"), 0, "PASS"),
        (SECOND, ("--low", "2.5"), 1, "FAIL"),
        (SECOND, ("--high", "1.5"), 1, "FAIL"),
        (SECOND, (), 0, "INCONCLUSIVE"),
        (SECOND, ("--strict",), 4, "INCONCLUSIVE"),
        (SECOND.replace("1.0e-3", "nan"), BAND, 3, "ERROR"),
        (SECOND.replace("1.0e-3", "Inf"), (), 3, "ERROR"),
        ("h,error\n1,1\n2,1\n4,1\n", (), 1, "FAIL"),
        ("h,error\n1,1\n2,4\n", BAND, 0, "INCONCLUSIVE"),
        ("h,error\n0.1,1\n0.05,2\n0.025,4\n", (), 1, "FAIL"),
        (SECOND, ("--exact", "0.01"), 0, "PASS"),
        (SECOND, ("--exact", "0.001"), 1, "FAIL"),
    ],
)
def test_exit_statuses(judge, content, options, status, verdict):
    result = judge(content, *options)
    assert result.exit_code == status
    assert verdicts(result) == {"error": verdict}


def test_the_output_shows_levels_orders_and_what_was_taken_for_what(judge):
    result = judge("h,n,L2,seconds\n0.1,10,4e-2,1\n0.05,20,1e-2,8\n0.025,40,2.5e-3,64\n", *BAND)
    *shown, last = result.output.splitlines(keepends=True)
    assert "".join(shown) == (
        "    h      L2  order\n"
        "  0.1    0.04      -\n"
        " 0.05    0.01  2.000\n"
        "0.025  0.0025  2.000\n"
        "\n"
        "Sizes: 'h'. Errors: 'L2'. Left out: 'n', 'seconds'.\n"
    )
    assert re.fullmatch(r"PASS L2: order 2\.000, interval \[1\.9\d+, 2\.0\d+\] from 3 levels \(asymptotic\)\n", last)


def test_without_a_band_order_interval_and_class_are_printed(judge):
    output = judge(SECOND).output
    assert re.search(r"order 1\.995, interval \[1\.9\d+, 2\.0\d+\] from 4 levels \(asymptotic\)", output)
    assert "no order passes" in output


def test_every_dropped_level_is_named(judge):
    assert "h=0.0125: at round-off" in judge(SECOND.replace("6.4e-5", "1e-14"), *BAND).output


@pytest.mark.parametrize("gap", ["", "-", "--", "N/A"])
def test_a_level_without_an_error_is_named_with_its_line(judge, gap):
    result = judge(SECOND.replace("1.0e-3", gap), *BAND)
    assert verdicts(result) == {"error": "PASS"}
    assert "from 3 levels" in result.output
    assert "no error is given at h=0.05 (line 3)" in result.output


def test_every_column_has_its_band(judge):
    table = powers(LADDER, 1, 2)
    assert verdicts(judge(table, *BAND)) == {"e1": "FAIL", "e2": "PASS"}
    assert verdicts(judge(table, *BAND, "--low", "e1=0.8", "--high", "e1=1.2")) == {"e1": "PASS", "e2": "PASS"}
    assert verdicts(judge(table, "--low", "e1=0.8", "--high", "e1=1.2")) == {"e1": "PASS", "e2": "INCONCLUSIVE"}
    assert verdicts(judge(table, "--error", "e2", *BAND)) == {"e2": "PASS"}
    assert judge(table, *BAND).exit_code == 1


def test_one_column_may_be_the_size_of_another(judge):
    assert verdicts(judge(powers(LADDER, 1, 2), "--h", "e1", "--error", "e2", *BAND)) == {"e2": "PASS"}


def test_absolute_errors_have_a_scale(judge):
    small = "h,u\n" + "".join(f"{h},{3e-14 * h**2!r}\n" for h in LADDER)
    result = judge(small, *BAND)
    assert verdicts(result) == {"u": "INCONCLUSIVE"}
    assert "give the size of the solution by --scale" in result.output
    assert "of the solution:" not in result.output
    for scale in ("1e-14", "u=1e-14"):
        assert verdicts(judge(small, *BAND, "--scale", scale)) == {"u": "PASS"}
    assert verdicts(judge(small, *BAND, "--round-off", "1e-18")) == {"u": "PASS"}


def test_errors_finer_than_their_reference_are_dropped(judge):
    result = judge(SECOND, *BAND, "--uncertainty", "2e-5")
    assert "finer than 10 times the uncertainty" in result.output
    assert "finer than 10 times the uncertainty" in judge(SECOND, *BAND, "--uncertainty", "2e-3", "--scale", "100").output


@pytest.mark.parametrize(
    ("name", "option"),
    [
        ("cells", ("--cells", "2")),
        ("N", ("--cells", "2")),
        ("ndofs", ("--dofs", "2")),
        ("who knows", ("--h", "who knows", "--dofs", "2")),
    ],
)
def test_a_count_becomes_a_size_by_its_dimension(judge, name, option):
    table = f"{name},u\n" + "".join(f"{n * n},{n**-2.0!r}\n" for n in (8, 16, 32, 64))
    assert verdicts(judge(table, *option, *BAND)) == {"u": "PASS"}
    refused = judge(table, *(option if len(option) == 2 and option[0] == "--h" else ()), *BAND)
    assert refused.exit_code == 2
    assert ("--cells" in refused.stderr or "--dofs" in refused.stderr) or "--h COLUMN" in refused.stderr


def test_cells_go_before_a_bare_n():
    table = "n,cells,u\n1,64,16\n2,256,4\n3,1024,1\n"
    result = CliRunner().invoke(cli, ["judge", "-", "--cells", "2", *BAND], input=table)
    assert verdicts(result) == {"u": "PASS"}
    assert "Left out: 'n'." in result.output


def test_a_level_becomes_a_size_by_its_ratio(judge):
    table = "level,u\n" + "".join(f"{k},{9.0**-k!r}\n" for k in range(4))
    assert verdicts(judge(table, "--levels", "3", *BAND)) == {"u": "PASS"}
    assert verdicts(judge(table, "--levels", "9", *BAND)) == {"u": "FAIL"}
    assert "--levels RATIO (for 'level')" in judge(table).stderr


def test_counts_along_an_edge_and_grids_need_no_option(judge):
    for name, cells in (("nx", "{0}"), ("1/h", "{0}"), ("steps", "{0}"), ("grid", "{0}x{0}"), ("mesh", "{0} × {0} × {0}")):
        table = f"{name},u\n" + "".join(f"{cells.format(n)},{n**-2.0!r}\n" for n in (8, 16, 32))
        assert verdicts(judge(table, *BAND)) == {"u": "PASS"}, name


@pytest.mark.parametrize("options", [("--h", "foo"), ("--h", "h")])
def test_errors_that_fall_as_a_size_of_whole_numbers_grows_are_refused(judge, options):
    table = f"{options[1]},u\n8,1\n16,0.25\n32,0.06\n"
    result = judge(table, *options)
    assert result.exit_code == 2
    assert "it is a count and no size" in result.stderr


def test_a_design_goes_to_the_separation_of_sources(judge):
    bands = ("--low", "h=1.8", "--high", "h=2.2", "--low", "dt=0.8", "--high", "dt=1.2")
    result = judge(DESIGN, *bands)
    assert verdicts(result) == {"u": "PASS"}
    assert "Sources of u" in result.output
    assert verdicts(judge(DESIGN, *bands, "--low", "dt=1.5", "--high", "dt=2")) == {"u": "FAIL"}
    assert verdicts(judge(DESIGN)) == {"u": "INCONCLUSIVE"}
    assert "no exponent passes" in judge(DESIGN).output
    matrix = "h \\ dt,0.2,0.1,0.05,0.025\n" + "".join(
        f"{h}," + ",".join(repr(3 * h**2 + dt) for dt in LADDER) + "\n" for h in LADDER
    )
    assert verdicts(judge(matrix, *bands)) == {"error": "PASS"}


def test_replicates_enter_the_fit_as_they_are(judge):
    rows = "".join(f"{h},{seed},{h**2 * (1 + 0.01 * seed)!r}\n" for h in LADDER for seed in (-1, 0, 1))
    result = judge(f"h,seed,u\n{rows}", *BAND)
    assert verdicts(result) == {"u": "PASS"}
    assert "12 errors at 4 sizes" in result.output
    assert "Left out: 'seed'." in result.output
    assert result.output.count(" 2.000\n") == 3, "one order for each size but the coarsest"


def test_series_that_a_number_tells_apart_are_no_replicates(judge):
    rows = "".join(f"{h},{nu},{nu * h**2!r}\n" for h in LADDER for nu in (0.1, 0.3))
    refused = judge(f"h,nu,u\n{rows}", *BAND)
    assert refused.exit_code == 2
    assert "several series, told apart by 'nu'" in refused.stderr
    assert verdicts(judge(f"h,case,u\n{rows}", *BAND)) == {"u (case=0.1)": "PASS", "u (case=0.3)": "PASS"}


def test_a_pressure_is_judged_and_a_time_step_k_is_not(judge):
    table = "h,k,p\n" + "".join(f"{h},{h},{h**2!r}\n" for h in LADDER)
    assert verdicts(judge(table, *BAND)) == {"p": "PASS"}


def test_a_count_that_varies_beside_dt_is_not_passed_over(judge):
    table = "N,dt,u\n8,0.4,16\n16,0.2,4\n32,0.1,1\n"
    assert "--cells DIM (for 'N'), or name a size by --h" in judge(table, *BAND).stderr
    assert "h and dt together" in judge(table, "--cells", "1", *BAND).output
    assert verdicts(judge(table, "--h", "dt", *BAND)) == {"u": "PASS"}
    assert verdicts(judge(table.replace("16,", "8,").replace("32,", "8,"), *BAND)) == {"u": "PASS"}


def test_a_design_may_be_exact(judge):
    assert verdicts(judge(DESIGN, "--exact", "1")) == {"u": "PASS"}
    assert verdicts(judge(DESIGN, "--exact", "1e-6")) == {"u": "FAIL"}


def test_a_design_with_a_run_that_went_wrong_is_an_error(judge):
    assert verdicts(judge(DESIGN.replace("0.2,0.2,", "0.2,0.2,nan\n0.2,0.3,"), "--low", "0.5")) == {"u": "ERROR"}


def test_a_size_goes_before_the_cells_along_an_edge(judge):
    assert "Sizes: 'h'." in judge("nx,h,u\n2,0.4,4\n4,0.2,1\n").output


def test_h_and_dt_together_are_one_ladder(judge):
    result = judge("h,dt,u\n" + "".join(f"{h},{2 * h},{h}\n" for h in LADDER), "--low", "0.9", "--high", "1.1")
    assert verdicts(result) == {"u": "PASS"}
    assert "h and dt together: min(p, q)" in result.output


def test_a_size_that_does_not_vary_is_none(judge):
    assert verdicts(judge("dt,h,ppc,u\n1,4,2,16\n1,2,2,4\n1,1,2,1\n", *BAND)) == {"u": "PASS"}
    assert "Sizes: 'dt'" in judge("dt,h,u\n4,1,16\n2,1,4\n1,1,1\n", *BAND).output


def test_methods_and_degrees_are_series_of_their_own(judge):
    table = "scheme,p,h,u\n" + "".join(
        f"{name},{p},{h},{h ** (p + 1)!r}\n" for name in ("FLIP", "PIC") for p in (1, 2) for h in LADDER
    )
    found = verdicts(judge(table, *BAND))
    assert found == {f"u (scheme={name}, p={p})": {1: "PASS", 2: "FAIL"}[p] for name in ("FLIP", "PIC") for p in (1, 2)}


@pytest.mark.parametrize(
    "same",
    [
        SECOND.replace(",", ";"),
        SECOND.replace(",", "\t"),
        SECOND.replace(",", " , "),
        SECOND.replace("\n", "\r\n"),
        SECOND.replace("\n", "\r"),
        SECOND.replace("\n", "\n\n"),
        "\ufeff" + SECOND,
        SECOND.encode("utf-16"),
        SECOND.replace("error", '"error"'),
        SECOND.rstrip(),
        "# mine\n" + SECOND,
        "\n".join([SECOND.splitlines()[0], *reversed(SECOND.splitlines()[1:])]),
    ],
)
def test_what_separates_and_how_levels_are_ordered_does_not_matter(judge, same):
    assert judge(same, *BAND).output == judge(SECOND, *BAND).output


@pytest.mark.parametrize("form", ["markdown", "latex", "csv"])
@pytest.mark.parametrize(
    "content", [SECOND, powers(LADDER, 1, 2), SECOND.replace("1.0e-3", "nan"), SECOND.replace("1.0e-3", "-")]
)
def test_every_format_is_read_again(judge, form, content):
    first = judge(content, *BAND, "--format", form)
    again = judge(first.output, *BAND)
    assert again.exit_code == first.exit_code
    assert verdicts(again) == verdicts(judge(content, *BAND))


def test_csv_keeps_every_digit(judge):
    table = powers((0.3, 0.1, 1 / 30), 1.7)
    lines = [line for line in judge(table, "--format", "csv").output.splitlines() if line and not line.startswith("#")]
    shown = [[float(cell) for cell in row[:2]] for row in csv.reader(io.StringIO("\n".join(lines[1:])))]
    assert shown == [[float(cell) for cell in row] for row in csv.reader(io.StringIO(table.partition("\n")[2]))]


def test_json_has_the_verdict_the_fit_and_the_levels(judge):
    data = json.loads(judge(SECOND.replace("6.4e-5", "nan"), *BAND, "--format", "json").output)
    assert [column["verdict"] for column in data["columns"]] == ["ERROR"]
    assert data["columns"][0]["levels"][3] == {"h": 0.0125, "error": None, "order": None}
    (column,) = json.loads(judge(SECOND, *BAND, "--format", "json").output)["columns"]
    assert column["order"] == pytest.approx(1.995, abs=1e-3)
    assert column["levels"][1]["order"] == pytest.approx(2.036, abs=1e-3)
    assert len(json.loads(judge(DESIGN, "--format", "json").output)["columns"][0]["sources"]) == 2


@pytest.mark.parametrize(
    ("content", "options", "said"),
    [
        ("", (), "is empty"),
        ("\n \n", (), "is empty"),
        ("# h,error\n", (), "is empty"),
        ("h,error\n", (), "has no level"),
        ("some words\nand no numbers\n", (), "has no level"),
        ("0.1,0.2\n0.05,0.1\n", (), "name the columns in the first line"),
        ("h\n1\n2\n", (), "has no column of errors beside 'h'"),
        ("h,\n1,2\n", (), "has no column of errors beside 'h'"),
        ("h,e,e\n1,2,3\n", (), "give each column its own name"),
        ("h,e\n1,2\n3\n", (), "line 3 has 1 cell where line 2 has 2"),
        ("h,e,f\n1,2\n3,4\n", (), "line 2 has 2 cells where 3 columns are named: the first line must name every column"),
        (SECOND, ("--error", "h", "--h", "h"), "the column 'h' holds the sizes"),
        ("h,dt,ppc\n1,2,2\n", (), "has no column of errors beside 'h'"),
        ("a,b\n1,2\n2,3\n", (), "no column of sizes by its name (a, b): say which with --h COLUMN"),
        ("h,e\n1,2\n\n3,4,5\n", (), "line 4 has 3 cells"),
        ("h,e\n1,two\n2,3\n", (), "line 2: 'two' in column 'e' is not a number"),
        ("h,e\n1,1_0\n2,3\n", (), "'1_0' in column 'e' is not a number"),
        ("h;e\n0,1;0.5\n", (), "mixes decimal commas ('0,1') and points ('0.5')"),
        ("h,e\n0,1,0,2\n0,05,0,1\n", (), "if commas are decimal signs, separate the columns with semicolons"),
        ("dofs;e\n1,024;1\n4,096;2\n", (), "'1,024' may be 1.024 or 1024"),
        ("h,e\n0,2\n1,3\n", (), "every h must be positive and finite, not 0"),
        ("h,e\nnan,2\n1,3\n", (), "every h must be positive and finite, not nan"),
        ("h,e\n,2\n1,3\n", (), "line 2: every h must be positive and finite, not empty"),
        ("h,e\n2,2\n1,-3\n", (), "line 3: the error -3 in column 'e' is negative"),
        (SECOND, ("--error", "u"), "has no column 'u': choose from h, error"),
        (SECOND, ("--h", "dx"), "has no column 'dx': choose from h, error"),
        ("h,dt,e\n2,1,2\n1,1,1\n2,2,3\n", ("--h", "h"), "has several 'dt' at h=2"),
        (SECOND, ("--low", "3", "--high", "2"), "the band of orders [3, 2] is empty"),
        (SECOND, ("--low", "nan"), "the band of orders"),
        (SECOND, ("--low", "high"), "is neither a number nor COLUMN=NUMBER"),
        (SECOND, ("--low", "u=2"), "'u' is no column that is judged"),
        (SECOND, ("--scale", "0"), "the scale must be positive"),
        (SECOND, ("--scale", "u=1", "--scale", "error=nan"), "the scale must be positive"),
        (SECOND, ("--round-off", "-1"), "at round-off must not be negative"),
        (SECOND, ("--uncertainty", "nan"), "uncertainty"),
        (SECOND, ("--exact", "nan"), "tolerance"),
        (SECOND, ("--exact", "1", "--low", "2"), "not both"),
        (SECOND, ("--cells", "2"), "has no column that is a number of cells by its name"),
        (SECOND, ("--cells", "4"), "--cells"),
        (SECOND, ("--levels", "1"), "--levels must be"),
        (b"\xff\xfe\x00\x00", (), "is not text"),
        (SECOND + "e" * 2000, (), "give the table alone"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", (), "is not text"),
        ('h,e\n"1,2\n', (), "line 2"),
        (SECOND + "\n\n" + SECOND, (), "holds two tables"),
    ],
)
def test_an_invalid_table_is_refused_in_one_sentence(judge, content, options, said):
    result = judge(content, *options)
    assert result.exit_code == 2
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert "Traceback" not in result.stderr


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path):
        result = CliRunner().invoke(cli, ["judge", str(path)])
        assert result.exit_code == 2
        assert str(path) in result.stderr


def test_standard_input_is_read(judge):
    result = CliRunner().invoke(cli, ["judge", "-", *BAND], input=SECOND)
    assert result.output == judge(SECOND, *BAND).output
    assert "standard input is empty" in CliRunner().invoke(cli, ["judge", "-"], input="").stderr


BLOCKED = """
import sys
for name in ("numba", "llvmlite", "xarray", "netCDF4", "pandas", "scipy", "rich", "skfem", "plotly", "jinja2", "latex2mathml"):
    sys.modules[name] = None
from mpmverify.cli import main
main()
"""


@pytest.mark.parametrize("command", [["judge", "-", *BAND], ["gci", "-", "--formal", "2"]])
def test_tables_need_nothing_but_click_and_numpy(command):
    done = subprocess.run([sys.executable, "-c", BLOCKED, *command], input=SECOND, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
