"""Weighted sums of rows in vector registers.

LLVM does not make vectors of the loops that these replace, since it cannot know that the result overlaps no row.
"""

from numba import types
from numba.core.cgutils import ir
from numba.extending import intrinsic

from .layout import NODE_CHANNELS, ROW, Node

WIDTH = 8  # channels summed at a time
LANE = ir.IntType(32)
LANES = ir.VectorType(LANE, ROW)
VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
FOUR = ir.VectorType(ir.DoubleType(), 4)
VALUE = (0,) * NODE_CHANNELS
BENT = tuple(  # which of the weights each channel takes: that of the corner, or of its slope over y, roll, yaw^2
    {"Y": 1, "ROLL": 2, "YAW2": 3}[channel.name.rpartition("_")[2]] if channel < Node.GAP else 0 for channel in Node
)


def _weights(builder, weights, c, pattern):
    """Weight of corner c for each of the channels of a pattern."""
    vector = ir.Constant(ir.VectorType(ir.DoubleType(), len(weights)), ir.Undefined)
    for k, each in enumerate(weights):
        vector = builder.insert_element(vector, builder.extract_value(each, c), ir.Constant(LANE, k))
    return builder.shuffle_vector(vector, vector, ir.Constant(ir.VectorType(LANE, WIDTH), pattern))


def _mixer(pattern):
    def generate(context, builder, signature, arguments):
        rows, places, *weights, results, place = arguments
        corners = range(len(signature.args[1]))

        def address(kind, array, index, channel):
            start = context.make_array(kind)(context, builder, array).data
            offset = builder.mul(index, ir.Constant(index.type, NODE_CHANNELS))
            offset = builder.add(offset, ir.Constant(index.type, channel))
            return builder.bitcast(builder.gep(start, [offset]), VECTOR.as_pointer())

        def partial(some, channel):
            total = None
            for c in some:
                at = address(signature.args[0], rows, builder.extract_value(places, c), channel)
                weight = _weights(builder, weights, c, pattern[channel : channel + WIDTH])
                term = builder.fmul(builder.load(at, align=8), weight, flags=["contract"])
                total = term if total is None else builder.fadd(total, term, flags=["contract"])
            return total

        half = len(corners) // 2
        for channel in range(0, NODE_CHANNELS, WIDTH):
            total = builder.fadd(partial(corners[:half], channel), partial(corners[half:], channel))
            builder.store(total, address(signature.args[-2], results, place, channel), align=8)
        return context.get_dummy_value()

    return generate


def _are_rows(*arrays):
    return all(isinstance(array, types.Array) and array.layout == "C" and array.ndim == 2 for array in arrays)


@intrinsic
def mix_bent(typingctx, node, n, w, y, roll, yaw2, sample, row):
    """sample[row] = sum of w[c] node[n[c]], slopes with weights of their own; rows of NODE_CHANNELS numbers.

    Parameters
    ----------
    node, sample : C-contiguous arrays (..., NODE_CHANNELS)
    n, w : tuples of integers and of as many floats, at least two
        Neither n nor row is negative.
    y, roll, yaw2 : tuples of as many floats
        Weights of the slopes over y, roll and yaw^2.
    row : int
    """
    if not _are_rows(node, sample):
        return None
    return types.void(node, n, w, y, roll, yaw2, sample, row), _mixer(BENT)


def _address(context, builder, kind, array, index, per_row):
    start = context.make_array(kind)(context, builder, array).data
    return builder.gep(start, [builder.mul(index, ir.Constant(index.type, per_row))])


def _weave(context, builder, signature, arguments):
    heights, first, per_roll, per_yaw2, per_y, *weights, results, row = arguments
    by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2 = weights
    start = context.make_array(signature.args[0])(context, builder, heights).data

    def add(total, vector, weight, c):
        lane = builder.insert_element(ir.Constant(FOUR, ir.Undefined), builder.extract_value(weight, c), LANE(0))
        weight = builder.shuffle_vector(lane, lane, ir.Constant(ir.VectorType(LANE, 4), (0,) * 4))
        term = builder.fmul(vector, weight, flags=["contract"])
        return term if total is None else builder.fadd(total, term, flags=["contract"])

    corners = range(len(signature.args[5]))
    value = along_y = along_roll = along_yaw2 = None
    for a in corners:
        plain = bent = turned = None
        for b in corners:
            index = builder.add(builder.mul(per_roll, per_roll.type(a)), builder.mul(per_yaw2, per_yaw2.type(b)))
            index = builder.add(first, index)
            height = sloped = None
            for c in corners:
                place = builder.gep(start, [builder.add(index, builder.mul(per_y, per_y.type(c)))])
                vector = builder.load(builder.bitcast(place, FOUR.as_pointer()), align=8)
                height, sloped = add(height, vector, by_y, c), add(sloped, vector, slope_y, c)
            plain, bent = add(plain, height, by_yaw2, b), add(bent, sloped, by_yaw2, b)
            turned = add(turned, height, slope_yaw2, b)
        value, along_y = add(value, plain, by_roll, a), add(along_y, bent, by_roll, a)
        along_yaw2, along_roll = add(along_yaw2, turned, by_roll, a), add(along_roll, plain, slope_roll, a)
    for k, vector in enumerate((value, along_y, along_roll, along_yaw2)):
        at = _address(context, builder, signature.args[-2], results, builder.add(row, row.type(k)), NODE_CHANNELS)
        builder.store(vector, builder.bitcast(at, FOUR.as_pointer()), align=8)
    return context.get_dummy_value()


def _mix_two(context, builder, signature, arguments):
    heights, places, weights, results, row = arguments
    for half in range(2):
        total = None
        for c in range(len(signature.args[1])):
            start = _address(context, builder, signature.args[0], heights, builder.extract_value(places, c), ROW)
            at = builder.gep(start, [ir.IntType(64)(half * ROW)])
            vector = builder.load(builder.bitcast(at, VECTOR.as_pointer()), align=8)
            lane = builder.insert_element(
                ir.Constant(VECTOR, ir.Undefined), builder.extract_value(weights, c), LANE(0)
            )
            term = builder.fmul(vector, builder.shuffle_vector(lane, lane, ir.Constant(LANES, (0,) * ROW)))
            total = term if total is None else builder.fadd(total, term)
        out = _address(context, builder, signature.args[-2], results, row, NODE_CHANNELS)
        at = builder.gep(out, [ir.IntType(64)(half * ROW)])
        builder.store(total, builder.bitcast(at, VECTOR.as_pointer()), align=8)
    return context.get_dummy_value()


@intrinsic
def mix_two(typingctx, heights, n, w, sample, row):
    """The sums of w[c] heights[n[c]] and of w[c] heights[n[c] + 1], one behind the other from the beginning of a row.

    Parameters
    ----------
    heights : C-contiguous array (..., ROW)
    n, w : tuples of integers and of as many floats
    sample : C-contiguous array (..., NODE_CHANNELS)
    row : int
        Of sample.
    """
    return (types.void(heights, n, w, sample, row), _mix_two) if _are_rows(heights, sample) else None


@intrinsic
def weave(
    typingctx, heights, first, per_roll, per_yaw2, per_y,
    by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2, sample, row,
):  # fmt: skip
    """Sums of four numbers side by side over all products of weights of three axes, and with slopes in place of one.

    Parameters
    ----------
    heights : C-contiguous array (..., ROW)
    first, per_roll, per_yaw2, per_y : int
        Number in it, counted on over its rows, with which the first four begin; from one roll, yaw^2, y to the next.
    by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2 : tuples of as many floats
        Weights along each axis and their derivatives.
    sample : C-contiguous array (..., NODE_CHANNELS)
        The first four of its `row` are filled with the sums, those of the next three with their derivatives by y, roll
        and yaw^2.
    row : int
    """
    if not _are_rows(heights, sample):
        return None
    weights = by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2
    return types.void(heights, first, per_roll, per_yaw2, per_y, *weights, sample, row), _weave
