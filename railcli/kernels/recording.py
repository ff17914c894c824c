"""What is gathered at every step: means and extremes of each interval of rows, and a low-passed stream of its own rate.

A row of results comes at the interval that the user asks for, so an instant of a force in it says little: what happens
between two rows is folded. Forces and accelerations of every step are therefore averaged over the interval, their
extremes kept beside the mean. What an assessment needs goes through a symmetric low-pass to a fixed rate besides, so
that no figure depends on the interval (docs/theory.md, 8.5). Coordinates and velocities are integrals of what is
low-passed and are taken as instants; wear numbers are summed.

Steps are gathered in batches of BATCH, because then the sums stay in registers.
"""

from enum import IntEnum
from math import isnan
from typing import NamedTuple

import numpy as np
from numba import types

from .assembly_layout import PORT, TRAIN
from .jit import kernel, mutable
from .layout import CONTACT, MAX_CONTACT, RAIL, Region
from .vec3 import cross, get, scale

BATCH = 4
PARTS = len(Region)  # of a wheel profile, for which T-gamma is summed
NONE = np.float32(0.0)


class Averaged(NamedTuple):
    """Where the channels stand that rows hold means and extremes of: slices; wheels in turn, or bodies with x, y, z."""

    y: slice  # force on the rail, to the right [N]
    q: slice  # down [N]
    x: slice  # forward [N]
    traction: slice  # force that holds the speed [N]
    acceleration: slice  # as Rows.acceleration [m/s^2]


class Instants(NamedTuple):
    """Where stands what the stream holds of a step, or of the steps since its row before: slices of Stream.still."""

    lateral: slice  # (n_body,) as Data.q [m]
    rotation: slice  # (n_body, 3) roll, pitch, yaw as Data.q [rad]
    omega: slice  # (n_body, 3) angular velocity about the own axes [rad/s]
    t_gamma: slice  # (n_wheel, PARTS) wear number of each part of the wheel profile, mean since the row before [N]


def _slices(kind, *sizes):
    ends = np.cumsum(sizes).tolist()
    return kind(*(slice(end - size, end) for end, size in zip(ends, sizes, strict=True)))


def averaged(n_wheel, n_body):
    """Averaged of so many wheels and bodies. Behind them the stream has the angular accelerations of sprung bodies."""
    return _slices(Averaged, n_wheel, n_wheel, n_wheel, 1, 3 * n_body)


def instants(n_wheel, n_body):
    """Instants of so many wheels and bodies."""
    return _slices(Instants, n_body, 3 * n_body, 3 * n_body, PARTS * n_wheel)


class Count(IntEnum):
    """Counters of a stream."""

    STEP = 0  # steps filtered; the first one of a run is 1, those before it equal it
    DONE = 1  # finished rows
    END = 2  # step with which the next row is finished
    WAIT = 3  # steps that are missing to the next instants
    STILL = 4  # row of these


class Stream(NamedTuple):
    """The low-passed stream: its filter, the last steps, and rows; those behind the finished ones are growing."""

    taps: np.ndarray  # (n,) symmetric coefficients between BATCH zeros at both ends; none: no stream is formed
    stride: np.ndarray  # (1,) steps between two of its rows
    count: np.ndarray  # (5,) Count
    now: np.ndarray  # (BATCH, n_channel) the last steps: `averaged`, angular accelerations of sprung bodies [rad/s^2]
    single: np.ndarray  # (BATCH, n_channel) the same in single precision
    past: np.ndarray  # (2, 2 n_wheel) Y and Q of the last step, and by how much they moved in it [N]
    filtered: np.ndarray  # (n, n_channel) rows: low-passed
    place: np.ndarray  # (n, n_body) s of every body at the step in its middle [m]
    still: np.ndarray  # (n, n_still) as `instants`, of the same step


class Rows(NamedTuple):
    """A block of recorded instants; the last five tell of every step between two of them."""

    time: np.ndarray  # (n,) [s]
    q: np.ndarray  # (n, n_body, 6) as Data
    v: np.ndarray  # (n, n_body, 6) as Data
    acceleration: np.ndarray  # (n, n_body, 3) what an accelerometer feels, track axes, z plus g [m/s^2]
    rail: np.ndarray  # (n, n_wheel) RAIL
    contact: np.ndarray  # (n, n_wheel, MAX_CONTACT) CONTACT
    traction: np.ndarray  # (n,) force that holds the speed [N]
    port: np.ndarray  # (n, n_axle) PORT
    train: np.ndarray  # (n,) TRAIN
    mean: np.ndarray  # (n, n_mean) over all steps since the row before; channels as recording.averaged
    least: np.ndarray  # (n, n_mean) of these steps
    greatest: np.ndarray  # (n, n_mean)
    turn: np.ndarray  # (n, 2 n_wheel) mean of d_k d_(k-1), d_k what Y or Q moved by in step k [N^2]
    move: np.ndarray  # (n, 2 n_wheel) mean of d_k^2 [N^2]


STEP, DONE, END, WAIT, STILL = (count.value for count in Count)
STREAM_TYPE = types.NamedTuple(
    (
        mutable(np.float32),
        mutable(np.int64),
        mutable(np.int64),
        mutable(np.float64, 2),
        mutable(np.float32, 2),
        mutable(np.float64, 2),
        mutable(np.float32, 2),
        mutable(np.float64, 2),
        mutable(np.float32, 2),
    ),
    Stream,
)


ROWS_TYPE = types.NamedTuple(
    (
        mutable(np.float64),
        *3 * [mutable(np.float64, 3)],
        mutable(RAIL, 2),
        mutable(CONTACT, 3),
        mutable(np.float64),
        mutable(PORT, 2),
        mutable(TRAIN),
        *5 * [mutable(np.float64, 2)],
    ),
    Rows,
)


def new_rows(model, n):
    """Room for n recorded instants."""
    n_body, n_wheel = model.body.size, model.wheel.size
    n_mean = 3 * n_wheel + 1 + 3 * n_body
    return Rows(
        time=np.zeros(n),
        q=np.zeros((n, n_body, 6)),
        v=np.zeros((n, n_body, 6)),
        acceleration=np.zeros((n, n_body, 3)),
        rail=np.zeros((n, n_wheel), RAIL),
        contact=np.zeros((n, n_wheel, MAX_CONTACT), CONTACT),
        traction=np.zeros(n),
        port=np.zeros((n, model.axle.size), PORT),
        train=np.zeros(n, TRAIN),
        mean=np.zeros((n, n_mean)),
        least=np.zeros((n, n_mean)),
        greatest=np.zeros((n, n_mean)),
        turn=np.zeros((n, 2 * n_wheel)),
        move=np.zeros((n, 2 * n_wheel)),
    )


def new_stream(model, taps=(), stride=1, steps=0):
    """A stream before the first step.

    Parameters
    ----------
    model : Model
    taps : sequence of float
        An odd number of symmetric coefficients whose sum is 1; none: no stream is formed.
    stride : int
        Steps between two of its rows.
    steps : int
        Most that are taken before `forget_done` makes room.
    """
    half = len(taps) // 2
    n_wheel, n_body = model.wheel.size, model.body.size
    n_sprung = n_body - int(np.sum(model.body["spins"]))
    n_channel = averaged(n_wheel, n_body)[-1].stop + 3 * n_sprung
    n = (steps + 2 * half + BATCH) // stride + 2
    zeros = [0.0] * BATCH if len(taps) else []
    return Stream(
        taps=np.array([*zeros, *taps, *zeros], np.float32),
        stride=np.array([stride], np.int64),
        count=np.array([min(0, stride - half - 1), 0, stride + half, stride, 0], np.int64),
        now=np.zeros((BATCH, n_channel)),
        single=np.zeros((BATCH, n_channel), np.float32),
        past=np.array([[np.nan], [0.0]]) * np.ones(2 * n_wheel),
        filtered=np.zeros((n, n_channel), np.float32),
        place=np.zeros((n, n_body)),
        still=np.zeros((n, instants(n_wheel, n_body)[-1].stop), np.float32),
    )


def forget_done(stream):
    """Drop the finished rows; those that are growing move to their place."""
    done = int(stream.count[DONE])
    for rows in (stream.filtered, stream.place, stream.still):
        rows[: len(rows) - done] = rows[done:].copy()
        rows[len(rows) - done :] = 0.0
    stream.count[[DONE, STILL]] -= done


@kernel
def felt(model, data, i):
    """Acceleration that an accelerometer at the centre of body i shows, gravity taken from z; track axes [m/s^2]."""
    gravity = model.param[0]["gravity"]
    frame, speed = data.frame[i], data.rate[i, 0]
    carried = cross(scale(speed, get(frame["rate"])), (data.v[i, 0], data.v[i, 1], data.v[i, 2]))
    return (
        data.dv[i, 0] + carried[0] - gravity * frame["track"][2, 0],
        data.dv[i, 1] + carried[1] - gravity * frame["track"][2, 1],
        data.dv[i, 2] + carried[2] - gravity * frame["track"][2, 2] + gravity,
    )


@kernel
def take(model, data, stream, b):
    """Take the step that was just made as the one of number b in a batch."""
    now, n_wheel = stream.now, model.wheel.size
    at = 3 * n_wheel + 1
    turning = at + 3 * model.body.size
    now[b, 3 * n_wheel] = data.traction[0]
    for w in range(n_wheel):
        rail = data.rail[w]
        now[b, w], now[b, n_wheel + w], now[b, 2 * n_wheel + w] = rail["y"], rail["q"], rail["x"]
    for i in range(model.body.size):
        now[b, at], now[b, at + 1], now[b, at + 2] = felt(model, data, i)
        at += 3
        if not model.body[i]["spins"]:
            now[b, turning], now[b, turning + 1], now[b, turning + 2] = data.dv[i, 3], data.dv[i, 4], data.dv[i, 5]
            turning += 3
    if stream.taps.size > 0:
        take_instants(model, data, stream)


@kernel
def take_instants(model, data, stream):
    """Sum the wear numbers for the row that comes; at the step in its middle keep where the bodies are."""
    still, row, n_body = stream.still, stream.count[STILL], model.body.size
    share = 1.0 / stream.stride[0]
    for w in range(model.wheel.size):
        tread, root, flank, tip = 0.0, 0.0, 0.0, 0.0
        for j in range(min(int(data.rail[w]["patches"]), MAX_CONTACT)):
            patch = data.contact[w, j]
            region = patch["region"]  # between the nodes of a table it is mixed
            number = share * (abs(patch["creep_x"] * patch["xi"]) + abs(patch["creep_t"] * patch["eta"]))
            tread += number if region < 0.5 else 0.0
            root += number if 0.5 <= region < 1.5 else 0.0
            flank += number if 1.5 <= region < 2.5 else 0.0
            tip += number if region >= 2.5 else 0.0
        at = 7 * n_body + PARTS * w
        still[row, at] += np.float32(tread)
        still[row, at + 1] += np.float32(root)
        still[row, at + 2] += np.float32(flank)
        still[row, at + 3] += np.float32(tip)
    stream.count[WAIT] -= 1
    if stream.count[WAIT] == 0:
        stream.count[WAIT] = stream.stride[0]
        stream.count[STILL] += 1
        for i in range(n_body):
            stream.place[row, i], still[row, i] = data.q[i, 0], data.q[i, 1]
            rotation, omega = n_body + 3 * i, 4 * n_body + 3 * i
            for c in range(3):
                still[row, rotation + c], still[row, omega + c] = data.q[i, 3 + c], data.v[i, 3 + c]


@kernel
def open_row(rows, n):
    """Begin the interval that ends in row n."""
    for c in range(rows.mean.shape[1]):
        rows.mean[n, c], rows.least[n, c], rows.greatest[n, c] = 0.0, np.inf, -np.inf
    for c in range(rows.turn.shape[1]):
        rows.turn[n, c], rows.move[n, c] = 0.0, 0.0


@kernel
def note(rows, n, stream, count, share):
    """Take the first `count` steps of a batch into row n, each with its share of the interval, and into the stream."""
    now, past = stream.now, stream.past
    for b in range(count, BATCH):
        for c in range(now.shape[1]):
            now[b, c] = now[count - 1, c]
    last0, last1, last2, last3 = 1.0 * (count == 1), 1.0 * (count == 2), 1.0 * (count == 3), 1.0 * (count == 4)
    for c in range(past.shape[1]):
        d0, before = now[0, c] - past[0, c], past[1, c]
        if isnan(d0):  # nothing is before the first step
            d0 = 0.0
        d1, d2, d3 = now[1, c] - now[0, c], now[2, c] - now[1, c], now[3, c] - now[2, c]
        rows.turn[n, c] += share * (d0 * before + d1 * d0 + d2 * d1 + d3 * d2)
        rows.move[n, c] += share * (d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
        past[0, c], past[1, c] = now[3, c], last0 * d0 + last1 * d1 + last2 * d2 + last3 * d3
    w1, w2, w3 = share * (count > 1), share * (count > 2), share * (count > 3)
    for c in range(rows.mean.shape[1]):
        x0, x1, x2, x3 = now[0, c], now[1, c], now[2, c], now[3, c]
        rows.mean[n, c] += share * x0 + w1 * x1 + w2 * x2 + w3 * x3
        rows.least[n, c] = min(rows.least[n, c], min(min(x0, x1), min(x2, x3)))
        rows.greatest[n, c] = max(rows.greatest[n, c], max(max(x0, x1), max(x2, x3)))
    if stream.taps.size > 0:
        for b in range(BATCH):
            for c in range(stream.single.shape[1]):
                stream.single[b, c] = now[b, c]
        while stream.count[STEP] < 0:  # what was before the first step equals it
            feed(stream, 1)
        feed(stream, count)


@kernel
def feed(stream, count):
    """Add the first `count` steps at hand to all rows in which they have part; finish rows that wait for no other.

    Row k = 1, 2, ... is the sum of taps[middle + l] x[k stride + l] over all l, so that nothing is delayed.
    """
    taps, x, rows, state = stream.taps, stream.single, stream.filtered, stream.count
    stride, width = stream.stride[0], taps.size - 1 - 2 * BATCH
    i, end = state[STEP] + 1, state[STEP] + count
    row, last = state[DONE], state[END]
    while last - width <= end:
        at = taps.size - 1 - BATCH + i - last
        t0 = taps[at]
        t1 = taps[at + 1] if count > 1 else NONE
        t2 = taps[at + 2] if count > 2 else NONE
        t3 = taps[at + 3] if count > 3 else NONE
        for c in range(rows.shape[1]):
            rows[row, c] += t0 * x[0, c] + t1 * x[1, c] + t2 * x[2, c] + t3 * x[3, c]
        row, last = row + 1, last + stride
    state[STEP] = end
    while state[END] <= end:
        state[DONE] += 1
        state[END] += stride


@kernel
def flush(stream):
    """Complete the rows to which steps are missing that will not come: they equal the last one."""
    if stream.taps.size > 0 and stream.count[STEP] > 0:
        stop = stream.count[STEP] // stream.stride[0] * stream.stride[0] + stream.taps.size // 2 - BATCH
        for c in range(stream.single.shape[1]):
            stream.single[0, c] = stream.single[BATCH - 1, c]
        while stream.count[STEP] < stop:
            feed(stream, 1)
