"""Which shard goes to which worker: decisions alone, without Dask and without a clock.

A worker is checked before it is given a shard, and has one at a time. One that leaves gives its shard back. After a
failure a worker rests, longer each time, so that one with a full disk does not draw all shards to itself; the shard
goes to another, and ends the whole when it has failed everywhere. At the end, a worker without work flies a
shard that takes others unusually long once more, and the first result counts: one that hangs holds nothing up.
"""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

FAILURES_MOST = 3
"""Failures of a shard, on as many workers where there are, that end the whole."""
KILLS_MOST = 100
"""How often the program may be killed while it flies one shard."""
LONGEST_REST_S = 60.0
"""Longest time for which a worker is given nothing."""
SLOW = 2.0
"""A shard that has taken so many mean times is flown a second time."""


class ShardFailed(Exception):
    """A shard fails everywhere; the text says which, and why."""


@dataclass
class Member:
    """A worker that is there."""

    fit: bool | None = None
    """Whether it would make what is asked for; ``None``: not known yet."""
    checking: bool = False
    shard: int | None = None
    since_s: float = 0.0
    rests_until_s: float = 0.0
    failures_in_a_row: int = 0


@dataclass
class Roster:
    """Shards that are left, and the workers that are there, by address."""

    left: OrderedDict[int, None]
    """Shards that nobody flies, the next first: an ordered set."""
    flown: set[int] = field(default_factory=set)
    """Shards that have been flown."""
    members: dict[str, Member] = field(default_factory=dict)
    """Workers that are there."""
    seconds: float = 0.0
    """Time that the shards flown took, together."""
    _failures: dict[int, Counter[str]] = field(default_factory=dict)
    _kills: Counter[int] = field(default_factory=Counter)

    @classmethod
    def of(cls, shards: Iterable[int]) -> Roster:
        """Of shards that are left to fly, in any order."""
        return cls(OrderedDict.fromkeys(sorted(shards)))

    def anew(self, shards: Iterable[int]) -> Roster:
        """Of other shards, by the workers that are there: nobody has one of them yet."""
        for member in self.members.values():
            member.shard = None
        return Roster(OrderedDict.fromkeys(sorted(shards)), members=self.members)

    @property
    def complete(self) -> bool:
        """Whether no shard is left, on the list or under way."""
        return not self.left and not self.flying()

    def flying(self) -> set[int]:
        """Shards under way."""
        return {member.shard for member in self.members.values() if member.shard is not None}

    def fit(self) -> list[str]:
        """Workers that would make what is asked for."""
        return [address for address, member in self.members.items() if member.fit]

    def present(self, addresses: Collection[str]) -> list[str]:
        """Takes note of the workers that are there; those that have left."""
        gone = [address for address in self.members if address not in addresses]
        for address in gone:
            self._give_back(address)
            del self.members[address]
        for address in addresses:
            self.members.setdefault(address, Member())
        return gone

    def to_check(self) -> list[str]:
        """Workers whose check is to begin now."""
        new = [a for a, m in self.members.items() if m.fit is None and not m.checking]
        for address in new:
            self.members[address].checking = True
        return new

    def checked(self, address: str, fit: bool) -> None:
        """A worker would make what is asked for, or something else."""
        if member := self.members.get(address):
            member.fit, member.checking = fit, False

    def check_lost(self, address: str) -> None:
        """A check's result is lost, by nobody's fault: it begins again."""
        if member := self.members.get(address):
            member.checking = False

    def to_fly(self, now_s: float) -> list[tuple[str, int]]:
        """Workers that begin a shard now, with its number."""
        begun = []
        for address, member in self.members.items():
            if not member.fit or member.shard is not None or member.rests_until_s > now_s:
                continue
            shard = self._next_for(address, now_s)
            if shard is not None:
                member.shard, member.since_s = shard, now_s
                begun.append((address, shard))
        return begun

    def done(self, address: str, shard: int, now_s: float) -> list[str]:
        """A shard has been flown, and is safe; other workers that still fly it."""
        self._free(address, shard, now_s, flown=True)
        self.flown.add(shard)
        self.left.pop(shard, None)
        others = [a for a, m in self.members.items() if m.shard == shard]
        for other in others:
            self.members[other].shard = None
        return others

    def lost(self, address: str, shard: int, now_s: float) -> None:
        """A shard's result is lost, by nobody's fault."""
        self._free(address, shard, now_s, flown=None)
        self._back_to_list(shard)

    def unfit(self, address: str, shard: int, now_s: float) -> None:
        """A worker turned out to make something else."""
        self.lost(address, shard, now_s)
        self.checked(address, fit=False)

    def failed(self, address: str, shard: int, why: str, killed: bool, now_s: float) -> None:
        """The program failed with a shard. ``ShardFailed``: it has failed everywhere."""
        self._free(address, shard, now_s, flown=False)
        self._back_to_list(shard)
        if killed:
            self._kills[shard] += 1
        else:
            self._failures.setdefault(shard, Counter())[address] += 1
        failures = self._failures.get(shard, Counter())
        enough = failures.total() >= FAILURES_MOST
        everywhere = len(failures) >= min(FAILURES_MOST, len(self.fit()))
        if (enough and everywhere) or self._kills[shard] >= KILLS_MOST:
            raise ShardFailed(f"shard {shard} fails everywhere, the last time on {address}: {why}")

    def _next_for(self, address: str, now_s: float) -> int | None:
        """The next shard for a worker without work."""
        for shard in self.left:
            failures = self._failures.get(shard, Counter())
            if failures[address] == 0 or all(failures[fit] > 0 for fit in self.fit()):
                del self.left[shard]
                return shard
        return None if self.left else self._slow(now_s)

    def _slow(self, now_s: float) -> int | None:
        """The shard that takes the longest of those that take unusually long, on one worker alone."""
        if not self.flown:
            return None
        mean_s = self.seconds / len(self.flown)
        fliers = Counter(member.shard for member in self.members.values() if member.shard is not None)
        slow = [
            (now_s - member.since_s, member.shard)
            for member in self.members.values()
            if member.shard is not None and fliers[member.shard] == 1 and now_s - member.since_s > SLOW * mean_s
        ]
        return max(slow)[1] if slow else None

    def _free(self, address: str, shard: int, now_s: float, flown: bool | None) -> None:
        """A worker has ended a shard: it is given the next, or rests."""
        member = self.members.get(address)
        if member is None or member.shard != shard:
            return
        member.shard = None
        if flown:
            self.seconds += now_s - member.since_s
            member.failures_in_a_row = 0
        elif flown is False:
            rest_s = min(LONGEST_REST_S, 2.0**member.failures_in_a_row)
            member.failures_in_a_row += 1
            member.rests_until_s = now_s + rest_s

    def _give_back(self, address: str) -> None:
        shard, self.members[address].shard = self.members[address].shard, None
        if shard is not None:
            self._back_to_list(shard)

    def _back_to_list(self, shard: int) -> None:
        if shard not in self.flown and shard not in self.left and shard not in self.flying():
            self.left[shard] = None
            self.left.move_to_end(shard, last=False)
