"""Who drives and what brakes: driver, brake, traction (docs/subsystems.md, 1 to 3)."""

from itertools import pairwise
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from railcli.kernels.assembly_layout import PLAN, Rise
from railcli.kernels.layout import CURVE_KNOTS

from .checks import Description, Name, NotNegative, Positive, Real, one_of

Share = Annotated[Real, Field(ge=0.0, le=1.0)]
Knots = Field(min_length=2, max_length=CURVE_KNOTS - 1)
Speeds = Annotated[tuple[Annotated[Real, Field(ge=0.0, le=200.0)], ...], Knots]
Torque = Annotated[Real, Field(ge=0.0, le=1e6)]
Time = Annotated[NotNegative, Field(le=600.0)]
RISES = {"linear": Rise.LINEAR, "exponential": Rise.EXPONENTIAL, "stepped": Rise.STEPPED}
CAST_IRON_MEAN = 0.12  # friction of cast iron at speed that a driver counts with [-]


def increasing(key, values, start=None):
    if any(later <= earlier for earlier, later in pairwise(values)):
        raise ValueError(f"{key} must increase from each value to the next")
    if start is not None and values[0] != start:
        raise ValueError(f"{key} must begin with {start:g}")


class HoldSpeed(Description):
    """The speed is given: a force on the first body holds it."""

    kind: Literal["hold"] = "hold"


class Coast(Description):
    """Nobody brakes or drives; speed is a result."""

    kind: Literal["coast"] = "coast"

    def curves(self):
        return None, None


class Demand(Description):
    """Demands over time, straight between their knots and constant after the last; speed is a result."""

    kind: Literal["demand"] = "demand"
    time: Annotated[tuple[NotNegative, ...], Knots] = Field(alias="time_s")
    brake: Annotated[tuple[Share, ...], Knots] | None = None
    traction: Annotated[tuple[Share, ...], Knots] | None = None

    @model_validator(mode="after")
    def _is_a_course(self):
        if any(later < earlier for earlier, later in pairwise(self.time)) or self.time[0] != 0.0:
            raise ValueError("time_s must begin with 0 and not fall from any value to the next")
        if self.brake is None and self.traction is None:
            raise ValueError("give brake, traction or both: the demands at time_s, 0 to 1")
        for key in ("brake", "traction"):
            values = getattr(self, key)
            if values is not None and len(values) != len(self.time):
                raise ValueError(f"time_s has {len(self.time)} values, {key} has {len(values)}")
        return self

    def curves(self):
        """Knots of brake and traction demand, the last one twice; None where there is none."""
        time = _apart(np.array([*self.time, self.time[-1] + 1.0]))
        return tuple(
            None if values is None else (time, np.array([*values, values[-1]]))
            for values in (self.brake, self.traction)
        )


class PlanPlace(Description):
    """A place on the driver's plan: the speed permitted from there on, a stop, or both."""

    at: NotNegative = Field(alias="at_m")  # arc length of the first body
    speed: Annotated[Real, Field(gt=0.0, le=150.0)] | None = Field(None, alias="speed_m_per_s")
    dwell: Annotated[NotNegative, Field(le=3600.0)] | None = Field(None, alias="dwell_s")  # time of a stop

    @model_validator(mode="after")
    def _says_something(self):
        if self.speed is None and self.dwell is None:
            raise ValueError("give speed_m_per_s (permitted from there on), dwell_s (a stop), or both")
        return self


class FollowLine(Description):
    """Runs at the permitted speeds of a line and stops where it says; speed is a result."""

    kind: Literal["line"] = "line"
    places: Annotated[tuple[PlanPlace, ...], Field(min_length=1, max_length=200)] = Field(alias="place")
    deceleration: Annotated[Positive, Field(le=3.0)] = Field(0.6, alias="deceleration_m_per_s2")  # of braking curves
    eager: Annotated[Positive, Field(le=5.0)] = Field(0.5, alias="eager_1_per_s")  # acceleration per lack of speed

    @model_validator(mode="after")
    def _in_order(self):
        increasing("place: at_m", [one.at for one in self.places], 0.0)
        if self.places[0].speed is None:
            raise ValueError("place[1]: give speed_m_per_s, permitted from the beginning")
        return self

    def packed(self):
        """The plan of the core."""
        plan, speed = np.zeros(len(self.places), PLAN), 0.0
        for row, place in zip(plan, self.places, strict=True):
            speed = speed if place.speed is None else place.speed
            row["place"], row["speed"], row["dwell"] = place.at, speed, place.dwell or 0.0
        return plan

    def curves(self):
        return None, None


def _apart(time):
    """Times of which no two are the same: a jump takes a millionth of a second."""
    for k in range(1, time.size):
        time[k] = max(time[k], time[k - 1] + 1e-6)
    return time


DriverOf = Annotated[HoldSpeed | Coast | Demand | FollowLine, Field(discriminator="kind")]


class Valves(Description):
    """Dump valves, one for each axle, through which its cylinders fill and empty."""

    fill: Annotated[Positive, Field(le=10.0)] = Field(0.35, alias="fill_s")  # time constants
    vent: Annotated[Positive, Field(le=10.0)] = Field(0.25, alias="vent_s")
    dead: Annotated[NotNegative, Field(le=1.0)] = Field(0.0, alias="dead_time_s")


class _Brake(Description):
    """What all friction brakes have in common."""

    rise: one_of(RISES) = "linear"
    apply: Time = Field(4.0, alias="apply_s")  # to the full pressure; exponential: to 95 % of it
    release: Time = Field(15.0, alias="release_s")
    inshot: Share = 0.1  # stepped: share of the full pressure that comes at once
    inshot_time: Time = Field(1.0, alias="inshot_s")
    delay: Annotated[NotNegative, Field(le=60.0)] = Field(0.0, alias="delay_s")
    pressure: Annotated[Positive, Field(le=2e6)] = Field(3.8e5, alias="pressure_Pa")  # of a cylinder at full demand
    volume: Annotated[Positive, Field(le=1.0)] = Field(0.010, alias="volume_m3")  # of the cylinders of an axle
    valves: Valves | None = None
    frames: tuple[Name, ...] | None = None  # bodies on which the torque of each axle reacts; None: found

    @model_validator(mode="after")
    def _rises(self):
        if self.rise == "stepped" and not 0.0 < self.inshot_time < self.apply:
            raise ValueError(
                f"inshot_s must lie between 0 and apply_s, got {self.inshot_time:g} s and {self.apply:g} s"
            )
        return self


class NominalBrake(_Brake):
    """A brake whose torque is in proportion to the pressure, whatever the speed."""

    kind: Literal["torque"] = "torque"
    torque: Annotated[Positive, Field(le=1e6)] = Field(alias="torque_Nm")  # of an axle at full pressure


class _Rubbing(_Brake):
    """A brake whose pads or blocks rub; friction is a number, or a table over the speed of the tread."""

    friction: Annotated[Positive, Field(le=1.0)] | None = None
    friction_speed: Speeds | None = Field(None, alias="friction_speed_m_per_s")
    friction_values: Annotated[tuple[Share, ...], Knots] | None = None

    @model_validator(mode="after")
    def _has_friction(self):
        if (self.friction_speed is None) != (self.friction_values is None):
            raise ValueError("friction_speed_m_per_s and friction_values: give both, the table, or neither")
        if self.friction_speed is not None:
            increasing("friction_speed_m_per_s", self.friction_speed)
            if len(self.friction_speed) != len(self.friction_values):
                raise ValueError(
                    f"friction_speed_m_per_s has {len(self.friction_speed)} values, friction_values has "
                    f"{len(self.friction_values)}"
                )
        given = [self.friction is not None, self.friction_speed is not None, getattr(self, "law", None) is not None]
        if sum(given) != 1:
            raise ValueError(f"friction of the brake: give one of {self.ways}")
        return self

    @property
    def friction_at_rest(self):
        """What a driver and blending count with [-]."""
        if self.friction is not None:
            return self.friction
        return self.friction_values[0] if self.friction_values is not None else CAST_IRON_MEAN

    ways: ClassVar[str] = "friction (a number) or friction_speed_m_per_s with friction_values (a table)"


class DiscBrake(_Rubbing):
    """Pads on discs."""

    kind: Literal["discs"] = "discs"
    discs: Annotated[int, Field(ge=1, le=16)] = 2  # of an axle
    clamp_force: Annotated[Positive, Field(le=1e6)] = Field(alias="clamp_force_N")  # of each of two at full pressure
    radius: Annotated[Positive, Field(le=1.0)] = Field(alias="radius_m")  # at which pads rub


class BlockBrake(_Rubbing):
    """Blocks on the treads."""

    kind: Literal["blocks"] = "blocks"
    blocks: Annotated[int, Field(ge=1, le=32)] = 4  # of an axle
    block_force: Annotated[Positive, Field(le=1e6)] = Field(alias="block_force_N")  # of one at full pressure
    law: Literal["P10"] | None = None  # cast iron, over speed and force

    ways: ClassVar[str] = "friction (a number), friction_speed_m_per_s with friction_values (a table), or law = \"P10\""


Brake = Annotated[NominalBrake | DiscBrake | BlockBrake, Field(discriminator="kind")]


class Traction(Description):
    """Motors: the largest torque at a driven axle over the speed of its tread."""

    kind: Literal["envelope"] = "envelope"
    speed: Speeds = Field(alias="speed_m_per_s")
    torque: Annotated[tuple[Torque, ...], Knots] = Field(alias="torque_Nm")
    axles: tuple[Annotated[int, Field(ge=1, le=100)], ...] | None = None  # from the front, from 1; None: all
    lag: Annotated[NotNegative, Field(le=10.0)] = Field(0.02, alias="lag_s")
    torque_rate: Annotated[NotNegative, Field(le=1e9)] = Field(0.0, alias="torque_rate_Nm_per_s")  # 0: no limit
    electric: Annotated[tuple[Torque, ...], Knots] | None = Field(None, alias="brake_torque_Nm")
    fade: tuple[NotNegative, NotNegative] = Field((3.0 / 3.6, 10.0 / 3.6), alias="fade_m_per_s")  # out: none, all of it
    ratio: Annotated[Positive, Field(le=50.0)] = 1.0  # of the gear
    rotor_inertia: Annotated[NotNegative, Field(le=1e4)] = Field(0.0, alias="rotor_inertia_kg_m2")

    @model_validator(mode="after")
    def _is_an_envelope(self):
        increasing("speed_m_per_s", self.speed)
        if len(self.speed) != len(self.torque):
            raise ValueError(f"speed_m_per_s has {len(self.speed)} values, torque_Nm has {len(self.torque)}")
        if any(later > earlier for earlier, later in pairwise(self.torque)):
            raise ValueError("torque_Nm must not rise with the speed")
        if self.electric is not None and len(self.electric) != len(self.speed):
            raise ValueError(f"speed_m_per_s has {len(self.speed)} values, brake_torque_Nm has {len(self.electric)}")
        if not self.fade[0] < self.fade[1]:
            raise ValueError(f"fade_m_per_s must increase, got {list(self.fade)}")
        if self.axles is not None and len(set(self.axles)) != len(self.axles):
            raise ValueError(f"axles names one twice: {list(self.axles)}")
        return self
