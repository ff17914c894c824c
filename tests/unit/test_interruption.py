"""Ctrl-C, SIGTERM and SIGHUP end a command at any moment, also where Python does not hear them."""

import os
import signal

import pytest

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of Unix")

START = """
import hashlib, os, signal, sys, threading, time
from railcli import interruption
interruption.PATIENCE = 0.3
interruption.listen()
def later(*numbers):
    def send():
        for number in numbers:
            time.sleep(0.1)
            os.kill(os.getpid(), number)
    threading.Thread(target=send, daemon=True).start()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_each_is_an_interrupt_with_its_exit_code(run_python, number):
    code = f"""import signal
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # below nohup it is ignored, and stays so
{START}
later({int(number)})
try:
    time.sleep(60)
except KeyboardInterrupt:
    print(interruption.sentence())
    sys.exit(interruption.exit_code())
"""
    done = run_python(code)
    words = "Interrupted." if number == signal.SIGINT else f"Stopped by {number.name}."
    assert (done.returncode, done.stdout.strip(), done.stderr) == (128 + number, words, "")


def test_a_second_one_does_not_disturb_the_closing_of_files(run_python):
    code = f"""{START}
interruption.PATIENCE = 60
later(signal.SIGINT, signal.SIGINT, signal.SIGTERM)
try:
    time.sleep(60)
except KeyboardInterrupt:
    time.sleep(1)
    print("closed")
"""
    assert run_python(code).stdout == "closed\n"


def test_where_python_does_not_hear_it_it_ends_all_the_same(run_python):
    """As within the compiler: minutes in C, during which no handler runs."""
    done = run_python(f"{START}\nlater(signal.SIGTERM)\nhashlib.pbkdf2_hmac('sha256', b'a', b'b', 10**9)")
    assert (done.returncode, done.stderr) == (143, "Stopped.\n")


def test_one_that_is_swallowed_is_raised_again(run_python):
    """An exception in a destructor reaches nobody."""
    code = f"""{START}
class Deaf:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000): pass
try:
    Deaf()
    time.sleep(10)
except KeyboardInterrupt:
    print("heard")
"""
    done = run_python(code)
    assert (done.stdout, done.stderr) == ("heard\n", "")


def test_one_that_is_ignored_stays_ignored(run_python):
    code = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)" + START + "os.kill(os.getpid(), signal.SIGHUP)"
    assert run_python(code).returncode == 0


def test_it_is_held_back_while_files_are_written(run_python):
    code = f"""{START}
try:
    with interruption.uninterrupted():
        later(signal.SIGTERM)
        time.sleep(1)
        print("written")
except KeyboardInterrupt:
    print(interruption.exit_code())
"""
    assert run_python(code).stdout.split() == ["written", "143"]
