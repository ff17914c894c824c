"""Limits that a user sets for an alignment in place of the standard's."""

from typing import Annotated

from pydantic import Field

from .checks import Description, Positive


class Limits(Description):
    """Largest allowed values; what is left out keeps the standard's."""

    cant: Positive | None = Field(None, alias="cant_m")
    cant_deficiency: Positive | None = Field(None, alias="cant_deficiency_m")
    cant_excess: Positive | None = Field(None, alias="cant_excess_m")
    cant_rate: Positive | None = Field(None, alias="cant_rate_m_per_s")
    cant_deficiency_rate: Positive | None = Field(None, alias="cant_deficiency_rate_m_per_s")
    twist: Positive | None = Field(None, alias="twist_m_per_m")
    vertical_acceleration: Positive | None = Field(None, alias="vertical_acceleration_m_per_s2")
    base: Annotated[Positive, Field(le=100.0)] = Field(3.0, alias="base_m")  # over which slopes are taken
