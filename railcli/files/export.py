"""Results for other programs: CSV and Parquet written piece by piece, MAT written channel by channel."""

import re

from railcli.errors import InputError

from .columns import pieces
from .extras import optional
from .output import json_text, whole_file

KINDS = ("csv", "parquet", "mat")
MAT_BYTES = 2**31 - 2**10  # MAT 5 counts the bytes of a variable, and those of its head, in 31 bits
MAT_NAME = 63  # letters of a name that MATLAB knows


def export(results, chosen, path, kind, progress=lambda rows: None):
    """Write some columns of a result, whole or not at all.

    Parameters
    ----------
    results : Results
    chosen : sequence of Column
    path : path-like
    kind : str
        One of KINDS.
    progress : callable
        Is told how many rows (of a MAT file: of all rows the share that matches the channels) are done.

    Raises
    ------
    InputError
        The extra of Parquet is missing, MAT cannot hold so many rows, or the file cannot be written.
    """
    {"csv": _csv, "parquet": _parquet, "mat": _mat}[kind](results, chosen, path, progress)


def origin(results):
    """Where an exported table comes from, as JSON text."""
    return json_text({"folder": results.folder.name, "provenance": results.provenance})


def _csv(results, chosen, path, progress):
    import pandas

    labels = [column.label for column in chosen]
    rows = 0
    with whole_file(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        for values in pieces(results, chosen):
            frame = pandas.DataFrame(dict(zip(labels, values, strict=True)), copy=False)
            frame.to_csv(file, header=rows == 0, index=False, lineterminator="\n")
            progress(rows := rows + len(frame))


def _parquet(results, chosen, path, progress):
    arrow = optional("pyarrow", "parquet", "Parquet")
    parquet = optional("pyarrow.parquet", "parquet", "Parquet")
    schema = arrow.schema(
        [
            arrow.field(column.label, arrow.float64(), metadata={"units": column.units, "about": column.description})
            for column in chosen
        ],
        metadata={"railcli": origin(results)},
    )
    rows = 0
    with (
        whole_file(path) as temporary,
        open(temporary, "wb") as file,
        parquet.ParquetWriter(file, schema, compression="zstd") as writer,
    ):
        for values in pieces(results, chosen):
            batch = arrow.record_batch([arrow.array(value, arrow.float64()) for value in values], schema)
            writer.write_batch(batch, row_group_size=batch.num_rows)
            progress(rows := rows + batch.num_rows)


def _mat(results, chosen, path, progress):
    """One variable for each column, then structures of the same fields that tell units and names."""
    from scipy.io import savemat

    if 8 * results.rows > MAT_BYTES:
        most = f"a variable of a MAT file holds at most {MAT_BYTES // 8:,} rows"
        raise InputError(path, f"{most}, here are {results.rows:,}; take CSV or Parquet")
    names = _mat_names(chosen)
    with whole_file(path) as temporary, open(temporary, "wb") as file:

        def save(**variables):  # appended: SciPy writes the head of a file only where it begins
            savemat(file, variables, do_compression=True, oned_as="column", long_field_names=True)

        kept, values = None, None
        for k, (column, name) in enumerate(zip(chosen, names, strict=True)):
            if column.channel != kept:
                kept, values = column.channel, results.read(column.channel)
            save(**{name: column.of(values)})
            progress(results.rows * (k + 1) // len(chosen))
        save(
            units={name: column.units for column, name in zip(chosen, names, strict=True)},
            channels={name: column.name for column, name in zip(chosen, names, strict=True)},
            origin=origin(results),
        )


def _mat_names(chosen):
    """Names of variables: letters, digits and underscores, begun by a letter, no two alike."""
    names = []
    for column in chosen:
        name = stem = re.sub(r"[^A-Za-z0-9]+", "_", column.name).strip("_")[-MAT_NAME:].lstrip("_0123456789") or "x"
        count = 1
        while name in (*names, "units", "channels", "origin"):
            count += 1
            name = f"{stem[: MAT_NAME - 1 - len(str(count))]}_{count}"
        names.append(name)
    return names
