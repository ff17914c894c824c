"""The folder of a parameter study: what it is, its rows as they come, and the tables of them in the end.

Rows are appended to a journal, one line each, so that whatever ends the study leaves all that were finished. The study
goes on in the same folder if it is the same study.
"""

import hashlib
import json
import os
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from railcli.errors import InputError

from .inputs import INPUTS, SCENARIO, profiles_of, restore, save
from .lock import alone
from .output import LIST, json_text, refusal, refused, results_folder, whole_file, write_json
from .read_results import built_scenario, read_json

STUDY, JOURNAL = "study.json", "rows.jsonl"
CSV, PARQUET = "rows.csv", "rows.parquet"
SYNC = 5.0  # between two times that the journal is made safe against a failure of the machine [s]
TEXTS = ("status", "verdict", "cause")


@contextmanager
def study_folder(name, record, output=None, overwrite=False):
    """Folder of a study; one in which the same study was begun is taken up again.

    Parameters
    ----------
    name : str
    record : dict
        What the study is; equal for equal studies. Its ``identity`` holds digests by what they are of.
    output : path-like, optional
    overwrite : bool
        Begin anew.

    Yields
    ------
    pathlib.Path

    Raises
    ------
    InputError
        The folder holds another study or something else, or another process works on it.
    """
    folder = None if output is None else Path(output)
    if folder is not None and (folder / STUDY).is_file() and not overwrite:
        _check_same(folder, record)
        with alone(folder / STUDY, lambda: _busy(folder)):
            yield folder
        return
    with results_folder("sweep", name, output, overwrite) as folder, alone(folder / STUDY, lambda: _busy(folder)):
        yield folder


def _busy(folder):
    raise InputError(folder, "another process works on this study; wait for it, or end it")


def _check_same(folder, record):
    before = read_json(folder / STUDY).get("identity")
    now = json.loads(json_text(record["identity"]))
    if before != now:
        others = [key for key in now if not isinstance(before, dict) or before.get(key) != now[key]]
        raise InputError(
            folder, f"holds another study ({', '.join(others)} differ); choose another place with -o/--output, or "
            "--overwrite to begin anew"
        )  # fmt: skip


def keep(folder, record, scenario):
    """Write what a study is into its folder, with the scenario and all that it was made from."""
    write_json(folder / SCENARIO, scenario.as_dict())
    save(scenario, folder / INPUTS)
    write_json(folder / STUDY, {**record, "profiles": profiles_of(scenario)})


def kept(folder):
    """What `keep` wrote: the record and the scenario, which knows every profile of the study."""
    from .inputs import profiles

    record, values = read_json(folder / STUDY), read_json(folder / SCENARIO)
    contents = restore(values, folder)
    more = profiles(folder / INPUTS, record["profiles"])
    return record, built_scenario(values, folder / SCENARIO).knowing({**more, **contents})


def packed(folder):
    """What a worker elsewhere needs of the folder of a study, as bytes by the names of files."""
    files = {name: (folder / name).read_bytes() for name in (STUDY, SCENARIO, INPUTS)}
    return {"digest": hashlib.sha256(b"".join(files.values())).hexdigest()[:16], "files": files}


def unpack(package, folder):
    """Write what `packed` gave into a folder."""
    for name in (STUDY, SCENARIO, INPUTS):
        (folder / name).write_bytes(package["files"][name])


class Journal:
    """Rows of a study as they come; used as a context manager.

    Parameters
    ----------
    folder : pathlib.Path

    Attributes
    ----------
    rows : dict of int to dict
        Rows by the number of their run, those found in the file at first.
    """

    def __init__(self, folder):
        self._path = folder / JOURNAL
        self.rows = {}

    def __enter__(self):
        with refused(self._path):
            self._file = open(self._path, "ab+", buffering=0)
        self._file.seek(0)
        good = 0
        for line in self._file.read().splitlines(keepends=True):
            row = _row(line)
            if row is None:
                break
            self.rows[row["run"]] = row
            good += len(line)
        self._file.truncate(good)
        self._synced = time.monotonic()
        _enlist(self._path)
        return self

    def add(self, row):
        """Append a row; when the disk is full, none of it."""
        line = json.dumps(row, allow_nan=False).encode() + b"\n"
        end = self._file.seek(0, os.SEEK_END)
        try:
            if self._file.write(line) != len(line):
                raise OSError(28, os.strerror(28))
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(end)
            raise refusal(self._path, error, f"The {len(self.rows):,} runs before are kept.") from error
        self.rows[row["run"]] = row
        if time.monotonic() - self._synced > SYNC:
            self._sync()

    def _sync(self):
        with suppress(OSError):
            os.fsync(self._file.fileno())
        self._synced = time.monotonic()

    def __exit__(self, *_):
        self._sync()
        self._file.close()


def _row(line):
    """A row of the journal; None for a line that was cut off."""
    if not line.endswith(b"\n"):
        return None
    try:
        row = json.loads(line)
        return row if isinstance(row, dict) and isinstance(row.get("run"), int) else None
    except ValueError:
        return None


def _enlist(path):
    place = path.with_name(LIST)
    if place.is_file() and path.name not in place.read_text(encoding="utf-8").splitlines():
        with open(place, "a", encoding="utf-8") as file:
            file.write(path.name + "\n")


def frame(rows):
    """Rows in the order of their runs as a DataFrame; its columns are those of all rows.

    Parameters
    ----------
    rows : dict of int to dict
        As the journal holds them: ``run``, ``inputs`` and ``outputs`` by name, and the rest.
    """
    import pandas

    ordered = [rows[number] for number in sorted(rows)]
    inputs = dict.fromkeys(name for row in ordered for name in row["inputs"])
    outputs = dict.fromkeys(name for row in ordered for name in row["outputs"])
    columns = {"run": [row["run"] for row in ordered]}
    for name in inputs:
        columns[name] = _plain_column([row["inputs"].get(name) for row in ordered])
    for name in outputs:
        values = [row["outputs"].get(name) for row in ordered]
        columns[name] = [float("nan") if value is None else float(value) for value in values]
    for name in TEXTS:
        columns[name] = [row[name] for row in ordered]
    for name in ("cpu_s", "time_s"):
        columns[name] = [float(row[name]) for row in ordered]
    return pandas.DataFrame(columns)


def _plain_column(values):
    """Numbers as numbers; a column with anything else as texts, tables and lists as JSON."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        whole = all(isinstance(value, int) for value in values)
        return values if whole else [float(value) for value in values]
    return [value if isinstance(value, str) else json.dumps(value) for value in values]


def write_tables(table, folder):
    """Write a table of rows as CSV and, where pyarrow is installed, Parquet; the names of the files."""
    with whole_file(folder / CSV) as temporary:
        table.to_csv(temporary, index=False, lineterminator="\n")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        return [CSV]
    with whole_file(folder / PARQUET) as temporary:
        table.to_parquet(temporary, engine="pyarrow", index=False, compression="zstd")
    return [CSV, PARQUET]


def read_table(folder):
    """The rows of a study, from the journal, as a DataFrame."""
    path = Path(folder) / JOURNAL
    if not path.is_file():
        raise InputError(folder, f"no study: no {JOURNAL} there; `railcli sweep -o FOLDER` writes one")
    rows = {}
    with open(path, "rb") as file:
        for line in file:
            if (row := _row(line)) is not None:
                rows[row["run"]] = row
    return frame(rows)
