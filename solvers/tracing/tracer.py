"""Tracing compiler: calling a Python function on `Value`s emits its LLVM IR.

Python runs a traced function once for each compiled call. What depends only on lengths of tuples and on numbers of Python is settled
then and emits no code; a loop over a tuple is unrolled. Numba sees a single instruction, where a jitted function of its own would
take a tenth of a second to compile.
"""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.registry import cpu_target
from numba.core.typing import signature
from numba.extending import lower_builtin, type_callable

from .arrays import Array, widened
from .values import KINDS, LANES_TYPE, Value, as_code, rank

F = TypeVar("F", bound=Callable[..., Any])
Tuples: Any = types.BaseTuple
NamedTuples: Any = types.BaseNamedTuple
ANNOTATED: dict[Any, types.Type] = {None: types.none, int: types.intp, bool: types.boolean}
"""Types of results that an annotation tells without a trace."""


def wrap(context: Any, builder: ir.IRBuilder, kind: Any, code: ir.Value) -> Any:
    """Argument of a traced function that stands for an argument of compiled code."""
    if isinstance(kind, Tuples):
        parts = zip(kind, cgutils.unpack_tuple(builder, code), strict=True)
        items = [wrap(context, builder, *part) for part in parts]
        return kind.instance_class(*items) if isinstance(kind, NamedTuples) else tuple(items)
    if isinstance(kind, types.Array):
        if kind.layout != "C":
            raise TypeError(f"{kind} may have gaps: pass a C-contiguous array")
        model = context.data_model_manager[kind]
        data, shape = (builder.extract_value(code, model.get_field_position(name)) for name in ("data", "shape"))
        return Array(context, builder, kind, data, cgutils.unpack_tuple(builder, shape))
    return None if kind == types.none else Value(builder, widened(context, builder, kind, code))


def type_of(result: Any) -> types.Type:
    """Numba's type of what a traced function returns; the numbers in a plain tuple are vectors if one of them is."""
    if result is None:
        return types.none
    if not isinstance(result, tuple):
        return KINDS[rank(result)][1]
    kinds = [type_of(item) for item in result]
    if LANES_TYPE in kinds and type(result) is tuple:
        kinds = [LANES_TYPE if kind == types.float64 else kind for kind in kinds]
    return types.BaseTuple.from_types(kinds, type(result))


def unwrap(context: Any, builder: ir.IRBuilder, kind: Any, result: Any) -> ir.Value:
    """Code of what a traced function returns."""
    if isinstance(kind, Tuples):
        parts = zip(kind, result, strict=True)
        return context.make_tuple(builder, kind, [unwrap(context, builder, *part) for part in parts])
    if kind == types.none:
        return context.get_dummy_value()
    return as_code(builder, result, next(code for code, numba in KINDS if numba == kind))


def traced(function: F) -> F:
    """Make a function callable from compiled code, which compiles each call of it by a trace.

    Parameters
    ----------
    function : callable
        Of numbers, values, C-contiguous arrays and tuples of these. An annotation of its result as `int`, `bool` or `None` saves the
        trace that finds out the type.

    Returns
    -------
    callable
        The function itself: jitted functions, other traced functions and Python call it.

    Raises
    ------
    TypeError
        If the function takes any number of arguments; when a call is compiled, if the function branches on a value or uses one as the wrong type.
    """
    parameters = inspect.signature(function)
    if any(one.kind is inspect.Parameter.VAR_POSITIONAL for one in parameters.parameters.values()):
        raise TypeError(f"the traced function {function.__name__} takes any number of arguments: give it a fixed number")
    known: dict[tuple[types.Type, ...], types.Type] = {}
    annotated = ANNOTATED.get(function.__annotations__.get("return", ...))

    def result_type(args: tuple[types.Type, ...]) -> types.Type:
        """Type of the result; unless annotated it is found by a trace into a module that is thrown away."""
        if annotated is not None:
            return annotated
        if args not in known:
            context = cpu_target.target_context
            signature_of_scratch = ir.FunctionType(ir.VoidType(), [context.get_value_type(arg) for arg in args])
            body = ir.Function(ir.Module(), signature_of_scratch, "scratch")
            builder = ir.IRBuilder(body.append_basic_block())
            items = [wrap(context, builder, *part) for part in zip(args, body.args, strict=True)]
            with context.push_code_library(context.codegen().create_library("scratch")):
                known[args] = type_of(function(*items))
        return known[args]

    @type_callable(function)
    def _typer(_: Any) -> Callable[..., Any]:
        def typed(*args: types.Type) -> Any:
            plain = tuple(types.unliteral(arg) for arg in args)
            return signature(result_type(plain), *plain)

        # numba reads the names of the parameters there; a type checker knows no such attribute of a function.
        typed.__signature__ = parameters  # type: ignore[attr-defined]
        return typed

    @lower_builtin(function, types.VarArg(types.Any))
    def _lowered(context: Any, builder: ir.IRBuilder, sig: Any, args: Any) -> ir.Value:
        items = [wrap(context, builder, *part) for part in zip(sig.args, args, strict=True)]
        return unwrap(context, builder, sig.return_type, function(*items))

    return function
