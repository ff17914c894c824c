"""Rigid bodies in moving track frames (theory.md section 3).

Coordinates q: arc length s, lateral y, vertical z of the centre; roll, pitch, yaw as finite rotations in the order
yaw (about z), roll (about the new x), pitch (about the newest y). A wheelset's pitch is its spin and its frame takes
no part in it. Velocities v: of the centre in track axes, angular velocity in the axes of the body's frame.
"""

from math import isfinite

from .jit import kernel
from .layout import Status
from .track import find_piece, place, turning
from .trig import sine_cosine
from .vec3 import accumulate, cross, get, inward, outward, put, scale


@kernel
def own_axes(sine, cosine):
    """Rows of the matrix whose columns are the body's axes in track axes: Rz(yaw) Rx(roll) Ry(pitch).

    sine, cosine : of roll, pitch and yaw; a wheelset's frame takes pitch as 0.
    """
    sr, sp, sy = sine
    cr, cp, cy = cosine
    return (
        (cy * cp - sy * sr * sp, -sy * cr, cy * sp + sy * sr * cp),
        (sy * cp + cy * sr * sp, cy * cr, sy * sp - cy * sr * cp),
        (-cr * sp, sr, cr * cp),
    )


@kernel
def sines(roll, pitch, yaw, spins):
    """Sines and cosines of roll, pitch and yaw, with a wheelset's pitch as 0."""
    sr, cr = sine_cosine(roll)
    sp, cp = sine_cosine(0.0 if spins else pitch)
    sy, cy = sine_cosine(yaw)
    return (sr, sp, sy), (cr, cp, cy)


@kernel
def rates(y, z, v, k, advance, sine, cosine):
    """dq/dt of one body.

    y, z : its place in the track frame [m].  v : its six velocities.  k, advance : rotation of the track frame and
    motion of its origin per metre, in track axes [1/m, -].  sine, cosine : as `sines`.
    Returns ds/dt, dy/dt, dz/dt [m/s], droll/dt, dpitch/dt, dyaw/dt [rad/s].
    """
    speed = v[0] / (advance[0] + k[1] * z - k[2] * y)
    sr, sp, sy = sine
    cr, cp, cy = cosine
    wx, wz = cp * v[3] + sp * v[5], cp * v[5] - sp * v[3]
    kx, ky = cy * k[0] + sy * k[1], cy * k[1] - sy * k[0]
    yaw = (wz - speed * (cr * k[2] - sr * ky)) / cr
    return (
        speed,
        v[1] + speed * (k[0] * z - advance[1]),
        v[2] - speed * (k[0] * y + advance[2]),
        wx - speed * kx,
        v[4] - speed * (cr * ky + sr * k[2]) - yaw * sr,
        yaw,
    )


@kernel
def put_rates(data, i, k, advance, sine, cosine):
    """Write dq/dt of body i."""
    q, v = data.q, data.v
    r = rates(q[i, 1], q[i, 2], (v[i, 0], v[i, 1], v[i, 2], v[i, 3], v[i, 4], v[i, 5]), k, advance, sine, cosine)
    for a in range(6):
        data.rate[i, a] = r[a]


@kernel
def drift(model, data):
    """Fill data.rate = dq/dt from q and v. Returns a status."""
    q, base = data.q, model.param[0]["cant_base"]
    for i in range(model.body.size):
        piece = find_piece(model.track, q[i, 0])
        if piece < 0:
            data.fault[0] = i
            return off_track(q[i, 0])
        k, advance, _ = turning(model.track, piece, q[i, 0], base)
        sine, cosine = sines(q[i, 3], q[i, 4], q[i, 5], model.body[i]["spins"])
        put_rates(data, i, k, advance, sine, cosine)
    return 0


@kernel
def drift_on(model, data):
    """As `drift`, where data.frame still holds for q."""
    for i in range(model.body.size):
        frame = data.frame[i]
        put_rates(data, i, get(frame["rate"]), get(frame["advance"]), get(frame["sine"]), get(frame["cosine"]))


@kernel
def off_track(s):
    """Status of a body whose arc length s lies on no piece of the track."""
    return Status.LEFT_TRACK.value if isfinite(s) else Status.NOT_FINITE.value


@kernel
def frames(model, data):
    """Fill data.frame (pose and motion of every body, forces zero) and data.rate. Returns a status."""
    qs, vs, base = data.q, data.v, model.param[0]["cant_base"]
    for i in range(model.body.size):
        frame = data.frame[i]
        piece = find_piece(model.track, qs[i, 0])
        if piece < 0:
            data.fault[0] = i
            return off_track(qs[i, 0])
        place(model.track, piece, qs[i, 0], base, frame)
        spins = model.body[i]["spins"]
        track, axes = frame["track"], frame["axes"]
        accumulate(frame["position"], outward(track, (0.0, qs[i, 1], qs[i, 2])))
        sine, cosine = sines(qs[i, 3], qs[i, 4], qs[i, 5], spins)
        put(frame["sine"], sine)
        put(frame["cosine"], cosine)
        r0, r1, r2 = own_axes(sine, cosine)
        for k in range(3):
            t0, t1, t2 = track[k, 0], track[k, 1], track[k, 2]
            axes[k, 0] = t0 * r0[0] + t1 * r1[0] + t2 * r2[0]
            axes[k, 1] = t0 * r0[1] + t1 * r1[1] + t2 * r2[1]
            axes[k, 2] = t0 * r0[2] + t1 * r1[2] + t2 * r2[2]
        put_rates(data, i, get(frame["rate"]), get(frame["advance"]), sine, cosine)
        omega = outward(axes, (vs[i, 3], vs[i, 4], vs[i, 5]))
        put(frame["velocity"], outward(track, (vs[i, 0], vs[i, 1], vs[i, 2])))
        put(frame["omega"], omega)
        if spins:
            omega = outward(axes, (vs[i, 3], vs[i, 4] - data.rate[i, 4], vs[i, 5]))
        put(frame["omega_frame"], omega)
        put(frame["force"], (0.0, 0.0, 0.0))
        put(frame["moment"], (0.0, 0.0, 0.0))
    return 0


@kernel
def inertia_loads(model, data):
    """Fill data.load with weight, suspension and the terms of the moving axes: M dv/dt but for the wheels and rails.

    Newton in track axes: m (dv/dt + ds/dt k x v) = F.  Euler in the frame's axes: I domega/dt + omega_frame x I omega
    = M; for a wheelset omega_frame lacks the spin, so that the gyroscopic moment stays in.
    """
    gravity = model.param[0]["gravity"]
    vs, load = data.v, data.load
    for i in range(model.body.size):
        frame, body = data.frame[i], model.body[i]
        mass, inertia = body["mass"], get(body["inertia"])
        v, w = (vs[i, 0], vs[i, 1], vs[i, 2]), (vs[i, 3], vs[i, 4], vs[i, 5])
        carried = cross(scale(data.rate[i, 0], get(frame["rate"])), v)
        spin = data.rate[i, 4] if body["spins"] else 0.0
        turn = cross((w[0], w[1] - spin, w[2]), (inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]))
        force = get(frame["force"])
        force = inward(frame["track"], (force[0], force[1], force[2] + mass * gravity))
        moment = inward(frame["axes"], get(frame["moment"]))
        for a in range(3):
            load[i, a] = force[a] - mass * carried[a]
            load[i, 3 + a] = moment[a] - turn[a]
