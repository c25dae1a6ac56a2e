"""The roster's decisions, carried out by Dask.

Each task is pinned to the worker that the roster chose: Dask moves bytes and knows who is there, and decides nothing.
A result is fetched and written on a thread beside, so that a worker gets its next shard first. A scheduler that is
lost is sought again; what was under way is then flown once more.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterable
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Self

from distributed import Client, Future, KilledWorker

from . import work
from .child import IsWanted, Stopped
from .folder import Folder, FolderError
from .instances import NUMBERS, Instances
from .order import Order
from .progress import Progress
from .roster import Roster

LOOK_EVERY_S = 1.0
"""How often it is looked who is there."""
ANSWERS_S = 10.0
"""How long the scheduler may take to answer."""
FETCH_S = 600.0
"""How long a result may take from the worker to here."""
FETCHES = 4
"""Results that are on their way, and in memory, at once."""

LOST = (CancelledError, KilledWorker, TimeoutError, OSError)
"""What a result that was lost raises: a worker, a connection or a scheduler ended."""


class NoWorkers(Exception):
    """No worker that is of use is there, or no scheduler."""


@dataclass(frozen=True)
class Task:
    """What a worker was sent: a shard, or (``None``) its check."""

    address: str
    shard: int | None


@dataclass(frozen=True)
class Saved:
    """A shard is in the folder."""


@dataclass(frozen=True)
class Ended:
    """A task that has ended, and of which order it is."""

    order: Order
    task: Task
    future: Future


@dataclass(frozen=True)
class Came:
    """What came of a task."""

    ended: Ended
    outcome: object


class Flight:
    """Workers of one scheduler, which fly one order after another; behind the context they are at rest."""

    def __init__(
        self, folder: Folder, address: str, progress: Progress, *, patience_s: float, is_wanted: IsWanted
    ) -> None:
        """To ``folder``, by the workers of the scheduler at ``address``, for whom it waits so long [s]."""
        self.folder = folder
        self.address = address
        self.progress = progress
        self.patience_s = patience_s
        self.is_wanted = is_wanted
        self.roster = Roster.of(())
        self._order: Order | None = None
        self._instances = Instances()
        self._threads: dict[str, int] = {}
        self._client: Client | None = None
        self._under_way: dict[Task, Future] = {}
        self._ended: queue.SimpleQueue[Ended] = queue.SimpleQueue()
        self._came: queue.SimpleQueue[Came] = queue.SimpleQueue()
        self._writing = threading.Semaphore(FETCHES)
        self._sent = 0
        self._missed = False
        self._looked_s = -LOOK_EVERY_S
        self._fit_s = time.monotonic()

    def __enter__(self) -> Self:
        """Begins to wait for results. Nobody waits for those threads: a worker that hangs would hold them up."""
        for _ in range(FETCHES):
            threading.Thread(target=self._fetch_all, name="fetch", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        """Ends what is under way: the workers end their children when nobody waits for them."""
        self._withdraw(list(self._under_way))
        self._write_no_more()
        client, self._client = self._client, None
        if client is not None:
            with suppress(OSError, CancelledError):
                client.close(timeout=ANSWERS_S)

    def run(self, order: Order, shards: Iterable[int]) -> None:
        """Flies these shards of an order, to the last; then nothing more of it is written.

        ``ShardFailed``, ``NoWorkers``, ``FolderError``, ``Stopped``: why it ended before.
        """
        self._order, self.roster = order, self.roster.anew(shards)
        self._fit_s = time.monotonic()
        self.progress.begin(order, self.roster)
        while not self.roster.complete:
            if not self.is_wanted():
                raise Stopped
            client = self._connection()
            if client is not None:
                self._look(client)
                self._send_all(client, order)
            self._take(order)
            self.progress.show()
        self._write_no_more()

    def _connection(self) -> Client | None:
        """The connection to the scheduler; ``None``: it is not there now."""
        if self._client is not None and self._client.status == "closed":
            self._client = None
            for task in list(self._under_way):
                self._lost(task)
            self.progress.report(f"the scheduler at {self.address} is gone: it is sought again")
        if self._client is None:
            try:
                self._client = Client(self.address, timeout=ANSWERS_S, set_as_default=False)
                if link := _dashboard(self._client):
                    self.progress.report(f"dashboard at {link}")
            except OSError as error:
                self._miss(f"no scheduler at {self.address}: {error}")
        return self._client

    def _look(self, client: Client) -> None:
        """Takes note of who is there."""
        now_s = time.monotonic()
        if now_s - self._looked_s < LOOK_EVERY_S:
            return
        try:
            present = client.nthreads(callback_timeout=ANSWERS_S)
        except Exception as error:
            # A connection that is about to end says so in many ways; it is lost for good when it is closed.
            if client.status == "running" and not isinstance(error, OSError):
                raise
            self._miss(f"no answer of the scheduler at {self.address}: {error}")
            return
        self._missed = False
        self._looked_s = now_s
        self._threads = dict(present)
        for gone in self.roster.present(present):
            self._instances.give_back(gone)
            self._withdraw([task for task in self._under_way if task.address == gone])
        if self.roster.fit():
            self._fit_s = now_s
        else:
            self._impatient(f"no worker at {self.address} is of use, {len(present)} are there")

    def _miss(self, why: str) -> None:
        """Takes note that the scheduler does not answer."""
        self._impatient(why)
        if not self._missed:
            self.progress.report(f"no scheduler answers at {self.address}: waiting for it")
        self._missed = True

    def _impatient(self, why: str) -> None:
        """Gives up when no worker has been there for too long."""
        if time.monotonic() - self._fit_s > self.patience_s:
            raise NoWorkers(f"{why}, for {self.patience_s:.0f} s (--patience)")

    def _send_all(self, client: Client, order: Order) -> None:
        """Sends what is to be done now to those who do it."""
        for address in self.roster.to_check():
            self._send(client, order, Task(address, None))
        for address, shard in self.roster.to_fly(time.monotonic()):
            self._send(client, order, Task(address, shard))

    def _send(self, client: Client, order: Order, task: Task) -> None:
        self._sent += 1
        key = f"samara-{order.id[:12]}-{self._sent}-{task.shard if task.shard is not None else 'check'}"
        where: dict[str, Any] = {"workers": [task.address], "allow_other_workers": False, "pure": False, "key": key}
        try:
            if task.shard is None:
                future = client.submit(work.check, order, **where)
            else:
                future = client.submit(work.fly, order, task.shard, self._own_options(order, task.address), **where)
        except Exception:
            if client.status == "running":
                raise
            self._lost(task)
            return
        self._under_way[task] = future
        future.add_done_callback(lambda future: self._ended.put(Ended(order, task, future)))

    def _own_options(self, order: Order, address: str) -> tuple[str, ...]:
        """Options of ``samara`` for one worker: the numbers of its PX4s."""
        if not order.flies_px4:
            return ()
        return ("--instance", str(self._instances.first(address, self._threads[address])))

    def _fetch_all(self) -> None:
        """Fetches results, for ever."""
        while True:
            ended = self._ended.get()
            self._came.put(Came(ended, self._fetched(ended)))

    def _fetched(self, ended: Ended) -> object:
        """A result, which is written when it is a shard that somebody still waits for; or the error instead."""
        try:
            outcome = ended.future.result(timeout=FETCH_S)
            if not isinstance(outcome, work.Flown) or ended.task.shard is None:
                return outcome
            with self._writing:
                if ended.order is not self._order:
                    return work.Withdrawn()
                self.folder.save(ended.order.result(ended.task.shard), outcome)
                return Saved()
        except Exception as error:
            return error

    def _write_no_more(self) -> None:
        """Waits for what is being written of the order; the rest is not."""
        for _ in range(FETCHES):
            self._writing.acquire()
        self._order = None
        self._writing.release(FETCHES)

    def _take(self, order: Order) -> None:
        """Takes what has come, and waits a while for the first."""
        wait_s = LOOK_EVERY_S
        with suppress(queue.Empty):
            while True:
                self._take_note(order, self._came.get(block=wait_s > 0.0, timeout=wait_s))
                wait_s = 0.0

    def _take_note(self, order: Order, came: Came) -> None:
        task, outcome, now_s = came.ended.task, came.outcome, time.monotonic()
        if isinstance(outcome, FolderError):
            raise outcome
        if self._under_way.get(task) is not came.ended.future:
            # It was given up, and came all the same.
            if isinstance(outcome, Saved) and task.shard is not None and came.ended.order is order:
                self._done(task.address, task.shard)
            return
        del self._under_way[task]
        if task.shard is None:
            self._checked(order, task.address, outcome)
        elif isinstance(outcome, Saved):
            self._done(task.address, task.shard)
        elif isinstance(outcome, work.OtherCampaign):
            self._left_out(task.address, outcome.why)
            self.roster.unfit(task.address, task.shard, now_s)
        elif isinstance(outcome, (work.Withdrawn, *LOST)):
            self.roster.lost(task.address, task.shard, now_s)
        else:
            failed = outcome if isinstance(outcome, work.Failed) else work.Failed(_text(outcome), killed=False)
            self.progress.report(f"shard {task.shard}, on {task.address}: {failed.why}")
            self.roster.failed(task.address, task.shard, failed.why, failed.killed, now_s)

    def _checked(self, order: Order, address: str, outcome: object) -> None:
        if isinstance(outcome, (work.Withdrawn, *LOST)):
            self.roster.check_lost(address)
            return
        why = None
        if isinstance(outcome, work.OtherCampaign):
            why = outcome.why
        elif not isinstance(outcome, work.Fit):
            why = _text(outcome)
        elif order.flies_px4 and address in self._threads:
            first = self._instances.first(address, self._threads[address])
            why = f"its host has no number left for its PX4s, {NUMBERS} in all" if first is None else None
        if why is not None:
            self._left_out(address, why)
        self.roster.checked(address, fit=why is None)

    def _left_out(self, address: str, why: str) -> None:
        self.progress.report(f"{address} is left out: {why}")

    def _done(self, address: str, shard: int) -> None:
        others = self.roster.done(address, shard, time.monotonic())
        self._withdraw([Task(flier, shard) for flier in (address, *others)])

    def _lost(self, task: Task) -> None:
        self._under_way.pop(task, None)
        if task.shard is None:
            self.roster.check_lost(task.address)
        else:
            self.roster.lost(task.address, task.shard, time.monotonic())

    def _withdraw(self, tasks: Iterable[Task]) -> None:
        """Lets workers know that nobody waits for their tasks any more."""
        futures = [future for task in tasks if (future := self._under_way.pop(task, None)) is not None]
        if self._client is not None and futures:
            # With the scheduler gone there is nobody to tell: Dask says that in many ways.
            with suppress(Exception):
                self._client.cancel(futures)


def _dashboard(client: Client) -> str | None:
    """The address of Dask's dashboard; ``None``: the scheduler has none."""
    try:
        return str(client.dashboard_link)
    except KeyError:
        return None


def _text(error: object) -> str:
    return f"{type(error).__name__}: {error}"
