"""Scenario: a vehicle, a track, what happens at the rails, and how long to run."""

import hashlib
import json
import math
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PrivateAttr, Strict, model_validator

from railcli.kernels.layout import CURVE_KNOTS

from .adhesion import Adhesion, Resistance
from .checks import Description, Name, NotNegative, Place, Positive, Real, Text, one_of
from .controls import AntiSlip, Odometer, SlideProtection, SpeedSensor
from .driving import Brake, DriverOf, HoldSpeed, Traction
from .irregularity import Source
from .limits import Limits
from .profile import TAPE_LIMITS, TAPE_TO_BACK
from .rails import course
from .sections import Gradient
from .submodels import CREEP_LAWS, NORMAL_LAWS
from .subsystems import OF_CONTACT, OPTIONAL, fault, is_free
from .track import MARGIN, Track, gradient_course, pack
from .track_support import TrackSupport
from .vehicle import Vehicle

FASTEST = 150.0  # [m/s]
STEEPEST_INCLINATION = 5.0  # 1 in ...
OF_ONE_LAW = {"adhesion_reduction": "polach", "slip_reduction": "polach", "fastsim_grid": "fastsim"}
WIDEST = 0.06  # measured gauge from the nominal one [m]
LONGEST_FREE = 1800.0  # time after which a free run ends that says nothing of it [s]
LONGEST_STEP = 2e-3  # that a scenario may ask for [s]
PROFILES = {  # keys of a contact that name a profile, and its kind
    "wheel_profile": "wheel", "rail_profile": "rail", "left_wheel_profile": "wheel", "left_rail_profile": "rail",
}  # fmt: skip
TABLES = ("table", "left_table")


def divides(step, interval):
    """True when an interval is a whole number of steps."""
    count = round(interval / step)
    return count >= 1 and math.isclose(count * step, interval, rel_tol=1e-9)


_Speed = Annotated[Real, Field(ge=0.0, le=FASTEST)]
_Knots = Field(min_length=2, max_length=CURVE_KNOTS - 1)


class SpeedCourse(Description):
    """Speed asked for over time, straight between its knots and constant after the last: start, stop, stand."""

    time: Annotated[tuple[NotNegative, ...], _Knots] = Field(alias="time_s")
    speed: Annotated[tuple[_Speed, ...], _Knots] = Field(alias="speed_m_per_s")

    @model_validator(mode="after")
    def _is_a_course(self):
        if len(self.time) != len(self.speed):
            raise ValueError(f"time_s has {len(self.time)} values, speed_m_per_s has {len(self.speed)}")
        if self.time[0] != 0.0 or any(later <= time for time, later in pairwise(self.time)):
            raise ValueError("time_s must begin with 0 and increase from each value to the next")
        if max(self.speed) == 0.0:
            raise ValueError("speed_m_per_s is 0 throughout; a run moves at least once")
        return self

    def knots(self):
        """Times [s] and speeds [m/s], the last one twice: what follows is constant."""
        return np.array([*self.time, self.time[-1] + 1.0]), np.array([*self.speed, self.speed[-1]])

    def travelled(self, time):
        """Length travelled by a time [s], at the speed asked for [m]."""
        times, speeds = self.knots()
        inner = times[times < time]
        at = np.append(inner, time)
        return float(np.trapezoid(np.interp(at, times, speeds), at))

    def arrival(self, distance):
        """Time at which a length [m] has been travelled [s]; infinite when the vehicle stands before that."""
        times, speeds = self.knots()
        lengths = np.array([self.travelled(time) for time in times])
        k = int(np.searchsorted(lengths, distance)) - 1
        if k < 0:
            return 0.0
        k = min(k, times.size - 2)
        rest, speed, rise = distance - lengths[k], speeds[k], (speeds[k + 1] - speeds[k]) / (times[k + 1] - times[k])
        root = math.sqrt(max(speed * speed + 2.0 * rise * rest, 0.0))
        return float(times[k] + 2.0 * rest / (speed + root)) if speed + root > 0.0 else math.inf


class Run(Description):
    """Speed, length and time steps of a run."""

    speed: Annotated[Positive, Field(le=FASTEST)] = Field(alias="speed_m_per_s")
    course: SpeedCourse | None = Field(None, alias="speed_course")  # its largest speed is then `speed`
    distance: Positive | None = Field(None, alias="distance_m")
    duration: Positive | None = Field(None, alias="duration_s")
    step: Annotated[Real, Field(ge=1e-6, le=LONGEST_STEP)] | None = Field(None, alias="step_s")  # None: chosen
    output_interval: Annotated[Real, Field(ge=1e-6, le=10.0)] = Field(10e-3, alias="output_interval_s")
    average_over: Positive = Field(100.0, alias="average_over_m")
    gravity: Annotated[Positive, Field(le=100.0)] = Field(9.81, alias="gravity_m_per_s2")

    @model_validator(mode="before")
    @classmethod
    def _speed_of_course(cls, values):
        if isinstance(values, dict) and not {"speed", "speed_m_per_s"} & set(values):
            given = values.get("speed_course", values.get("course"))
            if given is not None:
                given = SpeedCourse.model_validate(given)
                values = {**values, "speed_m_per_s": max(given.speed)}
        return values

    @model_validator(mode="after")
    def _fits_together(self):
        if self.course is not None and self.speed != max(self.course.speed):
            raise ValueError(
                f"speed must be the largest of speed_course, {max(self.course.speed):g} m/s, or be left out, "
                f"got {self.speed:g} m/s"
            )
        if self.step is not None and not divides(self.step, self.output_interval):
            raise ValueError(
                f"output interval must be a multiple of the step, got {self.output_interval * 1e3:g} ms and "
                f"{self.step * 1e3:g} ms"
            )
        return self

    @property
    def steps_per_output(self):
        """Only once there is a step (`analysis.step_choice`)."""
        return round(self.output_interval / self.step)


class Contact(Description):
    """Wheels, rails and what acts between them."""

    wheel_profile: Place = "ORES1002"  # a bundled one, or a file
    rail_profile: Place = "UIC60"
    left_wheel_profile: Place | None = None  # as a right-hand profile; None: the right one
    left_rail_profile: Place | None = None
    inclination: Annotated[Real, Field(ge=0.0, le=1000.0)] = 20.0  # 1 in ...; 0: as in the profile
    gauge: Annotated[Real, Field(ge=0.5, le=2.0)] = Field(1.435, alias="gauge_m")
    flange_back: Annotated[Real, Field(ge=0.4, le=1.95)] = Field(1.360, alias="flange_back_m")
    tape_to_back: Annotated[Real, Field(ge=TAPE_LIMITS[0], le=TAPE_LIMITS[1])] = Field(
        TAPE_TO_BACK, alias="tape_to_back_m"
    )
    friction: Annotated[NotNegative, Field(le=1.0)] = 0.30
    creep_law: one_of(CREEP_LAWS) = "fastrip"
    friction_ratio: Annotated[Positive, Field(le=1.0)] = 1.0  # at infinite over that at zero slip velocity
    friction_decay: Annotated[NotNegative, Field(le=1000.0)] = Field(0.0, alias="friction_decay_s_per_m")
    adhesion_reduction: Annotated[Positive, Field(le=1.0)] = 1.0  # k_A, k_S of Polach's law
    slip_reduction: Annotated[Positive, Field(le=1.0)] = 1.0
    fastsim_grid: Annotated[int, Strict(), Field(ge=10, le=50)] = 10  # strips of a patch, elements of a strip
    table: Place | None = None  # file of a contact table already built
    left_table: Place | None = None  # likewise of the left side; None: the right one
    young: Positive = Field(210e9, alias="young_Pa")
    poisson: Annotated[NotNegative, Field(lt=0.5)] = 0.28
    damping: Annotated[NotNegative, Field(le=100.0)] = Field(2.0, alias="damping_s_per_m")
    normal: one_of(NORMAL_LAWS) = "overlap"

    @model_validator(mode="after")
    def _fits_together(self):
        if 0.0 < self.inclination < STEEPEST_INCLINATION:
            raise ValueError(
                f"inclination means 1 in ...: must be 0 (as in the profile) or >= {STEEPEST_INCLINATION:g}, "
                f"got {self.inclination:g}"
            )
        for key, law in OF_ONE_LAW.items():
            if self.creep_law != law and getattr(self, key) != type(self).model_fields[key].default:
                raise ValueError(f"{key} belongs to creep_law {law!r}, got creep_law {self.creep_law!r}")
        if self.slip_reduction > self.adhesion_reduction:
            raise ValueError(
                f"slip_reduction must be at most adhesion_reduction, got {self.slip_reduction:g} and "
                f"{self.adhesion_reduction:g}"
            )
        if (self.friction_ratio < 1.0) != (self.friction_decay > 0.0):
            raise ValueError(
                "friction falls from friction to friction_ratio times it as exp(-friction_decay_s_per_m times slip "
                "velocity): give both (a ratio below 1 and a decay above 0) or neither, "
                f"got {self.friction_ratio:g} and {self.friction_decay:g} s/m"
            )
        if self.flange_back >= self.gauge:
            raise ValueError(
                f"no wheelset fits: flange back {self.flange_back * 1e3:g} mm, gauge {self.gauge * 1e3:g} mm"
            )
        return self

    @property
    def sides(self):
        """Wheel profile, rail profile and table file of the right and of the left side."""
        right = self.wheel_profile, self.rail_profile, self.table
        left = self.left_wheel_profile, self.left_rail_profile, self.left_table
        return right, tuple(one if other is None else other for one, other in zip(right, left, strict=True))

    @property
    def tape_circle(self):
        """Distance of the tape circles from the middle of the wheelset [m]."""
        return self.flange_back / 2.0 + self.tape_to_back


class Start(Description):
    """How the vehicle stands and runs at the beginning."""

    lateral: Annotated[Real, Field(ge=-0.01, le=0.01)] = Field(0.0, alias="lateral_m")  # of all bodies, to the right
    initial_speed: _Speed | None = Field(None, alias="initial_speed_m_per_s")  # of a free run; None: run.speed


class Scenario(Description):
    """Everything a run needs; built from a file by `railcli.files.scenario.load`.

    Attributes
    ----------
    contents : dict
        What the names in `contact` stand for, as far as it is known: name or file of a profile -> Profile, file of a
        contact table -> digest of the table.
    """

    name: Name
    title: Text = ""
    description: Text = ""
    changes: tuple[Text, ...] = ()  # what options of a command replaced, in words; the title tells it too
    cant_base: Annotated[Real, Field(ge=0.5, le=2.2)] = Field(1.5, alias="cant_base_m")
    cant_pivot: Literal["centre", "inner", "outer"] = "centre"  # what stays at its height where there is cant
    vehicle: Vehicle
    run: Run
    track: Track
    gradients: tuple[Gradient, ...] = Field((), alias="gradient")
    limits: Limits = Limits()
    contact: Contact = Contact()
    track_support: TrackSupport = TrackSupport()
    irregularity: tuple[Source, ...] = ()
    start: Start = Start()
    driver: DriverOf = HoldSpeed()
    brake: Brake | None = None
    traction: Traction | None = None
    speed_sensor: SpeedSensor | None = None
    slide_protection: SlideProtection | None = None
    anti_slip: AntiSlip | None = None
    odometry: Odometer | None = None
    adhesion: Adhesion | None = None
    resistance: Resistance | None = None
    _contents: dict = PrivateAttr(default_factory=dict)

    @model_validator(mode="after")
    def _fits_together(self):
        if problem := fault(self):
            raise ValueError(problem)
        if self.start.initial_speed is not None and not self.is_free:
            raise ValueError("start.initial_speed: belongs to a free run (driver kind \"coast\" or \"demand\")")
        if self.run.distance is not None and self.run.duration is not None and not self.is_free:
            raise ValueError("run: give either distance_m or duration_s, not both")
        if not math.isfinite(self.duration):
            if self.run.course is None:
                raise ValueError(f"run: {self.distance:g} m at {self.run.speed:g} m/s take for ever")
            raise ValueError(
                f"run.distance_m: must be at most the {self.run.course.travelled(self.run.course.time[-1]):g} m after "
                f"which speed_course stands, got {self.distance:g} m"
            )
        if self.distance > self.track.length * (1.0 + 1e-9):
            raise ValueError(
                f"track shorter than the run: {self.track.length:g} m of track, {self.distance:g} m to run; "
                "lengthen a section of [[track]] or shorten distance_m or duration_s in [run]"
            )
        if "average_over" in self.run.model_fields_set and self.run.average_over > self.distance * (1.0 + 1e-9):
            raise ValueError(
                f"run.average_over_m: must be at most the {self.distance:g} m of the run, "
                f"got {self.run.average_over:g} m"
            )
        if self.run.output_interval > self.duration * (1.0 + 1e-9):
            raise ValueError(
                f"run.output_interval_ms: must be at most {1e3 * self.duration:.6g} ms, the length of the run, "
                f"got {1e3 * self.run.output_interval:g} ms"
            )
        if self.vehicle.reach > MARGIN:
            raise ValueError(
                f"vehicle: a body stands {self.vehicle.reach:g} m from the first one; at most {MARGIN:g} m fit on the "
                "track that continues at both ends"
            )
        gradient_course(self.track, self.gradients)
        right, left = self.contact.sides
        radii = self.vehicle.wheel_radii
        if right[2] and right[2] == left[2] and (right != left or any(one != other for one, other in radii)):
            raise ValueError("contact.table: is for one side, and the sides differ; give contact.left_table as well")
        for section in self.track.sections:
            if section.kind == "measured" and section.gauge is not None:
                worst = max(section.gauge, key=lambda gauge: abs(gauge - self.contact.gauge))
                if abs(worst - self.contact.gauge) > WIDEST:
                    raise ValueError(
                        f"track: measured gauge of {worst * 1e3:.6g} mm is more than {WIDEST * 1e3:g} mm from the "
                        f"nominal {self.contact.gauge * 1e3:g} mm of contact.gauge_mm"
                    )
        for number, source in enumerate(self.irregularity, start=1):
            try:
                source.check(course(self))
            except ValueError as error:
                raise ValueError(f"irregularity[{number}]: {error}") from None
        return self

    @property
    def contents(self):
        return self._contents

    def knowing(self, contents):
        """The same scenario with these `contents`."""
        known = self.model_copy()
        known._contents = dict(contents)
        return known

    @property
    def is_free(self):
        """Whether speed is a result."""
        return is_free(self)

    @property
    def first_speed(self):
        """Speed at which the run begins [m/s]."""
        if self.is_free:
            return self.run.speed if self.start.initial_speed is None else self.start.initial_speed
        return self.run.speed if self.run.course is None else self.run.course.speed[0]

    @property
    def distance(self):
        """Length of the run [m]; of a free one the longest."""
        run = self.run
        if self.is_free:
            return self.track.length if run.distance is None else run.distance
        if run.distance is not None:
            return run.distance
        if run.course is not None:
            return run.course.travelled(self.duration)
        return run.duration * run.speed if run.duration is not None else self.track.length

    @property
    def duration(self):
        """Time of the run at the speed asked for [s]; a course of speed without length or time ends with its knots.

        Of a free run the longest time.
        """
        run = self.run
        if self.is_free:
            return LONGEST_FREE if run.duration is None else run.duration
        if run.duration is not None:
            return run.duration
        if run.course is None:
            return self.distance / run.speed
        return run.course.time[-1] if run.distance is None else run.course.arrival(run.distance)

    @property
    def final_speed(self):
        """Speed asked for while the run's last metres are averaged [m/s]; None when it changes there."""
        if self.is_free:
            return None
        if self.run.course is None:
            return self.run.speed
        times, speeds = self.run.course.knots()
        begin = self.run.course.arrival(self.distance - self.average_over)
        there = np.interp([begin, *times[(times > begin) & (times < self.duration)], self.duration], times, speeds)
        return float(there[0]) if np.ptp(there) == 0.0 else None

    def pieces(self):
        """The track packed for the compiled core."""
        return pack(self.track, gradients=self.gradients, pivot=self.cant_pivot)

    @property
    def average_over(self):
        """Length at the end of the run over which steady values are averaged [m]."""
        return min(self.run.average_over, self.distance)

    def varied(self, **groups):
        """The same scenario with other values, validated: ``varied(run={"speed": 30.0}, contact={"friction": 0.4})``.

        Keys are the names of the fields, values SI; what is not a group (``name``, ``vehicle``) is replaced whole.
        """
        values = dict(self)
        for key, value in groups.items():
            if isinstance(value, dict):
                group = values[key]
                fields = {name: getattr(group, name) for name in group.model_fields_set}
                value = type(group)(**{**fields, **value})
            values[key] = value
        return type(self)(**values).knowing(self.contents)

    def as_dict(self):
        """All values, defaults included, with units in the keys, and digests of what names stand for."""
        values = self.model_dump(mode="json")
        values["run"]["average_over_m"] = self.average_over
        if self.adhesion:  # says it in place of the contact
            for key in OF_CONTACT:
                del values["contact"][type(self.contact).model_fields[key].alias or key]
        given = {key: values["contact"][key] for key in (*PROFILES, *TABLES)}
        values["contact"]["digests"] = {
            key: digest_of(self.contents[place]) for key, place in given.items() if place in self.contents
        }
        return values

    def digest(self):
        """Hex digest of all that decides the results; equal for equal scenarios, whatever their files look like.

        Profiles, measured tracks and contact tables count by what they hold, not by the names of their files.
        """
        values = self.as_dict()
        for key in ("name", "title", "description", "changes", "limits"):
            del values[key]
        for key in OPTIONAL:
            if values[key] is None:
                del values[key]
        if not self.is_free:
            del values["driver"], values["start"]["initial_speed_m_per_s"]
        if not self.track_support.gives_way:
            del values["track_support"]
        left = zip(("left_wheel_profile", "left_rail_profile", "left_table"), self.contact.sides[1], strict=True)
        values["contact"].update(left)
        del values["contact"]["digests"]
        for key in (*PROFILES, *TABLES):
            if (place := values["contact"][key]) in self.contents:
                values["contact"][key] = digest_of(self.contents[place])
        for source in values["irregularity"]:
            source.pop("file", None)
        for body, values_of_body in zip(self.vehicle.bodies, values["vehicle"]["body"], strict=True):
            values_of_body["left_wheel_radius_m"] = body.wheel_radii[1]
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()[:16]


def digest_of(content):
    """Digest of a Profile (16 digits); of a contact table it is known already."""
    return content if isinstance(content, str) else content.digest()[:16]
