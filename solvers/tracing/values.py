"""What stands for numbers of compiled code, and for its arrays, while a traced function is called: to compute with it writes the code."""

from collections.abc import Iterator, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import models, register_model

COUNT = 4
"""Lanes of a register."""


class Lanes(types.Type):
    """Doubles that are computed with at the same time."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = Lanes()
TRUTH, WHOLE, DOUBLE = ir.IntType(1), ir.IntType(64), ir.DoubleType()
VECTOR = ir.VectorType(DOUBLE, COUNT)
KINDS: tuple[tuple[ir.Type, types.Type], ...] = (
    (TRUTH, types.boolean),
    (WHOLE, types.intp),
    (DOUBLE, types.float64),
    (VECTOR, LANES),
)
"""Of values, each more than the one before, with the types of numba."""


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Lanes) -> None:
        super().__init__(manager, lanes, VECTOR)


class Value:
    """A number, a truth or lanes of compiled code: to compute with it writes instructions."""

    def __init__(self, builder: ir.IRBuilder, code: ir.Value) -> None:
        self.builder, self.code = builder, code

    def _operated(self, instruction: str, x: Any, y: Any) -> "Value":
        a, b = alike(self.builder, x, y)
        if a.type == TRUTH:
            raise TypeError("truths are no numbers")
        write = getattr(self.builder, instruction if a.type == WHOLE else f"f{instruction}")
        return Value(self.builder, write(a, b))

    def _compared(self, predicate: str, y: Any) -> "Value":
        a, b = alike(self.builder, self, y)
        compare = self.builder.icmp_signed if a.type == WHOLE else self.builder.fcmp_ordered
        return Value(self.builder, compare(predicate, a, b))

    def __add__(self, y: Any) -> "Value":
        return self._operated("add", self, y)

    def __radd__(self, x: Any) -> "Value":
        return self._operated("add", x, self)

    def __sub__(self, y: Any) -> "Value":
        return self._operated("sub", self, y)

    def __rsub__(self, x: Any) -> "Value":
        return self._operated("sub", x, self)

    def __mul__(self, y: Any) -> "Value":
        return self._operated("mul", self, y)

    def __rmul__(self, x: Any) -> "Value":
        return self._operated("mul", x, self)

    def _divided(self, instruction: str, y: Any) -> "Value":
        a, b = alike(self.builder, self, y)
        if a.type != WHOLE:
            raise TypeError("only whole numbers have a whole quotient and a remainder")
        return Value(self.builder, getattr(self.builder, instruction)(a, b))

    def __mod__(self, y: Any) -> "Value":
        """Remainder of a whole number that is not negative."""
        return self._divided("urem", y)

    def __floordiv__(self, y: Any) -> "Value":
        """Whole quotient of a whole number that is not negative."""
        return self._divided("udiv", y)

    def __truediv__(self, y: Any) -> "Value":
        return self._operated("div", real(self), y)

    def __rtruediv__(self, x: Any) -> "Value":
        return self._operated("div", x, real(self))

    def __neg__(self) -> "Value":
        return Value(self.builder, self.builder.neg(self.code) if self.code.type == WHOLE else self.builder.fneg(self.code))

    def __lt__(self, y: Any) -> "Value":
        return self._compared("<", y)

    def __le__(self, y: Any) -> "Value":
        return self._compared("<=", y)

    def __gt__(self, y: Any) -> "Value":
        return self._compared(">", y)

    def __ge__(self, y: Any) -> "Value":
        return self._compared(">=", y)

    def __and__(self, y: "Value") -> "Value":
        return Value(self.builder, self.builder.and_(self.code, code_of(self.builder, y, self.code.type)))

    def __or__(self, y: "Value") -> "Value":
        return Value(self.builder, self.builder.or_(self.code, code_of(self.builder, y, self.code.type)))

    def __bool__(self) -> bool:
        raise TypeError("a traced function has no branches on values, see `where`")

    def __eq__(self, y: object) -> bool:
        raise TypeError("values are not compared by ==, which Python would take for their identity: see `where`")


class Four:
    """Index of as many in a row as a register has lanes, from one on."""

    def __init__(self, first: Value) -> None:
        self.first = first


class Memory:
    """An array of compiled code, or a part of one, without gaps; only a number of Python as an index may count from the end."""

    def __init__(
        self, context: Any, builder: ir.IRBuilder, kind: types.Array, data: ir.Value, shape: Sequence[ir.Value]
    ) -> None:
        self.context, self.builder, self.kind, self.data = context, builder, kind, data
        self.shape = tuple(Value(builder, length) for length in shape)

    def address(self, *index: Any) -> ir.Value:
        """Address of what is stored from an index on."""
        if len(index) > len(self.shape):
            raise TypeError(f"{len(index)} indices of {self.kind}")
        place: Any = 0
        for axis, length in enumerate(self.shape):
            k = index[axis] if axis < len(index) else 0
            place = place * length + (length + k if isinstance(k, int) and k < 0 else k)
        return beyond(self.builder, self.data, place)

    def __getitem__(self, index: Any) -> Any:
        *before, last = index if isinstance(index, tuple) else (index,)
        if len(before) + 1 < len(self.shape):
            lengths = [length.code for length in self.shape[len(before) + 1 :]]
            return Memory(self.context, self.builder, self.kind, self.address(*before, last), lengths)
        if isinstance(last, Four):
            return Value(self.builder, self.together(self.address(*before, last.first), VECTOR))
        return self.load(self.address(*before, last), 0)

    def __setitem__(self, index: Any, x: Any) -> None:
        *before, last = index if isinstance(index, tuple) else (index,)
        if len(before) + 1 != len(self.shape):
            raise TypeError(f"{len(before) + 1} indices of {self.kind} for one number")
        if isinstance(last, Four):
            self.store_together(self.address(*before, last.first), code_of(self.builder, x, VECTOR))
        else:
            self.store(self.address(*before, last), 0, x)

    def load(self, address: ir.Value, k: int) -> Value:
        """The k-th number from an address on."""
        found = self.builder.load(beyond(self.builder, address, k))
        return Value(self.builder, loaded(self.context, self.builder, self.kind.dtype, found))

    def store(self, address: ir.Value, k: int, x: Any) -> None:
        """Write a number as the k-th from an address on; TypeError unless it may be."""
        kind = self.kind.dtype
        if isinstance(kind, types.Integer) and self.kind.mutable and rank(x) == 1:
            code = self.context.cast(self.builder, code_of(self.builder, x, WHOLE), types.intp, kind)
        else:
            self._of_doubles(written=True)
            code = code_of(self.builder, x, DOUBLE)
        self.builder.store(code, beyond(self.builder, address, k))

    def together(self, address: ir.Value, kind: ir.VectorType) -> ir.Value:
        """The doubles from an address on, as many as fill a vector; TypeError where there are none."""
        self._of_doubles(written=False)
        return self.builder.load(self.builder.bitcast(address, kind.as_pointer()), align=8)

    def store_together(self, address: ir.Value, vector: ir.Value) -> None:
        """Write doubles from an address on; TypeError unless they may be."""
        self._of_doubles(written=True)
        self.builder.store(vector, self.builder.bitcast(address, vector.type.as_pointer()), align=8)

    def _of_doubles(self, *, written: bool) -> None:
        if self.kind.dtype != types.float64 or (written and not self.kind.mutable):
            raise TypeError(f"{self.kind} is no array of doubles{' that is written to' if written else ''}")


def loaded(context: Any, builder: ir.IRBuilder, kind: types.Type, code: ir.Value) -> ir.Value:
    """A number of compiled code, a whole one as wide as others."""
    return context.cast(builder, code, kind, types.intp) if isinstance(kind, types.Integer) else code


def beyond(builder: ir.IRBuilder, address: ir.Value, k: Any) -> ir.Value:
    """Address of the k-th number from one on."""
    return builder.gep(address, [code_of(builder, k, WHOLE)])


def splat(builder: ir.IRBuilder, code: ir.Value) -> ir.Value:
    """A number in every lane; lanes as they are."""
    if isinstance(code.type, ir.VectorType):
        return code
    one = builder.insert_element(ir.Constant(ir.VectorType(code.type, COUNT), ir.Undefined), code, cgutils.int32_t(0))
    return shuffled(builder, one, one, [0] * COUNT)


def shuffled(builder: ir.IRBuilder, a: ir.Value, b: ir.Value, numbers: list[int]) -> ir.Value:
    """Lanes of two registers by number, those of the second counted on."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(cgutils.int32_t, len(numbers)), numbers))


def code_of(builder: ir.IRBuilder, x: Any, kind: ir.Type) -> ir.Value:
    """A number or a value as code of a kind that can hold it; TypeError for a value of another function."""
    if not isinstance(x, Value):
        return ir.Constant(kind, [float(x)] * COUNT if kind == VECTOR else x)
    if x.builder.function is not builder.function:
        raise TypeError("a value of another function: what runs in threads sees what is shared alone")
    code = x.code
    if code.type == WHOLE and kind in (DOUBLE, VECTOR):
        code = builder.sitofp(code, DOUBLE)
    code = splat(builder, code) if kind == VECTOR else code
    if code.type != kind:
        raise TypeError(f"{code.type} is no {kind}")
    return code


def alike(builder: ir.IRBuilder, *items: Any) -> list[ir.Value]:
    """Numbers and values as code of one kind: lanes, if one of them is, else doubles, if one is."""
    kind = KINDS[max(rank(x) for x in items)][0]
    return [code_of(builder, x, kind) for x in items]


def rank(x: Any) -> int:
    """Place in `KINDS` of a number or a value."""
    if isinstance(x, Value):
        return [kind for kind, _ in KINDS].index(x.code.type)
    return 0 if isinstance(x, bool) else 1 if isinstance(x, int) else 2


def real(x: Any) -> Any:
    """A whole number as a double."""
    return Value(x.builder, code_of(x.builder, x, DOUBLE)) if isinstance(x, Value) and x.code.type == WHOLE else x


def where(truth: Any, a: Any, b: Any) -> Any:
    """The first where something is true, else the second: arrays of one kind, numbers, values, or tuples, of which both are computed."""
    if not isinstance(truth, Value):
        return a if truth else b
    if isinstance(a, tuple):
        return tuple(where(truth, x, y) for x, y in zip(a, b, strict=True))
    if a is b:
        return a
    if isinstance(a, Memory):
        data = a.builder.select(truth.code, a.data, b.data)
        lengths = [where(truth, x, y).code for x, y in zip(a.shape, b.shape, strict=True)]
        return Memory(a.context, a.builder, a.kind, data, lengths)
    x, y = alike(truth.builder, a, b)
    if isinstance(truth.code.type, ir.VectorType):
        x, y = (code_of(truth.builder, Value(truth.builder, code), VECTOR) for code in (x, y))
    return Value(truth.builder, truth.builder.select(truth.code, x, y))


def equal(a: Any, b: Any) -> Any:
    """Whether two whole numbers are equal."""
    if not isinstance(a, Value):
        return a == b
    return Value(a.builder, a.builder.icmp_signed("==", *alike(a.builder, a, b)))


def opposite(truth: Any) -> Any:
    """Whether something is not true."""
    return where(truth, False, True)


def leaves(found: Any) -> list[ir.Value]:
    """The code that values, arrays and tuples of these are made of."""
    if isinstance(found, tuple):
        return [code for item in found for code in leaves(item)]
    if isinstance(found, Memory):
        return [found.data, *(length.code for length in found.shape)]
    return [found.code] if isinstance(found, Value) else []


def rebuilt(found: Any, builder: ir.IRBuilder, codes: Iterator[ir.Value]) -> Any:
    """The same made of other code."""
    if isinstance(found, tuple):
        items = [rebuilt(item, builder, codes) for item in found]
        return type(found)(*items) if hasattr(found, "_fields") else tuple(items)
    if isinstance(found, Memory):
        return Memory(found.context, builder, found.kind, next(codes), [next(codes) for _ in found.shape])
    return Value(builder, next(codes)) if isinstance(found, Value) else found
