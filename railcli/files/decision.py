"""What a reader decided about a file, and how that is told."""

import sys
from pathlib import Path
from typing import NamedTuple

WARNING = "warning"  # subject of a decision that is told wherever the file is read


class Decision(NamedTuple):
    """What was decided, how, and why."""

    subject: str
    choice: str
    reason: str


def tell(path, decisions):
    """Say on stderr, in one line for a file, what of the decisions a reader of results must know."""
    told = [f"{one.choice}: {one.reason}" for one in decisions if one.subject == WARNING]
    if told:
        line = f"Warning: {Path(path).name}: {'; '.join(told)}"
        print("".join(letter if letter.isprintable() else "?" for letter in line), file=sys.stderr)
