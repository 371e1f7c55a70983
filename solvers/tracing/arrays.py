"""Arrays of compiled code, addresses in them, and small tables on the stack."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from .values import DOUBLE, FUSED, INTEGER, LANES, VECTOR, Value, as_code, on_stack, promoted, rank, shuffle


class Kind(NamedTuple):
    """Kind of an array.

    dtype : numpy.dtype
        Of the elements: doubles or integers.
    axes : int
        Their number.
    mutable : bool
        Whether elements may be written.
    """

    dtype: "np.dtype[Any]"
    axes: int
    mutable: bool

    def __str__(self) -> str:
        return f"{'an' if self.mutable else 'a read-only'} array of {self.dtype.str} with {self.axes} axes"

    @property
    def element(self) -> ir.Type:
        return DOUBLE if self.dtype.kind == "f" else ir.IntType(8 * self.dtype.itemsize)


class Consecutive:
    """Index of `LANES` consecutive elements along the last axis, from `first` on."""

    def __init__(self, first: Value) -> None:
        self.first = first


class Array:
    """A C-contiguous array of compiled code, or a part of one.

    Only a Python integer as an index may be negative and count from the end. Indices are not checked against the shape.

    Parameters
    ----------
    builder : IRBuilder
    kind : Kind
    data : ir.Value
        Address of the first element.
    shape : sequence of ir.Value
    """

    def __init__(self, builder: ir.IRBuilder, kind: Kind, data: ir.Value, shape: Sequence[ir.Value]) -> None:
        self.builder, self.kind, self.data = builder, kind, data
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
        return Pointer(self.builder, self.kind, self.data).offset(place)

    def head(self, count: Any) -> "Array":
        """Return the first `count` elements or parts along the first axis."""
        first = as_code(self.builder, count, INTEGER)
        return Array(self.builder, self.kind, self.data, [first, *(length.code for length in self.shape[1:])])

    def __getitem__(self, index: Any) -> Any:
        *before, last = index if isinstance(index, tuple) else (index,)
        if len(before) + 1 < len(self.shape):
            lengths = [length.code for length in self.shape[len(before) + 1 :]]
            kind = self.kind._replace(axes=len(lengths))
            return Array(self.builder, kind, self.pointer(*before, last).address, lengths)
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

    def __init__(self, builder: ir.IRBuilder, kind: Kind, address: ir.Value) -> None:
        self.builder, self.kind, self.address = builder, kind, address

    def offset(self, k: Any) -> "Pointer":
        """Return the address of the element that is k further on."""
        return Pointer(self.builder, self.kind, self._beyond(k))

    def load(self, k: int = 0) -> Value:
        """Return the element that is k further on; integers are widened to 64 bits."""
        found, dtype = self.builder.load(self._beyond(k), typ=self.kind.element), self.kind.dtype
        if dtype.kind != "f" and dtype.itemsize < 8:
            found = (self.builder.zext if dtype.kind == "u" else self.builder.sext)(found, INTEGER)
        return Value(self.builder, found)

    def store(self, x: Any, k: int = 0) -> None:
        """Write to the element that is k further on.

        Raises
        ------
        TypeError
            If the array is read-only or its elements cannot hold the value.
        """
        if self.kind.dtype.kind != "f" and self.kind.mutable and rank(x) == 1:
            code = as_code(self.builder, x, INTEGER)
            code = self.builder.trunc(code, self.kind.element) if self.kind.dtype.itemsize < 8 else code
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
        self.store_vector(self.builder.fadd(self.load_vector(some.type), some, flags=FUSED))

    def load_vector(self, kind: ir.VectorType) -> ir.Value:
        """Return as many consecutive doubles as a type of vector holds; TypeError for other elements."""
        self._check_doubles(written=False)
        return self.builder.load(self.builder.bitcast(self.address, kind.as_pointer()), align=8, typ=kind)

    def store_vector(self, vector: ir.Value) -> None:
        """Write a vector of doubles to consecutive elements; TypeError if the array does not take them."""
        self._check_doubles(written=True)
        self.builder.store(vector, self.builder.bitcast(self.address, vector.type.as_pointer()), align=8)

    def _beyond(self, k: Any) -> ir.Value:
        return self.builder.gep(self.address, [as_code(self.builder, k, INTEGER)], source_etype=self.kind.element)

    def _check_doubles(self, *, written: bool) -> None:
        if self.kind.dtype.kind != "f" or (written and not self.kind.mutable):
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
        self.place = on_stack(builder, self.kind, len(items))
        for k, item in enumerate(items):
            builder.store(item, self._address(INTEGER(k)))

    def __getitem__(self, k: Value) -> Value:
        return Value(self.builder, self.builder.load(self._address(k.code), typ=self.kind))

    def _address(self, k: ir.Value) -> ir.Value:
        return self.builder.gep(self.place, [k], inbounds=True, source_etype=self.kind)
