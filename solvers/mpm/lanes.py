"""Values that lie side by side in memory: as a tuple, or as lanes, the doubles of one register of the processor.

A stencil is a few rows of nodes that lie side by side, which LLVM does not find out by itself. Sums, differences and products of lanes
with lanes and numbers, and the functions below, are for compiled code alone.
"""

import operator
from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic as numba_intrinsic
from numba.extending import lower_builtin, models, register_model
from numba.np.arrayobj import make_array

# What numba calls while it compiles has types of its own.
# mypy: disable-error-code="no-untyped-def"

intrinsic = cast(Callable[[Callable[..., Any]], Callable[..., Any]], numba_intrinsic)
"""A function that is called without the first of its arguments, and makes the code of its call itself."""


class Lanes(types.Type):
    """Doubles that are computed with at the same time."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(name=f"Lanes({count})")


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes) -> None:
        super().__init__(manager, lanes, ir.VectorType(ir.DoubleType(), lanes.count))


def _lanes_of(values: types.UniTuple | Lanes) -> int:
    """Lanes for so many values: four for three, which LLVM would load and store in two parts."""
    return 4 if values.count == 3 else values.count


def _splat(builder: ir.IRBuilder, value: ir.Value, count: int) -> ir.Value:
    """As many times one double."""
    vector = ir.VectorType(value.type, count)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, cgutils.int32_t(0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(cgutils.int32_t, count), [0] * count))


def _arithmetic(operation: Callable[..., Any], instruction: str) -> None:
    """Give lanes an operation with lanes, and with a number on either side."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) == 2 and any(isinstance(arg, Lanes) for arg in args):
                both = args[0] if isinstance(args[0], Lanes) else args[1]
                if all(arg in (both, types.float64) for arg in args):
                    return signature(both, *args)
            return None

    @lower_builtin(operation, Lanes, Lanes)
    @lower_builtin(operation, types.Float, Lanes)
    @lower_builtin(operation, Lanes, types.Float)
    def _lanewise(context, builder, sig, args):
        values = (
            value if isinstance(kind, Lanes) else _splat(builder, value, sig.return_type.count)
            for kind, value in zip(sig.args, args, strict=True)
        )
        return getattr(builder, instruction)(*values)


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")


def _address(context, builder, array, value, indices) -> ir.Value:
    """Address of what is stored from an index on."""
    struct = make_array(array)(context, builder, value)
    shape, strides = cgutils.unpack_tuple(builder, struct.shape), cgutils.unpack_tuple(builder, struct.strides)
    return cgutils.get_item_pointer2(context, builder, struct.data, shape, strides, "C", indices)


def _read(builder, address, count) -> ir.Value:
    vector = ir.VectorType(ir.DoubleType(), count).as_pointer()
    return builder.load(builder.bitcast(address, vector), align=8)


def _indices(context, builder, index, values):
    """Index values as machine integers."""
    return [context.cast(builder, value, type, types.intp) for type, value in zip(index, values, strict=True)]


@intrinsic
def load(typingctx, array, index, like):
    """The values from array[index] on in as many lanes as a stencil of the width of `like` takes: neighbours along the last axis."""
    count = _lanes_of(like)

    def code(context, builder, sig, args):
        values = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        return _read(builder, _address(context, builder, array, args[0], values), count)

    return Lanes(count)(array, index, like), code


@intrinsic
def add_to(typingctx, array, index, lanes):
    """Add lanes to the values from array[index] on."""

    def code(context, builder, sig, args):
        values = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        address = _address(context, builder, array, args[0], values)
        total = builder.fadd(_read(builder, address, lanes.count), args[2])
        builder.store(total, builder.bitcast(address, total.type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, index, lanes), code


@intrinsic
def row(typingctx, array, index, like):
    """The values from array[index] on as a tuple, as many as `like` has; no index counts from the end, which costs a test."""
    found = types.UniTuple(array.dtype, like.count)

    def code(context, builder, sig, args):
        values = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        address = _address(context, builder, array, args[0], values)
        items = [builder.load(builder.gep(address, [context.get_constant(types.intp, k)])) for k in range(like.count)]
        return context.make_tuple(builder, found, items)

    return found(array, index, like), code


@intrinsic
def store(typingctx, array, index, values):
    """Write a tuple to array[index] and on."""

    def code(context, builder, sig, args):
        at = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        address = _address(context, builder, array, args[0], at)
        for k, value in enumerate(cgutils.unpack_tuple(builder, args[2])):
            builder.store(value, builder.gep(address, [context.get_constant(types.intp, k)]))
        return context.get_dummy_value()

    return types.void(array, index, values), code


@intrinsic
def lanes(typingctx, values):
    """A tuple of floats as lanes; zero where there is none."""
    count = _lanes_of(values)

    def code(context, builder, sig, args):
        vector = ir.Constant(ir.VectorType(ir.DoubleType(), count), [0.0] * count)
        for k, value in enumerate(cgutils.unpack_tuple(builder, args[0])):
            vector = builder.insert_element(vector, value, cgutils.int32_t(k))
        return vector

    return Lanes(count)(values), code


@intrinsic
def lane(typingctx, values, k):
    """Value number k."""

    def code(context, builder, sig, args):
        return builder.extract_element(args[0], builder.trunc(context.cast(builder, args[1], k, types.int64), cgutils.int32_t))

    return types.float64(values, k), code


@intrinsic
def total(typingctx, values):
    """Sum of the values, that of the upper half added to the lower one."""

    def code(context, builder, sig, args):
        items = [builder.extract_element(args[0], cgutils.int32_t(k)) for k in range(values.count)]
        while len(items) > 1:
            half = (len(items) + 1) // 2
            items = [builder.fadd(a, b) for a, b in zip(items, items[half:], strict=False)] + items[len(items) - half : half]
        return items[0]

    return types.float64(values), code


@infer_global(len)
class _Count(AbstractTemplate):
    def generic(self, args, kws):
        return signature(types.intp, *args) if len(args) == 1 and isinstance(args[0], Lanes) else None


@lower_builtin(len, Lanes)
def _count(context, builder, sig, args):
    return context.get_constant(types.intp, sig.args[0].count)
