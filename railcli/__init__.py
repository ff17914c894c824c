"""railcli: three-dimensional railway vehicle dynamics in real time, open and checkable."""

__version__ = "0.1.0"


def open_results(path, *channels, filtered=False):
    """Time series of a results folder as a pandas DataFrame.

    Parameters
    ----------
    path : path-like
        Folder that `railcli run` wrote, or the file of time series in it.
    *channels : str
        Globs of the channels to read, such as ``"wheels/*/Q"``; all without any.
    filtered : bool
        The low-passed rows at a fixed rate, of which an assessment is made, instead of those of the output interval.

    Returns
    -------
    pandas.DataFrame
        A row for each recorded instant, its index the time [s]. Columns are named by channel, component and unit, such
        as ``wheels/W1_right/Q [N]`` and ``bodies/car body/position/y [m]``; SI, in track axes: x forward, y to the
        right, z down; forces of a wheel act on its rail.

    Raises
    ------
    railcli.errors.InputError
        There is no result, it is damaged, or holds no such channel.

    Examples
    --------
    >>> frame = railcli.open_results("results", "wheels/*/Q")  # doctest: +SKIP
    >>> frame.plot()  # doctest: +SKIP
    """
    from railcli.files.columns import chosen_rows, columns, data_frame
    from railcli.files.read_results import Results

    with Results(path) as results:
        rows = chosen_rows(results, filtered)
        return data_frame(rows, columns(rows, channels))
