"""Ctrl-C, SIGTERM and SIGHUP: one way out for all three, at any moment, after which nothing of use is lost."""

import os
import signal
import sys
import threading
import time
from contextlib import contextmanager, suppress

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
PATIENCE = 5.0  # s: who asks again sooner disturbs the closing of files no more; later it ends at once
_first = None  # signal that was heard, and when
_swallowed = False
_holding = False


def listen():
    """Let each of the three raise KeyboardInterrupt; one that whoever started us ignores (nohup) stays ignored."""
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hear)
    sys.unraisablehook = _unraisable
    heard_at, tells_at = os.pipe()
    os.set_blocking(tells_at, False)
    signal.set_wakeup_fd(tells_at, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(heard_at,), daemon=True).start()


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
    global _holding
    pressed = []
    outer, _holding = _holding, True
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in SIGNALS}
        before = {number: handler for number, handler in before.items() if callable(handler)}
    for number in before:
        signal.signal(number, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        _holding = outer
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


def _watch(place):
    """End the process when its main thread hears nothing for long, as within the compiler; there is nothing to keep."""
    while number := os.read(place, 1)[0]:
        if number in SIGNALS and signal.getsignal(number) is not signal.SIG_IGN:
            time.sleep(PATIENCE)
            while _holding:
                time.sleep(0.1)
            if _first is None:
                with suppress(OSError, ValueError):
                    os.write(2, b"Interrupted.\n" if number == signal.SIGINT else b"Stopped.\n")
                os._exit(128 + number)


def _unraisable(problem):
    """What was raised where nobody can catch it, such as in a call from C, is raised again; else as Python does."""
    global _swallowed
    if issubclass(problem.exc_type, KeyboardInterrupt) and _first:
        import _thread

        _swallowed = True
        threading.Timer(0.01, _thread.interrupt_main, (_first[0],)).start()  # not within this very call
    else:
        sys.__unraisablehook__(problem)
