"""What a reader decided about a file, and how that is told."""

import warnings
from pathlib import Path
from typing import NamedTuple

from railcli.errors import RailcliWarning

WARNING = "warning"  # subject of a decision that is told wherever the file is read


class Decision(NamedTuple):
    """What was decided, how, and why."""

    subject: str
    choice: str
    reason: str


def tell(path, decisions):
    """Warn, in one line for a file, of what a reader of results must know of the decisions."""
    told = [f"{one.choice}: {one.reason}" for one in decisions if one.subject == WARNING]
    if told:
        warnings.warn(f"{Path(path).name}: {'; '.join(told)}", RailcliWarning, stacklevel=2)
