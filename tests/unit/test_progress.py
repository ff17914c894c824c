"""Progress goes to stderr, seldom where it is kept in a file, never when quiet."""

import pytest

from railcli.files import progress
from railcli.files.progress import Progress


class Clock:
    def __init__(self):
        self.now = 100.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(progress, "time", clock)
    return clock


def work(clock, steps=40, seconds=1.0, **options):
    with Progress("Run", total=steps, unit="s", **options) as job:
        for step in range(1, steps + 1):
            clock.now += seconds
            job.update(step, f"{step} x real time")


def test_long_job_gives_a_line_every_few_seconds(clock, capsys):
    work(clock)
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.splitlines()
    assert lines[0] == "Run: 12%, 1 s/s, 0:35 left, 5 x real time"
    assert lines[-1] == "Run: 100%, 1 s/s, 0:40 taken, 40 x real time"
    assert len(lines) <= 40 / progress._Lines.interval + 1
    assert sum(line.startswith("Run: 100%") for line in lines) == 1


def test_short_job_is_silent_in_a_log(clock, capsys):
    work(clock, seconds=0.01)
    assert capsys.readouterr() == ("", "")


def test_quiet_is_silent(clock, capsys):
    work(clock, quiet=True)
    assert capsys.readouterr() == ("", "")


def test_terminal_gets_a_bar_on_stderr(clock, capsys, monkeypatch):
    monkeypatch.setattr(progress, "_on_terminal", lambda: True)
    monkeypatch.setenv("COLUMNS", "120")
    work(clock)
    out, err = capsys.readouterr()
    assert out == ""
    assert "100%" in err and "40 x real time" in err


def test_job_that_ends_early_says_how_far_it_came(clock, capsys):
    with pytest.raises(KeyboardInterrupt), Progress("Run", total=100, unit="s") as job:
        clock.now += 20.0
        job.update(10)
        clock.now += 1.0
        raise KeyboardInterrupt
    assert capsys.readouterr().err.splitlines()[-1].startswith("Run: 10%, ")


def test_nothing_to_do_is_done(clock, capsys):
    work(clock, steps=0)
    assert capsys.readouterr() == ("", "")
