"""The line that says how far an order is, on a terminal and elsewhere."""

import io
import sys

import pytest
from samara_tpf.campaign.order import StudyRound
from samara_tpf.campaign.progress import Progress
from samara_tpf.campaign.roster import Roster

ORDER = StudyRound(
    None, "/", ("study", "effects"), "", shards=4, after=3, stem="0-", count=8, earlier=(), sha256=None
)


class Terminal(io.StringIO):
    """What a terminal is sent."""

    def isatty(self):
        return True


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_what_ends_a_flight_stands_on_a_line_of_its_own(monkeypatch, kind):
    """Whatever ends it, and with the last state above it."""
    monkeypatch.setattr(sys, "stderr", kind())
    with pytest.raises(ValueError, match="the end"), Progress() as progress:
        roster = Roster.of([1, 2, 3])
        progress.begin(ORDER, roster)
        progress.show()
        roster.done("a", 1, 1.0)
        raise ValueError("the end")
    said = sys.stderr.getvalue()
    assert said.endswith("\n") and not said.endswith("\n\n")
    last = said.replace("\r", "\n").splitlines()[-1]
    assert last.startswith("3 rows, [") and "] 2 of 4 shards, 0 workers, " in last and "jobs/s" in last


def test_nothing_is_said_where_nothing_is_flown(capsys):
    with Progress():
        pass
    assert capsys.readouterr() == ("", "")
