"""Which input of a sample moves an output: Sobol indices, by SALib.

Of a sample of ``sobol-indices`` the first-order index S1 (share of the output's variance that an input alone explains)
and the total index ST (that it explains with all others) of Saltelli et al. 2010; of other samples S1 by random balance
designs (Tarantola et al. 2006, Plischke 2010).
"""

from typing import NamedTuple

import numpy as np

from railcli.files.extras import optional

RESAMPLES = 200  # of the bootstrap
CONFIDENCE = 0.95
SEED = 1
LEAST = 64  # rows from which indices mean anything
WHERE = "Sobol indices"
NOTHING = 1e-12  # spread, as a share of the size, below which an output does not vary


class Indices(NamedTuple):
    """Of one output; arrays (n_inputs,), half widths of the 95 % intervals beside them.

    `total` and `total_within` are None where the sample gives none; `rows` are those that were used.
    """

    first: np.ndarray
    first_within: np.ndarray
    total: np.ndarray | None
    total_within: np.ndarray | None
    rows: int


def indices(study, design, table, outputs):
    """Indices by output, of those of a sample that vary.

    Raises
    ------
    InputError
        SALib is not installed.
    """
    inputs = [one.name for one in study.parameters if one.is_sampled]
    if not inputs or len(inputs) < len(study.parameters) or study.seeds is not None:
        return {}
    optional("SALib", "sensitivity", WHERE)
    x = np.stack([table[name].to_numpy(float) for name in inputs], axis=1)
    found = {}
    for name in outputs:
        y = table[name].to_numpy(float)
        one = _of_mixtures(inputs, y) if study.sample.method == "sobol-indices" else _of_any(inputs, x, y)
        if one is not None:
            found[name] = one
    return found


def _problem(inputs):
    return {"num_vars": len(inputs), "names": list(inputs), "bounds": [[0.0, 1.0]] * len(inputs)}


def _varies(y):
    return y.size >= LEAST and np.ptp(y) > NOTHING * np.abs(y).max()


def _of_mixtures(inputs, y):
    """By base points whose mixtures all have a value."""
    from SALib.analyze import sobol

    blocks = y.reshape(-1, len(inputs) + 2)
    blocks = blocks[np.isfinite(blocks).all(axis=1)]
    if not _varies(blocks.ravel()):
        return None
    options = {"num_resamples": RESAMPLES, "conf_level": CONFIDENCE, "seed": SEED, "calc_second_order": False}
    found = sobol.analyze(_problem(inputs), blocks.ravel(), **options)
    return Indices(*(np.asarray(found[key]) for key in ("S1", "S1_conf", "ST", "ST_conf")), blocks.size)


def _of_any(inputs, x, y):
    from SALib.analyze import rbd_fast

    there = np.isfinite(y)
    if not _varies(y[there]):
        return None
    options = {"num_resamples": RESAMPLES, "conf_level": CONFIDENCE, "seed": SEED}
    found = rbd_fast.analyze(_problem(inputs), x[there], y[there], **options)
    return Indices(np.asarray(found["S1"]), np.asarray(found["S1_conf"]), None, None, int(there.sum()))


def rows(inputs, found):
    """Rows of text: output, then S1 and ST of each input."""
    lines = []
    for output, one in found.items():
        cells = []
        for k in range(len(inputs)):
            text = f"{one.first[k]:.2f} +- {one.first_within[k]:.2f}"
            cells.append(text if one.total is None else f"{text} / {one.total[k]:.2f} +- {one.total_within[k]:.2f}")
        lines.append([output, *cells])
    return lines
