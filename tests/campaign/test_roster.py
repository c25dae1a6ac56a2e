"""Which shard goes to which worker: the roster's decisions, by hand."""

import pytest
from samara_tpf.campaign.roster import KILLS_MOST, Roster, ShardFailed


def roster(shards, workers):
    """Shards that are left, and workers that are fit."""
    made = Roster.of(range(shards))
    made.present([f"w{i}" for i in range(workers)])
    for address in made.to_check():
        made.checked(address, fit=True)
    return made


def test_each_worker_has_one_shard_in_their_order():
    crew = roster(5, 2)
    assert crew.to_fly(0.0) == [("w0", 0), ("w1", 1)]
    assert crew.to_fly(1.0) == []
    assert crew.done("w1", 1, 2.0) == []
    assert crew.to_fly(2.0) == [("w1", 2)]
    for address, shard in [("w0", 0), ("w1", 2)]:
        crew.done(address, shard, 3.0)
    assert crew.to_fly(3.0) == [("w0", 3), ("w1", 4)] and not crew.complete
    for address, shard in [("w0", 3), ("w1", 4)]:
        crew.done(address, shard, 4.0)
    assert crew.complete and crew.flown == set(range(5))


def test_a_worker_is_checked_once_and_flies_only_when_it_is_fit():
    crew = Roster.of(range(3))
    crew.present(["a", "b"])
    assert crew.to_fly(0.0) == [] and crew.to_check() == ["a", "b"] and crew.to_check() == []
    crew.checked("a", fit=False)
    crew.check_lost("b")
    assert crew.to_check() == ["b"]
    crew.checked("b", fit=True)
    assert crew.to_fly(0.0) == [("b", 0)] and crew.fit() == ["b"]
    # It turns out to fly another campaign: its shard is another's.
    crew.present(["a", "b", "c"])
    crew.unfit("b", 0, 1.0)
    assert crew.to_check() == ["c"]
    crew.checked("c", fit=True)
    assert crew.to_fly(1.0) == [("c", 0)]


def test_who_leaves_gives_its_shard_back():
    crew = roster(3, 2)
    crew.to_fly(0.0)
    assert crew.present(["w1"]) == ["w0"]
    crew.done("w1", 1, 1.0)
    assert crew.to_fly(1.0) == [("w1", 0)]
    # The result of the one that left came all the same: nothing is flown again, nothing is counted twice.
    assert crew.done("w0", 0, 1.5) == ["w1"]
    crew.lost("w1", 0, 1.6)
    assert crew.to_fly(1.6) == [("w1", 2)]
    crew.done("w1", 2, 2.0)
    assert crew.complete and crew.flown == {0, 1, 2}


def test_who_fails_rests_ever_longer_and_the_shard_goes_to_another():
    crew = roster(3, 2)
    assert crew.to_fly(0.0) == [("w0", 0), ("w1", 1)]
    crew.failed("w0", 0, "disk full", False, 1.0)
    assert crew.to_fly(1.9) == [], "it rests for a second"
    assert crew.to_fly(2.1) == [("w0", 2)], "another shard than the one that it failed with"
    crew.failed("w0", 2, "disk full", False, 3.0)
    assert crew.to_fly(4.5) == [] and crew.members["w0"].rests_until_s == 5.0
    crew.done("w1", 1, 5.5)
    # What failed on the one is flown by the other.
    assert crew.to_fly(5.5) == [("w1", 2)]
    crew.done("w1", 2, 6.0)
    assert crew.to_fly(6.0) == [("w1", 0)]
    crew.done("w1", 0, 7.0)
    assert crew.complete


@pytest.mark.parametrize("workers", [1, 2, 3, 5])
def test_a_shard_that_fails_everywhere_ends_the_campaign(workers):
    crew = roster(1, workers)
    with pytest.raises(ShardFailed, match="shard 0 .*w.: no plan"):
        for now_s in range(0, 1000, 10):
            for address, shard in crew.to_fly(float(now_s)):
                crew.failed(address, shard, "no plan", False, float(now_s))
    failures = [member.failures_in_a_row for member in crew.members.values()]
    assert sum(failures) == max(3, min(3, workers)) and max(failures) == -(-3 // min(3, workers))


def test_a_shard_may_be_killed_often_but_not_for_ever():
    crew = roster(1, 1)
    kills = 0
    with pytest.raises(ShardFailed):
        for now_s in range(0, 100_000, 100):
            for address, shard in crew.to_fly(float(now_s)):
                kills += 1
                crew.failed(address, shard, "exit code -9", True, float(now_s))
    assert kills == KILLS_MOST


def test_one_that_hangs_holds_nothing_up():
    crew = roster(3, 2)
    assert crew.to_fly(0.0) == [("w0", 0), ("w1", 1)]
    crew.done("w1", 1, 10.0)
    assert crew.to_fly(10.0) == [("w1", 2)]
    crew.done("w1", 2, 20.0)
    # 20 s are two mean times: not yet unusually long.
    assert crew.to_fly(20.0) == []
    assert crew.to_fly(20.1) == [("w1", 0)]
    crew.present(["w0", "w1", "w2"])
    crew.to_check()
    crew.checked("w2", fit=True)
    assert crew.to_fly(99.0) == [], "two fly it already"
    assert crew.done("w1", 0, 100.0) == ["w0"] and crew.complete
