"""Arithmetic that is compiled by being called, on values that stand for numbers of compiled code and write it.

Python runs a traced function once for each call of it that is compiled: what it asks of lengths, and its loops over them, are known by then
and make no code. Such a function has no branches on values, see `where`, and what `flow` has in their place. To numba it is one instruction, where it
would take a tenth of a second for a function of its own. Where there are neither arrays nor lanes it is what it says to Python, too,
but that both of what `where` is given have to exist.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.registry import cpu_target
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin

from .values import KINDS, LANES, VECTOR, Memory, Value, code_of, loaded, rank

F = TypeVar("F", bound=Callable[..., Any])
Tuples: Any = types.BaseTuple
NamedTuples: Any = types.BaseNamedTuple
DECLARED: dict[Any, types.Type] = {None: types.none, int: types.intp, bool: types.boolean}
"""What an annotation says of what a traced function returns."""


def wrapped(context: Any, builder: ir.IRBuilder, kind: Any, code: ir.Value) -> Any:
    """What a traced function gets for an argument of compiled code."""
    if isinstance(kind, Tuples):
        parts = zip(kind, cgutils.unpack_tuple(builder, code), strict=True)
        items = [wrapped(context, builder, *part) for part in parts]
        return kind.instance_class(*items) if isinstance(kind, NamedTuples) else tuple(items)
    if isinstance(kind, types.Array):
        if kind.layout != "C":
            raise TypeError(f"{kind} may have gaps")
        model = context.data_model_manager[kind]
        data, shape = (builder.extract_value(code, model.get_field_position(name)) for name in ("data", "shape"))
        return Memory(context, builder, kind, data, cgutils.unpack_tuple(builder, shape))
    return None if kind == types.none else Value(builder, loaded(context, builder, kind, code))


def kind_of(found: Any) -> types.Type:
    """Type for numba of what a traced function returns; the numbers of a tuple are lanes if one of them is."""
    if found is None:
        return types.none
    if not isinstance(found, tuple):
        return KINDS[rank(found)][1]
    lanewise = any(isinstance(item, Value) and item.code.type == VECTOR for item in found)
    kinds = [kind_of(item) for item in found]
    if lanewise and type(found) is tuple:
        kinds = [LANES if kind == types.float64 else kind for kind in kinds]
    return types.BaseTuple.from_types(kinds, type(found))


def unwrapped(context: Any, builder: ir.IRBuilder, kind: Any, found: Any) -> ir.Value:
    """What a traced function returns as compiled code."""
    if isinstance(kind, Tuples):
        parts = zip(kind, found, strict=True)
        return context.make_tuple(builder, kind, [unwrapped(context, builder, *part) for part in parts])
    if kind == types.none:
        return context.get_dummy_value()
    return code_of(builder, found, next(code for code, numba in KINDS if numba == kind))


def traced(function: F) -> F:
    """Compile calls of a function by calling it; compiled functions call it, and other traced ones, and Python."""
    known: dict[tuple[types.Type, ...], types.Type] = {}
    declared = DECLARED.get(function.__annotations__.get("return", ...))

    def returned(args: tuple[types.Type, ...]) -> types.Type:
        """What the function returns, which unless it says so is found by writing code that is thrown away."""
        if declared is not None:
            return declared
        if args not in known:
            context = cpu_target.target_context
            nowhere = ir.FunctionType(ir.VoidType(), [context.get_value_type(arg) for arg in args])
            body = ir.Function(ir.Module(), nowhere, "nowhere")
            builder = ir.IRBuilder(body.append_basic_block())
            items = [wrapped(context, builder, *part) for part in zip(args, body.args, strict=True)]
            with context.push_code_library(context.codegen().create_library("nowhere")):
                known[args] = kind_of(function(*items))
        return known[args]

    class Typed(AbstractTemplate):
        key = function

        def generic(self, args: tuple[types.Type, ...], kws: dict[str, types.Type]) -> Any:
            plain = tuple(types.unliteral(arg) for arg in args)
            return signature(returned(plain), *plain)

    infer_global(function, types.Function(Typed))

    @lower_builtin(function, types.VarArg(types.Any))
    def _written(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> ir.Value:
        items = [wrapped(context, builder, *part) for part in zip(sig.args, args, strict=True)]
        return unwrapped(context, builder, sig.return_type, function(*items))

    return function


def builder_of(args: Any) -> Any:
    """What writes the code of a value among some."""
    if not isinstance(args, tuple):
        return getattr(args, "builder", None)
    return next((found for found in map(builder_of, args) if found is not None), None)
