"""Published coefficients of friction, and studies that name a pair of materials."""

from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.model.friction_pairs import CONDITIONS, PAIRS, SOURCES

TIMER = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, 0.2)


def test_every_range_has_a_source_and_lies_between_zero_and_one():
    used = set()
    for (one, other, condition), (static, sliding, keys) in PAIRS.items():
        assert one <= other
        assert condition in CONDITIONS
        assert static or sliding
        for low, high in filter(None, (static, sliding)):
            assert 0.0 < low <= high < 1.0
        used |= {*keys.split()}
        found = esc.friction_of(other, one, condition)
        assert found.sources == tuple(SOURCES[key] for key in keys.split())
        ends = [end for pair in (static, sliding) if pair for end in pair]
        assert (found.low, found.high) == (min(ends), max(ends))
    assert used == {*SOURCES}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("steel", "bras"), "did you mean 'brass'"),
        (("steel", "PLA"), "one of acetal, brass"),
        (("brass", "brass"), "brass on steel, dry"),
        (("steel", "bronze", "dry"), "bronze on steel, greased"),
        (("steel", "steel", "wet"), "condition must be one of dry, oiled, greased"),
    ],
)
def test_pairs_without_a_figure_are_refused_with_those_that_have_one(given, said):
    with pytest.raises(InvalidValue, match=said):
        esc.friction_of(*given)


def test_a_sample_and_a_sweep_name_a_pair():
    sample = {"method": "random", "size": 50, "seed": 1}
    named = esc.sweep(TIMER, sample=sample | {"friction": "steel on brass, oiled"})
    ends = {"low": 0.11, "high": 0.19}
    given = esc.sweep(TIMER, sample=sample | {"friction": ends})
    np.testing.assert_array_equal(named["period"], given["period"])
    swept = esc.sweep(TIMER, friction={"pair": "steel on brass, oiled", "num": 5})
    np.testing.assert_array_equal(swept.axes["friction"], np.linspace(0.11, 0.19, 5))


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ("steel and brass", 'as in "steel on brass, oiled"'),
        ("steel on gold", "sample.friction: .*one of acetal"),
        ("steel on steel, oily", "sample.friction: condition"),
    ],
)
def test_a_sample_that_names_no_pair_is_refused(form, said):
    table = {"method": "random", "size": 4, "friction": form}
    with pytest.raises(InvalidValue, match=said):
        esc.sweep(TIMER, sample=table)


def test_only_coefficients_of_friction_take_a_pair():
    table = {"method": "random", "size": 4, "torque": "steel on brass"}
    with pytest.raises(InvalidValue, match=r"sample\.torque must be a table"):
        esc.sweep(TIMER, sample=table)


def test_the_page_of_friction_shows_the_table():
    page = Path(__file__).parents[1].joinpath("docs", "effects.md").read_text(encoding="utf-8")
    table = page.partition("## Which effects matter")[0].splitlines()
    rows = [line.strip("| ").split("|") for line in table if line.startswith("| ")]
    shown = {tuple(cell.strip() for cell in row) for row in rows if " on " in row[0]}

    def text(ends):
        low, high = ends or ("", "")
        return f"{low}" if low == high else f"{low:g} to {high:g}"

    for (one, other, condition), (static, sliding, keys) in PAIRS.items():
        numbers = ", ".join(str([*SOURCES].index(key) + 1) for key in keys.split())
        assert (f"{one} on {other}", condition, text(static), text(sliding), numbers) in shown
    assert len(shown) == len(PAIRS)
    assert all(f"{source}." in " ".join(page.split()) for source in SOURCES.values())
