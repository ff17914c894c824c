"""Schema of contact tables: one documented line per field, SI units (theory.md sections 4 and 6.8)."""

from enum import IntEnum

import numpy as np

NODE_CHANNELS = 24
LEVELS = 12  # energies at which a table of heights is kept
PART_LEVELS = (0, 2, 4, 6, 8, 11)  # those at which it holds the parts of the contact
PARTS = len(PART_LEVELS)
ROW = 8  # numbers in each row of a table of heights

TABLE = np.dtype(  # one contact table in the pool; axes: lateral position, roll, squared yaw
    [
        ("y_start", "f8"),  # lateral position of the reference point about nominal [m]
        ("y_step", "f8"),
        ("y_count", "i8"),
        ("roll_start", "f8"),  # [rad]
        ("roll_step", "f8"),
        ("roll_count", "i8"),
        ("yaw2_step", "f8"),  # squared yaw, from 0 [rad^2]
        ("yaw2_count", "i8"),
        ("cell_base", "i8"),  # where its cells begin in Model.cell
        ("branch_base", "i8"),  # where its branches begin in Model.branch
        ("node_base", "i8"),  # where its nodes begin in Model.node
        ("levels", "i8"),  # where its heights begin in Model.heights, -1: it has none; then what belongs to its axes
        ("y_bins", "i8"),
        ("roll_bins", "i8"),
        ("yaw2_bins", "i8"),
        ("y_knots", "i8"),
        ("y_basis", "i8"),
        ("roll_knots", "i8"),
        ("roll_basis", "i8"),
        ("yaw2_knots", "i8"),
        ("yaw2_basis", "i8"),
        ("coefficients", "i8"),
        ("parts", "i8"),  # of the contact: PARTS rows for each node
        ("shear", "f8"),  # shear modulus of wheel and rail [Pa]
        ("poisson", "f8"),  # [-]
    ],
    align=True,
)


class Node(IntEnum):
    """Channels of a table node: one contact point of a wheel at one grid pose (theory.md section 4)."""

    GAP_Y = 0  # slopes over y: of GAP [-], of SLOPE [1/m], of LATERAL [-]
    SLOPE_Y = 1
    LATERAL_Y = 2
    GAP_ROLL = 3  # over roll [m/rad, 1/rad, m/rad]
    SLOPE_ROLL = 4
    LATERAL_ROLL = 5
    GAP_YAW2 = 6  # over yaw^2 [m/rad^2, 1/rad^2, m/rad^2]
    SLOPE_YAW2 = 7
    LATERAL_YAW2 = 8
    GAP = 9  # D, distance from rail to wheel along z [m]
    SLOPE = 10  # of the rail there, tangent of the contact angle [-]
    LATERAL = 11  # profile coordinate on the wheel, from the tape circle to the field side [m]
    RADIUS = 12  # distance of the contact from the axle; in a table less WHEEL_SLOPE LATERAL / 2 [m]
    WHEEL_SLOPE = 13  # of the wheel profile there, dRADIUS / dLATERAL [-]
    BARRIER_GAUGE = 14  # D of the saddle towards the flange minus D, at most BARRIER_CAP [m]
    BARRIER_FIELD = 15  # likewise towards the field side [m]
    HERTZ = 16  # k of N = k d^1.5, d the approach along the normal [N/m^1.5]
    SEMI_X = 17  # a / d^0.5 [m^0.5]
    SEMI_Y = 18  # b / d^0.5 [m^0.5]
    F11 = 19  # f11 / d [N/m]
    F22 = 20  # f22 / d [N/m]
    F23 = 21  # f23 / d^1.5 [N/m^0.5]
    F33 = 22  # f33 / d^2 [N]
    REGION = 23  # part of the wheel profile, Region


class Part(IntEnum):
    """What a table of heights holds of each part of the contact at PART_LEVELS, in rows (theory.md section 6.8)."""

    SHARE = 0  # of the normal forces of the wheel [-]
    SLOPE = 1  # tangent of the contact angle of its resultant [-]
    LATERAL = 2  # profile coordinate of its load on the wheel [m]
    RADIUS = 3  # distance of that from the axle [m]
    SEMI_X = 4  # a / w^0.5 [m/J^0.2]
    SEMI_Y = 5  # b / w^0.5, of the ellipse with its a and area [m/J^0.2]
    PRESSURE = 6  # greatest one / w^0.5 [Pa/J^0.2]
    UNUSED = 7


class Region(IntEnum):
    """Label of a contact point: the part of the wheel profile on which it lies."""

    TREAD = 0
    ROOT = 1
    FLANK = 2
    TIP = 3
