"""Periods begin by the clock; what the system grants is said, and taken back."""

import ctypes
import errno
import gc
import os
import sys

import pytest

from railcli.runtime import pacing
from railcli.runtime.pacing import NOT_ASKED, NOT_AVAILABLE, Granted, Metronome, real_time, undisturbed

PERIOD = 1_000_000


class Clock:
    """Time that passes by sleeping (a little longer than asked), working and reading the clock."""

    def __init__(self, oversleep=0):
        self.now, self.oversleep, self.slept = 5_000_000_000, oversleep, []

    def __call__(self):
        self.now += 10
        return self.now

    def sleep(self, seconds):
        self.slept.append(round(seconds * 1e9))
        self.now += self.slept[-1] + self.oversleep


def cycles(clock, works, spin=0):
    """When each period was due and began, counted from the start, while each has some work [ns]."""
    metronome = Metronome(PERIOD, spin, clock, clock.sleep)
    metronome.start()
    start, found = clock.now, []
    for work in works:
        due, began = metronome.wait()
        found.append((due - start, began - start))
        clock.now += work
    return found


@pytest.mark.parametrize("oversleep", [-400_000, -1, 0, 1, 120_000])
def test_periods_are_counted_from_the_start_and_none_begins_early(oversleep):
    found = cycles(Clock(oversleep), [300_000] * 20)
    assert [due for due, _ in found] == [PERIOD * (k + 1) for k in range(20)]
    assert all(due <= began <= due + max(oversleep, 0) + 20 for due, began in found)


def test_spinning_hides_a_sleep_that_lasts_too_long():
    late = [began - due for due, began in cycles(Clock(120_000), [300_000] * 5)]
    spun = [began - due for due, began in cycles(Clock(120_000), [300_000] * 5, spin=150_000)]
    assert min(late) >= 120_000
    assert max(spun) <= 10


def test_missed_period_begins_late_and_the_next_ones_catch_up():
    clock = Clock()
    found = cycles(clock, [3_400_000, 100_000, 100_000, 100_000, 100_000, 100_000])
    late = [began - due for due, began in found]
    assert late[0] < 100
    assert [round(value, -5) for value in late[1:4]] == [2_400_000, 1_500_000, 600_000]
    assert late[4] < 100 and late[5] < 100
    assert len(clock.slept) == 3


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
@pytest.mark.parametrize("was_on", [True, False])
def test_garbage_is_collected_again_afterwards(error, was_on):
    before = gc.isenabled()
    try:
        (gc.enable if was_on else gc.disable)()
        try:
            with undisturbed():
                assert not gc.isenabled()
                if error:
                    raise error
        except KeyboardInterrupt:
            pass
        assert gc.isenabled() == was_on
        assert gc.get_freeze_count() == 0
    finally:
        (gc.enable if before else gc.disable)()


# What the system grants


class Memory:
    """The C library, as far as it locks memory."""

    def __init__(self, answer):
        self.answer, self.called = answer, []

    def mlockall(self, flags):
        ctypes.set_errno(errno.ENOMEM)
        self.called.append("lock")
        return self.answer

    def munlockall(self):
        self.called.append("unlock")


@pytest.fixture
def linux(monkeypatch):
    """Function that puts a system in place which grants, or refuses; gives what it was asked."""

    def pretend(grants):
        asked, memory = [], Memory(0 if grants else -1)

        def schedule(pid, policy, param):
            asked.append((pid, policy, param))
            if not grants:
                raise PermissionError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(sys, "platform", "linux")
        for name, value in (
            ("SCHED_FIFO", "fifo"),
            ("sched_param", int),
            ("sched_getscheduler", lambda pid: "other"),
            ("sched_getparam", lambda pid: "nice"),
            ("sched_setscheduler", schedule),
        ):
            monkeypatch.setattr(os, name, value, raising=False)
        monkeypatch.setattr(pacing.ctypes, "CDLL", lambda *_, **__: memory)
        return asked, memory.called

    return pretend


@pytest.mark.parametrize("error", [None, KeyboardInterrupt, ValueError])
def test_what_is_granted_is_taken_back(linux, error):
    asked, memory = linux(grants=True)
    try:
        with real_time() as granted:
            assert asked == [(0, "fifo", pacing.PRIORITY)] and memory == ["lock"]
            assert granted.scheduling.startswith("granted") and granted.memory.startswith("granted")
            if error:
                raise error
    except (KeyboardInterrupt, ValueError):
        pass
    assert asked[1:] == [(0, "other", "nice")]
    assert memory == ["lock", "unlock"]


def test_refusal_says_why_and_what_is_needed(linux):
    asked, memory = linux(grants=False)
    with real_time() as granted:
        assert granted.scheduling.startswith(f"not granted ({os.strerror(errno.EPERM)})")
        assert "ulimit -r" in granted.scheduling
        assert granted.memory.startswith(f"not granted ({os.strerror(errno.ENOMEM)})") and "ulimit -l" in granted.memory
    assert len(asked) == 1 and memory == ["lock"]


def test_nothing_is_asked_unasked(linux):
    asked, memory = linux(grants=True)
    with real_time(False) as granted:
        assert granted == Granted(NOT_ASKED, NOT_ASKED)
    assert asked == memory == []


def test_other_systems_say_that_they_have_none(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.delattr(os, "sched_setscheduler", raising=False)
    with real_time() as granted:
        assert granted == Granted(NOT_AVAILABLE, NOT_AVAILABLE)


@pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="this system has no real-time scheduling")
def test_scheduler_of_this_system_is_restored():
    before = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
    with real_time() as granted:
        inside = os.sched_getscheduler(0)
    assert (inside == os.SCHED_FIFO) == granted.scheduling.startswith("granted")
    assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == before
