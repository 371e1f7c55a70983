"""Values of compiled code: to compute with a `Value` emits LLVM instructions."""

from functools import cache
from typing import Any

from llvmlite import ir

LANES = 4
"""Number of lanes of a vector."""
BOOLEAN, INTEGER, DOUBLE, NUMBER = ir.IntType(1), ir.IntType(64), ir.DoubleType(), ir.IntType(32)
"""Types of values, and `NUMBER`, the type of the number of a lane or of what is on the stack."""
VECTOR = ir.VectorType(DOUBLE, LANES)
KINDS: tuple[ir.Type, ...] = (BOOLEAN, INTEGER, DOUBLE, VECTOR)
"""Kinds of values in order of promotion."""
RANKS = {kind: rank for rank, kind in enumerate(KINDS)}
"""Index of each kind in `KINDS`."""
FUSED = ("contract",)
"""Flags of arithmetic: a product and a sum may be fused; nothing else that changes results is allowed."""


class Value:
    """A boolean, an integer, a double or a vector of doubles of compiled code; its operators emit instructions."""

    def __init__(self, builder: ir.IRBuilder, code: ir.Value) -> None:
        self.builder, self.code = builder, code

    def _operated(self, instruction: str, x: Any, y: Any) -> "Value":
        a, b = promoted(self.builder, x, y)
        if a.type == BOOLEAN:
            raise TypeError("booleans have no arithmetic: select numbers with `where`")
        if a.type == INTEGER:
            return Value(self.builder, getattr(self.builder, instruction)(a, b))
        return Value(self.builder, getattr(self.builder, f"f{instruction}")(a, b, flags=FUSED))

    def _compared(self, predicate: str, y: Any) -> "Value":
        a, b = promoted(self.builder, self, y)
        compare = self.builder.icmp_signed if a.type == INTEGER else self.builder.fcmp_ordered
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
        a, b = promoted(self.builder, self, y)
        if a.type != INTEGER:
            raise TypeError("// and % take integers only: use `floor` for doubles")
        return Value(self.builder, getattr(self.builder, instruction)(a, b))

    def __mod__(self, y: Any) -> "Value":
        """Remainder of integers that are not negative."""
        return self._divided("urem", y)

    def __floordiv__(self, y: Any) -> "Value":
        """Quotient of integers that are not negative."""
        return self._divided("udiv", y)

    def __truediv__(self, y: Any) -> "Value":
        return self._operated("div", as_double(self), y)

    def __rtruediv__(self, x: Any) -> "Value":
        return self._operated("div", x, as_double(self))

    def __neg__(self) -> "Value":
        code = self.code
        return Value(self.builder, self.builder.neg(code) if code.type == INTEGER else self.builder.fneg(code, flags=FUSED))

    def __lt__(self, y: Any) -> "Value":
        return self._compared("<", y)

    def __le__(self, y: Any) -> "Value":
        return self._compared("<=", y)

    def __gt__(self, y: Any) -> "Value":
        return self._compared(">", y)

    def __ge__(self, y: Any) -> "Value":
        return self._compared(">=", y)

    def __and__(self, y: "Value") -> "Value":
        return Value(self.builder, self.builder.and_(self.code, as_code(self.builder, y, self.code.type)))

    def __or__(self, y: "Value") -> "Value":
        return Value(self.builder, self.builder.or_(self.code, as_code(self.builder, y, self.code.type)))

    def __bool__(self) -> bool:
        raise TypeError("a traced function cannot branch on a value: use `where`, `cond` or `when`")

    def __eq__(self, y: object) -> bool:
        raise TypeError("values are not compared by ==, which Python may take for identity: use `equal`")


def as_code(builder: ir.IRBuilder, x: Any, kind: ir.Type) -> ir.Value:
    """Code of a number or a value, promoted to a kind.

    Raises
    ------
    TypeError
        If the kind cannot hold the value, or the value belongs to another function.
    """
    if not isinstance(x, Value):
        return _in_lanes(float(x).hex()) if kind == VECTOR else ir.Constant(kind, x)
    if x.builder is builder and x.code.type is kind:
        return x.code
    if x.builder.function is not builder.function:
        raise TypeError(
            "a value of another function cannot be used here: pass it as an argument, or to `parallel_for` as shared"
        )
    code = x.code
    if code.type == INTEGER and kind in (DOUBLE, VECTOR):
        code = builder.sitofp(code, DOUBLE)
    code = broadcast(builder, code) if kind == VECTOR else code
    if code.type != kind:
        raise TypeError(f"a value of type {code.type} cannot become one of type {kind}")
    return code


@cache
def _in_lanes(number: str) -> ir.Constant:
    """Vector of a double in every lane, by its hexadecimal text, which tells the zeros apart; one object, so that it is written once."""
    return ir.Constant(VECTOR, [float.fromhex(number)] * LANES)


def promoted(builder: ir.IRBuilder, *items: Any) -> list[ir.Value]:
    """Code of numbers and values, all promoted to the highest of their kinds."""
    kind = KINDS[max(map(rank, items))]
    return [as_code(builder, x, kind) for x in items]


def rank(x: Any) -> int:
    """Index in `KINDS` of the kind of a number or a value."""
    if isinstance(x, Value):
        return RANKS[x.code.type]
    return 0 if isinstance(x, bool) else 1 if isinstance(x, int) else 2


def as_double(x: Any) -> Any:
    """Promote an integer value to a double; anything else stays as it is."""
    return Value(x.builder, as_code(x.builder, x, DOUBLE)) if isinstance(x, Value) and x.code.type == INTEGER else x


def broadcast(builder: ir.IRBuilder, code: ir.Value) -> ir.Value:
    """Copy a scalar to every lane; a vector stays as it is."""
    if isinstance(code.type, ir.VectorType):
        return code
    first = builder.insert_element(ir.Constant(ir.VectorType(code.type, LANES), ir.Undefined), code, NUMBER(0))
    return shuffle(builder, first, first, [0] * LANES)


def shuffle(builder: ir.IRBuilder, a: ir.Value, b: ir.Value, lanes: list[int]) -> ir.Value:
    """Vector of chosen lanes of two vectors; the lanes of the second are counted on from those of the first."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(NUMBER, len(lanes)), lanes))


def valued(tree: Any, like: Any) -> Any:
    """Return a number of Python, or a tree of numbers, as values of the function that `like` belongs to; values and arrays stay."""
    if isinstance(tree, tuple):
        items = [valued(item, like) for item in tree]
        return type(tree)(*items) if hasattr(tree, "_fields") else tuple(items)
    if isinstance(tree, bool | int | float):
        return Value(like.builder, ir.Constant(KINDS[rank(tree)], tree))
    return tree


def on_stack(builder: ir.IRBuilder, kind: ir.Type, count: int = 1) -> ir.Value:
    """Address of room for some values of a type on the stack of the function, also where the code is in a loop."""
    with builder.goto_entry_block():
        return builder.alloca(kind, size=count)


def external(builder: ir.IRBuilder, name: str, kind: ir.FunctionType) -> ir.Function:
    """Function of this name that the module does not define: an intrinsic one of LLVM, or one of the process."""
    found = builder.module.globals.get(name)
    return ir.Function(builder.module, kind, name) if found is None else found
