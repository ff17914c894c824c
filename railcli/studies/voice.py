"""What a study tells while it works: announcements, warnings, and how far a job has come."""

import warnings
from contextlib import contextmanager


class Voice:
    """Silent but for warnings; whoever starts a study gives it another voice to hear more.

    Notes
    -----
    A job is a context manager whose `update(done, text)` says how much is done, in the unit of its total.
    """

    def announce(self, text):
        """Take a sentence that says what a wait is for."""

    def warn(self, text):
        """Take a sentence that doubts a result."""
        warnings.warn(text, RuntimeWarning, stacklevel=3)

    @contextmanager
    def job(self, title, total, unit):
        """Begin a job; gives what has `update`.

        Parameters
        ----------
        title : str
            Such as ``Contact table``.
        total : float
            Amount of work.
        unit : str
            What is counted, such as ``s``; ``%`` for a share.
        """
        yield Job(lambda done, text: None)


class Job:
    """How far a job has come goes to a function: of the amount done, and a text."""

    def __init__(self, tell):
        self._tell = tell

    def update(self, done, text=""):
        self._tell(done, text)


class Told(Voice):
    """Calls a function with the title of a job, the share of it that is done, and a text."""

    def __init__(self, progress):
        self._progress = progress

    @contextmanager
    def job(self, title, total, unit):
        yield Job(lambda done, text: self._progress(title, min(done / total, 1.0), text))
        self._progress(title, 1.0, "")


SILENT = Voice()
