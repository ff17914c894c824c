"""What a run is judged by: figures with their processing and source, and limits that a user may replace.

None of the standards named here could be consulted: what is said to be theirs comes from secondary sources and common
knowledge of the field, and is marked as such wherever it is shown (docs/assessment.md lists the sources).
"""

from math import radians
from typing import Annotated, NamedTuple

from pydantic import Field

from .checks import Description, NotNegative, Positive, Real

NOT_CONSULTED = "k"  # mark of what rests on common knowledge of the field, the standard not consulted

_FORCES = "20 Hz low-pass"
_SLIDING = "20 Hz low-pass, 2 m sliding mean in steps of 0.5 m"
_RATIO = f"Y and Q {_FORCES}, ratio"
_RIDE = "0.4 to 10 Hz band-pass"
_RUNNING = "EN 14363, UIC 518"
_COMFORT = "EN 12299"
_WEAR = "Pearce and Sherratt 1991"


class Figure(NamedTuple):
    """A figure of the assessment.

    Attributes
    ----------
    title, unit : str
        Values are SI; the unit is the one they are shown in.
    how : str
        Filter, sliding mean, percentile.
    source : str
        Of the processing and of the limit.
    mark : str
        NOT_CONSULTED, or empty where nothing of a standard is used.
    """

    title: str
    unit: str
    how: str
    source: str
    mark: str = NOT_CONSULTED


FIGURES = {
    "sum_Y": Figure("sum Y", "kN", f"{_SLIDING}, 0.15 and 99.85 %", "Prud'homme; EN 14363, UIC 518"),
    "Y_Q": Figure("Y/Q, guiding wheel", "", f"{_RATIO}, 2 m sliding mean in steps of 0.5 m, 99.85 %", _RUNNING),
    "Y_Q_peak": Figure("Y/Q, peak of any wheel", "", f"{_RATIO}, largest value", "Nadal 1908", ""),
    "unloading": Figure("wheel unloading 1 - Q/Q0", "", f"{_FORCES}, 0.15 %", _RUNNING),
    "stability": Figure(
        "sum Y, rms over 100 m", "kN", "band-pass 2 Hz around the dominant frequency, rms over 100 m, largest", _RUNNING
    ),
    "Q_max": Figure("Q", "kN", f"{_FORCES}, 99.85 %", _RUNNING),
    "Y_qst": Figure("Y quasi-static, outer wheel", "kN", f"{_FORCES}, 50 %, full curves", _RUNNING),
    "Q_qst": Figure("Q quasi-static, outer wheel", "kN", f"{_FORCES}, 50 %, full curves", _RUNNING),
    "ay_max": Figure("lateral acceleration", "m/s^2", f"{_RIDE}, 0.15 and 99.85 %", _RUNNING),
    "az_max": Figure("vertical acceleration", "m/s^2", f"{_RIDE}, 0.15 and 99.85 %", _RUNNING),
    "ay_rms": Figure("lateral acceleration, rms", "m/s^2", f"{_RIDE}, rms", _RUNNING),
    "az_rms": Figure("vertical acceleration, rms", "m/s^2", f"{_RIDE}, rms", _RUNNING),
    "ay_qst": Figure("lateral acceleration, quasi-static", "m/s^2", f"{_FORCES}, 50 %, full curves", _RUNNING),
    "ay_centre": Figure("lateral acceleration, centre of mass", "m/s^2", f"{_RIDE}, 0.15 and 99.85 %", _RUNNING),
    "az_centre": Figure("vertical acceleration, centre of mass", "m/s^2", f"{_RIDE}, 0.15 and 99.85 %", _RUNNING),
    "N_MV": Figure("mean comfort N_MV", "", "W_d, W_d, W_b; rms over 5 s; 95 % of each direction", _COMFORT),
    "C_y": Figure("lateral comfort C_Cy", "m/s^2", "W_d, rms over 5 s, largest", _COMFORT),
    "C_z": Figure("vertical comfort C_Cz", "m/s^2", "W_b, rms over 5 s, largest", _COMFORT),
    "Wz_y": Figure("Sperling Wz, lateral", "", "B_y, rms of the whole run", "Sperling and Betzhold 1956"),
    "Wz_z": Figure("Sperling Wz, vertical", "", "B_z, rms of the whole run", "Sperling and Betzhold 1956"),
    "wear_wheel": Figure("T-gamma of a wheel", "N", "all contacts, mean of a section", _WEAR),
    "wear_contact": Figure(
        "T-gamma of a contact", "N", "contacts on one part of the profile, mean of a section", _WEAR
    ),
}
GROUPS = {  # heading: first figure
    "Running safety": "sum_Y",
    "Track loading": "Q_max",
    "Ride, floor above the bogies": "ay_max",
    "Comfort, floor": "N_MV",
    "Wear": "wear_wheel",
}

COMFORT_GRADES = (  # N_MV below which a word holds
    (1.5, "very comfortable"),
    (2.5, "comfortable"),
    (3.5, "medium"),
    (4.5, "uncomfortable"),
    (float("inf"), "very uncomfortable"),
)
SPERLING_GRADES = (
    (1.0, "not noticeable"),
    (2.0, "just noticeable"),
    (2.5, "clearly noticeable"),
    (3.0, "more pronounced, not unpleasant"),
    (3.25, "strong, irregular, still tolerable"),
    (3.5, "very irregular"),
    (4.0, "extremely irregular, unpleasant"),
    (float("inf"), "extremely unpleasant"),
)
WEAR_GRADES = ((100.0, "mild wear"), (200.0, "between mild and severe wear"), (float("inf"), "severe wear"))
GRADES = {
    "N_MV": COMFORT_GRADES,
    "Wz_y": SPERLING_GRADES,
    "Wz_z": SPERLING_GRADES,
    "wear_wheel": WEAR_GRADES,
    "wear_contact": WEAR_GRADES,
}

Q_CAPS = ((160.0, 200e3), (200.0, 190e3), (250.0, 180e3), (300.0, 170e3), (float("inf"), 160e3))  # to km/h, N
TIGHTEST = 250.0  # radius from which on EN 14363 limits Y/Q and Y_qst [m]
TIGHT = 400.0  # radius below which the limit of Y_qst depends on it [m]

_Share = Annotated[Real, Field(gt=0.0, le=1.0)]


class Limits(Description):
    """Limits and conditions of an assessment; a key left out keeps its default, None means as the standard has it."""

    run_in: NotNegative = Field(3.0, alias="run_in_s")
    run_out: NotNegative = Field(2.0, alias="run_out_s")
    section_length: Annotated[Positive, Field(ge=10.0)] | None = Field(None, alias="section_length_m")
    floor_height: Annotated[Positive, Field(le=10.0)] = Field(1.2, alias="floor_height_m")
    warn_share: _Share = 0.9
    flange_angle: Annotated[Real, Field(ge=radians(30.0), le=radians(89.0))] = Field(
        radians(70.0), alias="flange_angle_rad"
    )
    friction: Annotated[NotNegative, Field(le=1.0)] | None = None  # of Nadal's limit; None: the scenario's
    sum_y_factor: Positive = Field(1.0, alias="sum_Y_factor")
    y_over_q: Positive = Field(0.8, alias="Y_over_Q")
    unloading: _Share = 0.6
    stability_share: Positive = 0.5
    q_over_static: Positive = Field(90e3, alias="Q_over_static_N")
    q_max: Positive | None = Field(None, alias="Q_max_N")
    y_qst: Positive | None = Field(None, alias="Y_qst_N")
    q_qst: Positive = Field(145e3, alias="Q_qst_N")
    ay_max: Positive = Field(2.5, alias="ay_max_m_per_s2")
    az_max: Positive = Field(2.5, alias="az_max_m_per_s2")
    ay_rms: Positive = Field(0.5, alias="ay_rms_m_per_s2")
    az_rms: Positive = Field(0.75, alias="az_rms_m_per_s2")
    ay_qst: Positive = Field(1.5, alias="ay_qst_m_per_s2")
    n_mv: Positive | None = Field(None, alias="N_MV")
    wz: Positive | None = Field(None, alias="Wz")
    t_gamma: Positive | None = Field(None, alias="T_gamma_N")

    def largest_q(self, static, speed):
        """Limit of Q [N] for a static wheel load [N] at a speed [m/s]: Q0 + 90 kN, but no more than a cap."""
        cap = self.q_max
        if cap is None:
            cap = next(cap for kmh, cap in Q_CAPS if 3.6 * speed <= kmh * (1.0 + 1e-9))
        return min(static + self.q_over_static, cap)

    def largest_y_qst(self, radius):
        """Limit of Y_qst [N] in a curve of a radius [m]; None below 250 m, where EN 14363 has none."""
        if self.y_qst is not None:
            return self.y_qst
        if radius < TIGHTEST:
            return None
        return 60e3 if radius >= TIGHT else 30e3 + 10500e3 / radius


def section_length(speed, radius):
    """Length of a section that is evaluated by itself [m] (EN 14363, k).

    Parameters
    ----------
    speed : float
        [m/s]
    radius : float
        [m]; infinite on straight track.
    """
    kmh = 3.6 * speed
    if radius < TIGHT:
        return 70.0
    if radius <= 600.0:
        return 100.0
    if radius < float("inf") and kmh <= 140.0:
        return 100.0
    return 250.0 if kmh <= 220.0 else 500.0
