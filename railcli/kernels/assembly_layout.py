"""Schema of what brakes, drives and controls a vehicle: ports, states and parameters, SI units (docs/subsystems.md).

A *port* is what one subsystem hands to another; all of an axle stand in PORT, all of the vehicle in TRAIN, and each
family writes only its own. Axles count from the front. Torques act about the axle and are positive forward, but for
`brake_torque`, which is positive against it.
"""

from enum import IntEnum

import numpy as np

EVENTS = 8  # valve commands on their way through a dead time
WINDOW = 6  # speeds that a controller keeps
DELAYED = 256  # samples of the brake demand on its way through the pipe
GUEST_STATE = 256  # numbers that a guest keeps
GUEST_INPUTS = 4  # of each axle: speed [m/s], relative pressure, demands of brake and traction [-]
GUEST_OUTPUTS = 2  # of each axle: Valve, share of the traction torque [-]


class Rise(IntEnum):
    """How the distributor follows the demand."""

    LINEAR = 0  # at a constant rate
    EXPONENTIAL = 1
    STEPPED = 2  # an inshot, then at a constant rate


class Pad(IntEnum):
    """Friction of pads and blocks."""

    NOMINAL = 0  # the given torque at full pressure, whatever the speed
    CONSTANT = 1
    TABLE = 2  # over speed
    CAST_IRON = 3  # P10, Karwatzki's law


class Valve(IntEnum):
    """States of a dump valve."""

    FILL = 0  # the cylinder follows the distributor
    HOLD = 1
    VENT = 2


class Protection(IntEnum):
    """Wheel slide protection."""

    NONE = 0
    THRESHOLD = 1  # slide and acceleration against fixed limits


class Reference(IntEnum):
    """Where the reference speed of a slide protection comes from."""

    TRUE = 0  # the first body's own; no rig has it
    AXLES = 1  # the fastest axle, and a pilot axle that is let go now and then


class Grip(IntEnum):
    """What a rail lends a wheel: friction mu0 ((1 - A) exp(-B w) + A) at a slip velocity w, Polach's reductions."""

    FRICTION = 0  # mu0 [-]
    RATIO = 1  # A [-]
    DECAY = 2  # B [s/m]
    ADHESION = 3  # k_A [-]
    SLIP = 4  # k_S [-]


GRIPS = len(Grip)


class Driver(IntEnum):
    """Who asks for brake and traction."""

    NOBODY = 0
    DEMAND = 1  # demands over time
    LINE = 2  # permitted speeds and stops along the line


class Odometry(IntEnum):
    """How speed and distance are told from the sensors."""

    NONE = 0
    AXLES = 1  # fastest axle in braking, slowest in traction, within limits of the rate
    KALMAN = 2  # an accelerometer, corrected by those axles that agree with it


class Sensor(IntEnum):
    """How the speed of an axle is sensed."""

    IDEAL = 0  # radius times spin
    COUNTING = 1  # edges of a phonic wheel over the period of the controller
    TIMING = 2  # time between its edges


class Memory(IntEnum):
    """What cleans a contact."""

    NONE = 0
    OWN = 1  # its own work
    RAIL = 2  # the work of the wheels that passed


AXLE = np.dtype(  # what brakes and drives one wheelset
    [
        ("wheelset", "i8"),  # body
        ("frame", "i8"),  # body on which the torques react
        ("first", "i8"),  # its right wheel
        ("row", "i8"),  # of its brake in Data.stiff
        ("radius", "f8"),  # of its wheels, that sensors and brakes count with [m]
        ("brake_torque", "f8"),  # at full pressure: Pad.NOMINAL [N m]
        ("brake_force", "f8"),  # of all pads or blocks on their discs or wheels [N]
        ("block_force", "f8"),  # of one of them [N]
        ("brake_radius", "f8"),  # at which they rub [m]
        ("full_torque", "f8"),  # of its brake at full demand and rest, that blending counts with [N m]
        ("driven", "i8"),  # 1: has traction
        ("sensed_radius", "f8"),  # that its sensor takes for its radius [m]
    ],
    align=True,
)

ASSEMBLY = np.dtype(  # parameters of the subsystems
    [
        ("driver", "i8"),  # Driver
        ("brake_curve", "i8"),  # demand of the driver over time, index into curves; -1: none
        ("traction_curve", "i8"),
        ("planned", "f8"),  # LINE: deceleration with which it brakes to a place or speed [m/s^2]
        ("eager", "f8"),  # LINE: acceleration asked for per lack of speed [1/s]
        ("mass", "f8"),  # LINE: of the vehicle with its rotation [kg]
        ("delay", "f8"),  # of the demand on its way to the distributor [s]
        ("rise", "i8"),  # Rise
        ("apply", "f8"),  # time of the rise, linear to the full pressure, exponential to 95 % of it [s]
        ("release", "f8"),  # likewise down [s]
        ("inshot", "f8"),  # share of the full pressure that comes at once: STEPPED [-]
        ("inshot_time", "f8"),  # within this time [s]
        ("pressure", "f8"),  # of a cylinder at full demand [Pa]
        ("volume", "f8"),  # of the cylinders of an axle [m^3]
        ("fill", "f8"),  # time constant of a cylinder behind its valve; 0: it follows the distributor [s]
        ("vent", "f8"),  # [s]
        ("dead", "f8"),  # of a valve [s]
        ("pad", "i8"),  # Pad
        ("pad_friction", "f8"),  # CONSTANT [-]
        ("pad_curve", "i8"),  # TABLE: over the speed at the wheel's tread [m/s]
        ("envelope", "i8"),  # torque at an axle over the tread's speed at full traction, index into curves; -1: none
        ("electric", "i8"),  # largest braking torque of the motors likewise; -1: they do not brake
        ("fade", "f8", 2),  # speeds between which the electric brake fades out: none below, all above [m/s]
        ("lag", "f8"),  # time constant of the traction torque [s]
        ("torque_rate", "f8"),  # largest of the traction torque [N m/s]
        ("sensor", "i8"),  # Sensor
        ("teeth", "i8"),  # of a phonic wheel, an edge each
        ("clock", "f8"),  # resolution with which edges are timed; 0: exact [s]
        ("seed", "i8"),  # of its noise
        ("noise", "f8"),  # of a sensed speed: standard deviation [m/s]
        ("period", "f8"),  # at which sensors are read and controllers act; 0: nobody reads them [s]
        ("protection", "i8"),  # Protection
        ("reference", "i8"),  # Reference
        ("active_above", "f8"),  # reference speed below which it lets all valves fill [m/s]
        ("slide_vent", "f8"),  # slide beyond which it vents [-]
        ("slide_hold", "f8"),  # holds [-]
        ("slide_watch", "f8"),  # heeds the deceleration [-]
        ("fall", "f8"),  # acceleration below which it vents then [m/s^2]
        ("regain", "f8"),  # from which on it holds in place of venting [m/s^2]
        ("reference_fall", "f8"),  # fastest that the reference speed may fall with no axle to trust [m/s^2]
        ("pilot_every", "f8"),  # time between two pilot axles [s]
        ("guest", "i8"),  # address of a user's controller; 0: none
        ("antislip", "i8"),  # 1: torque is cut at axles that spin
        ("slip_cut", "f8"),  # speed over the slowest axle beyond which it is cut [m/s]
        ("spin_cut", "f8"),  # acceleration beyond which it is cut [m/s^2]
        ("cut", "f8"),  # share of it that stays at each sample [-]
        ("regrip", "f8"),  # rate at which it comes back [1/s]
        ("odometry", "i8"),  # Odometry
        ("odometer_fall", "f8"),  # AXLES: fastest change of the speed down [m/s^2]
        ("odometer_rise", "f8"),  # and up [m/s^2]
        ("bias", "f8"),  # KALMAN: of the accelerometer [m/s^2]
        ("acceleration_noise", "f8"),  # KALMAN: what it takes for its standard deviation [m/s^2]
        ("speed_noise", "f8"),  # KALMAN: what it takes for that of an axle's speed [m/s]
        ("memory", "i8"),  # Memory
        ("cleaning", "f8"),  # tau: energy per metre of rail at which 63 % are recovered, its inverse [m/J]
        ("cell", "f8"),  # length over which a rail remembers [m]
        ("cell_start", "f8"),  # arc length of the first [m]
        ("resistance", "f8", 3),  # A + B V + C V^2 [N, N s/m, N s^2/m^2]
        ("ends", "i8"),  # 1: the run ends when the vehicle stands
        ("end_place", "f8"),  # or at this arc length [m]
        ("free", "i8"),  # 1: speed is a result, not held
    ],
    align=True,
)

PLAN = np.dtype(  # a place on the driver's plan
    [
        ("place", "f8"),  # arc length of the first body [m]
        ("speed", "f8"),  # permitted from there on [m/s]
        ("dwell", "f8"),  # time for which the vehicle stands there; 0: it runs through [s]
    ],
    align=True,
)

LINE = np.dtype(  # a stretch of the line
    [
        ("start", "f8"),  # arc length from which on it holds [m]
        ("blend", "f8"),  # length over which it takes the place of the one before [m]
        ("grip", "f8", (2, GRIPS)),  # of the right and the left rail: Grip
        ("clean", "f8", (2, GRIPS)),  # when its film is gone
        ("films", "i8"),  # 1: has a film that goes
    ],
    align=True,
)

PORT = np.dtype(  # of an axle
    [
        ("speed", "f8"),  # sensor: of its tread, as sampled last [m/s]
        ("edge", "f8"),  # sensor: number of the last edge, as an angle counts them [-]
        ("edge_time", "f8"),  # sensor: when that passed; -1: none has [s]
        ("acceleration", "f8"),  # controller: of that [m/s^2]
        ("kept", "f8", WINDOW),  # controller: the last samples [m/s]
        ("kept_count", "i8"),
        ("valve", "i8"),  # controller: Valve asked for
        ("valve_now", "i8"),  # brake: Valve after the dead time
        ("event_time", "f8", EVENTS),  # brake: when a command arrives [s]
        ("event_valve", "i8", EVENTS),
        ("events", "i8"),  # commands on their way
        ("relative", "f8"),  # brake: pressure of the cylinder over that at full demand [-]
        ("pressure", "f8"),  # brake: [Pa]
        ("pad_friction", "f8"),  # brake: [-]
        ("brake_limit", "f8"),  # brake: largest torque against the relative spin [N m]
        ("brake_torque", "f8"),  # brake: that acts, against running forward [N m]
        ("air", "f8"),  # brake: used, at 1.013 bar [m^3]
        ("vents", "i8"),  # brake: how often the valve began to vent
        ("torque_share", "f8"),  # controller: of the demanded traction torque that it lets pass [-]
        ("traction_torque", "f8"),  # traction: forward; the electric brake's is negative [N m]
        ("place", "i8", 2),  # adhesion: cell of each rail under it
        ("pending", "f8", 2),  # adhesion: work per metre that waits to be handed to that cell [J/m]
        ("work", "f8", 2),  # adhesion: per metre, that counts for each wheel [J/m]
        ("piece", "i8"),  # adhesion: of the line
        ("slide", "f8"),  # (V - v) / V, true [-]
        ("largest_slide", "f8"),  # so far, while the vehicle ran above 5 m/s [-]
        ("used", "f8"),  # longitudinal force on the rails over the vertical one [-]
        ("offered", "f8"),  # friction at the slip velocity of its wheels, mean [-]
        ("locked", "f8"),  # time for which it stood while the vehicle ran [s]
        ("flat_work", "f8"),  # work of its creep forces then [J]
    ],
    align=True,
)

TRAIN = np.dtype(  # of the vehicle
    [
        ("brake_demand", "f8"),  # driver: 0 to 1 [-]
        ("traction_demand", "f8"),  # driver: 0 to 1 [-]
        ("delayed_at", "i8"),  # brake: sample of Data.delayed that was written last
        ("target_speed", "f8"),  # driver: LINE [m/s]
        ("trim", "f8"),  # driver: acceleration that makes up for what it does not know [m/s^2]
        ("next", "i8"),  # driver: place on the plan before which the vehicle is, of those with a stop
        ("dwelt", "f8"),  # driver: time for which it has stood at a stop [s]
        ("arrived", "f8"),  # brake: demand at the distributor [-]
        ("applied", "f8"),  # brake: pressure of the distributor over that at full demand [-]
        ("due", "f8"),  # controller: next sample [s]
        ("reference", "f8"),  # controller: reference speed [m/s]
        ("reference_rate", "f8"),  # controller: at which it falls while no axle keeps up with it [m/s^2]
        ("alone", "f8"),  # controller: time for which none has [s]
        ("pilot", "i8"),  # controller: axle that is let go; -1: none
        ("pilot_next", "i8"),  # controller: the one to come
        ("pilot_since", "f8"),  # controller: when it was let go, or the one before was taken back [s]
        ("known_speed", "f8"),  # controller: of the vehicle, as the pilot before told it [m/s]
        ("known_time", "f8"),  # controller: when; -1: not yet [s]
        ("odometer_speed", "f8"),  # odometry [m/s]
        ("began", "f8"),  # odometry: arc length at which the run began [m]
        ("odometer", "f8"),  # odometry: distance since the run began [m]
        ("odometer_variance", "f8"),  # odometry: of its speed [m^2/s^2]
        ("odometer_cone", "f8"),  # odometry: largest error of the distance over 5 m + 5 % so far [-]
        ("seed", "u8"),  # sensor: state of its noise
        ("resistance", "f8"),  # line: force against running forward [N]
        ("standing", "f8"),  # time for which the vehicle has stood [s]
        ("stop_time", "f8"),  # when it came to stand; -1: it runs [s]
        ("stop_place", "f8"),  # and where [m]
        ("creep_loss", "f8"),  # energy ledger: what creep forces took, spin included [J]
        ("normal_loss", "f8"),  # what normal forces took: stored, or lost in contact and track [J]
        ("suspension_loss", "f8"),  # what springs, dampers and friction of the suspension took: stored, or lost [J]
        ("brake_loss", "f8"),  # what brakes took [J]
        ("resistance_loss", "f8"),  # what running resistance took [J]
        ("traction_work", "f8"),  # what traction gave [J]
        ("holding_work", "f8"),  # what the force that holds the speed gave [J]
        ("gravity_work", "f8"),  # what weights gave [J]
    ],
    align=True,
)
