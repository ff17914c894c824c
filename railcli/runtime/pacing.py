"""Keeping time: periods that begin by the clock, and what the system grants against interruptions."""

import ctypes
import gc
import os
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

PRIORITY = 50  # of 1 ... 99; interrupt threads of the kernel have 50 too, its watchdogs 99
LOCK_NOW, LOCK_LATER = 1, 2  # MCL_CURRENT and MCL_FUTURE of mlockall(2)
NOT_ASKED = "not asked for"
NOT_AVAILABLE = "not available on this system"


class Metronome:
    """Waits for the beginning of one period after the other, always counted from the start.

    A period that is missed is not skipped: it begins late, and the next ones try to catch up.

    Parameters
    ----------
    period : int
        [ns]
    spin : int
        Sleep only until so long before the beginning, then watch the clock [ns].
    clock, sleep : callable
        Time now [ns]; waits for some seconds.
    """

    def __init__(self, period, spin=0, clock=time.perf_counter_ns, sleep=time.sleep):
        self._period, self._spin, self._clock, self._sleep = period, spin, clock, sleep

    def start(self):
        """The first period begins one period from now."""
        self._due = self._clock() + self._period

    def wait(self):
        """Wait for the next period; returns when it had to begin and when it does [ns]."""
        due = self._due
        self._due += self._period
        left = due - self._clock() - self._spin
        if left > 0:
            self._sleep(left * 1e-9)
        while (now := self._clock()) < due:
            pass
        return due, now


@contextmanager
def undisturbed():
    """No garbage collection within the block."""
    was_on = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if was_on:
            gc.enable()


@dataclass(frozen=True)
class Granted:
    """What the system said, for readers: real-time scheduling of this thread, and memory kept from being paged out."""

    scheduling: str = NOT_ASKED
    memory: str = NOT_ASKED


@contextmanager
def real_time(asked=True):
    """Within the block, real-time scheduling and locked memory as far as the system permits; afterwards as before.

    Yields
    ------
    Granted
    """
    with ExitStack() as undo:
        yield Granted(_schedule(undo), _lock_memory(undo)) if asked else Granted()


def _schedule(undo):
    if not hasattr(os, "sched_setscheduler"):
        return NOT_AVAILABLE
    try:
        before = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError as error:
        return _refused(error.errno, "needs root, CAP_SYS_NICE or a limit on rtprio above 0 (ulimit -r)")
    undo.callback(os.sched_setscheduler, 0, *before)
    return f"granted, SCHED_FIFO with priority {PRIORITY}"


def _lock_memory(undo):
    if not sys.platform.startswith("linux"):
        return NOT_AVAILABLE
    system = ctypes.CDLL(None, use_errno=True)
    if system.mlockall(LOCK_NOW | LOCK_LATER) != 0:
        return _refused(ctypes.get_errno(), "needs root, CAP_IPC_LOCK or a larger limit on memlock (ulimit -l)")
    undo.callback(system.munlockall)
    return "granted, all pages locked"


def _refused(number, needs):
    return f"not granted ({os.strerror(number)}); {needs}"
