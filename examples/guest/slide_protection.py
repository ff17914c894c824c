"""A slide protection in thirty lines: limits of slide and acceleration, reference speed from the fastest axle.

    railcli run scenario my-brake.toml --guest slide_protection.py

`control` is called every PERIOD_MS with

- time: of the sample [s];
- axles[a]: what sensors give of axle a, from the front: speed of its tread [m/s], pressure of its cylinder over the
  full one, demands of brake and traction (0 to 1);
- state: 256 numbers that it keeps, all 0 at the beginning;
- out[a]: valve (0 fill, 1 hold, 2 vent) and share of the traction torque (0 to 1) as they were, to be changed.

It is compiled: numbers, loops, `math`; nothing that allocates.
"""

PERIOD_MS = 10.0
FILL, HOLD, VENT = 0.0, 1.0, 2.0
FALL = 1.3  # fastest fall of the reference speed [m/s^2]
SAMPLES = 6  # speeds kept of each axle; state[0]: reference speed, state[1]: samples so far, then the speeds


def control(time, axles, state, out):
    period = 1e-3 * PERIOD_MS
    reference = state[0] - FALL * period if state[1] > 0.0 else 0.0
    for a in range(axles.shape[0]):
        reference = max(reference, axles[a, 0])
    count = int(state[1])
    for a in range(axles.shape[0]):
        first, speed = 2 + SAMPLES * a, axles[a, 0]
        before = state[first + (count + 1) % SAMPLES]
        acceleration = (speed - before) / ((SAMPLES - 1) * period) if count >= SAMPLES else 0.0
        state[first + count % SAMPLES] = speed
        out[a, 0] = FILL
        if reference > 1.4:
            slide = (reference - speed) / reference
            if slide > 0.20 or (acceleration < -3.0 and slide > 0.03):
                out[a, 0] = HOLD if acceleration >= 1.0 else VENT
            elif slide > 0.10:
                out[a, 0] = HOLD
    state[0], state[1] = reference, count + 1.0
