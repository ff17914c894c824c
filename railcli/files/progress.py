"""Progress on stderr: a bar on a terminal, an occasional line elsewhere, nothing when quiet."""

import os
import sys
import time

from railcli.errors import harmless

BAR_WIDTH = 30


class Progress:
    """Progress of one job, as a context manager.

    Parameters
    ----------
    title : str
        What is being done, such as ``Contact table``.
    total : float
        Amount of work, in `unit`.
    unit : str
        What is counted, such as ``positions`` or ``s``.
    quiet : bool
        Show nothing.

    Examples
    --------
    >>> with Progress("Run", total=25.0, unit="s", quiet=True) as progress:
    ...     progress.update(12.5, "80 x real time")
    """

    def __init__(self, title, total, unit, quiet=False):
        self._title = title
        self._total = total
        self._unit = unit
        self._quiet = quiet

    def __enter__(self):
        self._view = None if self._quiet else _Bar(self._title) if _on_terminal() else _Lines(self._title)
        self._start = self._shown = time.monotonic()
        self._done, self._text, self._told_end = 0, "", False
        return self

    def update(self, done, text=""):
        """Say how much is done.

        Parameters
        ----------
        done : float
            Work done since the start, in the unit of the total.
        text : str
            Anything else worth seeing, such as the simulated time and the real-time factor.
        """
        self._done, self._text = done, text
        if self._view and not self._told_end and time.monotonic() - self._shown >= self._view.interval:
            self._show()

    def __exit__(self, *_):
        if self._view:
            if not self._told_end and self._view.shows_end(time.monotonic() - self._start):
                self._show()
            self._view.close()

    def _show(self):
        self._shown = time.monotonic()
        elapsed = max(self._shown - self._start, 1e-9)
        rate = self._done / elapsed
        parts = [f"{_number(rate)} {self._unit}/s"]
        self._told_end = self._done >= self._total
        if self._told_end:
            parts.append(f"{_clock(elapsed)} taken")
        elif rate > 0:
            parts.append(f"{_clock((self._total - self._done) / rate)} left")
        share = min(self._done / self._total, 1.0) if self._total else 1.0
        self._view.show(share, ", ".join([*parts, *filter(None, [self._text])]))


class _Lines:
    """Lines for a log file: none for a short job, then one every few seconds and one at the end."""

    interval = 5.0

    def __init__(self, title):
        self._title = title

    def show(self, share, text):
        print(harmless(f"{self._title}: {share:.0%}, {text}"), file=sys.stderr, flush=True)

    def shows_end(self, elapsed):
        return elapsed >= self.interval

    def close(self):
        pass


class _Bar:
    """A bar that is redrawn by `show` only, so that no thread disturbs what is being timed."""

    interval = 0.1

    def __init__(self, title):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

        self._bar = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(BAR_WIDTH),
            TaskProgressColumn(),
            TextColumn("{task.fields[text]}", markup=False),
            console=Console(stderr=True),
            auto_refresh=False,
            redirect_stdout=False,
        )
        self._task = self._bar.add_task(harmless(title, ""), total=1.0, text="")
        self._bar.start()

    def show(self, share, text):
        self._bar.update(self._task, completed=share, text=harmless(text, ""), refresh=True)

    def shows_end(self, elapsed):
        return True

    def close(self):
        self._bar.stop()


def _on_terminal():
    return sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


def _number(value):
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _clock(seconds):
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
