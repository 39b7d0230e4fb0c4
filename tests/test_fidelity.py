"""The same design with models of increasing detail."""

from dataclasses import replace

import pytest

import escapement as esc
from escapement.base.errors import InvalidValue

WHEEL = esc.Geneva(4, crank_radius=0.01, pin_radius=5e-4, clearance=2e-5)
LOOSE = esc.Escapement(
    WHEEL, esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.3, driver_bearing_torque=1e-4
)


def test_each_model_is_the_design_with_less():
    found = esc.compare_fidelity(LOOSE)
    assert list(found.figures) == ["ideal", "losses", "impact"]
    ideal = esc.Escapement(
        esc.Geneva(4, crank_radius=0.01), LOOSE.inertia, torque=0.0113, friction=0.3
    )
    without_clearance = replace(LOOSE, mechanism=replace(WHEEL, clearance=0.0))
    for name, model in (("ideal", ideal), ("losses", without_clearance), ("impact", LOOSE)):
        assert found.figures[name].period == esc.terminal(model).period
    change = found.figures["impact"].period / found.figures["losses"].period - 1.0
    assert found.changes["impact"]["period"] == pytest.approx(change)
    assert found.message.startswith("impact is enough")


def test_an_ideal_design_is_the_only_model():
    plain = esc.Escapement(esc.Geneva(4), LOOSE.inertia, torque=0.0113, friction=0.3)
    found = esc.compare_fidelity(plain)
    assert list(found.figures) == ["ideal"]
    assert found.message == "ideal is enough for the period within 0.1 %"


def test_a_loss_that_hardly_matters_is_told():
    own = esc.Escapement(
        esc.Geneva(4), LOOSE.inertia, torque=0.0113, friction=0.3, driver_drag=1e-12
    )
    assert esc.compare_fidelity(own).message.startswith("ideal is enough")


def test_a_jam_is_told_and_other_things_are_refused():
    tight = replace(LOOSE, friction=0.6)
    assert "there is no cycle on ideal" in esc.compare_fidelity(tight).message
    with pytest.raises(InvalidValue, match="escapement must be an Escapement"):
        esc.compare_fidelity(WHEEL)
