"""Tracing compiler: numerical code written as plain Python on tuples, compiled by calling it.

What belongs here: values and arrays of compiled code, arithmetic and elementary functions on scalars and on vectors of `LANES` doubles,
control flow at run time, functions that calls share, loops in threads, and the compilation and its cache. Nothing else in the
repository imports llvmlite. What does not belong here: anything of a numerical method or of mechanics, such as
particles, grids, tensors or laws. The handbook's page `tracing` tells how a traced function differs from Python.
"""

from .arrays import Array, Consecutive, Pointer, Table
from .compilation import Compiled, checksum
from .control import Variable, cond, for_range, for_strides, leavable, switch, when, while_loop
from .elementary import acos, asinh, atanh, cos, exp, expm1, log, power
from .lanes import (
    absolute,
    all_positive,
    as_integer,
    count_leading,
    fill_from_first,
    floor,
    has_lanes,
    leading_ones,
    maximum,
    minimum,
    pack,
    reduce_sum,
    reduce_sums,
    split_floor,
    sqrt,
    unpack,
)
from .outline import outlined
from .rows import add_sums, load_row, load_rows, store_rows
from .selection import equal, logical_not, where
from .threads import parallel_for, start_threads
from .tracer import traced
from .values import LANES, Value, as_double, valued

__all__ = [
    "LANES",
    "Array",
    "Compiled",
    "Consecutive",
    "Pointer",
    "Table",
    "Value",
    "Variable",
    "absolute",
    "acos",
    "add_sums",
    "all_positive",
    "as_double",
    "as_integer",
    "asinh",
    "atanh",
    "checksum",
    "cond",
    "cos",
    "count_leading",
    "equal",
    "exp",
    "expm1",
    "fill_from_first",
    "floor",
    "for_range",
    "for_strides",
    "has_lanes",
    "leading_ones",
    "leavable",
    "load_row",
    "load_rows",
    "log",
    "logical_not",
    "maximum",
    "minimum",
    "outlined",
    "pack",
    "parallel_for",
    "power",
    "reduce_sum",
    "reduce_sums",
    "split_floor",
    "sqrt",
    "start_threads",
    "store_rows",
    "switch",
    "traced",
    "unpack",
    "valued",
    "when",
    "where",
    "while_loop",
]
