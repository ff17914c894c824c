"""Settings of scenarios side by side: flat, and only where they differ."""

WORDS = ("title", "description")  # of a scenario or vehicle: they decide nothing


def flat(value, name=""):
    """A nested table as {`vehicle.body[1].mass_kg`: value}; entries of lists of tables count from 1.

    Parameters
    ----------
    value : dict, list or plain value
    name : str
        In front of every key.
    """
    if isinstance(value, dict):
        parts = ((f"{name}.{key}" if name else str(key), part) for key, part in value.items())
    elif isinstance(value, list) and any(isinstance(part, dict) for part in value):
        parts = ((f"{name}[{k}]", part) for k, part in enumerate(value, start=1))
    else:
        return {name: value}
    return {key: found for place, part in parts for key, found in flat(part, place).items()}


def differing(tables):
    """Rows (key, value of each table) of the keys whose values are not the same in all; None where one has none.

    Titles and descriptions are left out.
    """
    flats = [flat(table) for table in tables]
    keys = dict.fromkeys(key for one in flats for key in one)
    rows = [(key, *(one.get(key) for one in flats)) for key in keys]
    return [row for row in rows if row[0].split(".")[-1] not in WORDS and any(value != row[1] for value in row[2:])]


def shown(value):
    """A setting as a reader sees it."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, list):
        return ", ".join(shown(part) for part in value)
    return str(value)
