"""Results of a study: chosen by name, equal to those of `terminal`; unknown names are refused."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from both_engines import each_engine
from escapement import plots
from escapement.base.errors import InvalidValue
from escapement.base.units import INCH, INCH_POUND, POUND_FORCE
from escapement.dynamics.figure_table import FIGURES
from escapement.study.parse import parse_plan, plan_from
from escapement.study.subject import ESCAPEMENT
from study_tools import assert_as_alone

WHEEL = esc.Geneva(4, crank_radius=0.02)
TIMER = esc.Escapement(WHEEL, esc.Inertia(3.4e-7, 5.6e-6), 0.0113, 0.35)
INCHES = {
    "units": "in-lbf-s",
    "mechanism": {"slots": 4, "crank_radius": 0.5},
    "inertia": {"driver": 3e-6, "follower": 50e-6},
    "sweep": {"friction": [0.3], "torque": [0.1]},
}
PIN = {"pin_length": 2e-3, "pin_gap": 1e-4, "pin_material": "steel", "wheel_material": "brass"}
JOURNALS = {"follower_bearing_friction": 0.1, "follower_bearing_radius": 1e-3}
INSIDE = esc.Geneva(5, internal=True, crank_radius=0.02)
UNEVEN = replace(WHEEL, centre_distance_error=2e-5)
DRIVES = {
    "losses": (TIMER, {"friction": [0.0, 0.2, 0.5], "torque": [0.01, 0.04]}),
    "wheels": (TIMER, {"slots": [3, 4], "follower_inertia": [1e-6, 1e-5]}),
    "starts": (TIMER, {"torque": [0.01, 0.02], "initial_speed": [0.0, 90.0], "slots": [3, 8]}),
    "inside": (replace(TIMER, mechanism=INSIDE), {"load_torque": [0.0, 2e-4], "torque": [0.01]}),
    "uneven": (replace(TIMER, mechanism=UNEVEN), {"friction": [0.2], "torque": [0.01, 0.03]}),
    "loaded pins": (
        replace(TIMER, mechanism=replace(WHEEL, pins=1, pin_radius=1e-3), **PIN, **JOURNALS),
        {"friction": [0.02, 0.2], "torque": [0.01, 0.03], "pin_length": [1e-3, 2e-3]},
    ),
    "pins": (
        replace(TIMER, mechanism=replace(WHEEL, pin_radius=1e-3)),
        {"load_torque": [0.0, 1e-3, 1.0]},
    ),
    "widths": (TIMER, {"pin_radius": [0.0, 5e-4, 1e-3], "driver_inertia": [1e-7, 1e-6]}),
    "clearance": (TIMER, {"clearance": [0.0, 2e-5], "friction": [0.2, 0.3]}),
    "trains": (
        replace(TIMER, torque=0.0565, barrel=esc.Train(5.0, 0.8, 8e-6), load_train=esc.Train(3.0)),
        {"barrel_ratio": [4.0, 5.0], "load_train_inertia": [0.0, 6e-8]},
    ),
    "a mesh": (
        esc.Escapement(esc.EllipticalPlanetary(0.02, 0.007), TIMER.inertia, 0.01, efficiency=0.9),
        {"initial_speed": [0.0, 100.0]},
    ),
}


@pytest.mark.parametrize(
    "drive", [pytest.param(d, marks=[pytest.mark.slow] * (d == "uneven")) for d in DRIVES]
)
def test_every_figure_is_what_terminal_says(drive):
    # the time of a run needs its turns, and is no figure of a cycle
    names = [name for name in FIGURES if name != "run_time"]
    plan = plan_from(*DRIVES[drive], results=names)
    study = esc.run_plan(plan)
    assert [*study.results] == [*names, "status"]
    assert_as_alone(plan, study.results)


@each_engine
def test_results_are_in_the_units_of_the_study(engine):
    names = ["contact_moment_max", "contact_force_max", "acceleration_max", "jam_margin"]
    study = esc.run_plan(parse_plan(INCHES | {"results": names, "solver": {"engine": engine}}))
    inertia = esc.Inertia(3e-6 * INCH_POUND, 50e-6 * INCH_POUND)
    wheel = esc.Geneva(4, crank_radius=0.5 * INCH)
    cycle = esc.terminal(esc.Escapement(wheel, inertia, 0.1 * INCH_POUND, 0.3), engine=engine)
    for name, unit in zip(names, (INCH_POUND, POUND_FORCE, 1.0, 1.0), strict=True):
        value = getattr(cycle, name) / unit
        assert study.results[name].item() == pytest.approx(value, rel=1e-9)
    assert [study.units[name] for name in names] == ["in lbf", "lbf", "rad s-2", "1"]
    assert study.results["status"].dtype == np.uint8


@pytest.mark.parametrize("names", [["period"], ["rise_time"], ["jam_margin", "rise_time_98"]])
def test_no_number_depends_on_what_else_is_asked_for(names):
    axes = {"friction": np.linspace(0.05, 0.5, 50), "initial_speed": [0.0, 300.0]}
    some = esc.sweep(TIMER, results=names, **axes).results
    every = esc.sweep(TIMER, results=[*ESCAPEMENT.usual, *names, *names, "status"], **axes).results
    assert [*some] == [*names, "status"]
    assert len(every) == len({*ESCAPEMENT.usual, *names, "status"})
    for name, values in some.items():
        np.testing.assert_array_equal(values, every[name])


def test_the_usual_results_need_not_be_named():
    plain, named = parse_plan(INCHES), parse_plan(INCHES | {"results": [*ESCAPEMENT.usual]})
    assert plain.configuration == named.configuration
    other = parse_plan(INCHES | {"results": ["period", "status", "period"]})
    assert [*other.results] == ["period", "status"]
    assert parse_plan(other.configuration).results == other.results


@pytest.mark.parametrize("given", ["period", [], ["perod"], ["period", 3], [["period"]], 7])
def test_what_is_no_list_of_figures_is_refused_in_a_line(given):
    said = "did you mean 'period'" if given == ["perod"] else "results must be"
    with pytest.raises(InvalidValue, match=said) as error:
        esc.sweep(TIMER, friction=[0.3], results=given)
    assert "\n" not in str(error.value)
    if isinstance(given, list) and given:
        assert all(name in str(error.value) for name in FIGURES)


def test_a_chosen_study_is_written_read_and_drawn(tmp_path):
    names = ["contact_moment_max", "last_reversal_angle", "rise_time", "rise_time_63"]
    axes = {"friction": np.linspace(0.1, 0.4, 6), "torque": np.linspace(0.01, 0.02, 5)}
    made = esc.sweep(TIMER, results=names, path=tmp_path / "a.h5", **axes)
    for name, values in esc.sweep(TIMER, results=names, **axes).results.items():
        np.testing.assert_array_equal(made.results[name], values)
    # lines and maps of each, and a bar for each map
    assert len(plots.plot_study(made).axes) == 3 * len(names)
    labels = [ax.get_ylabel() for ax in plots.plot_study(made, ["rise_time_63"]).axes]
    assert labels[0] == "Rise time, 63 % (ms)"
    with pytest.raises(InvalidValue, match=r"result must be one of contact_moment_max, .*'period'"):
        plots.plot_study(made, ["period"])
