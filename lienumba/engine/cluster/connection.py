"""The connection to a cluster of dask; whatever ends it is a ClusterError, a finished message."""

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from lienumba import __version__
from lienumba.errors import ClusterError, ScenarioError
from lienumba.words import show

if TYPE_CHECKING:
    from distributed import Client, Future

LOCAL = "local"
PATIENCE = 30  # s to find the scheduler
LOOK = 1.0  # s between two looks at how many workers there are


def check_dask(given: object, workers: int | None) -> None:
    """Refuse what is no cluster, or has what it cannot have, before anything is computed."""
    try:
        from distributed import Client
    except ImportError:
        raise ScenarioError('dask: is not installed; in the clone of lienumba, pip install ".[dask]"') from None
    if given != LOCAL and not isinstance(given, Client) and not _is_address(given):
        raise ScenarioError(
            f'dask = {show(given)}: is no cluster; give "local", the address of a scheduler such as '
            '"tcp://10.0.0.1:8786", or a distributed.Client'
        )
    if isinstance(given, Client) and given.asynchronous:
        raise ScenarioError("dask: this client is asynchronous; make it by Client(address) outside of a coroutine")
    if given != LOCAL and workers is not None:
        raise ScenarioError(
            f"workers = {workers}: a cluster has as many as were started; leave it out, or start other ones"
        )


def _is_address(given: object) -> bool:
    from distributed.comm.addressing import get_address_host_port

    try:
        return isinstance(given, str) and bool(get_address_host_port(given))
    except ValueError:
        return False


class Connection:
    """given: "local", which becomes a cluster of `workers` processes, the address of a scheduler, or a Client."""

    def __init__(self, given: "str | Client", workers: int) -> None:
        from distributed import Client, LocalCluster

        self.where = f"the cluster {given}" if isinstance(given, str) else f"the cluster {given.scheduler.address}"
        self._ends, self._cores, self._looked = ExitStack(), 0, -LOOK
        try:
            if isinstance(given, Client):
                self.client = given
                return
            address: Any = given
            if given == LOCAL:
                address = LocalCluster(
                    n_workers=workers, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0",
                    silence_logs=logging.ERROR, preload="lienumba.engine.cluster.dask_worker",
                )  # fmt: skip
                self._ends.callback(address.close)
            self.client = Client(address, timeout=PATIENCE, set_as_default=False)
        except OSError as error:
            raise ScenarioError(
                f"dask {given}: no scheduler answers there ({error}); start one by `dask scheduler`, or correct the "
                "address"
            ) from None
        self._ends.callback(self.client.close)

    def put(self, name: list[str], value: object) -> None:
        """Leave something with the scheduler, for all workers, those to come too."""
        with self._lost():
            self.client.set_metadata(name, value)

    def submit(self, function: Callable[..., Any], *arguments: object) -> "Future":
        with self._lost():
            return self.client.submit(function, *arguments, pure=False)

    def result(self, future: "Future") -> Any:
        """What was computed; None if all workers died that took it."""
        from distributed.scheduler import KilledWorker

        with self._lost():
            error = future.exception() if future.status == "error" else None
        if isinstance(error, KilledWorker):
            return None
        if error is not None:
            raise self._told(error)
        try:
            with self._lost():
                return self.client.gather(future, direct=True)  # the scheduler has other things to do
        except KilledWorker:  # who had it has died, and so did who computed it again
            return None

    @property
    def cores(self) -> int:
        """How many chunks the workers can compute at the same time."""
        if monotonic() - self._looked >= LOOK:
            with self._lost():
                self._cores = sum(self.client.nthreads().values())
            self._looked = monotonic()
        return self._cores

    def cancel(self, futures: "Iterable[Future]") -> None:
        with suppress(Exception):  # of a cluster that is lost there is nothing to cancel
            self.client.cancel(list(futures), force=True)

    def close(self) -> None:
        with suppress(Exception):
            self._ends.close()

    @contextmanager
    def _lost(self) -> Iterator[None]:
        from asyncio import CancelledError as Dropped
        from concurrent.futures import CancelledError

        try:
            yield
        except (CancelledError, Dropped, OSError) as error:
            raise ClusterError(
                f"{self.where} was lost ({error}): its scheduler has ended, or has dropped what was to be computed"
            ) from None

    def _told(self, error: BaseException) -> BaseException:
        """What a task raised; others do not know what this process sends if it is not installed there."""
        if isinstance(error, ImportError) or "deserializ" in str(error):
            return ScenarioError(
                f"dask: {self.where} cannot load lienumba {__version__} ({error}); install the same versions on all "
                "machines, that of the scheduler too"
            )
        return error
