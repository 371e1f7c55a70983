"""Arrays of compiled code, addresses in them, and small tables on the stack."""

from collections.abc import Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from .values import DOUBLE, INTEGER, LANES, VECTOR, Value, as_code, promoted, rank, shuffle


class Consecutive:
    """Index of `LANES` consecutive elements along the last axis, from `first` on."""

    def __init__(self, first: Value) -> None:
        self.first = first


class Array:
    """A C-contiguous array of compiled code, or a part of one.

    Only a Python integer as an index may be negative and count from the end. Indices are not checked against the shape.

    Parameters
    ----------
    context : numba target context
    builder : IRBuilder
    kind : numba.types.Array
    data : ir.Value
        Address of the first element.
    shape : sequence of ir.Value
    """

    def __init__(
        self, context: Any, builder: ir.IRBuilder, kind: types.Array, data: ir.Value, shape: Sequence[ir.Value]
    ) -> None:
        self.context, self.builder, self.kind, self.data = context, builder, kind, data
        self.shape = tuple(Value(builder, length) for length in shape)

    def pointer(self, *index: Any) -> "Pointer":
        """Return the address of an element, or of the first element of a part.

        Raises
        ------
        TypeError
            If there are more indices than axes.
        """
        if len(index) > len(self.shape):
            raise TypeError(f"{len(index)} indices for {self.kind}: give at most {len(self.shape)}")
        place: Any = 0
        for axis, length in enumerate(self.shape):
            k = index[axis] if axis < len(index) else 0
            place = place * length + (length + k if isinstance(k, int) and k < 0 else k)
        return Pointer(self.context, self.builder, self.kind, self.data).offset(place)

    def __getitem__(self, index: Any) -> Any:
        *before, last = index if isinstance(index, tuple) else (index,)
        if len(before) + 1 < len(self.shape):
            lengths = [length.code for length in self.shape[len(before) + 1 :]]
            return Array(self.context, self.builder, self.kind, self.pointer(*before, last).address, lengths)
        if isinstance(last, Consecutive):
            return Value(self.builder, self.pointer(*before, last.first).load_vector(VECTOR))
        return self.pointer(*before, last).load()

    def __setitem__(self, index: Any, x: Any) -> None:
        *before, last = index if isinstance(index, tuple) else (index,)
        if len(before) + 1 != len(self.shape):
            raise TypeError(f"one element of {self.kind} takes {len(self.shape)} indices, not {len(before) + 1}")
        if isinstance(last, Consecutive):
            self.pointer(*before, last.first).store_vector(as_code(self.builder, x, VECTOR))
        else:
            self.pointer(*before, last).store(x)


class Pointer:
    """Address of an element of an array."""

    def __init__(self, context: Any, builder: ir.IRBuilder, kind: types.Array, address: ir.Value) -> None:
        self.context, self.builder, self.kind, self.address = context, builder, kind, address

    def offset(self, k: Any) -> "Pointer":
        """Return the address of the element that is k further on."""
        return Pointer(self.context, self.builder, self.kind, self._beyond(k))

    def load(self, k: int = 0) -> Value:
        """Return the element that is k further on; integers are widened to 64 bits."""
        kind, found = self.kind.dtype, self.builder.load(self._beyond(k), typ=self._element)
        return Value(self.builder, widened(self.context, self.builder, kind, found))

    def store(self, x: Any, k: int = 0) -> None:
        """Write to the element that is k further on.

        Raises
        ------
        TypeError
            If the array is read-only or its elements cannot hold the value.
        """
        kind = self.kind.dtype
        if isinstance(kind, types.Integer) and self.kind.mutable and rank(x) == 1:
            code = self.context.cast(self.builder, as_code(self.builder, x, INTEGER), types.intp, kind)
        else:
            self._check_doubles(written=True)
            code = as_code(self.builder, x, DOUBLE)
        self.builder.store(code, self._beyond(k))

    def add(self, x: Any, k: int = 0) -> None:
        """Add a number to the element that is k further on."""
        self.store(self.load(k) + x, k)

    def add_lanes(self, x: Value, first: int = 0, count: int = LANES) -> None:
        """Add `count` lanes of a vector, from lane `first` on, to as many consecutive elements."""
        lanes = list(range(first, first + count))
        some = x.code if len(lanes) == LANES else shuffle(self.builder, x.code, x.code, lanes)
        self.store_vector(self.builder.fadd(self.load_vector(some.type), some))

    def load_vector(self, kind: ir.VectorType) -> ir.Value:
        """Return as many consecutive doubles as a type of vector holds; TypeError for other elements."""
        self._check_doubles(written=False)
        return self.builder.load(self.builder.bitcast(self.address, kind.as_pointer()), align=8, typ=kind)

    def store_vector(self, vector: ir.Value) -> None:
        """Write a vector of doubles to consecutive elements; TypeError if the array does not take them."""
        self._check_doubles(written=True)
        self.builder.store(vector, self.builder.bitcast(self.address, vector.type.as_pointer()), align=8)

    @property
    def _element(self) -> ir.Type:
        return self.context.get_data_type(self.kind.dtype)

    def _beyond(self, k: Any) -> ir.Value:
        return self.builder.gep(self.address, [as_code(self.builder, k, INTEGER)], source_etype=self._element)

    def _check_doubles(self, *, written: bool) -> None:
        if self.kind.dtype != types.float64 or (written and not self.kind.mutable):
            raise TypeError(f"{self.kind} is no {'writable ' if written else ''}array of doubles")


class Table:
    """Values in an array on the stack, which compiled code looks up by an index.

    Parameters
    ----------
    values : sequence of Value or float
    like : Value or Array
        Of the function that the table is part of.
    """

    def __init__(self, values: Sequence[Any], like: Any) -> None:
        builder = like.builder
        items = promoted(builder, *values)
        self.builder, self.kind = builder, items[0].type
        self.place = cgutils.alloca_once(builder, self.kind, size=len(items))
        for k, item in enumerate(items):
            builder.store(item, self._address(INTEGER(k)))

    def __getitem__(self, k: Value) -> Value:
        return Value(self.builder, self.builder.load(self._address(k.code), typ=self.kind))

    def _address(self, k: ir.Value) -> ir.Value:
        return self.builder.gep(self.place, [k], inbounds=True, source_etype=self.kind)


def widened(context: Any, builder: ir.IRBuilder, kind: types.Type, code: ir.Value) -> ir.Value:
    """Code of a number with integers widened to 64 bits."""
    return context.cast(builder, code, kind, types.intp) if isinstance(kind, types.Integer) else code
