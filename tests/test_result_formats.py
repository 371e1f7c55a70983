"""Results of codes outside Python: the same arrays from every form of file, and a sentence on every damaged one."""

import contextlib
import itertools
from pathlib import Path

import meshio
import netCDF4
import numpy as np
import pytest
from arrays import assert_close
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mpmverify import studies
from mpmverify.adapters.body_force import in_modes
from mpmverify.adapters.deck import Deck
from mpmverify.adapters.result import read_result
from mpmverify.execution.contract import malformed
from mpmverify.problem import components
from mpmverify.solution import RunError, Solution

QUANTITIES = ("displacement", "velocity", "stress", "displacement_gradient")


def deck_of(dimension: int) -> Deck:
    study, name = {1: ("axial-vibration", "literature"), 2: ("plane-waves", "clamped"), 3: ("plane-waves", "yeoh-cuboid")}[
        dimension
    ]
    (case,) = (case for case in studies.get(study).cases if case.name == name)
    return Deck(case.problem.problem, case.ladder_in_h().levels[0])


def solution(deck: Deck) -> Solution:
    """Numbers of the right shape that mean nothing."""
    random, (X, weight), t = np.random.default_rng(1), deck.sample, deck.output_times
    parts = {q: len(components(q, deck.problem.dimension)) for q in QUANTITIES}
    fields = {q: random.normal(size=(len(t), len(X), count)) for q, count in parts.items()}
    position = X + fields["displacement"]
    weights = weight * random.uniform(0.5, 1.5, (len(t), len(X)))
    steps, dt = deck.steps
    histories = {"time": dt * np.arange(steps + 1)}
    histories |= {name: random.normal(size=steps + 1) for name in components("momentum", deck.problem.dimension)}
    return Solution(t, dt, X, position, weights, fields, histories, None)


def columns_of(found: Solution, dimension: int, output: int) -> dict[str, np.ndarray]:
    """Every component at one output time."""
    arrays = {"reference": found.reference, "position": found.position[output]} | {
        q: f[output] for q, f in found.fields.items()
    }
    named = {part: values[:, k] for q, values in arrays.items() for k, part in enumerate(components(q, dimension))}
    return {"time": np.full(len(found.reference), found.time[output]), "weight": found.weight[output]} | named


def write_table(path: Path, columns: dict[str, np.ndarray], separator: str, comment: str) -> None:
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, fmt="%.17g", delimiter=separator, header=separator.join(columns), comments=comment)


def write_histories(folder: Path, found: Solution) -> None:
    write_table(folder / "histories.csv", dict(found.histories), ",", "")


def as_one_table(folder: Path, found: Solution, dimension: int, separator: str = ",", comment: str = "") -> str:
    parts = [columns_of(found, dimension, n) for n in range(len(found.time))]
    write_table(folder / "all.csv", {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}, separator, comment)
    return "all.csv"


def as_tables_of_one_output(folder: Path, found: Solution, dimension: int) -> str:
    for n in range(len(found.time)):
        write_table(folder / f"out{n}.dat", columns_of(found, dimension, n), " ", "# ")
    return "out*.dat"


def as_shuffled_rows(folder: Path, found: Solution, dimension: int) -> str:
    random, parts = np.random.default_rng(2), []
    for n in range(len(found.time)):
        part = columns_of(found, dimension, n) | {"point": np.arange(len(found.reference), dtype=float)}
        order = random.permutation(len(found.reference))
        parts.append({name: values[order] for name, values in part.items()})
    write_table(folder / "all.txt", {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}, "\t", "")
    return "all.txt"


def as_npz(folder: Path, found: Solution, dimension: int) -> str:
    arrays = {"time": found.time, "weight": found.weight, "reference": found.reference, "position": found.position}
    np.savez(folder / "all.npz", **arrays, **found.fields)
    return "all.npz"


def as_npz_of_components(folder: Path, found: Solution, dimension: int) -> str:
    parts = [columns_of(found, dimension, n) for n in range(len(found.time))]
    arrays = {name: np.stack([part[name] for part in parts]) for name in parts[0] if name != "time"}
    np.savez(folder / "all.npz", time=found.time, **arrays)
    return "all.npz"


def as_netcdf(folder: Path, found: Solution, dimension: int) -> str:
    arrays = {"time": found.time, "weight": found.weight, "reference": found.reference, "position": found.position} | dict(
        found.fields
    )
    with netCDF4.Dataset(folder / "all.nc", "w") as data:
        names = (f"n{k}" for k in itertools.count())
        for name, values in arrays.items():
            dimensions = [next(names) for _ in values.shape]
            for dimension_name, length in zip(dimensions, values.shape, strict=True):
                data.createDimension(dimension_name, length)
            data.createVariable(name, "f8", dimensions)[:] = values
    return "all.nc"


def as_vtu(folder: Path, found: Solution, dimension: int) -> str:
    """One file for each output, as ParaView takes them: all vectors and tensors in three dimensions."""

    def padded(values: np.ndarray) -> np.ndarray:
        return np.pad(values, ((0, 0), (0, 3 - dimension)))

    pairs = {1: ["xx"], 2: ["xx", "yy", "xy"], 3: ["xx", "yy", "zz", "xy", "yz", "xz"]}[dimension]
    for n in range(len(found.time)):
        stress = np.zeros((len(found.reference), 6))
        stress[:, [["xx", "yy", "zz", "xy", "yz", "xz"].index(pair) for pair in pairs]] = found.fields["stress"][n]
        gradient = found.fields["displacement_gradient"][n].reshape(-1, dimension, dimension)
        whole = np.pad(gradient, ((0, 0), (0, 3 - dimension), (0, 3 - dimension))).reshape(-1, 9)
        data = {
            "reference": padded(found.reference),
            "displacement": padded(found.fields["displacement"][n]),
            "velocity": padded(found.fields["velocity"][n]),
            "stress": stress,
            "displacement_gradient": whole,
            "weight": found.weight[n],
        }
        cells = [("vertex", np.arange(len(found.reference))[:, None])]
        meshio.write(folder / f"out{n}.vtu", meshio.Mesh(padded(found.position[n]), cells, point_data=data))
    return "out*.vtu"


WRITERS = (
    as_one_table,
    as_tables_of_one_output,
    as_shuffled_rows,
    as_npz,
    as_npz_of_components,
    as_netcdf,
    as_vtu,
)


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("write", WRITERS, ids=lambda writer: writer.__name__)
def test_every_form_of_file_gives_the_same_solution(write, dimension, tmp_path):
    deck = deck_of(dimension)
    expected = solution(deck)
    write_histories(tmp_path, expected)
    found = read_result(tmp_path, write(tmp_path, expected, dimension), "histories.csv", {}, deck, 1.5)
    assert found.inconsistency() == ""
    assert found.work.seconds == 1.5
    theirs, ours = found.arrays(), expected.arrays()
    assert theirs.keys() == ours.keys()
    for name, values in ours.items():
        assert np.array_equal(theirs[name], values) or (name == "time" and np.allclose(theirs[name], values, rtol=1e-15)), name


@pytest.mark.parametrize(("separator", "comment"), [(",", "# "), (";", ""), ("\t", "%"), (" ", "#"), (", ", "")])
def test_tables_have_any_separator_and_a_comment_or_none(separator, comment, tmp_path):
    deck = deck_of(2)
    expected = solution(deck)
    found = read_result(tmp_path, as_one_table(tmp_path, expected, 2, separator, comment), "", {}, deck)
    assert np.array_equal(found.fields["stress"], expected.fields["stress"])


def test_short_names_and_own_names_of_columns(tmp_path):
    deck = deck_of(2)
    expected = solution(deck)
    names = {"time": "t", "weight": "V", "reference_x": "X", "reference_y": "Y", "position_x": "x", "position_y": "y"}
    names |= {
        "displacement_x": "ux",
        "velocity_y": "vy",
        "stress_xy": "sxy",
        "stress_xx": "S11",
        "displacement_gradient_xx": "H11",
    }
    parts = [columns_of(expected, 2, n) for n in range(len(expected.time))]
    table = {names.get(name, name): np.concatenate([p[name] for p in parts]) for name in parts[0]}
    table["density"] = np.ones_like(table["t"])
    write_table(tmp_path / "all.csv", table, ",", "")
    own = {"S11": "stress_xx", "H11": "displacement_gradient_xx"}
    found = read_result(tmp_path, "all.csv", "", own, deck)
    for name, values in expected.fields.items():
        assert np.array_equal(found.fields[name], values), name


def test_what_a_result_does_not_say_is_that_of_the_problem(tmp_path):
    deck = deck_of(2)
    expected = solution(deck)
    np.savez(tmp_path / "all.npz", displacement=expected.fields["displacement"])
    found = read_result(tmp_path, "all.npz", "", {}, deck)
    assert np.array_equal(found.time, deck.output_times)
    assert np.array_equal(found.reference, deck.sample[0])
    assert np.array_equal(found.position, expected.position)
    assert np.array_equal(found.weight, np.tile(deck.sample[1], (len(found.time), 1)))
    np.savez(tmp_path / "all.npz", position=expected.position)
    by_position = read_result(tmp_path, "all.npz", "", {}, deck)
    assert_close(by_position.fields["displacement"], expected.fields["displacement"], abs=1e-14)


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"velocity": (3, 5, 2)}, "the result has 5 points, the problem .* is it that of another level"),
        ({"velocity": (3, 5, 2), "reference": (5, 2)}, "add the volume of each as 'weight'"),
        ({"velocity_x": (3, 5)}, "lacks velocity_y"),
        ({"velocity": (3, 5, 2), "displacement": (3, 4, 2)}, "different shapes"),
        ({"velocity": (3, 5, 2), "weight": (4,)}, "weight of the result has the shape"),
        ({"velocity": (3, 5, 2), "time": (4,)}, "3 outputs and 4 output times"),
        ({"velocity": (3, 5, 2), "ux": (3, 5), "displacement_x": (3, 5)}, "two columns of displacement_x"),
        ({"velocty": (3, 5, 2)}, "a column 'velocty': is it 'velocity'"),
        ({"density": (3, 5)}, "the result has none of displacement, velocity"),
    ],
)
def test_a_result_that_lacks_something_is_said_in_a_sentence(arrays, said, tmp_path):
    arrays = {name: np.ones(shape) for name, shape in arrays.items()}
    np.savez(tmp_path / "all.npz", **{"time": np.arange(3.0)} | arrays)
    with pytest.raises(RunError, match=said):
        read_result(tmp_path, "all.npz", "", {}, deck_of(2))


def test_columns_of_a_table_without_times_are_those_of_the_problem(tmp_path):
    deck = deck_of(2)
    expected = solution(deck)
    parts = [columns_of(expected, 2, n) for n in range(len(expected.time))]
    table = {name: np.concatenate([p[name] for p in parts]) for name in parts[0] if name != "time"}
    write_table(tmp_path / "all.csv", table, ",", "")
    found = read_result(tmp_path, "all.csv", "", {}, deck)
    assert np.array_equal(found.time, deck.output_times)
    assert np.array_equal(found.fields["velocity"], expected.fields["velocity"])
    write_table(tmp_path / "all.csv", {name: values[1:] for name, values in table.items()}, ",", "")
    with pytest.raises(RunError, match=r"no column 'time', and .* rows are not those of"):
        read_result(tmp_path, "all.csv", "", {}, deck)


def test_the_time_step_is_the_largest_of_the_histories(tmp_path):
    deck = deck_of(1)
    expected = solution(deck)
    uneven = np.array([0.0, 0.1, 0.4, 1.0]) * deck.problem.end_time
    write_table(tmp_path / "histories.csv", {"time": uneven}, ",", "")
    found = read_result(tmp_path, as_npz(tmp_path, expected, 1), "histories.csv", {}, deck)
    assert found.dt == pytest.approx(0.6 * deck.problem.end_time)
    assert found.work.steps == 3


def test_a_point_has_one_number(tmp_path):
    deck = deck_of(1)
    expected = solution(deck)
    points = np.tile(np.arange(len(expected.reference), dtype=float), (len(expected.time), 1))
    points[:, 1] = 0
    np.savez(tmp_path / "all.npz", point=points, displacement=expected.fields["displacement"])
    with pytest.raises(RunError, match="one stands for two points"):
        read_result(tmp_path, "all.npz", "", {}, deck)


def test_an_own_name_stands_for_a_column_that_there_is(tmp_path):
    np.savez(tmp_path / "all.npz", displacement=solution(deck_of(1)).fields["displacement"])
    with pytest.raises(RunError, match="`columns` names 'bar', which is none of time"):
        read_result(tmp_path, "all.npz", "", {"foo": "bar"}, deck_of(1))


def test_reference_positions_do_not_move(tmp_path):
    deck = deck_of(2)
    expected = solution(deck)
    np.savez(tmp_path / "all.npz", reference=expected.position, weight=expected.weight, **expected.fields)
    with pytest.raises(RunError, match="differ between output times"):
        read_result(tmp_path, "all.npz", "", {}, deck)


def test_an_array_of_python_objects_is_not_loaded(tmp_path):
    np.savez(tmp_path / "all.npz", displacement=np.array([Path("x")], dtype=object))
    with pytest.raises(RunError, match="cannot be read"):
        read_result(tmp_path, "all.npz", "", {}, deck_of(1))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A whole file of each form."""
    folder, deck = tmp_path_factory.mktemp("whole"), deck_of(1)
    expected = solution(deck)
    for write in WRITERS:
        write(folder, expected, 1)
    return {path.suffix: path.read_bytes() for path in folder.iterdir() if path.stem in ("all", "out0")}


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_damaged_file_is_a_solution_or_a_sentence(data, whole, tmp_path):
    suffix = data.draw(st.sampled_from(sorted(whole)))
    body = bytearray(whole[suffix])
    start = data.draw(st.integers(0, len(body)))
    kind = data.draw(st.sampled_from(["cut", "overwrite", "insert", "noise"]))
    noise = data.draw(st.binary(max_size=60))
    if kind == "cut":
        body = body[:start]
    elif kind == "noise":
        body = bytearray(noise)
    else:
        body[start : start + (len(noise) if kind == "overwrite" else 0)] = noise
    for path in tmp_path.iterdir():
        path.unlink()
    (tmp_path / f"all{suffix}").write_bytes(body)
    with contextlib.suppress(RunError):
        assert malformed(read_result(tmp_path, f"all{suffix}", "", {}, deck_of(1)), 1) == ""
    assert [path.name for path in tmp_path.iterdir()] == [f"all{suffix}"]


@pytest.mark.parametrize("count", [1, 7, 400])
def test_a_body_force_is_the_sum_of_its_modes(count):
    X, t = np.linspace(0, 1, 11)[:, None], np.linspace(0, 3, count)

    def steady(t):
        return np.ones((len(t), 1, 1)) * X

    def smooth(t):
        return np.sin(5 * t[:, None, None] + X) * np.exp(X)

    def rough(t):
        return np.abs(np.sin(40 * t[:, None, None])) * X

    for force, fields in ((steady, 1), (smooth, 32), (rough, count)):
        amplitudes, modes = in_modes(force, t)
        assert len(modes) <= max(min(fields, count), 1)
        assert_close(np.tensordot(amplitudes, modes, axes=1), force(t), abs=1e-12 * np.exp(1))
    assert len(in_modes(lambda t: np.zeros((len(t), 3, 2)), t)[1]) == 1
