"""Sensors of the axles and the controllers that read them (docs/subsystems.md, 3, 5 and 6)."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from railcli.kernels.assembly_layout import Reference, Sensor

from .checks import Description, NotNegative, Positive, Real, one_of
from .driving import Share

SENSORS = {"ideal": Sensor.IDEAL, "counting": Sensor.COUNTING, "timing": Sensor.TIMING}
REFERENCES = {"true": Reference.TRUE, "axles": Reference.AXLES}


class SlideProtection(Description):
    """Wheel slide protection by limits of slide and acceleration."""

    kind: Literal["threshold"] = "threshold"
    reference: one_of(REFERENCES) = "axles"  # the vehicle's true speed is there to compare with: no rig has it
    active_above: Annotated[NotNegative, Field(le=50.0)] = Field(1.4, alias="active_above_m_per_s")
    slide_vent: Share = 0.20
    slide_hold: Share = 0.10
    slide_watch: Share = 0.03
    fall: Annotated[Real, Field(ge=-1000.0, lt=0.0)] = Field(-3.0, alias="fall_m_per_s2")
    regain: Annotated[Real, Field(gt=0.0, le=1000.0)] = Field(1.0, alias="regain_m_per_s2")
    reference_fall: Annotated[Positive, Field(le=10.0)] = Field(1.3, alias="reference_fall_m_per_s2")
    pilot_every: Annotated[Positive, Field(le=60.0)] = Field(2.0, alias="pilot_every_s")

    @model_validator(mode="after")
    def _in_order(self):
        if not self.slide_watch <= self.slide_hold <= self.slide_vent:
            raise ValueError(
                "slide_watch, slide_hold, slide_vent must not fall in this order, got "
                f"{self.slide_watch:g}, {self.slide_hold:g}, {self.slide_vent:g}"
            )
        return self


class SpeedSensor(Description):
    """How and when the speeds of the axles are read; every controller acts at that time."""

    kind: one_of(SENSORS) = "ideal"
    period: Annotated[Positive, Field(ge=1e-4, le=1.0)] = Field(0.010, alias="period_s")
    teeth: Annotated[int, Field(ge=1, le=10000)] = 100  # of the phonic wheel
    clock: Annotated[NotNegative, Field(le=1e-2)] = Field(0.0, alias="clock_s")  # resolution of the time of an edge
    radius_error: Annotated[tuple[Annotated[Real, Field(ge=-0.1, le=0.1)], ...], Field(min_length=1)] = (0.0,)
    noise: Annotated[NotNegative, Field(le=10.0)] = Field(0.0, alias="noise_m_per_s")  # standard deviation
    seed: Annotated[int, Field(ge=0, le=2**31)] = 0


class AntiSlip(Description):
    """Cuts the traction torque of axles that spin."""

    kind: Literal["threshold"] = "threshold"
    slip: Annotated[Positive, Field(le=50.0)] = Field(0.5, alias="slip_m_per_s")  # over the slowest axle
    spin: Annotated[Positive, Field(le=1000.0)] = Field(1.5, alias="acceleration_m_per_s2")
    cut: Annotated[Real, Field(ge=0.0, lt=1.0)] = 0.8  # what stays of the torque at each sample
    regrip: Annotated[Positive, Field(le=100.0)] = Field(0.3, alias="regrip_1_per_s")


class AxleOdometry(Description):
    """Fastest axle in braking, slowest in traction, within limits of the rate."""

    kind: Literal["axles"] = "axles"
    fall: Annotated[Positive, Field(le=10.0)] = Field(1.5, alias="fall_m_per_s2")
    rise: Annotated[Positive, Field(le=10.0)] = Field(1.0, alias="rise_m_per_s2")


class KalmanOdometry(Description):
    """An accelerometer along the first body, corrected by the axles that agree with it."""

    kind: Literal["kalman"] = "kalman"
    bias: Annotated[Real, Field(ge=-1.0, le=1.0)] = Field(0.0, alias="bias_m_per_s2")  # of the accelerometer
    acceleration_noise: Annotated[Positive, Field(le=10.0)] = Field(0.05, alias="acceleration_noise_m_per_s2")
    speed_noise: Annotated[Positive, Field(le=10.0)] = Field(0.05, alias="speed_noise_m_per_s")


Odometer = Annotated[AxleOdometry | KalmanOdometry, Field(discriminator="kind")]
