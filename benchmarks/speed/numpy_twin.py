"""The right-hand side of the model in NumPy: an independent twin of the compiled core, and its yardstick of speed.

Written from the equations, vectorised over bodies, elements and wheels. Where the core uses closed forms this twin uses
the general tool: linear systems for the rates of the angles, rotation vectors and Jacobians of SO(3) for the mean axes
of a joint, gradients of the quaternion for its rotational stiffness.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from railcli.kernels.layout import MAX_CONTACT, Axes, Creep, Kind, Node

SCALED = (Node.F11, Node.F22, Node.F23, Node.F33)
POWERS = np.array([2.0, 2.0, 3.0, 4.0]) / 3.0  # of d^1.5 that each grows with
PART = Node.GAP_Y  # of a sample: weight of the corners that have the branch


class Bodies(NamedTuple):
    """Pose and motion of all bodies: leading axis body, vectors in ground axes unless said otherwise."""

    track: np.ndarray  # (n, 3, 3) columns: axes of the track frame
    turning: np.ndarray  # (n, 3) rotation of the track frame per metre, track axes [1/m]
    advance: np.ndarray  # (n, 3) motion of its origin per metre, track axes [-]
    pose: np.ndarray  # (n, 3, 3) columns: axes of the body's frame, in track axes
    axes: np.ndarray  # (n, 3, 3) columns: axes of the body's frame
    position: np.ndarray  # (n, 3) of the centre [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    omega: np.ndarray  # (n, 3) of the body [rad/s]
    omega_frame: np.ndarray  # (n, 3) of its frame, a wheelset's without spin [rad/s]
    rate: np.ndarray  # (n, 6) dq/dt


class Patches(NamedTuple):
    """Contact patches: axes wheel, patch; track axes, forces on the wheel; patches without load are zero."""

    normal: np.ndarray  # [N]
    creep: np.ndarray  # (..., 3) along x, along t [N], spin moment [N m]
    creepage: np.ndarray  # (..., 3) xi, eta [-], phi [1/m]
    depth: np.ndarray  # [m]
    lateral: np.ndarray  # [m]
    force: np.ndarray  # (..., 3) whole force [N]
    moment: np.ndarray  # (..., 3) about the wheelset's centre [N m]


class Loads(NamedTuple):
    """What `evaluate` gives."""

    load: np.ndarray  # (n_body, 6) M dv/dt: force in track axes, moment in own axes [N, N m]
    acceleration: np.ndarray  # (n_body, 6) dv/dt
    damper_rate: np.ndarray  # (n_state,) [m/s]
    bodies: Bodies
    patches: Patches


def rotation(axis, angle):
    """Matrices of rotations about coordinate axis 0, 1 or 2; angle : (n,) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((angle.size, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[:, axis, axis] = 1.0
    matrix[:, i, i] = matrix[:, j, j] = c
    matrix[:, i, j], matrix[:, j, i] = -s, s
    return matrix


def turn(matrix, vector):
    """matrix @ vector over leading axes."""
    return np.einsum("...ij,...j->...i", matrix, vector)


def turn_back(matrix, vector):
    """Transposed matrix @ vector over leading axes."""
    return np.einsum("...ji,...j->...i", matrix, vector)


def skew(v):
    """Matrices S with S w = v x w."""
    s = np.zeros((*v.shape, 3))
    s[..., 0, 1], s[..., 0, 2], s[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return s - np.swapaxes(s, -1, -2)


def polynomial(coefficients, u):
    """Sum of coefficients[:, k] u^k."""
    return np.sum(coefficients * u[:, None] ** np.arange(coefficients.shape[1]), axis=1)


def track_frames(model, s):
    """Origin (n, 3), axes (n, 3, 3), turning and advance (n, 3) of the track frame at arc lengths s."""
    piece = model.track[np.searchsorted(model.track["start"], s, side="right") - 1]
    u = s - piece["start"]
    base = model.param["cant_base"][0]
    curvature, cant = polynomial(piece["curvature"], u), polynomial(piece["cant"], u)
    cant_slope = polynomial(piece["cant"][:, 1:] * np.arange(1, 4), u)
    tangent = piece["cos_heading"] + 1j * piece["sin_heading"]
    heading = np.angle(tangent) + u * polynomial(piece["curvature"] / np.arange(1, 5), u)
    plan = piece["x"] + 1j * piece["y"] + tangent * u * polynomial(piece["path_x"] + 1j * piece["path_y"], u)
    roll, pitch = np.arcsin(cant / base), polynomial(piece["gradient"], u)
    depth = piece["z"] + u * polynomial(piece["path_z"], u) - piece["lift"] * cant
    origin = np.stack([plan.real, plan.imag, depth], axis=1)
    roll_rate = cant_slope / np.sqrt(base**2 - cant**2)
    sloping = rotation(1, pitch) @ rotation(0, roll)
    down, across = turn_back(sloping, np.array([0.0, 0.0, 1.0])), turn_back(sloping, np.array([0.0, 1.0, 0.0]))
    turning = roll_rate[:, None] * [1.0, 0.0, 0.0] + curvature[:, None] * down + piece["gradient"][:, 1:] * across
    advance = np.array([1.0, 0.0, 0.0]) - (piece["lift"] * cant_slope)[:, None] * down
    return origin, rotation(2, heading) @ sloping, turning, advance


def kinematics(model, q, v):
    """Bodies at coordinates q and velocities v, (n, 6) each."""
    spins = model.body["spins"].astype(bool)
    origin, track, turning, advance = track_frames(model, q[:, 0])
    offset = q[:, :3] * [0.0, 1.0, 1.0]
    first = rotation(2, q[:, 5])
    second = first @ rotation(0, q[:, 3])
    pose = second @ rotation(1, np.where(spins, 0.0, q[:, 4]))
    per_metre = advance + np.cross(turning, offset)
    speed = v[:, 0] / per_metre[:, 0]
    carried = speed[:, None] * turning
    along = v[:, :3] - speed[:, None] * per_metre
    relative = turn(pose, v[:, 3:]) - carried
    angles = np.linalg.solve(np.stack([first[:, :, 0], second[:, :, 1], first[:, :, 2]], axis=2), relative[..., None])
    rate = np.column_stack([speed, along[:, 1:], angles[..., 0]])
    axes = track @ pose
    spin = np.where(spins, rate[:, 4], 0.0)[:, None] * [0.0, 1.0, 0.0]
    return Bodies(
        track=track, turning=turning, advance=advance, pose=pose, axes=axes, position=origin + turn(track, offset),
        velocity=turn(track, v[:, :3]), omega=turn(axes, v[:, 3:]), omega_frame=turn(axes, v[:, 3:] - spin), rate=rate,
    )  # fmt: skip


def read_curves(model, index, x):
    """Value and slope of curves index (n,) at x (n,); zero where the index is negative."""
    value, slope = np.zeros_like(x), np.zeros_like(x)
    for i in np.unique(index[index >= 0]):
        mine = index == i
        n = model.curve[i]["count"]
        knots, values = model.curve[i]["x"][:n], model.curve[i]["y"][:n]
        piece = np.clip(np.searchsorted(knots, x[mine]) - 1, 0, n - 2)
        slope[mine] = (np.diff(values) / np.diff(knots))[piece]
        value[mine] = values[piece] + slope[mine] * (x[mine] - knots[piece])
    return value, slope


def solve_curves(model, index, weight, target):
    """x with y(x) + weight x = target on curves index (n,) that do not fall; zero where the index is negative."""
    found = np.zeros_like(target)
    for k in np.flatnonzero(index >= 0):
        n = model.curve[index[k]]["count"]
        x, y = model.curve[index[k]]["x"][:n], model.curve[index[k]]["y"][:n]
        total = y + weight[k] * x
        piece = np.clip(np.searchsorted(total, target[k]) - 1, 0, n - 2)
        slope = (total[piece + 1] - total[piece]) / (x[piece + 1] - x[piece])
        found[k] = x[piece] + (target[k] - total[piece]) / slope
    return found


def left_jacobian(vector):
    """Matrices J of rotation vectors: the angular velocity of exp(vector) is J d vector/dt. Series near zero."""
    square = np.sum(vector**2, axis=-1)[..., None, None]
    angle = np.sqrt(square)
    small = angle < 1e-2
    safe = np.where(small, 1.0, angle)
    one = np.where(small, 0.5 - square / 24.0 + square**2 / 720.0, (1.0 - np.cos(safe)) / safe**2)
    two = np.where(small, 1.0 / 6.0 - square / 120.0 + square**2 / 5040.0, (safe - np.sin(safe)) / safe**3)
    matrix = skew(vector)
    return np.eye(3) + one * matrix + two * matrix @ matrix


def exponential(vector):
    """Rotation matrices of rotation vectors."""
    matrix = skew(vector)
    return np.eye(3) + left_jacobian(vector) @ matrix


def relative_rotation(lower, upper):
    """Quaternion (vector, scalar) and rotation vector that turn the lower axes into the upper, in lower axes."""
    matrix = np.swapaxes(lower, -1, -2) @ upper
    scalar = 0.5 * np.sqrt(1.0 + np.trace(matrix, axis1=-2, axis2=-1))
    odd = matrix - np.swapaxes(matrix, -1, -2)
    vector = np.stack([odd[..., 2, 1], odd[..., 0, 2], odd[..., 1, 0]], axis=-1) / (4.0 * scalar[..., None])
    sine = np.linalg.norm(vector, axis=-1)
    ratio = np.where(sine < 1e-6, 2.0, 2.0 * np.arctan2(sine, scalar) / np.where(sine < 1e-6, 1.0, sine))
    return vector, scalar, ratio[..., None] * vector


def suspension(model, bodies, damper, half_step):
    """Forces (n, 3) and moments about the centres (n, 3) of all joints, ground axes, and the rates of the dampers."""
    joint, element = model.joint, model.element
    if not np.isin(element["kind"], (Kind.BUSHING, Kind.LINK)).all() or (element["stiff"] >= 0).any():
        raise ValueError("this twin knows bushings and links whose dampers act at their present rate")
    force, moment = np.zeros_like(bodies.position), np.zeros_like(bodies.position)
    rates = np.zeros(damper.size)
    if joint.size == 0:
        return force, moment, rates
    vector, scalar, angle = relative_rotation(bodies.axes[joint["lower"]], bodies.axes[joint["upper"]])
    is_mean = (joint["axes"] == Axes.MEAN)[:, None, None]
    lower_axes = bodies.axes[joint["lower"]]
    frame = lower_axes @ np.where(is_mean, exponential(0.5 * angle), exponential(angle))
    share = 0.5 * left_jacobian(0.5 * angle) @ np.linalg.inv(left_jacobian(angle))
    share = np.where(is_mean, lower_axes @ share @ np.swapaxes(lower_axes, 1, 2), np.eye(3))

    of = np.repeat(np.arange(joint.size), joint["count"])
    lower, upper = joint["lower"][of], joint["upper"][of]
    arm_l, arm_u = turn(bodies.axes[lower], element["lower"]), turn(bodies.axes[upper], element["upper"])
    gap = bodies.position[upper] + arm_u - bodies.position[lower] - arm_l
    gap_rate = bodies.velocity[upper] + np.cross(bodies.omega_frame[upper], arm_u)
    gap_rate -= bodies.velocity[lower] + np.cross(bodies.omega_frame[lower], arm_l)

    relative = bodies.omega_frame[joint["upper"]] - bodies.omega_frame[joint["lower"]]
    omega = (bodies.omega_frame[joint["lower"]] + turn(share, relative))[of]
    d, rate = turn_back(frame[of], gap), turn_back(frame[of], gap_rate - np.cross(omega, gap))
    curves = np.stack([read_curves(model, element["spring_curve"][:, k], d[:, k])[0] for k in range(3)], axis=1)
    own = np.where((element["kind"] == Kind.BUSHING)[:, None], element["damper_curve"], -1)
    curves += np.stack([read_curves(model, own[:, k], rate[:, k])[0] for k in range(3)], axis=1)
    bushing = turn(frame[of], element["preload"] - element["k"] * d - element["c"] * rate - curves)

    length = np.linalg.norm(gap, axis=1)
    unit = gap / np.where(length > 0.0, length, 1.0)[:, None]
    stretch = length - element["length"]
    tension = element["preload"][:, 0] + element["k"][:, 0] * stretch
    tension += read_curves(model, np.where(element["kind"] == Kind.LINK, element["spring_curve"][:, 0], -1), stretch)[0]
    table, series = element["damper_curve"][:, 0] >= 0, element["state"] >= 0
    closing = np.sum(unit * gap_rate, axis=1)
    rigid = np.where(table, read_curves(model, element["damper_curve"][:, 0], closing)[0], element["c"][:, 0] * closing)
    trial = np.where(series, element["series"] * (length - damper[element["state"]] if damper.size else 0.0), 0.0)
    weight = half_step * element["series"]
    linear = trial / np.where(element["c"][:, 0] + weight > 0.0, element["c"][:, 0] + weight, 1.0)
    speed = np.where(table, solve_curves(model, element["damper_curve"][:, 0], weight, trial), linear)
    tension += np.where(series, trial - half_step * speed * element["series"], rigid)
    rates[element["state"][series]] = speed[series]

    is_link = (element["kind"] == Kind.LINK)[:, None]
    on_upper = np.where(is_link, -tension[:, None] * unit, bushing)
    couple = np.where(is_link, 0.0, np.cross(on_upper, gap))
    to_upper = turn_back(share[of], couple)
    np.add.at(force, upper, on_upper)
    np.add.at(force, lower, -on_upper)
    np.add.at(moment, upper, np.cross(arm_u, on_upper) + to_upper)
    np.add.at(moment, lower, couple - to_upper - np.cross(arm_l, on_upper))

    if (joint["turn"][model.body["spins"][joint["lower"]] + model.body["spins"][joint["upper"]] > 0] != 0.0).any():
        raise ValueError("this twin knows no rotational stiffness on a wheelset")
    stiff = 2.0 * joint["turn"] * vector
    stiff = turn(lower_axes, scalar[:, None] * stiff + np.cross(vector, stiff))
    np.add.at(moment, joint["upper"], -stiff)
    np.add.at(moment, joint["lower"], stiff)
    return force, moment, rates


class Rails(NamedTuple):
    """The rail under every wheel: leading axis wheel, track axes."""

    place: np.ndarray  # (n, 2) lateral, vertical displacement [m]
    slope: np.ndarray  # (n, 2) [-]
    bend: np.ndarray  # (n, 2) [1/m]
    axes: np.ndarray  # (n, 3, 3) columns: along the rail, right of it, down


def rails(model, s):
    """Displacement of the rail under every wheel, its wheelset at arc lengths s; IndexError where it is not given."""
    param, right = model.param[0], model.wheel["side"] > 0.0
    if not model.shift.size:
        none = np.zeros((s.size, 2))
        return Rails(none, none, none, np.broadcast_to(np.eye(3), (s.size, 3, 3)))
    knots = param["shift_start"] + param["shift_step"] * np.arange(model.shift.shape[0])
    if not ((s >= knots[0]) & (s <= knots[-1])).all():
        raise IndexError("off the displaced rails")
    both = model.shift.reshape(-1, 2, 2, 2)
    spline = CubicHermiteSpline(knots, both[..., 0], both[..., 1])
    place, slope, bend = (
        np.where(right[:, None], values[:, 0], values[:, 1]) for values in (spline(s), spline(s, 1), spline(s, 2))
    )
    yaw = np.arctan(slope[:, 0])
    pitch = -np.arctan(slope[:, 1] * np.cos(yaw))
    return Rails(place, slope, bend, rotation(2, yaw) @ rotation(1, pitch))


def enter(wheel, q, rail):
    """Pose (y about nominal, z, roll, yaw) of the reference point of every wheel, a left wheel's in the mirror.

    In the frame of its rail, whose origin lies under the nominal tape circle and moves with the rail.
    """
    side, b, r = wheel["side"], wheel["lateral"], wheel["radius"]
    of, nothing = wheel["body"], np.zeros(side.size)
    axes = rotation(2, q[of, 5]) @ rotation(0, q[of, 3])
    origin = np.column_stack([nothing, side * b, nothing])
    centre = q[of, :3] * [0.0, 1.0, 1.0] - origin - np.column_stack([nothing, rail.place])
    centre = turn_back(rail.axes, centre) + origin
    axle = turn_back(rail.axes, axes[:, :, 1])
    roll, yaw = np.arcsin(axle[:, 2]), np.arctan2(-axle[:, 0], axle[:, 1])
    axes = rotation(2, side * yaw) @ rotation(0, side * roll)
    bottom = centre * np.column_stack([nothing, side, nothing + 1.0])
    bottom = bottom + b[:, None] * axes[:, :, 1] + r[:, None] * axes[:, :, 2]
    return bottom[:, 1] - b, bottom[:, 2], side * roll, side * yaw


def look_up(model, table_index, y, roll, yaw, depth):
    """Loaded branches of every wheel, flange to field: channels (n, MAX_CONTACT, ...) and which exist (n, MAX_CONTACT).

    Channels as `Node`, with GAP replaced by the penetration and GAP_Y by PART. Raises IndexError off the table.
    """
    table = model.table[table_index]
    count = np.stack([table["y_count"], table["roll_count"], table["yaw2_count"]], axis=1)
    step = np.stack([table["y_step"], table["roll_step"], table["yaw2_step"]], axis=1)
    place = np.stack([y - table["y_start"], roll - table["roll_start"], yaw**2], axis=1) / step
    if not ((place >= 0.0) & (place <= count - 1)).all():
        raise IndexError("off the table")
    low = np.minimum(place.astype(int), count - 2)
    cell = table["cell_base"] + (low[:, 1] * (count[:, 2] - 1) + low[:, 2]) * (count[:, 0] - 1) + low[:, 0]
    first, number = model.cell[cell], model.cell[cell + 1] - model.cell[cell]
    lane = np.arange(number.max())
    exists = lane < number[:, None]
    rows = np.where(exists, table["branch_base"][:, None] + first[:, None] + lane, 0)
    corner = model.branch[rows]
    reached = exists[..., None] & (corner >= 0)
    node = model.node[np.where(reached, table["node_base"][:, None, None] + corner, 0)]
    bits = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)])
    inside = (place - low)[:, None, :] - bits
    weight = np.prod(np.where(bits == 0, 1.0 - (place - low)[:, None], (place - low)[:, None]), axis=2)
    weight = np.where(reached, weight[:, None, :], 0.0)
    total = weight.sum(axis=2)
    usable = total > 1e-9
    mean_of = weight / np.where(usable, total, 1.0)[..., None]
    offset = inside * step[:, None, :]
    value = np.einsum("wbc,wbck->wbk", mean_of, node)
    straight = value[..., Node.LATERAL].copy()
    offset = offset[:, None] + np.einsum("wbc,wck->wbk", mean_of, offset)[:, :, None, :]
    for member in (Node.GAP, Node.SLOPE, Node.LATERAL):
        slopes = node[..., [Node[f"{member.name}_{axis}"] for axis in ("Y", "ROLL", "YAW2")]]
        value[..., member] += 0.5 * np.einsum("wbc,wbck,wbck->wb", mean_of, slopes, offset)
    value[..., Node.RADIUS] += value[..., Node.WHEEL_SLOPE] * (value[..., Node.LATERAL] - 0.5 * straight)
    value[..., PART] = total
    value[..., Node.GAP] = depth[:, None] - value[..., Node.GAP]
    loaded = usable & (value[..., Node.GAP] > 0.0)
    found, slot = np.zeros((y.size, MAX_CONTACT, value.shape[2])), np.cumsum(loaded, axis=1) - 1
    wheel, branch = np.nonzero(loaded)
    found[wheel, slot[wheel, branch]] = value[wheel, branch]
    return found, np.arange(MAX_CONTACT) < loaded.sum(axis=1)[:, None]


def elastic(sample, loaded, cosine):
    """Elastic force over Hertz factor (d^1.5, d = penetration along the normal): overlaps merged, ends faded out."""
    depth = sample[..., Node.GAP]
    alone = np.maximum(depth * cosine, 0.0) ** 1.5
    merged = alone.copy()
    for mine, theirs, shift in (
        (Node.BARRIER_GAUGE, Node.BARRIER_FIELD, 1), (Node.BARRIER_FIELD, Node.BARRIER_GAUGE, -1),
    ):  # fmt: skip
        near, far, rest = sample[..., mine], np.zeros(loaded.shape), np.ones(loaded.shape)
        for away in range(1, loaded.shape[1]):
            there = np.roll(loaded, shift * away, axis=1)
            there[:, slice(None, away) if shift > 0 else slice(-away, None)] = False
            part = np.where(there, np.roll(sample[..., PART], shift * away, axis=1), 0.0)
            far += rest * part * np.roll(sample[..., theirs], shift * away, axis=1)
            rest *= 1.0 - part
        neighbour = np.roll(loaded, shift, axis=1)
        neighbour[:, 0 if shift > 0 else -1] = False
        both = np.where(neighbour, np.maximum((depth - near) * cosine, 0.0), 0.0)
        merged -= far / np.maximum(near + far, 1e-12) * both**1.5
    return np.where(loaded, sample[..., PART] * np.maximum(merged, 0.0), 0.0)


def creep(param, coefficient, limit, creepage):
    """Creep forces and spin moment (..., 3) on the wheel from coefficients f11, f22, f23, f33 (..., 4)."""
    f11, f22, f23, f33 = np.moveaxis(coefficient, -1, 0)
    xi, eta, phi = np.moveaxis(creepage, -1, 0)
    linear = -np.stack([f11 * xi, f22 * eta + f23 * phi, f33 * phi - f23 * eta], axis=-1)
    size = np.hypot(linear[..., 0], linear[..., 1])
    acts = (limit > 0.0) & (size > 0.0)
    ratio = np.where(acts, size / np.where(acts, limit, 1.0), 1.0)
    if param["creep_law"] == Creep.SMOOTH:
        allowed = np.where(ratio < 3.0, 1.0 - (1.0 - ratio / 3.0) ** 3, 1.0)
    else:
        allowed = np.minimum(ratio, 1.0)
    return np.where(limit > 0.0, np.where(size > 0.0, allowed / ratio, 1.0), 0.0)[..., None] * linear


def contact(model, bodies, q, v):
    """Patches of all wheels."""
    param, wheel = model.param[0], model.wheel
    of = wheel["body"]
    rail = rails(model, q[of, 0])
    y, z, roll, yaw = enter(wheel, q, rail)
    sample, loaded = look_up(model, wheel["table"], y, roll, yaw, z)
    slope = wheel["side"][:, None] * sample[..., Node.SLOPE]
    normal = np.stack([np.zeros_like(slope), -slope, np.ones_like(slope)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    cosine = normal[..., 2]
    normal = turn(rail.axes[:, None], normal)
    axle = bodies.pose[of][:, None, :, 1]
    radial = normal - np.sum(normal * axle, axis=-1, keepdims=True) * axle
    sine = np.linalg.norm(radial, axis=-1, keepdims=True)
    radial /= sine
    out = wheel["side"][:, None] * (wheel["lateral"][:, None] + sample[..., Node.LATERAL])
    arm = out[..., None] * axle + sample[..., Node.RADIUS][..., None] * radial
    ahead, down = rail.axes[:, None, :, 0], sample[..., Node.RADIUS] / sine[..., 0]
    bend = np.einsum("wbi,wi->wb", normal[..., 1:], rail.bend)
    place = arm[..., 0] / (1.0 + bend * down * ahead[..., 0])
    arm = arm - (down * bend * place)[..., None] * ahead

    rate = bodies.rate[of]
    first = rotation(2, q[of, 5])
    unspun = first[:, :, 0] * rate[:, 3:4] + first[:, :, 2] * rate[:, 5:6]
    bent = np.zeros_like(arm)
    bent[..., 1:] = arm[..., :1] * rail.bend[:, None]
    moving = rate[:, None, :3] * [0.0, 1.0, 1.0] + np.cross(unspun[:, None], arm)
    moving[..., 1:] -= rate[:, None, :1] * (rail.slope[:, None] + bent[..., 1:])
    approach = np.sum(normal * moving, axis=-1)
    spring = elastic(sample, loaded, cosine)
    rise = np.sign(approach) * np.abs(approach) ** param["damping_rate_power"]
    damped = spring ** (param["damping_depth_power"] / 1.5) * rise
    force_n = np.where(loaded, np.maximum(sample[..., Node.HERTZ] * (spring + param["damping"] * damped), 0.0), 0.0)

    velocity, omega = v[of][:, None, :3], turn(bodies.pose[of], v[of, 3:])[:, None]
    way = np.where(v[of, 0] >= 0.0, 1.0, -1.0)[:, None, None]
    point = arm + q[of][:, None, :3] * [0.0, 1.0, 1.0]
    moved = bodies.advance[of][:, None] + np.cross(bodies.turning[of][:, None], point)
    along = way * (ahead + moved * [0.0, 1.0, 1.0] + bent)
    normal = normal - np.sum(normal * bent, axis=-1, keepdims=True) * ahead
    across = np.cross(normal, along)
    surface = velocity + np.cross(omega, arm)
    speed = np.maximum(np.linalg.norm(v[of, :3], axis=1), param["creep_speed"])[:, None]
    creepage = np.stack([np.sum(axis * motion, axis=-1) / speed for axis, motion in
                         ((along, surface), (across, surface), (normal, omega))], axis=-1)  # fmt: skip
    grown = spring[..., None] ** POWERS * sample[..., SCALED]
    tangential = creep(param, grown, wheel["friction"][:, None] * force_n, creepage)
    tx, tt, mz = np.moveaxis(tangential, -1, 0)[..., None]
    force = tx * along + tt * across - force_n[..., None] * normal
    moment = np.cross(arm, force) + mz * normal
    rise = bodies.advance[of][:, None] * [0.0, 1.0, 1.0]
    lean = force_n[..., None] * np.sum(normal * rise, axis=-1, keepdims=True) * [1.0, 0.0, 0.0]
    force, moment = force + lean, moment + np.cross(arm * [0.0, 1.0, 0.0], lean)
    there = loaded[..., None]
    return Patches(
        normal=force_n, creep=np.where(there, tangential, 0.0), creepage=np.where(there, creepage, 0.0),
        depth=np.where(loaded, sample[..., Node.GAP], 0.0), lateral=sample[..., Node.LATERAL],
        force=np.where(there, force, 0.0), moment=np.where(there, moment, 0.0),
    )  # fmt: skip


def evaluate(model, q, v, damper, half_step=0.0):
    """Loads and accelerations of the whole model at q and v.

    Parameters
    ----------
    model : Model
    q, v : array (n_body, 6)
    damper : array (n_state,)
        Lengths of the dampers with series stiffness [m].
    half_step : float
        Time over which these move implicitly [s].

    Returns
    -------
    Loads
    """
    param, body = model.param[0], model.body
    bodies = kinematics(model, q, v)
    force, moment, damper_rate = suspension(model, bodies, damper, half_step)
    force[:, 2] += body["mass"] * param["gravity"]
    carried = np.cross(bodies.rate[:, :1] * bodies.turning, v[:, :3])
    frame_rate = turn_back(bodies.axes, bodies.omega_frame)
    turning = np.cross(frame_rate, body["inertia"] * v[:, 3:])
    pushed = turn_back(bodies.track, force) - body["mass"][:, None] * carried
    load = np.concatenate([pushed, turn_back(bodies.axes, moment) - turning], axis=1)
    patches = contact(model, bodies, q, v)
    of = model.wheel["body"]
    np.add.at(load[:, :3], of, patches.force.sum(axis=1))
    np.add.at(load[:, 3:], of, turn_back(bodies.pose[of], patches.moment.sum(axis=1)))
    load[0, 0] += param["hold"] * (param["speed"] - bodies.rate[0, 0])
    mass = np.column_stack([np.repeat(body["mass"][:, None], 3, axis=1), body["inertia"]])
    return Loads(load, load / mass, damper_rate, bodies, patches)
