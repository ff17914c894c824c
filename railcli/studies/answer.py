"""What a study found, for machines and for people."""

import html
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any


class Answer(Mapping[str, Any]):
    """Values by name, units in the names, as `--format json` prints them; as text what a terminal shows.

    Attributes
    ----------
    record : dict
    lines : list of str
    folder : pathlib.Path or None
        Where the files of the study are, if any were written.
    """

    def __init__(self, record: dict[str, Any], lines: list[str], folder: Path | None = None) -> None:
        self.record, self.lines, self.folder = record, lines, folder

    def __getitem__(self, key: str) -> Any:
        return self.record[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.record)

    def __len__(self) -> int:
        return len(self.record)

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {', '.join(self.record)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"
