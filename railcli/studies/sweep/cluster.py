"""Runs of a study by the workers of a dask scheduler that is there already.

Sent are the study and its scenario with all that it was made from, once, and for each run its number and values. Rows
come back. Tasks are functions of `cluster_task`, so that a worker needs railcli of the same version and nothing else.
"""

from railcli import __version__
from railcli.errors import InputError, SimulationError
from railcli.files.extras import optional
from railcli.files.sweep import packed
from railcli.kernels import jit

from . import cluster_task
from .processes import lost

PATIENCE = 20.0  # to find the scheduler, and at least one worker [s]
AHEAD = 3  # tasks for each thread that wait or run


class Cluster:
    """The workers of a dask scheduler; used as a context manager.

    Parameters
    ----------
    address : str
        ``tcp://HOST:PORT``.
    folder : pathlib.Path
        Of the study.
    voice : Voice

    Raises
    ------
    InputError
        dask is not installed; the scheduler is not there, has no workers, or they are of another version.
    """

    def __init__(self, address, folder, voice):
        self._distributed = optional("distributed", "cluster", "--scheduler")
        self._where, self._folder, self._voice = f"--scheduler {address}", folder, voice
        self._address = address

    def __enter__(self):
        try:
            self._client = self._distributed.Client(self._address, timeout=PATIENCE, set_as_default=False)
        except (TimeoutError, OSError, ValueError) as error:
            words = " ".join(str(error).split())[:120]
            raise InputError(
                self._where, f"no scheduler answers there ({words}); start one with `dask scheduler`, and workers with "
                "`dask worker ADDRESS`"
            ) from None  # fmt: skip
        try:
            self._threads = self._checked()
        except BaseException:
            self._client.close()
            raise
        return self

    def __exit__(self, *_):
        self._client.close()

    def _checked(self):
        """Threads of the workers, all of which run the same railcli as this process."""
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(self._where, "has no workers; start some with `dask worker ADDRESS`") from None
        ours = cluster_task.versions()
        try:
            theirs = self._client.run(cluster_task.versions)
        except Exception as error:  # whatever a worker raises that cannot load railcli
            raise InputError(
                self._where, f"its workers do not run railcli {__version__} ({type(error).__name__}: "
                f"{' '.join(str(error).split())[:160]}); install it in their environment"
            ) from None  # fmt: skip
        for worker, found in theirs.items():
            other = [f"{name} {found.get(name)}, not {one}" for name, one in ours.items() if found.get(name) != one]
            if other:
                raise InputError(
                    self._where, f"worker {worker} is of another version: {'; '.join(other)}; rows would not be alike: "
                    "install the same everywhere"
                )  # fmt: skip
        threads = self._client.nthreads()
        self._voice.announce(f"{len(threads)} workers with {sum(threads.values())} threads at {self._address}.")
        return max(1, sum(threads.values()))

    def rows(self, tasks):
        """Yield the row of every task as it is finished; parameters as of `processes.Processes.rows`.

        Raises
        ------
        SimulationError
            The scheduler went away.
        """
        from distributed import as_completed

        package, tasks = packed(self._folder), iter(tasks)
        study = self._client.submit(cluster_task.unpacked, package, key=f"railcli-{jit.source_digest()[:8]}-{id(self)}")
        running, waiting = {}, as_completed(loop=self._client.loop)

        def send():
            task = next(tasks, None)
            if task is not None:
                future = self._client.submit(cluster_task.row, study, task, pure=False)
                running[future.key] = task
                waiting.add(future)

        try:
            for _ in range(AHEAD * self._threads):
                send()
            for future in waiting:
                task = running.pop(future.key)
                yield self._row(future, task)
                send()
        except (OSError, self._distributed.CancelledError, self._distributed.comm.CommClosedError) as error:
            raise SimulationError(
                f"{self._where}: the scheduler went away ({type(error).__name__}); what was made is kept, the same "
                "command goes on"
            ) from None  # fmt: skip

    def _row(self, future, task):
        if future.status == "finished":
            return future.result()
        error = future.exception() if future.status == "error" else self._distributed.CancelledError(future.key)
        if isinstance(error, self._distributed.KilledWorker):
            return lost(task, f"every worker ended that took up this run: {' '.join(str(error).split())[:300]}")
        raise error
