"""Runs of a study by processes of this machine."""

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from pathlib import Path

from railcli.errors import InputError

TRIES = 2  # of a run at which a process ends
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
PATIENCE = 0.5  # between two looks at whether the user wants to end [s]
LAST_WORDS = 300  # letters of what a process said before it ended


class Processes:
    """Some processes that make runs; used as a context manager.

    Parameters
    ----------
    folder : pathlib.Path
        Of the study.
    count : int
    voice : Voice
    """

    def __init__(self, folder, count, voice):
        self._folder, self._count, self._voice = folder, count, voice
        self.about = f"{count} process{'es' * (count != 1)}"

    def __enter__(self):
        self._answers, self._lock, self._ended = queue.Queue(), threading.Lock(), False
        self._running = []
        return self

    def rows(self, tasks):
        """Yield the row of every task as it is finished.

        Parameters
        ----------
        tasks : iterator of tuple
            Number, inputs and changes of a run (one_run.Runner.row).

        Raises
        ------
        InputError
            A process cannot work, so nor can the rest of the study.
        """
        self._tasks = iter(tasks)
        threads = [threading.Thread(target=self._serve, daemon=True) for _ in range(self._count)]
        for thread in threads:
            thread.start()
        told, open_ends = set(), len(threads)
        while open_ends:
            try:
                kind, what = self._answers.get(timeout=PATIENCE)
            except queue.Empty:
                continue
            if kind == "row":
                yield what
            elif kind == "end":
                open_ends -= 1
            elif kind == "error":
                raise what
            elif what not in told:
                told.add(what)
                getattr(self._voice, kind)(what)

    def __exit__(self, *_):
        self._ended = True
        with self._lock:
            for process in self._running:
                with suppress(OSError):
                    process.kill()
        for process in self._running:
            process.wait()

    def _next(self):
        with self._lock:
            return None if self._ended else next(self._tasks, None)

    def _serve(self):
        """Give one process after the other its tasks; a new one takes over where one ended."""
        try:
            task, tries = self._next(), 0
            while task is not None:
                task, tries = self._with_process(task, tries)
        except BaseException as error:
            self._answers.put(("error", error))
        self._answers.put(("end", None))

    def _with_process(self, task, tries):
        """Have one process work off tasks; the task at which it ended with its tries, (None, 0) without."""
        with tempfile.TemporaryFile() as errors:
            process = self._started(errors)
            try:
                while task is not None:
                    row = self._answer(process, task)
                    if row is None:
                        return self._after_end(process, errors, task, tries + 1)
                    self._answers.put(("row", row))
                    task, tries = self._next(), 0
            finally:
                self._close(process)
        return None, 0

    def _started(self, errors):
        place = str(Path(__file__).parents[3])
        path = os.pathsep.join(filter(None, [place, os.environ.get("PYTHONPATH")]))
        process = subprocess.Popen(
            [sys.executable, "-m", "railcli.studies.sweep.worker", str(self._folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True, encoding="utf-8",
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
        )  # fmt: skip
        with self._lock:
            self._running.append(process)
        return process

    def _answer(self, process, task):
        """The row of a task; None when the process ended at it."""
        try:
            process.stdin.write(json.dumps(task) + "\n")
            process.stdin.flush()
        except OSError:
            pass  # its last words are still to be read
        for line in process.stdout:
            try:
                (kind, what), *_ = json.loads(line).items()
            except ValueError:
                return None
            if kind == "row":
                return what
            if kind == "error":
                where, _, message = what.partition(": ")
                raise InputError(where, message)
            self._answers.put((kind, what))
        return None

    def _after_end(self, process, errors, task, tries):
        if self._ended:
            return None, 0
        code = process.wait()
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        errors.seek(0)
        words = " ".join(errors.read().decode(errors="replace").split())[-LAST_WORDS:]
        if tries < TRIES:
            self._answers.put(("announce", f"A process ended at run {task[0]} ({how}); another one takes it up."))
            return task, tries
        self._answers.put(("row", lost(task, f"{TRIES} processes ended at this run ({how}) {words}".strip())))
        return self._next(), 0

    def _close(self, process):
        with suppress(OSError):
            process.stdin.close()
        if not self._ended:
            process.wait()
        process.stdout.close()
        with self._lock:
            self._running.remove(process)


def lost(task, cause):
    """The row of a run at which whatever made it ended."""
    number, inputs, _ = task
    return {"run": number, "inputs": inputs, "outputs": {}, "status": "failed", "verdict": "", "cause": cause,
            "cpu_s": 0.0, "time_s": 0.0}  # fmt: skip
