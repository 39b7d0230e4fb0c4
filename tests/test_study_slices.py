"""A study at some values of its axes."""

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from study_tools import study


def test_a_slice_holds_the_cases_at_that_value():
    whole = study((3, 5, 4))
    part = whole.at(slots=5, friction=0.25)
    assert part.shape == (1, 5, 1)
    assert part.axes["slots"] == [5]
    for name, values in whole.results.items():
        np.testing.assert_array_equal(part.results[name], values[1:2, :, 2:3])
    assert sum(part.outcomes.values()) == part.cases == 5
    assert whole.at().shape == whole.shape


def test_a_case_of_a_sample_keeps_what_was_drawn():
    timer = esc.Escapement(esc.Geneva(slots=4), esc.Inertia(3e-7, 6e-6), friction=0.2, torque=0.01)
    drawn = {"method": "sobol", "size": 8, "driver_inertia": {"relative_tolerance": 0.1}}
    whole = esc.sweep(timer, torque=[0.01, 0.02], sample=drawn)
    part = whole.at(case=6)
    assert part.sampled["driver_inertia"] == whole.sampled["driver_inertia"][6]
    np.testing.assert_array_equal(part.results["period"], whole.results["period"][:, 6:7])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"torque": 0.1001}, "torque must be a value of the study, got 0.1001; the nearest is 0.1"),
        ({"torque": np.nan}, "torque must be a finite number, got nan"),
        ({"torque": None}, "torque must be a finite number"),
        ({"torqe": 0.1}, "axis must be one of friction, torque, got 'torqe'; did you mean"),
    ],
)
def test_what_is_not_there_is_refused(values, message):
    with pytest.raises(InvalidValue, match=message):
        study().at(**values)
