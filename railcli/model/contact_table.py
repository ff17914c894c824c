"""Contact tables: what one is built from, what it holds, how it enters the core."""

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from railcli.errors import InputError
from railcli.kernels.layout import NO_HEIGHTS, PARTS, TABLE

from .heights import making, places
from .profile import TAPE_LIMITS, TAPE_TO_BACK
from .submodels import NORMAL_LAWS, choose

VERSION = 3  # of the table's meaning; a table of another version is refused

OF_HEIGHTS = (
    *(f"{axis}_{kind}" for axis in ("y", "roll", "yaw2") for kind in ("bins", "knots", "basis")),
    "coefficients", "parts",
)  # fmt: skip
SAME_TAPE = 1e-6  # distances of tape circles from flange backs that count as one [m]
MOST_POSITIONS = 10_000_000  # some GB
LIMITS = {
    "gauge": (0.5, 2.0, "m"),
    "flange_back": (0.4, 2.0, "m"),
    "tape_to_back": (*TAPE_LIMITS, "m"),
    "radius": (0.1, 1.0, "m"),
    "y_range": (0.001, 0.1, "m"),
    "y_step": (1e-6, 1e-3, "m"),
    "roll_range": (0.001, 0.2, "rad"),
    "roll_step": (1e-5, 0.01, "rad"),
    "yaw_range": (0.001, 0.1, "rad"),
    "yaw_count": (2, 200, "nodes"),
    "young": (1e9, 1e12, "Pa"),
    "poisson": (0.0, 0.5, "-"),
    "curvature_window": (0.0, 0.02, "m"),
    "fineness": (0.25, 3.0, "-"),  # 2 GB of a usual pair
}


@dataclass(frozen=True)
class TableSettings:
    """Geometry, material and grid of a contact table; SI.

    Attributes
    ----------
    inclination : float
        Rail inclination 1:n as n, which is given to the rail's profile; 0: the rail stands as in its profile.
    gauge, flange_back, radius : float
        Track gauge (at 14 mm below the top of the inclined rail), distance of the flange backs, wheel radius at the
        tape circle [m].
    tape_to_back : float
        Distance of the tape circle, the origin of wheel profiles, from the flange back [m].
    y_range, y_step : float
        Lateral position of the wheel's reference point about nominal: half range and step [m].
    roll_range, roll_step : float
        Half range and step [rad].
    yaw_range : float
        Largest yaw [rad]; the table holds positive yaw only.
    yaw_count : int
        Nodes, uniform in the square of yaw.
    young, poisson : float
        Of wheel and rail [Pa], [-].
    curvature_window : float
        Arc length over which the profile curvatures of Hertz's ellipse are averaged [m].
    normal : str
        Patches: a name of `submodels.NORMAL_LAWS`.
    fineness : float
        Divides the distances of the knots that a table of heights chooses for itself; y_step, roll_step, yaw_count and
        curvature_window are nothing to it.
    """

    inclination: float = 20.0
    gauge: float = 1.435
    flange_back: float = 1.360
    tape_to_back: float = TAPE_TO_BACK
    radius: float = 0.460
    y_range: float = 0.020
    y_step: float = 0.05e-3
    roll_range: float = 0.025
    roll_step: float = 1.25e-3
    yaw_range: float = 0.030
    yaw_count: int = 11
    young: float = 210e9
    poisson: float = 0.28
    curvature_window: float = 2.0e-3
    normal: str = "overlap"
    fineness: float = 1.0

    def __post_init__(self):
        for key, (low, high, unit) in LIMITS.items():
            value = getattr(self, key)
            if not (math.isfinite(value) and low <= value <= high):
                raise InputError(f"contact table: {key}", f"must lie in {low:g} ... {high:g} {unit}, got {value:g}")
        if not (self.inclination == 0 or 5 <= abs(self.inclination) <= 1000):
            raise InputError(
                "contact table: inclination",
                f"1:n needs n of 5 ... 1000, or 0 for a rail as in its profile; got {self.inclination:g}",
            )
        choose(NORMAL_LAWS, "contact table: normal", self.normal)
        if not self.stores_heights and self.positions > MOST_POSITIONS:
            raise InputError(
                "contact table",
                f"{self.positions:.4g} positions of the wheel (y {self.y_count}, roll {self.roll_count}, yaw "
                f"{self.yaw_count}); at most {MOST_POSITIONS:g}: reduce a range or enlarge a step",
            )
        if self.fineness != 1.0 and not self.stores_heights:
            raise InputError("contact table: fineness", f"must be 1 with normal {self.normal}, whose grid is given")

    @property
    def stores_heights(self):
        """True when the table holds the heights of energies, in place of rigid contact points."""
        return NORMAL_LAWS[self.normal].value == "heights"

    @property
    def lateral(self):
        """Distance of the tape circle from the wheelset's centre [m]."""
        return 0.5 * self.flange_back + self.tape_to_back

    @property
    def y_count(self):
        return 2 * round(self.y_range / self.y_step) + 1

    @property
    def roll_count(self):
        return 2 * round(self.roll_range / self.roll_step) + 1

    @property
    def positions(self):
        """Number of wheel poses in the grid."""
        return self.y_count * self.roll_count * self.yaw_count

    def on(self, *rails):
        """These settings for rail profiles; their inclination is 0 where all of them include it already."""
        return replace(self, inclination=0.0) if all(rail.inclined for rail in rails) else self

    def as_dict(self):
        return asdict(self)


@dataclass(frozen=True)
class Mounting:
    """Right-hand wheel over right-hand rail as the difference kernels take them.

    Attributes
    ----------
    wheel, rail : array (n, 3)
        Graphs (value [m], slope [-], mean curvature [1/m]); the rail inclined, its top at z = 0.
    wheel_start, wheel_step, rail_start, rail_step : float
        Their grids [m].
    seat : float
        Lateral position of the nominal reference point in the rail's axes [m].
    radius : float
        Of the tape circle [m].
    pressed : float
        0: contact points of rigid profiles. Else quasi-elastic: the places of greatest approach when the wheel is
        pressed in by this much beyond first touch [m].
    """

    wheel: np.ndarray
    wheel_start: float
    wheel_step: float
    rail: np.ndarray
    rail_start: float
    rail_step: float
    seat: float
    radius: float
    pressed: float = 0.0

    @property
    def kernel_arguments(self):
        """r0, seat, wheel graph, rail graph in the order of the difference kernels."""
        return (
            self.radius, self.seat,
            self.wheel, self.wheel_start, self.wheel_step,
            self.rail, self.rail_start, self.rail_step,
        )  # fmt: skip


def check_tape(wheel, tape_to_back):
    """Raise an InputError if a wheel profile counts from another tape circle [m from the flange back]."""
    own = wheel.tape_to_back
    if own is not None and abs(own - tape_to_back) > SAME_TAPE:
        raise InputError(
            wheel.name,
            f"counts from a tape circle {own * 1e3:g} mm from the flange back, needed: {tape_to_back * 1e3:g} mm; give "
            f"--tape-to-back {own * 1e3:g} (in a scenario: contact.tape_to_back_mm = {own * 1e3:g}), or import the "
            f"wheel with --tape-to-back {tape_to_back * 1e3:g}",
        )


def mount(wheel, rail, settings):
    """Place a right-hand wheel and rail profile against each other.

    Gauge is measured between the innermost points of both inclined rails down to 14 mm below their top. A rail whose
    profile includes its inclination is not inclined again.
    """
    check_tape(wheel, settings.tape_to_back)
    settings = settings.on(rail)
    angle = -math.atan(1.0 / settings.inclination) if settings.inclination else 0.0
    inclined = rail.rotated(angle)
    y_gauge, z_top = inclined.gauge_point()
    inclined = inclined.translated(0.0, -z_top)
    window = settings.curvature_window
    rail_start, rail_step, rail_graph = inclined.graph(window=window)
    wheel_start, wheel_step, wheel_graph = wheel.graph(window=window)
    return Mounting(
        wheel=np.ascontiguousarray(wheel_graph),
        wheel_start=wheel_start,
        wheel_step=wheel_step,
        rail=np.ascontiguousarray(rail_graph),
        rail_start=rail_start,
        rail_step=rail_step,
        seat=settings.lateral - 0.5 * settings.gauge + y_gauge,
        radius=settings.radius,
    )


@dataclass(frozen=True, eq=False)
class ContactTable:
    """Every contact point of a right-hand wheel over a grid of poses.

    Attributes
    ----------
    settings : TableSettings
    wheel_name, rail_name, wheel_digest, rail_digest : str
        The profiles it was built from.
    method : str
        "simplex" or "locus".
    node : array (n_row, NODE_CHANNELS)
        Contact points at grid poses, channels as `kernels.layout.Node`; none with `settings.stores_heights`.
    cell : int32 array (n_cell + 1,)
        First branch of each cell, cells ordered roll, yaw^2, y (fastest).
    branch : int32 array (n_branch, 8)
        Node, or part of the contact, at each corner of the cell (bit 0: y, 1: roll, 2: yaw^2); -1 where the branch ends
        before it.
    heights : array (n, ROW)
        As `model.heights.pack`; empty unless `settings.stores_heights`.
    counts : tuple of int
        Knots of y, roll and yaw^2; of the grid of the settings unless `settings.stores_heights`.
    """

    settings: TableSettings
    wheel_name: str
    rail_name: str
    wheel_digest: str
    rail_digest: str
    method: str
    node: np.ndarray
    cell: np.ndarray
    branch: np.ndarray
    heights: np.ndarray = field(default_factory=NO_HEIGHTS.copy)
    counts: tuple = ()

    def __post_init__(self):
        if not self.counts:
            s = self.settings
            object.__setattr__(self, "counts", (s.y_count, s.roll_count, s.yaw_count))
        for key in ("node", "cell", "branch", "heights"):
            getattr(self, key).flags.writeable = False

    @property
    def points(self):
        """Number of contact points."""
        if self.settings.stores_heights:
            return (self.heights.shape[0] - places(self.counts)[-1]) // PARTS
        return self.node.shape[0]

    @property
    def record(self):
        """The TABLE record of this table alone, as a pool of one."""
        s, record = self.settings, np.zeros(1, TABLE)
        record["y_start"], record["y_step"] = -s.y_step * (s.y_count // 2), s.y_step
        record["roll_start"], record["roll_step"] = -s.roll_step * (s.roll_count // 2), s.roll_step
        record["yaw2_step"] = s.yaw_range**2 / (s.yaw_count - 1)
        record["y_count"], record["roll_count"], record["yaw2_count"] = self.counts
        record["levels"] = -1
        record["shear"], record["poisson"] = 0.5 * s.young / (1.0 + s.poisson), s.poisson
        if s.stores_heights:
            record["levels"] = 0
            for key, row in zip(OF_HEIGHTS, places(self.counts), strict=True):
                record[key] = row
        return record

    @property
    def key(self):
        """Digest of all that determines the table's contents."""
        return table_key(self.settings, self.wheel_digest, self.rail_digest, self.method)

    @property
    def bytes(self):
        return self.node.nbytes + self.cell.nbytes + self.branch.nbytes + self.heights.nbytes


def version(stores_heights):
    """What a table means, with heights or without: one of another version is refused."""
    return f"{VERSION}, heights {making()}" if stores_heights else VERSION


def table_key(settings, wheel_digest, rail_digest, method):
    """Digest of settings, profiles, method and version: two tables with one key are the same table."""
    found = [version(settings.stores_heights), settings.as_dict(), wheel_digest, rail_digest, method]
    text = json.dumps(found, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
