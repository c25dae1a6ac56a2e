"""The roster's decisions, carried out by Dask.

Each task is pinned to the worker that the roster chose: Dask moves bytes and knows who is there, and decides nothing.
A result is fetched and written on a thread beside, so that a worker gets its next shard first. A scheduler that is
lost is sought again; what was under way is then flown once more.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Self

from distributed import Client, Future, KilledWorker

from . import work
from .folder import Folder, FolderError
from .instances import NUMBERS, Instances
from .order import Order
from .roster import Roster

LOOK_EVERY_S = 1.0
"""How often it is looked who is there."""
CONNECT_S = 10.0
"""How long one try to reach the scheduler lasts."""
FETCH_S = 600.0
"""How long a result may take from the worker to here."""
FETCHES = 4
"""Results that are on their way, and in memory, at once."""

LOST = (CancelledError, KilledWorker, TimeoutError, OSError)
"""What a result that was lost raises: a worker, a connection or a scheduler ended."""


class NoWorkers(Exception):
    """No worker that flies this campaign is there, or no scheduler."""


class Interrupted(Exception):
    """The driver was asked to stop."""


@dataclass(frozen=True)
class Asked:
    """What a worker was asked for: a shard, or (``None``) its check."""

    address: str
    shard: int | None


@dataclass(frozen=True)
class Saved:
    """A shard is in the campaign's folder."""


@dataclass(frozen=True)
class Came:
    """What came of what a worker was asked for, and of which order it is."""

    order: Order
    asked: Asked
    future: Future
    outcome: object


class Flight:
    """Flies the shards that are left, to the last."""

    def __init__(
        self,
        order: Order,
        roster: Roster,
        folder: Folder,
        address: str,
        *,
        patience_s: float,
        stop: threading.Event,
        report: Callable[[str], None],
    ) -> None:
        """Of the campaign ``order`` to ``folder``, by the workers of the scheduler at ``address``."""
        self.order = order
        self.roster = roster
        self.folder = folder
        self.address = address
        self.patience_s = patience_s
        self.stop = stop
        self.report = report
        self._instances = Instances() if order.flies_px4 else None
        self._threads: dict[str, int] = {}
        self._client: Client | None = None
        self._under_way: dict[Asked, Future] = {}
        self._came: queue.SimpleQueue[Came] = queue.SimpleQueue()
        self._fetching = ThreadPoolExecutor(FETCHES, thread_name_prefix="fetch")
        self._asked = 0
        self._missed = False
        self._looked_s = -LOOK_EVERY_S
        self._fit_s = time.monotonic()

    def __enter__(self) -> Self:
        """What is under way ends with the context."""
        return self

    def __exit__(self, *_: object) -> None:
        """Ends what is under way."""
        self._end()

    def begin(self, order: Order, shards: Iterable[int]) -> None:
        """Goes on with another order, by the workers that are there: it asks the same of their programs."""
        for asked in [asked for asked in self._under_way if asked.shard is not None]:
            self._withdraw(asked)
        self.order, self.roster = order, self.roster.anew(shards)
        self._fit_s = time.monotonic()

    def run(self, show: Callable[[], None]) -> None:
        """Flies until nothing is left; ``show`` is called in between, about once a second.

        ``CampaignFailed``, ``NoWorkers``, ``FolderError``, ``Interrupted``: why it ended before.
        """
        while not self.roster.complete:
            if self.stop.is_set():
                raise Interrupted
            client = self._connection()
            if client is not None:
                self._look(client)
                self._ask(client)
            self._take()
            show()

    def _connection(self) -> Client | None:
        """The connection to the scheduler; ``None``: it is not there now."""
        if self._client is not None and self._client.status == "closed":
            self._client = None
            for asked in list(self._under_way):
                self._lost(asked)
            self.report(f"the scheduler at {self.address} is gone: it is sought again")
        if self._client is None:
            try:
                self._client = Client(self.address, timeout=CONNECT_S, set_as_default=False)
                if link := _dashboard(self._client):
                    self.report(f"dashboard at {link}")
                self._missed = False
            except OSError as error:
                self._impatient(f"no scheduler at {self.address}: {error}")
                if not self._missed:
                    self.report(f"no scheduler answers at {self.address}: waiting for it")
                self._missed = True
        return self._client

    def _look(self, client: Client) -> None:
        """Takes note of who is there."""
        now_s = time.monotonic()
        if now_s - self._looked_s < LOOK_EVERY_S:
            return
        self._looked_s = now_s
        try:
            present = client.nthreads()
        except OSError:
            # The connection says by itself when it is lost for good.
            return
        self._threads = dict(present)
        for gone in self.roster.present(present):
            if self._instances:
                self._instances.give_back(gone)
            for asked in [asked for asked in self._under_way if asked.address == gone]:
                self._withdraw(asked)
        if self.roster.fit():
            self._fit_s = now_s
        else:
            self._impatient(f"no worker at {self.address} flies this campaign, {len(present)} are there")

    def _impatient(self, why: str) -> None:
        """Ends the campaign when no worker has been there for too long."""
        if time.monotonic() - self._fit_s > self.patience_s:
            raise NoWorkers(f"{why}, for {self.patience_s:.0f} s (--patience)")

    def _ask(self, client: Client) -> None:
        """Sends what is to be done now to those who do it."""
        for address in self.roster.to_check():
            self._send(client, Asked(address, None))
        for address, shard in self.roster.to_fly(time.monotonic()):
            self._send(client, Asked(address, shard))

    def _send(self, client: Client, asked: Asked) -> None:
        self._asked += 1
        key = f"samara-{self.order.id[:12]}-{self._asked}-{asked.shard if asked.shard is not None else 'check'}"
        where: dict[str, Any] = {"workers": [asked.address], "allow_other_workers": False, "pure": False, "key": key}
        if asked.shard is None:
            future = client.submit(work.check, self.order, **where)
        else:
            future = client.submit(work.fly, self.order, asked.shard, self._own_options(asked.address), **where)
        self._under_way[asked] = future
        order = self.order
        future.add_done_callback(lambda future: self._fetching.submit(self._fetch, order, asked, future))

    def _own_options(self, address: str) -> tuple[str, ...]:
        """Options of ``samara assess`` for one worker: the numbers of its PX4s."""
        if self._instances is None:
            return ()
        return ("--instance", str(self._instances.first(address, self._threads[address])))

    def _fetch(self, order: Order, asked: Asked, future: Future) -> None:
        """Fetches a result, and writes it when it is a shard."""
        outcome: object
        try:
            outcome = future.result(timeout=FETCH_S)
            if isinstance(outcome, work.Flown) and asked.shard is not None:
                self.folder.save(order.result(asked.shard), outcome)
                outcome = Saved()
        except Exception as error:
            outcome = error
        self._came.put(Came(order, asked, future, outcome))

    def _take(self) -> None:
        """Takes what has come, and waits a while for the first."""
        wait_s = LOOK_EVERY_S
        while True:
            try:
                came = self._came.get(timeout=wait_s) if wait_s > 0.0 else self._came.get_nowait()
            except queue.Empty:
                return
            wait_s = 0.0
            self._take_note(came)

    def _take_note(self, came: Came) -> None:
        asked, outcome, now_s = came.asked, came.outcome, time.monotonic()
        if isinstance(outcome, FolderError):
            raise outcome
        if self._under_way.get(asked) is not came.future:
            # It was given up, and came all the same.
            if isinstance(outcome, Saved) and asked.shard is not None and came.order is self.order:
                self._done(asked.address, asked.shard)
            return
        del self._under_way[asked]
        if asked.shard is None:
            self._checked(asked.address, outcome)
        elif isinstance(outcome, Saved):
            self._done(asked.address, asked.shard)
        elif isinstance(outcome, work.OtherCampaign):
            self._left_out(asked.address, outcome.why)
            self.roster.unfit(asked.address, asked.shard, now_s)
        elif isinstance(outcome, (work.Withdrawn, *LOST)):
            self.roster.lost(asked.address, asked.shard, now_s)
        else:
            failed = outcome if isinstance(outcome, work.Failed) else work.Failed(_text(outcome), killed=False)
            self.report(f"shard {asked.shard}, on {asked.address}: {failed.why}")
            self.roster.failed(asked.address, asked.shard, failed.why, failed.killed, now_s)

    def _checked(self, address: str, outcome: object) -> None:
        if isinstance(outcome, LOST):
            self.roster.check_lost(address)
            return
        why = None
        if isinstance(outcome, work.OtherCampaign):
            why = outcome.why
        elif not isinstance(outcome, work.Fit):
            why = _text(outcome)
        elif self._instances and address in self._threads:
            first = self._instances.first(address, self._threads[address])
            why = f"its host has no number left for its PX4s, {NUMBERS} in all" if first is None else None
        if why is not None:
            self._left_out(address, why)
        self.roster.checked(address, fit=why is None)

    def _left_out(self, address: str, why: str) -> None:
        self.report(f"{address} is left out: {why}")

    def _done(self, address: str, shard: int) -> None:
        for other in self.roster.done(address, shard, time.monotonic()):
            self._withdraw(Asked(other, shard))

    def _lost(self, asked: Asked) -> None:
        del self._under_way[asked]
        if asked.shard is None:
            self.roster.check_lost(asked.address)
        else:
            self.roster.lost(asked.address, asked.shard, time.monotonic())

    def _withdraw(self, asked: Asked) -> None:
        """Lets the worker know that nobody waits any more."""
        future = self._under_way.pop(asked, None)
        if future is not None:
            future.cancel()

    def _end(self) -> None:
        """Ends what is under way: the workers end their children when nobody waits for them."""
        client, self._client = self._client, None
        if client is not None:
            try:
                client.cancel(list(self._under_way.values()))
                client.close(timeout=CONNECT_S)
            except (OSError, CancelledError):
                # With the scheduler gone there is nobody to tell.
                pass
        self._under_way.clear()
        self._fetching.shutdown(wait=True, cancel_futures=True)


def _dashboard(client: Client) -> str | None:
    """The address of Dask's dashboard; ``None``: the scheduler has none."""
    try:
        return str(client.dashboard_link)
    except KeyError:
        return None


def _text(error: object) -> str:
    return f"{type(error).__name__}: {error}"
