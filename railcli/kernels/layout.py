"""Schema of the compiled core: one documented line per field, SI units.

Frames (docs/nomenclature.md): the *track frame* at arc length s has x forward, y right, z down, its origin midway
between the rails in the plane of their tops; the *frame of a body* follows the body's yaw, roll and pitch, but for a
wheelset not its pitch, which is its spin. A left wheel enters its contact table mirrored.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numba import types

from .assembly_layout import (
    ASSEMBLY,
    AXLE,
    DELAYED,
    GRIPS,
    GUEST_INPUTS,
    GUEST_OUTPUTS,
    GUEST_STATE,
    LINE,
    PLAN,
    PORT,
    TRAIN,
    Memory,
)
from .jit import constant, mutable
from .table_layout import LEVELS as LEVELS
from .table_layout import NODE_CHANNELS as NODE_CHANNELS
from .table_layout import PART_LEVELS as PART_LEVELS
from .table_layout import PARTS as PARTS
from .table_layout import ROW as ROW
from .table_layout import TABLE as TABLE
from .table_layout import Node as Node
from .table_layout import Part as Part
from .table_layout import Region as Region

MAX_CONTACT = 6  # contact patches kept per wheel: four branches, and more where they end within a cell
CURVE_KNOTS = 32
PATH_ORDER = 8
SAMPLE_ROWS = MAX_CONTACT + 4  # patches, then rows at hand
SHIFT_CHANNELS = 8  # right rail: lateral [m], its slope [-], vertical [m], its slope [-]; left rail likewise


class Status(IntEnum):
    """How a call of the core ended; `Data.fault` names the culprit."""

    OK = 0
    NOT_FINITE = 1  # fault = body
    LEFT_TABLE = 2  # fault = wheel
    DERAILED = 3  # fault = wheel
    LEFT_TRACK = 4  # fault = body
    TOO_MANY_CONTACTS = 5  # fault = wheel
    LEFT_SHIFT = 6  # fault = wheel: the displacement of its rail is not given there
    UNKNOWN_ELEMENT = 7  # fault = element: its kind is not one of Kind
    GUEST = 8  # fault = 0: the guest went beyond its arrays; else the axle that it gave a command that is none


class Kind(IntEnum):
    """Kinds of force element."""

    BUSHING = 0  # three springs and dampers along the joint's axes
    LINK = 1  # acts along the line between its two ends
    DRY = 2  # dry friction along one or several of the joint's axes
    DRY_LINK = 3  # dry friction along the line between its two ends
    LEAF = 4  # leaf spring along the joint's z
    MATRIX = 5  # stiffness and damping that couple all six relative motions
    TORQUE = 6  # turns the bodies against each other about one axis
    AIR = 7  # a bushing that holds, along z, a volume of air with a reservoir behind an orifice


class Axes(IntEnum):
    """Whose axes the bushings of a joint use."""

    MEAN = 0  # halfway between the two bodies; forces act midway between the displaced ends
    UPPER = 1  # the upper body's; forces act at the lower end


class Creep(IntEnum):
    """Laws of the creep force."""

    HARD = 0  # linear, one factor: cut off at the friction limit
    SMOOTH = 1  # linear, one factor: bent towards the limit
    POLACH = 2
    FASTSIM = 3
    TABLE = 4  # FASTSIM, tabulated
    FASTRIP = 5  # strip theory and FASTSIM, tabulated


PARAM = np.dtype(
    [
        ("step", "f8"),  # time step [s]
        ("gravity", "f8"),  # [m/s^2]
        ("cant_base", "f8"),  # lateral distance over which cant is measured [m]
        ("speed", "f8"),  # speed asked of the first body along the track [m/s]
        ("speed_curve", "i8"),  # likewise over time, index into curves; -1: constant
        ("hold", "f8"),  # force per speed error on the first body, along its track tangent [N s/m]
        ("hold_rate", "f8"),  # at which that force grows while there is an error [1/s]
        ("creep_law", "i8"),  # Creep
        ("creep_speed", "f8"),  # creepages are divided by at least this; below it patches remember [m/s]
        ("settled", "f8"),  # change of creepages within which a step takes creep forces as linear in them [-]
        ("fastsim_grid", "i8"),  # strips of a patch, and elements of a strip
        ("adhesion_reduction", "f8"),  # k_A of Polach's law [-]
        ("slip_reduction", "f8"),  # k_S of Polach's law [-]
        ("friction_ratio", "f8"),  # A: friction at infinite over that at zero slip velocity [-]
        ("friction_decay", "f8"),  # B: how fast friction falls with slip velocity; 0: it does not [s/m]
        ("damping", "f8"),  # k2 / k1 of the normal force (theory.md) [(s/m)^g2]
        ("damping_rate_power", "f8"),  # g2 [-]
        ("damping_depth_power", "f8"),  # g3 [-]
        ("derail_lift", "f8"),  # climb of a wheel over its nominal height that ends the run [m]
        ("shift_start", "f8"),  # arc length of the first row of Model.shift [m]
        ("shift_step", "f8"),  # between two of its rows [m]
        ("rail_stiffness", "f8", 2),  # of what bears a rail under a wheel, lateral and vertical; 0: rigid [N/m]
        ("rail_damping", "f8", 2),  # likewise [N s/m]
    ],
    align=True,
)

PIECE = np.dtype(  # a stretch of track short enough for polynomials of u = s - start
    [
        ("start", "f8"),  # arc length at its beginning [m]
        ("length", "f8"),  # [m]
        ("x", "f8"),  # plan position of its beginning [m]
        ("y", "f8"),
        ("heading", "f8"),  # heading of its beginning, positive to the right [rad]
        ("cos_heading", "f8"),
        ("sin_heading", "f8"),
        ("z", "f8"),  # height of its beginning, down [m]
        ("curvature", "f8", 4),  # heading per metre, coefficients in u, positive to the right [1/m, 1/m^2, ...]
        ("cant", "f8", 4),  # height of left over right rail, coefficients in u [m, -, ...]
        ("lift", "f8"),  # rise of the middle of the track per cant: 0 when cant turns about it [-]
        ("graded", "i8"),  # 0: level, the gradient is zero throughout
        ("gradient", "f8", 2),  # angle of the rising track, coefficients in u [rad, rad/m]
        ("path_x", "f8", PATH_ORDER),  # plan position along the first heading, coefficients of u^1 ... [m]
        ("path_y", "f8", PATH_ORDER),  # right of it
        ("path_z", "f8", PATH_ORDER),  # and down
    ],
    align=True,
)

BODY = np.dtype(
    [
        ("mass", "f8"),  # [kg]
        ("inertia", "f8", 3),  # about the axes of its frame through its centre [kg m^2]
        ("spins", "i8"),  # 1: wheelset, whose frame does not pitch
    ],
    align=True,
)

JOINT = np.dtype(  # everything between one pair of bodies
    [
        ("lower", "i8"),
        ("upper", "i8"),
        ("first", "i8"),  # its elements: first ... first + count - 1
        ("count", "i8"),
        ("axes", "i8"),  # Axes
        ("turn", "f8", 3),  # rotational stiffness about the mean axes; on a wheelset: of its axle [N m/rad]
    ],
    align=True,
)

ELEMENT = np.dtype(
    [
        ("kind", "i8"),  # Kind
        ("lower", "f8", 3),  # end on the lower body, in its frame; torque: its axis [m], [-]
        ("upper", "f8", 3),  # end on the upper body, in its frame [m]
        ("k", "f8", 3),  # stiffness along x, y, z; link, torque: k[0]; friction: 0 where it has none [N/m, N m/rad]
        ("c", "f8", 3),  # damping likewise; friction: c[0] beside its series spring; air: c[2] orifice [N s/m]
        ("preload", "f8", 3),  # bushing: force on the upper body at rest; link: -, tension in [0] [N]; torque [N m]
        ("spring_curve", "i8", 3),  # force over displacement beside k, index into curves; -1: none; leaf: upper, lower
        ("damper_curve", "i8", 3),  # force over rate in place of c, index into curves; -1: none
        ("dampers", "i8"),  # bushing: 1: some of its damping is a table or implicit
        ("stiff", "i8", 3),  # place in Data.tension of what acts implicitly in its rate; -1: explicit
        ("series", "f8"),  # stiffness in series with the damper of a link or air spring, with friction; 0: none [N/m]
        ("reservoir", "f8"),  # air: stiffness beside that damper [N/m]
        ("dry", "i8"),  # 1: a damper in series whose table has a flat part
        ("state", "i8"),  # its first place in Data.damper; -1: none
        ("matrix", "i8"),  # its place in Model.matrix
        ("length", "f8"),  # link: length without spring force [m]
        ("limit", "f8"),  # dry friction: constant part of its limit [N], of a torque [N m]
        ("coefficient", "f8"),  # and part per load of the element `source` [-]
        ("source", "i8"),  # element whose load it feels, before it in the same joint; -1: none
        ("decay", "f8"),  # leaf: deflection over which its force fades towards an envelope by 1/e [m]
    ],
    align=True,
)

CURVE = np.dtype(  # piecewise linear, continued along its last slopes
    [("count", "i8"), ("x", "f8", CURVE_KNOTS), ("y", "f8", CURVE_KNOTS)],
    align=True,
)

WHEEL = np.dtype(
    [
        ("body", "i8"),
        ("side", "f8"),  # +1 right, -1 left
        ("table", "i8"),
        ("lateral", "f8"),  # distance of its tape circle from the wheelset's centre [m]
        ("radius", "f8"),  # of its tape circle [m]
        ("friction", "f8"),  # where the line says nothing of it [-]
    ],
    align=True,
)

FRAME = np.dtype(  # derived: pose and motion of a body against the ground, all vectors in ground axes
    [
        ("track", "f8", (3, 3)),  # columns: axes of its track frame
        ("rate", "f8", 3),  # rotation of the track frame per metre, in track axes [1/m]
        ("advance", "f8", 3),  # motion of the track frame's origin per metre, in track axes [-]
        ("sine", "f8", 3),  # sines and cosines of roll, pitch (0 for a wheelset) and yaw
        ("cosine", "f8", 3),
        ("axes", "f8", (3, 3)),  # columns: axes of its frame
        ("position", "f8", 3),  # of its centre [m]
        ("velocity", "f8", 3),  # of its centre [m/s]
        ("omega", "f8", 3),  # angular velocity of the body [rad/s]
        ("omega_frame", "f8", 3),  # angular velocity of its frame (a wheelset's without spin) [rad/s]
        ("force", "f8", 3),  # sum of the suspension forces [N]
        ("moment", "f8", 3),  # sum of their moments about its centre [N m]
    ],
    align=True,
)

CONTACT = np.dtype(  # derived: one contact patch; forces on the wheel, contact axes x, t, n of theory.md
    [
        ("normal", "f8"),  # [N]
        ("creep_x", "f8"),  # [N]
        ("creep_t", "f8"),  # [N]
        ("spin_moment", "f8"),  # [N m]
        ("xi", "f8"),  # creepages: slip of wheel over rail [-]
        ("eta", "f8"),  # [-]
        ("phi", "f8"),  # [1/m]
        ("slip_x", "f8"),  # slip velocity of wheel over rail [m/s]
        ("slip_t", "f8"),  # [m/s]
        ("depth", "f8"),  # penetration along z [m]
        ("angle", "f8"),  # contact angle, positive when the normal leans to the flange [rad]
        ("lateral", "f8"),  # on the wheel profile, from the tape circle to the field side [m]
        ("radius", "f8"),  # distance from the axle [m]
        ("semi_x", "f8"),  # contact ellipse [m]
        ("semi_y", "f8"),
        ("region", "f8"),  # Region
        ("linear", "f8"),  # linear creep force over the friction limit [-]
        ("slope", "f8"),  # dz/dy of the rail there, track axes [-]
        ("arm", "f8", 3),  # from the wheelset's centre, track axes [m]
        ("f11", "f8"),  # creep coefficients [N]
        ("f22", "f8"),  # [N]
        ("f23", "f8"),  # [N m]
        ("f33", "f8"),  # [N m^2]
        ("pressure", "f8"),  # greatest [Pa]
        ("stiffness", "f8"),  # of the normal force over the approach [N/m]
        ("viscosity", "f8"),  # over its rate [N s/m]
    ],
    align=True,
)

RAIL = np.dtype(  # derived: force of one wheel on its rail, and how far that rail is from its ideal place; track axes
    [
        ("x", "f8"),  # [N]
        ("y", "f8"),  # Y, to the right [N]
        ("q", "f8"),  # Q, down [N]
        ("patches", "f8"),  # loaded contact patches
        ("lateral", "f8"),  # displacement at the wheelset's arc length, to the right [m]
        ("vertical", "f8"),  # down [m]
        ("lateral_slope", "f8"),  # its derivatives along the track [-]
        ("vertical_slope", "f8"),
        ("lateral_bend", "f8"),  # [1/m]
        ("vertical_bend", "f8"),
        ("couple", "f8", 3),  # moment on the wheelset beside that of the forces of its patches [N m]
        ("give", "f8", 2),  # how far it gives way under the wheel beside that: to the right, down [m]
        ("seat", "f8", 2),  # its force on its springs and dampers, to the right, down [N]
        ("level", "f8"),  # of its table of heights, from which the next search begins
        ("grip", "f8", GRIPS),  # Grip
    ],
    align=True,
)

SUPPORT = np.dtype(  # derived: a rail that gives way under a wheel, to the right and down; balance within one step
    [
        ("first", "f8", 2),  # its rate at the creep forces of the step before [m/s]
        ("rate", "f8", 2),  # at those at hand [m/s]
        ("push", "f8", 2),  # normal forces on it [N]
        ("drag", "f8", 2),  # creep forces on it [N]
        ("impedance", "f8", 3),  # force per rate, its place following it: yy, yz, zz [N s/m]
        ("follow", "f8", (2, 6)),  # change of its rate per change of the wheelset's velocity
    ],
    align=True,
)


STIFF = np.dtype(  # derived: a scalar force or torque that acts implicitly; tension T, rate of extension r
    [
        ("upper", "i8"),  # bodies
        ("lower", "i8"),
        ("curve", "i8"),  # T over r; -1: damping times rate
        ("damping", "f8"),  # [N s/m], [N m s/rad]
        ("friction", "f8"),  # beside it: dry friction [N], [N m]
        ("slides", "i8"),  # 1: it cannot stick within this step, and bears its full friction
        ("change", "f8"),  # of its tension in this step [N], [N m]
        ("rate", "f8"),  # r at the predicted velocity [m/s], [rad/s]
        ("upper_pull", "f8", 6),  # loads on the upper body per tension, as Data.load; r = - pull . v
        ("lower_pull", "f8", 6),
        ("upper_answer", "f8", 6),  # accelerations that these loads make
        ("lower_answer", "f8", 6),
        ("give", "f8"),  # W: fall of r per tension over the implicit share of the step [m/(N s)], [rad/(N m s)]
    ],
    align=True,
)


class Model(NamedTuple):
    """What does not change during a run: read-only arrays."""

    param: np.ndarray  # (1,) PARAM
    track: np.ndarray  # (n_piece,) PIECE
    body: np.ndarray  # (n_body,) BODY
    joint: np.ndarray  # (n_joint,) JOINT
    element: np.ndarray  # (n_element,) ELEMENT
    curve: np.ndarray  # (n_curve,) CURVE
    wheel: np.ndarray  # (n_wheel,) WHEEL; both wheels of a wheelset adjoin
    table: np.ndarray  # (n_table,) TABLE
    node: np.ndarray  # (n_node, NODE_CHANNELS); behind a table's nodes their patches, if any
    cell: np.ndarray  # (n_cell + 1,) first branch of each cell
    branch: np.ndarray  # (n_branch, 8) node of each corner; -1: the branch ends before it
    heights: np.ndarray  # (n, ROW) tables of heights: `heights.stored`; n = 0: none
    creep: np.ndarray  # (n, 4) creep_table.tabulate; empty unless the creep law needs it
    shift: np.ndarray  # (n, SHIFT_CHANNELS) displacement of the rails at equal distances; n = 0: they lie ideally
    matrix: np.ndarray  # (n, 12, 6) stiffness above damping over x, y, z, roll, pitch, yaw [N/m, N, N m/rad ... and s]
    axle: np.ndarray  # (n_axle,) AXLE, from the front; n = 0: nothing brakes, drives or runs free
    assembly: np.ndarray  # (1,) ASSEMBLY
    plan: np.ndarray  # (n,) PLAN, in the order of their places
    line: np.ndarray  # (n,) LINE, in the order of their places; n = 0: friction is that of the wheels


class Data(NamedTuple):
    """What changes: the state, then what is derived from it."""

    q: np.ndarray  # state: (n_body, 6) s, y, z [m], roll, pitch, yaw [rad] against its track frame
    v: np.ndarray  # state: (n_body, 6) velocity in track axes [m/s], angular velocity in its own axes [rad/s]
    dv: np.ndarray  # state: (n_body, 6) acceleration of the last step, which predicts the next
    damper: np.ndarray  # state: (n_state,) lengths of dampers with series stiffness, of friction; leaf springs [m, N]
    tension: np.ndarray  # state: (n_stiff,) of what acts implicitly in its rate, at the last step [N], [N m]
    yielded: np.ndarray  # state: (n_wheel, 2) how far each rail gives way, right, down; empty where none does [m]
    yielding: np.ndarray  # state: (n_wheel, 2) how fast, at the last step [m/s]
    dragged: np.ndarray  # state: (n_wheel, 2) creep forces on each rail, at the last step [N]
    lag: np.ndarray  # state: (n_wheel, MAX_CONTACT, 6) slow patches: strain [N], place [m], 1: is one; then derived
    clock: np.ndarray  # state: (1,) time [s]
    held: np.ndarray  # state: (1,) grown part of the force that holds the speed [N]
    port: np.ndarray  # state: (n_axle,) PORT
    train: np.ndarray  # state: (1,) TRAIN
    delayed: np.ndarray  # state: (n,) brake demand on its way through the pipe; n = 0: there is no brake [-]
    guest: np.ndarray  # state: (n,) what a guest keeps, then its inputs and outputs by axle; n = 0: there is none
    memory: np.ndarray  # state: (2, n_cell) work of wheels on right and left rail, per metre [J/m]; n = 0: forgotten
    q_start: np.ndarray  # derived: (n_body, 6) coordinates and velocities at the beginning of the step
    v_start: np.ndarray  # derived: (n_body, 6)
    dv_start: np.ndarray  # derived: (n_body, 6) acceleration of the last step
    rate: np.ndarray  # derived: (n_body, 6) dq/dt
    frame: np.ndarray  # derived: (n_body,) FRAME
    damper_rate: np.ndarray  # derived: (n_state,) [m/s, N/s]
    carried: np.ndarray  # derived: (n_element,) push of a bushing on its upper body along -z of the joint's axes [N]
    load: np.ndarray  # derived: (n_body, 6) M dv/dt: force in track axes, moment in own axes [N, N m]
    rail_load: np.ndarray  # derived: (n_body, 6) part of it from the rails: normal and creep forces
    sample: np.ndarray  # derived: (SAMPLE_ROWS, NODE_CHANNELS) table values of the wheel at hand
    contact: np.ndarray  # derived: (n_wheel, MAX_CONTACT) CONTACT
    rail: np.ndarray  # derived: (n_wheel,) RAIL
    creep_damping: np.ndarray  # derived: (n_body, 6, 6) -d load / d v of the creep forces
    wheel_damping: np.ndarray  # derived: (n_wheel, 6, 6) of each wheel, its rail's rate held; empty as yielded
    support: np.ndarray  # derived: (n_wheel,) SUPPORT; empty as yielded
    stiff: np.ndarray  # derived: (n_stiff,) STIFF
    traction: np.ndarray  # derived: (1,) force that holds the speed [N]
    fault: np.ndarray  # derived: (1,) index of the culprit when the status is not OK


MODEL_TYPE = types.NamedTuple(
    (
        *map(constant, (PARAM, PIECE, BODY, JOINT, ELEMENT, CURVE, WHEEL, TABLE)),
        constant(np.float64, 2),
        constant(np.int32),
        constant(np.int32, 2),
        *3 * [constant(np.float64, 2)],
        constant(np.float64, 3),
        *map(constant, (AXLE, ASSEMBLY, PLAN, LINE)),
    ),
    Model,
)

DATA_TYPE = types.NamedTuple(
    (
        *3 * [mutable(np.float64, 2)],
        *2 * [mutable(np.float64)],
        *3 * [mutable(np.float64, 2)],
        mutable(np.float64, 3),
        *2 * [mutable(np.float64)],
        mutable(PORT),
        mutable(TRAIN),
        *2 * [mutable(np.float64)],
        mutable(np.float64, 2),
        *4 * [mutable(np.float64, 2)],
        mutable(FRAME),
        *2 * [mutable(np.float64)],
        *3 * [mutable(np.float64, 2)],
        mutable(CONTACT, 2),
        mutable(RAIL),
        *2 * [mutable(np.float64, 3)],
        mutable(SUPPORT),
        mutable(STIFF),
        mutable(np.float64),
        mutable(np.int64),
    ),
    Data,
)


def new_data(model, q, n_damper):
    """Data at rest at coordinates q.

    Parameters
    ----------
    model : Model
    q : array_like, shape (n_body, 6)
        Coordinates against the track frame [m, rad].
    n_damper : int
        Number of damper states.
    """
    n_body, n_wheel = model.body.size, model.wheel.size
    n_yield = n_wheel if model.param[0]["rail_stiffness"].any() else 0
    n_stiff = 1 + max(model.element["stiff"].max(initial=-1), model.axle["row"].max(initial=-1))
    rail, param = np.zeros(n_wheel, RAIL), model.param[0]
    for grip, friction in zip(rail["grip"], model.wheel["friction"], strict=True):
        grip[:] = friction, *(param[key] for key in OF_GRIP)
    port, train = np.zeros(model.axle.size, PORT), np.zeros(1, TRAIN)
    port["edge_time"], port["torque_share"], train["seed"] = -1.0, 1.0, 1 + model.assembly[0]["seed"]
    n_guest = model.axle.size * (GUEST_INPUTS + GUEST_OUTPUTS)
    train["pilot"], train["stop_time"], train["known_time"] = -1, -1.0, -1.0
    return Data(
        q=np.array(q, dtype=np.float64).reshape(n_body, 6),
        v=np.zeros((n_body, 6)),
        dv=np.zeros((n_body, 6)),
        damper=np.zeros(n_damper),
        tension=np.zeros(n_stiff),
        yielded=np.zeros((n_yield, 2)),
        yielding=np.zeros((n_yield, 2)),
        dragged=np.zeros((n_yield, 2)),
        lag=np.zeros((n_wheel, MAX_CONTACT, 6)),
        clock=np.zeros(1),
        held=np.zeros(1),
        port=port,
        train=train,
        delayed=np.zeros(DELAYED if model.axle.size else 0),
        guest=np.zeros(GUEST_STATE + n_guest if model.assembly[0]["guest"] else 0),
        memory=np.zeros((2, n_cells(model))),
        q_start=np.zeros((n_body, 6)),
        v_start=np.zeros((n_body, 6)),
        dv_start=np.zeros((n_body, 6)),
        rate=np.zeros((n_body, 6)),
        frame=np.zeros(n_body, FRAME),
        damper_rate=np.zeros(n_damper),
        carried=np.zeros(model.element.size),
        load=np.zeros((n_body, 6)),
        rail_load=np.zeros((n_body, 6)),
        sample=np.zeros((SAMPLE_ROWS, NODE_CHANNELS)),
        contact=np.zeros((n_wheel, MAX_CONTACT), CONTACT),
        rail=rail,
        creep_damping=np.zeros((n_body, 6, 6)),
        wheel_damping=np.zeros((n_yield, 6, 6)),
        support=np.zeros(n_yield, SUPPORT),
        stiff=np.zeros(n_stiff, STIFF),
        traction=np.zeros(1),
        fault=np.zeros(1, np.int64),
    )


OF_GRIP = ("friction_ratio", "friction_decay", "adhesion_reduction", "slip_reduction")  # of PARAM, as Grip counts them


def n_cells(model):
    """Cells in which each rail remembers the work of wheels."""
    assembly = model.assembly[0]
    if assembly["memory"] != Memory.RAIL:
        return 0
    end = model.track[-1]["start"] + model.track[-1]["length"]
    return 1 + int((end - assembly["cell_start"]) / assembly["cell"])


NO_AXLE, NO_ASSEMBLY = np.zeros(0, AXLE), np.zeros(1, ASSEMBLY)
NO_PLAN, NO_LINE = np.zeros(0, PLAN), np.zeros(0, LINE)
NO_SHIFT = np.zeros((0, SHIFT_CHANNELS))  # Model.shift of rails in their ideal place
NO_HEIGHTS = np.zeros((0, ROW))
NO_MATRIX = np.zeros((0, 12, 6))


def freeze(model):
    """The same model with every array made read-only."""
    for array in model:
        array.flags.writeable = False
    return model
