"""The command `railcli`, and `python -m railcli`: it can be stopped from its first moment on."""

import os
import sys

from railcli import interruption


def main():
    """Run the command and leave with its exit code."""
    interruption.listen()
    _open_streams()
    try:
        from railcli.cli import main as command

        command(prog_name="railcli")
    except BaseException as error:
        code = error.code if isinstance(error, SystemExit) else None
        if code is None and interruption.heard():
            code = interruption.exit_code()
            if sys.stderr:
                print(interruption.sentence(), file=sys.stderr)
        elif not isinstance(error, SystemExit):
            raise
        sys.exit(code)
    finally:
        interruption.deafen()


def _open_streams():
    """What is said goes nowhere where a stream is closed, and never into a file that took its place.

    A letter that the encoding of a terminal lacks is an escape.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) < 3:
        pass
    os.close(descriptor)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        getattr(sys, name).reconfigure(errors="backslashreplace")


if __name__ == "__main__":
    main()
