"""What a notebook shows: all text escaped, numbers at 6 digits, of long tables both ends."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, assert_type, cast

import numpy as np
import pytest
import samara_tpf as samara
from IPython.core.formatters import DisplayFormatter
from conftest import Page
from samara_tpf import Columns, _settings, _show, inside

EVIL = "<script>alert('&')</script>"
# Texts of these keys are of users' files; those that results are told apart by stay as they are.
KEYS = {"mission", "gains", "decided_by", "quantity", "about", "name", "design", "air", "file", "label", "a", "text"}
WORDS = {"none", "all"}


def evil(value: Any) -> Any:
    """A document whose texts are code of a page."""
    if isinstance(value, dict):
        is_text = {key: key in KEYS and isinstance(one, str) and one not in WORDS for key, one in value.items()}
        return {key: EVIL if is_text[key] else evil(one) for key, one in value.items()}
    return [evil(one) for one in value] if isinstance(value, list) else value


class Evil:
    """What the extension module gave, with code of a page for texts."""

    def __init__(self, inner: object) -> None:
        self._inner = inner

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._inner, name)
        return (lambda: self._turned(value())) if callable(value) else self._turned(value)

    @staticmethod
    def _turned(value: object) -> object:
        if not isinstance(value, str) or value.startswith("<svg"):
            return value
        return json.dumps(evil(json.loads(value))) if value.startswith("{") else EVIL


def assert_harmless(result: Any) -> None:
    page = Page(result._repr_html_())
    assert EVIL in page.text and "script" not in page.elements and page.open == []


def test_a_table_has_both_ends_and_the_number_of_its_rows() -> None:
    n = np.arange(100)
    html = Columns({"t_s": n / 3.0, "n": n, "word": np.array(["a"] * 100), "late": n > 50})._repr_html_()
    assert "Columns: 100 rows" in Page(html).text and html.count("<tr>") == 1 + 5 + 1 + 5
    for text in ("0.333333", "1.33333", "31.6667", "...", "95", "99", "a", "no", "yes"):
        assert f">{text}</td>" in html, text
    assert ">1.66667</td>" not in html and ">5</td>" not in html
    short = Columns({"t_s": np.array([np.nan, np.inf, 1e-9])})._repr_html_()
    assert "<td></td>" in short and ">inf</td>" in short and ">1e-09</td>" in short and "..." not in short
    assert Page(Columns({})._repr_html_()).open == []


def test_names_and_cells_of_a_table_are_escaped() -> None:
    assert_harmless(Columns({EVIL: np.array([1.0])}))
    assert_harmless(Columns({"word": np.array([EVIL])}))


def test_closed_form_shares_are_steps_up_to_the_share_that_is_finite() -> None:
    drawn = _show.shares({"a": np.array([1.0, 3.0]), "b": np.array([2.0, np.inf, 5.0, np.inf])}, "J")
    # 420 wide from 1 to 5, 160 high; from the last step on a level line.
    assert '<path d="M0 160H0.0V80.0H210.0V0.0H420" stroke-dasharray="none">' in drawn
    assert '<path d="M0 160H105.0V120.0H420.0V80.0H420" stroke-dasharray="4 3">' in drawn
    assert "at or below a J: a solid, b dashed" in Page(drawn).text and Page(drawn).open == []
    assert _show.shares({"a": np.array([np.inf])}, "J") == ""


@pytest.mark.parametrize(
    "fly",
    [
        lambda: samara.plan("titan_drop"),
        lambda: samara.drop("titan_drop"),
        lambda: samara.assess("titan_drop", trials=4),
        lambda: samara.tune("titan_paper", objective="rms", iterations=1, particles=6, seed=6),
        lambda: samara.study("effects", "x500_drop", trials=2),
        lambda: samara.study("replan", "x500_drop", trials=2),
        lambda: samara.study("free_fall", "titan_no_wire", trials=20, hours=1),
        lambda: samara.study("sobol", "x500_drop", points=64),
        lambda: samara.study("tune", "x500_drop", objective="rms", iterations=1, particles=4, unseen=8),
    ],
)
def test_texts_of_files_are_escaped(fly: Any) -> None:
    result = fly()
    (inner,) = (value for name, value in vars(result).items() if type(value).__module__ == "samara_tpf._samara")
    assert_harmless(type(result)(Evil(inner)))


def test_texts_of_what_is_odd_and_of_a_design_are_escaped() -> None:
    assert_harmless(type(samara.check("titan_drop"))((json.dumps({"mission": EVIL, "odd": [EVIL]}), EVIL, False)))

    class Designed:
        json = json.dumps({"mission": EVIL, "fresh": [{"design": EVIL, "air": EVIL, "results": {"flights": 1}}]})
        sentence = text = EVIL

    assert_harmless(samara.Design(cast(Any, Designed), "titan_drop"))


def test_texts_of_logs_and_drafts_are_escaped() -> None:
    tells = [{"quantity": EVIL, "can": False, "lacks": [EVIL, EVIL]}]
    of_log = {"file": EVIL, "length_s": 1.0, "says": [{"name": EVIL, "text": EVIL}], "tells": tells}
    assert_harmless(samara.FlightLog(of_log | {"quantities": [], "phases": [], "topics": []}, EVIL))
    number = {"name": EVIL, "unit": EVIL, "base": 1.0, "found": None, "interval": None, "error": None, "refused": EVIL}
    of_vehicle = {"base": EVIL, "looked_at_s": 1.0, "numbers": [number], "predicted": [{"name": EVIL}]}
    assert_harmless(samara.Identification(of_vehicle, {}, False))
    of_flight = {"vehicle": EVIL, "length_s": 1.0, "manoeuvres": [{"name": EVIL}], "numbers": [{"name": EVIL}]}
    assert_harmless(samara.Manoeuvre(of_flight, {}, False))
    keys = [{"key": EVIL, "a": EVIL, "b": None}]
    missions = {"keys": keys, "derived": []}
    compared: dict[str, Any] = {"campaigns": [], "drops": None, "missions": missions, "logged": None}
    assert_harmless(samara.Comparison([EVIL, EVIL], {"compare.json": json.dumps(compared)}, EVIL))
    origin = {"keys": [EVIL], "kind": EVIL, "file": EVIL, "formula": EVIL}
    vehicle = {"name": EVIL, "about": EVIL, "mass_kg": 1.0, "rotors": [], "origins": [origin]}
    assert_harmless(samara.VehicleDraft(json.dumps(vehicle), [EVIL]))


def test_a_notebook_takes_the_page_and_the_line() -> None:
    shown, _ = DisplayFormatter().format(samara.plan("titan_drop"))  # type: ignore[no-untyped-call]
    assert set(shown) == {"text/html", "text/plain"} and "<svg" in shown["text/html"]
    assert shown["text/plain"].startswith("<Plan: converged")


def test_margins_of_loops_are_a_table() -> None:
    page = Page(inside.loops("x500_drop")._repr_html_())
    assert page.open == [] and "table" in page.elements and "pitch rate" in page.text and "target" in page.text


def test_settings_are_those_of_the_kinds() -> None:
    types = {
        "effects": _settings.EffectsSettings,
        "envelope": _settings.EnvelopeSettings,
        "rare": _settings.RareSettings,
        "sobol": _settings.SobolSettings,
        "replan": _settings.ReplanSettings,
        "free_fall": _settings.FreeFallSettings,
        "design": _settings.DesignSettings,
        "tune": _settings.TuneSettings,
        "tune_px4": _settings.TunePx4Settings,
    }
    common = set(_settings.Flown.__annotations__)
    assert {kind: set(of.__annotations__) - common for kind, of in types.items()} == {
        kind: set(settings) for kind, settings in samara.studies().items()
    }


if TYPE_CHECKING:

    def each_kind_has_its_type(any_kind: str) -> None:
        assert_type(samara.study("effects", trials=4, seed=1), samara.Effects)
        assert_type(samara.study("envelope", "x500_drop", pairs=[("wind", "delay")]), samara.Envelope)
        assert_type(samara.study("rare", least=1e-3), samara.RareFailures)
        assert_type(samara.study("sobol", points=64), samara.Sensitivities)
        assert_type(samara.study("replan", when=["release", 1]), samara.Renewals)
        assert_type(samara.study("free-fall", hours=1), samara.FreeFall)
        assert_type(samara.study("design", budget=2), samara.DesignStudy)
        assert_type(samara.study("tune", robust=True), samara.TuningStudy)
        assert_type(samara.study("tune_px4", px4_version="v1.14"), samara.Px4TuningStudy)
        assert_type(samara.study(any_kind), samara.Study)
