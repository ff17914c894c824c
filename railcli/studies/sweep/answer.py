"""What a parameter study found."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from railcli.studies.answer import Answer

if TYPE_CHECKING:
    from pandas import DataFrame


class Swept(Answer):
    """An Answer with a table of all runs.

    Attributes
    ----------
    frame : pandas.DataFrame
        A row for each run: its number, inputs, outputs, status, verdict, cause and times.
    """

    def __init__(self, record: dict[str, Any], lines: list[str], folder: Path | None, frame: DataFrame) -> None:
        super().__init__(record, lines, folder)
        self.frame = frame
