"""Tables of force over displacement or rate, and of moment over angle or rate of turning."""

from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from railcli.kernels.layout import CURVE_KNOTS

from .checks import Description, Flag
from .element_parts import Values, check_knots


class _Table(Description):
    """Piecewise linear, continued along its first and last slopes."""

    argument_name: ClassVar[str]
    value_name: ClassVar[str] = "force"
    odd: Flag = False  # given for the positive side only; f(-x) = -f(x)

    def knots(self):
        """Both coordinates of all knots, the mirrored side included."""
        x, y = np.array(self.argument), np.array(self.value)
        if self.odd:
            keep = x > 0.0
            x = np.concatenate([-x[keep][::-1], x])
            y = np.concatenate([-y[keep][::-1], y])
        return x, y

    @model_validator(mode="after")
    def _is_a_spring_or_damper(self):
        name, value = self.argument_name, self.value_name
        check_knots(name, self.argument, self.value, value)
        if self.odd and (self.argument[0] < 0.0 or (self.argument[0] == 0.0 and self.value[0] != 0.0)):
            raise ValueError(f"with odd = true, {name} must not be negative and the {value} at 0 must be 0")
        x, y = self.knots()
        if x.size > CURVE_KNOTS:
            raise ValueError(f"has {x.size} knots with the mirrored side, at most {CURVE_KNOTS} are allowed")
        if not x[0] <= 0.0 <= x[-1] or abs(np.interp(0.0, x, y)) > 1e-9 * np.abs(y).max():
            raise ValueError(f"must pass through (0, 0): no {value} in the nominal geometry or at rest")
        return self


class SpringTable(_Table):
    """Force over displacement, beside the linear stiffness."""

    argument_name = "displacement"
    displacement: Values = Field(alias="displacement_m")
    force: Values = Field(alias="force_N")

    @property
    def argument(self):
        return self.displacement

    @property
    def value(self):
        return self.force


class DamperTable(_Table):
    """Force over rate of extension."""

    argument_name = "rate"
    rate: Values = Field(alias="rate_m_per_s")
    force: Values = Field(alias="force_N")

    @property
    def argument(self):
        return self.rate

    @property
    def value(self):
        return self.force


class TurnTable(_Table):
    """Moment over angle, beside the linear rotational stiffness."""

    argument_name, value_name = "angle", "moment"
    angle: Values = Field(alias="angle_rad")
    moment: Values = Field(alias="moment_Nm")

    @property
    def argument(self):
        return self.angle

    @property
    def value(self):
        return self.moment


class TurnDamperTable(_Table):
    """Moment over rate of turning."""

    argument_name, value_name = "rate", "moment"
    rate: Values = Field(alias="rate_rad_per_s")
    moment: Values = Field(alias="moment_Nm")

    @property
    def argument(self):
        return self.rate

    @property
    def value(self):
        return self.moment
