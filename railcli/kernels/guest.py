"""The guest slot: a user's own controller, compiled elsewhere and called by its address (docs/subsystems.md, 10)."""

from math import isfinite

from numba import types
from numba.core.cgutils import ir
from numba.extending import intrinsic

from .assembly_layout import GUEST_INPUTS, GUEST_OUTPUTS, GUEST_STATE, Valve
from .jit import seldom

MOST_VALVE = float(Valve.VENT.value)


def _call(context, builder, signature, arguments):
    address, time, axles, room = arguments
    double = ir.DoubleType()
    kind = ir.FunctionType(ir.IntType(64), [double, ir.IntType(64), double.as_pointer()])
    start = context.make_array(signature.args[3])(context, builder, room).data
    return builder.call(builder.inttoptr(address, kind.as_pointer()), [time, axles, start])


@intrinsic
def call(typingctx, address, time, axles, room):
    """Call int64 f(double time, int64 axles, double *room) at an address; room : C-contiguous array (n,)."""
    return types.int64(types.int64, types.float64, types.int64, room), _call


@seldom
def invite(model, data):
    """Let the guest act on a sample: sensor values in, commands to valves and motors out. Returns its fault.

    0 : none.  1 : it went beyond its arrays.  2 + axle : a command that is none, for that axle.
    """
    room, n = data.guest, model.axle.size
    train = data.train[0]
    for a in range(n):
        port, at = data.port[a], GUEST_STATE + GUEST_INPUTS * a
        room[at], room[at + 1] = port["speed"], port["relative"]
        room[at + 2], room[at + 3] = train["brake_demand"], train["traction_demand"]
        at = GUEST_STATE + GUEST_INPUTS * n + GUEST_OUTPUTS * a
        room[at], room[at + 1] = port["valve"], port["torque_share"]
    if call(model.assembly[0]["guest"], data.clock[0], n, room) != 0:
        return 1
    for a in range(n):
        at = GUEST_STATE + GUEST_INPUTS * n + GUEST_OUTPUTS * a
        valve, share = room[at], room[at + 1]
        if not (isfinite(valve) and 0.0 <= valve <= MOST_VALVE and valve == int(valve) and 0.0 <= share <= 1.0):
            return 2 + a
        data.port[a]["valve"], data.port[a]["torque_share"] = int(valve), share
    return 0
