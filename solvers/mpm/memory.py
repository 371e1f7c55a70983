"""What compiled code reads and writes: rows of arrays, and the values of nodes at a stencil."""

from functools import partial, reduce

from llvmlite import ir
from numba.core import cgutils, types
from numba.np.arrayobj import make_array

from .lanes import COUNT, LANES, VECTOR, as_tuple, built, intrinsic, nested, plus, shuffled, taken, times, type_for

# What numba calls while it compiles has types of its own.
# mypy: disable-error-code="no-untyped-def"


def _address(context, builder, array, value, indices) -> ir.Value:
    """Address of what is stored from an index on."""
    struct = make_array(array)(context, builder, value)
    shape, strides = cgutils.unpack_tuple(builder, struct.shape), cgutils.unpack_tuple(builder, struct.strides)
    return cgutils.get_item_pointer2(context, builder, struct.data, shape, strides, "C", indices)


def _indices(context, builder, index, values):
    """Index values as machine integers."""
    return [context.cast(builder, value, type, types.intp) for type, value in zip(index, values, strict=True)]


def _next(context, builder, address, k) -> ir.Value:
    return builder.gep(address, [context.get_constant(types.intp, k)])


@intrinsic
def row(typingctx, array, index, like):
    """The values from array[index] on as a tuple, as many as `like` has; no index counts from the end, which costs a test."""
    found = types.UniTuple(array.dtype, like.count)

    def code(context, builder, sig, args):
        values = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        address = _address(context, builder, array, args[0], values)
        return context.make_tuple(
            builder, found, [builder.load(_next(context, builder, address, k)) for k in range(like.count)]
        )

    return found(array, index, like), code


@intrinsic
def store(typingctx, array, index, values):
    """Write a tuple to array[index] and on."""

    def code(context, builder, sig, args):
        at = _indices(context, builder, index, cgutils.unpack_tuple(builder, args[1]))
        address = _address(context, builder, array, args[0], at)
        for k, value in enumerate(cgutils.unpack_tuple(builder, args[2])):
            builder.store(value, _next(context, builder, address, k))
        return context.get_dummy_value()

    return types.void(array, index, values), code


@intrinsic
def rows(typingctx, array, numbers, column, like):
    """As many columns as `like` has, from one on, of the rows of some numbers, one or four: a tuple of values."""
    found = types.UniTuple(type_for(numbers.count), like.count)

    def code(context, builder, sig, args):
        (first,) = _indices(context, builder, [column], [args[2]])
        starts = [_address(context, builder, array, args[0], [n, first]) for n in cgutils.unpack_tuple(builder, args[1])]
        items = [[builder.load(_next(context, builder, start, k)) for start in starts] for k in range(like.count)]
        return context.make_tuple(builder, found, [built(builder, of_all) for of_all in items])

    return found(array, numbers, column, like), code


@intrinsic
def store_rows(typingctx, array, numbers, column, values):
    """Write a tuple of values into the rows of some numbers, from a column on; the first row last, which stands in for missing ones."""

    def code(context, builder, sig, args):
        (first,) = _indices(context, builder, [column], [args[2]])
        starts = [_address(context, builder, array, args[0], [n, first]) for n in cgutils.unpack_tuple(builder, args[1])]
        items = [taken(builder, value) for value in cgutils.unpack_tuple(builder, args[3])]
        for j in reversed(range(len(starts))):
            for k, of_all in enumerate(items):
                builder.store(of_all[j], _next(context, builder, starts[j], k))
        return context.get_dummy_value()

    return types.void(array, numbers, column, values), code


def _shape(grid) -> tuple[int, int]:
    """Width of the stencils of a grid, and its dimension."""
    width, stride = (grid.types[grid.fields.index(name)] for name in ("width", "stride"))
    return width.count, stride.count


def _starts(context, builder, grid, value, nodes, array, component, first) -> list[ir.Value]:
    """Addresses of the first nodes of the rows along x of a stencil, that along y fastest."""
    width, _ = _shape(grid)
    stride = cgutils.unpack_tuple(builder, builder.extract_value(value, grid.fields.index("stride")))
    starts = [_address(context, builder, nodes, array, [component, first])]
    for step in stride[:0:-1]:
        moves = [builder.mul(step, context.get_constant(types.intp, k)) for k in range(width)]
        starts = [builder.gep(start, [move]) for start in starts for move in moves]
    return starts


@intrinsic
def gathered(typingctx, grid, nodes, first, w):
    """Sums of w a_I over a stencil that begins at its first node, by component of the values of nodes (C, n), as many as axes.

    w are the products of functions w (d, W) along the axes.
    """
    found = _found(*w)

    def code(context, builder, sig, args):
        loads = _loaded(context, builder, grid, args[0], nodes, args[1], args[2])
        functions = nested(builder, args[3])
        return as_tuple(context, builder, sig, [_product_sum(builder, component, functions) for component in loads])

    return types.UniTuple(found, w.count)(grid, nodes, types.intp, w), code


@intrinsic
def gathered_by(typingctx, grid, nodes, first, w, e):
    """The same with each of e (d, W) in the place of its own: by component, then by axis."""
    found = _found(*w, *e)

    def code(context, builder, sig, args):
        loads = _loaded(context, builder, grid, args[0], nodes, args[1], args[2])
        functions, others = nested(builder, args[3]), nested(builder, args[4])
        sums = [
            _product_sum(builder, component, [*functions[:k], others[k], *functions[k + 1 :]])
            for component in loads
            for k in range(w.count)
        ]
        return as_tuple(context, builder, sig, sums)

    return types.UniTuple(found, w.count**2)(grid, nodes, types.intp, w, e), code


@intrinsic
def add_field(typingctx, grid, nodes, component, first, w, e, amount, slope):
    """Add to components of the values of nodes (C, n), from one on, what particles have at a stencil: a_c w + sum_k s_kc w_k.

    w_k are the products with e_k in the place of w_k. Either of the amounts a (C,) and the slopes s (d, C) may be None.
    """
    width, dimension = _shape(grid)

    def code(context, builder, sig, args):
        w, e = nested(builder, args[4]), nested(builder, args[5])
        amounts = None if amount == types.none else cgutils.unpack_tuple(builder, args[6])
        slopes = None if slope == types.none else nested(builder, args[7])
        for c in range(len(amounts or slopes[0])):
            # What stands before w and, by axis, before e: by nodes, as one axis after the other is multiplied in.
            terms = [(amounts and amounts[c], [s[c] for s in slopes] if slopes else [None] * dimension)]
            for k in range(dimension - 1, 0, -1):
                terms = [
                    (
                        plus(builder, times(builder, a, w[k][j]), times(builder, s[k], e[k][j])),
                        [times(builder, b, w[k][j]) for b in s[:k]],
                    )
                    for a, s in terms
                    for j in range(width)
                ]
            values = [
                plus(builder, times(builder, a, w[0][j]), times(builder, s[0], e[0][j])) for a, s in terms for j in range(width)
            ]
            number = builder.add(args[2], context.get_constant(types.intp, c))
            starts = _starts(context, builder, grid, args[0], nodes, args[1], number, args[3])
            _add(context, builder, starts, values, width)
        return context.get_dummy_value()

    return types.void(grid, nodes, types.intp, types.intp, w, e, amount, slope), code


def _found(*functions: types.UniTuple) -> types.Type:
    return LANES if any(function.dtype == LANES for function in functions) else types.float64


def _loaded(context, builder, grid, value, nodes, array, first) -> list[list[list[ir.Value]]]:
    """Values of nodes by component, row and node."""
    width, dimension = _shape(grid)
    found = []
    for c in range(dimension):
        starts = _starts(context, builder, grid, value, nodes, array, context.get_constant(types.intp, c), first)
        found.append([[builder.load(_next(context, builder, start, j)) for j in range(width)] for start in starts])
    return found


def _product_sum(builder, component: list[list[ir.Value]], functions: list[list[ir.Value]]) -> ir.Value:
    """Sum of values by row and node times the products of functions by axis and node."""
    sums = [value for row in component for value in row]
    for factors in functions:
        terms = [times(builder, factors[k % len(factors)], value) for k, value in enumerate(sums)]
        sums = [reduce(partial(plus, builder), terms[k : k + len(factors)]) for k in range(0, len(terms), len(factors))]
    return sums[0]


def _add(context, builder, starts: list[ir.Value], values: list[ir.Value], width: int) -> None:
    """Add values by row and node, each the sum of its lanes, to what begins at the starts of the rows."""
    if values[0].type != VECTOR:
        for k, value in enumerate(values):
            place = _next(context, builder, starts[k // width], k % width)
            builder.store(builder.fadd(builder.load(place), value), place)
        return
    together = min(2, len(starts)) if width == 2 else 1  # rows that fill a register
    for k in range(0, len(starts), together):
        zeros = [ir.Constant(VECTOR, [0.0] * COUNT)] * (COUNT - width * together)
        sums = _added_up(builder, values[k * width : (k + together) * width] + zeros)
        for j, start in enumerate(starts[k : k + together]):
            total = shuffled(builder, sums, sums, [2 * j, 2 * j + 1]) if width == 2 else sums
            place = builder.bitcast(start, total.type.as_pointer())
            builder.store(builder.fadd(builder.load(place, align=8), total), place, align=8)


def _added_up(builder, values: list[ir.Value]) -> ir.Value:
    """Sums over the lanes of four values, as lanes; pairs of registers are added until each lane holds a sum."""
    for even, odd in ([0, 4, 2, 6], [1, 5, 3, 7]), ([0, 1, 4, 5], [2, 3, 6, 7]):
        pairs = zip(values[::2], values[1::2], strict=True)
        values = [builder.fadd(shuffled(builder, a, b, even), shuffled(builder, a, b, odd)) for a, b in pairs]
    return values[0]
