"""The command `railcli`, and `python -m railcli`: it can be stopped from its first moment on."""

import sys

from railcli import interruption


def main():
    """Run the command and leave with its exit code."""
    interruption.listen()
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


if __name__ == "__main__":
    main()
