"""The command that judges a CSV file of errors: one verdict for each column, and one sentence for an invalid file."""

import pytest
from click.testing import CliRunner

from mpmverify.cli import cli
from mpmverify.convergence import read_table

SECOND = "h,error\n0.1,4.1e-3\n0.05,1.0e-3\n0.025,2.6e-4\n0.0125,6.4e-5\n"
BAND = ("--low", "1.8", "--high", "2.2")


@pytest.fixture
def judge(tmp_path):
    def call(content, *options):
        path = tmp_path / "errors.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return CliRunner().invoke(cli, ["judge", str(path), *options])

    return call


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
    ],
)
def test_exit_statuses(judge, content, options, status, verdict):
    result = judge(content, *options)
    assert result.exit_code == status
    assert result.output.startswith(f"{verdict} error: ")


def test_without_a_band_order_interval_and_class_are_printed(judge):
    output = judge(SECOND).output
    assert "order 1.995, interval [1.955, 2.030] from 4 levels (asymptotic)" in output
    assert "no order passes" in output


def test_several_errors_at_one_size_are_replicates(judge):
    result = judge(SECOND + "0.1,4.0e-3\n0.05,1.02e-3\n", *BAND)
    assert result.exit_code == 0
    assert "from 6 errors at 4 sizes, each as it is" in result.output


def test_every_dropped_level_is_named(judge):
    assert "h=0.0125: at round-off" in judge(SECOND.replace("6.4e-5", "1e-14"), *BAND).output


def test_every_other_column_is_judged_and_the_worst_verdict_counts(judge):
    two = "dt;displacement;velocity\n4;16;4\n2;4;2\n1;1;1\n"
    result = judge(two, *BAND)
    assert [line.split(":")[0] for line in result.output.splitlines()] == ["PASS displacement", "FAIL velocity", "Sizes"]
    assert result.exit_code == 1
    assert judge(two, "--error", "displacement", *BAND).exit_code == 0
    assert judge(two, "--h", "velocity", "--error", "displacement", *BAND).exit_code == 0


def test_the_column_h_holds_the_sizes_and_other_sizes_are_not_judged(judge):
    table = "dt,h,ppc,u\n1,4,2,16\n1,2,2,4\n1,1,2,1\n"
    result = judge(table, *BAND)
    assert [line.split(":")[0] for line in result.output.splitlines()] == ["PASS u", "Sizes"]
    assert result.output.endswith("Sizes: column 'h'.\n")
    assert judge(table, "--error", "dt", *BAND).output.startswith("FAIL dt")
    assert judge("dx,u\n4,16\n2,4\n1,1\n", *BAND).output.endswith("Sizes: column 'dx'.\n")


@pytest.mark.parametrize(
    "same",
    [
        SECOND.replace(",", ";"),
        SECOND.replace(",", "\t"),
        SECOND.replace(",", " , "),
        SECOND.replace("\n", "\r\n"),
        SECOND.replace("\n", "\n\n"),
        "\ufeff" + SECOND,
        SECOND.replace("error", '"error"'),
        SECOND.rstrip(),
        "\n".join([SECOND.splitlines()[0], *reversed(SECOND.splitlines()[1:])]),
    ],
)
def test_what_separates_and_how_levels_are_ordered_does_not_matter(judge, same):
    assert judge(same, *BAND).output == judge(SECOND, *BAND).output


@pytest.mark.parametrize(
    ("content", "options", "said"),
    [
        ("", (), "is empty"),
        ("\n \n", (), "is empty"),
        ("h,error\n", (), "has no level"),
        ("0.1,0.2\n0.05,0.1\n", (), "name the columns in the first line"),
        ("h\n1\n2\n", (), "has no column of errors beside 'h'"),
        ("h,\n1,2\n", (), "must name every column"),
        ("h,e,e\n1,2,3\n", (), "each name once"),
        ("h,e\n1,2\n3\n", (), "line 3 has 1 cell where 2 columns are named: the first line must name every column"),
        ("# mine\nh,e\n1,2\n", (), "line 2 has 2 cells where 1 column is named: the first line must"),
        (SECOND, ("--error", "h"), "the column 'h' holds the sizes"),
        ("h,dt,ppc\n1,2,2\n", (), "has no column of errors beside 'h'"),
        ("h,e\n1,2\n\n3,4,5\n", (), "line 4 has 3 cells"),
        ("h,e\n1,two\n", (), "line 2: 'two' in column 'e' is not a number"),
        ("h,e\n1,\n", (), "line 2: '' in column 'e' is not a number"),
        ("h,e\n1,1_0\n", (), "'1_0' in column 'e' is not a number"),
        ("h;e\n0,1;2\n", (), "'0,1' in column 'h' is not a number"),
        ("h,e\n0,2\n1,3\n", (), "every h must be positive and finite, not 0"),
        ("h,e\nnan,2\n1,3\n", (), "every h must be positive and finite, not nan"),
        ("h,e\n2,2\n1,-3\n", (), "an error norm cannot be negative"),
        (SECOND, ("--error", "u"), "has no column 'u': choose from h, error"),
        (SECOND, ("--h", "dx"), "has no column 'dx': choose from h, error"),
        (SECOND, ("--low", "3", "--high", "2"), "the band of orders [3, 2] is empty"),
        (SECOND, ("--low", "nan"), "the band of orders"),
        (b"\xff\xfe\x00\x00", (), "is not text"),
        ('h,e\n"1,2\n', (), "line 2"),
    ],
)
def test_an_invalid_table_is_refused_in_one_sentence(judge, content, options, said):
    result = judge(content, *options)
    assert result.exit_code == 2
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert "Traceback" not in result.stderr


def test_a_missing_file_is_named(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path):
        result = CliRunner().invoke(cli, ["judge", str(path)])
        assert result.exit_code == 2
        assert str(path) in result.stderr


def test_a_table_gives_its_columns_as_numbers(tmp_path):
    path = tmp_path / "errors.csv"
    path.write_text("h,who,error\n1,me,nan\n2,you,inf\n")
    table = read_table(path)
    assert table.names == ("h", "who", "error")
    assert table.numbers("h").tolist() == [1, 2]
    assert str(table.numbers("error").tolist()) == "[nan, inf]"
