"""Ctrl-C, SIGTERM and SIGHUP: one way out for all three, at any moment, after which nothing of use is lost."""

import os
import signal
import sys
import threading
import time
from contextlib import contextmanager

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
PATIENCE = 5.0  # s: who asks again sooner disturbs the closing of files no more; later it ends at once
_first = None  # signal that was heard, and when
_swallowed = False


def listen():
    """Let each of the three raise KeyboardInterrupt; one that whoever started us ignores (nohup) stays ignored."""
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hear)
    sys.unraisablehook = _unraisable


def deafen():
    """Hear none of them from now on: all is done, or being told."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def heard():
    """The signal that asked for the end; None when none did."""
    return _first and _first[0]


def exit_code():
    """128 and the number of the signal: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return 128 + (heard() or signal.SIGINT)


def sentence():
    """What happened, for the user."""
    number = heard()
    return "Interrupted." if number in (None, signal.SIGINT) else f"Stopped by {signal.Signals(number).name}."


@contextmanager
def uninterrupted():
    """Hold the three back until the block is done."""
    pressed = []
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in SIGNALS}
        before = {number: handler for number, handler in before.items() if callable(handler)}
    for number in before:
        signal.signal(number, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if pressed:
            before[pressed[0]](pressed[0], None)


def _hear(number, frame):
    global _first, _swallowed
    now = time.monotonic()
    if _first is None or _swallowed:
        _first, _swallowed = _first or (signal.Signals(number), now), False
        raise KeyboardInterrupt
    if now - _first[1] > PATIENCE:
        os._exit(exit_code())


def _unraisable(problem):
    """What was raised where nobody can catch it, such as in a call from C, is raised again; else as Python does."""
    global _swallowed
    if isinstance(problem.exc_value, KeyboardInterrupt) and _first:
        import _thread

        _swallowed = True
        _thread.interrupt_main(_first[0])
    else:
        sys.__unraisablehook__(problem)
