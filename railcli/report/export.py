"""What a result holds, as a list for readers."""

from .text import columns


def listing(results, chosen):
    """Lines that name channels with unit and meaning; the components of a channel share a line.

    Parameters
    ----------
    results : Results
    chosen : sequence of Column
    """
    rows = {}
    for column in chosen:
        components = results.channels[column.channel].components
        name = f"{column.channel}/{{{','.join(components)}}}" if components else column.channel
        rows[name] = (name, f"[{column.units}]", column.description)
    lines = columns([row[:2] for row in rows.values()])
    return [f"{line}  {row[2]}" for line, row in zip(lines, rows.values(), strict=True)]
