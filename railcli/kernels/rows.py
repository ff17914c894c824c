"""Weighted sum of rows in vector registers.

LLVM does not make vectors of the loop that this replaces, since it cannot know that the result overlaps no row.
"""

from numba import types
from numba.core.cgutils import ir
from numba.extending import intrinsic

from .layout import NODE_CHANNELS


@intrinsic
def mix(typingctx, node, n, w, sample, row):
    """sample[row] = sum of w[c] node[n[c]]; rows of NODE_CHANNELS numbers, n and row not negative.

    Parameters
    ----------
    node, sample : C-contiguous arrays (..., NODE_CHANNELS)
    n, w : tuples of integers and of as many floats, at least two
    row : int
    """
    for array in (node, sample):
        if not isinstance(array, types.Array) or array.layout != "C" or array.ndim != 2:
            return None

    def generate(context, builder, signature, arguments):
        vector = ir.VectorType(ir.DoubleType(), NODE_CHANNELS)
        nothing = ir.Constant(vector, ir.Undefined)
        first_lane = ir.Constant(ir.VectorType(ir.IntType(32), NODE_CHANNELS), None)
        rows, places, weights, results, place = arguments

        def address(kind, array, index):
            start = context.make_array(kind)(context, builder, array).data
            offset = builder.mul(index, ir.Constant(index.type, NODE_CHANNELS))
            return builder.bitcast(builder.gep(start, [offset]), vector.as_pointer())

        def term(c):
            values = builder.load(address(node, rows, builder.extract_value(places, c)), align=8)
            weight = builder.insert_element(nothing, builder.extract_value(weights, c), ir.Constant(ir.IntType(32), 0))
            weight = builder.shuffle_vector(weight, nothing, first_lane)
            return builder.fmul(values, weight, flags=["contract"])

        def partial(corners):
            total = term(corners[0])
            for c in corners[1:]:
                total = builder.fadd(total, term(c), flags=["contract"])
            return total

        half = len(n) // 2
        total = builder.fadd(partial(range(half)), partial(range(half, len(n))))
        builder.store(total, address(sample, results, place), align=8)
        return context.get_dummy_value()

    return types.void(node, n, w, sample, row), generate
