"""A process that makes runs of a study: `python -m railcli.studies.sweep.worker FOLDER`.

It reads a task a line from stdin and writes a row a line to stdout, both JSON, and ends when stdin does: with whoever
started it, however that ends.
"""

import json
import signal
import sys
from pathlib import Path

from railcli.errors import RailcliError
from railcli.files.sweep import kept
from railcli.model.assessment import Limits
from railcli.model.study import Study
from railcli.studies.voice import Voice

from .one_run import Given, Runner


class _Reported(Voice):
    """Hands on what runs tell, each sentence once."""

    def __init__(self):
        self._told = set()

    def announce(self, text):
        self._tell("announce", text)

    def warn(self, text):
        self._tell("warn", text)

    def _tell(self, kind, text):
        if text not in self._told:
            self._told.add(text)
            say({kind: text})


def given(folder):
    """What all runs of the study in a folder have in common."""
    record, scenario = kept(Path(folder))
    study = Study.model_validate(record["study"], by_alias=True, by_name=False)
    limits = Limits.model_validate(record["identity"]["limits"], by_alias=True, by_name=False)
    return Given(study, scenario, limits)


def say(message):
    """Write a line of JSON."""
    sys.stdout.write(json.dumps(message, allow_nan=False) + "\n")
    sys.stdout.flush()


def main(folder):
    """Answer tasks until there are none."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started this process ends it
    try:
        runner = Runner(given(folder), _Reported())
        for line in sys.stdin:
            say({"row": runner.row(*json.loads(line))})
    except RailcliError as error:
        say({"error": str(error)})


if __name__ == "__main__":
    main(sys.argv[1])
