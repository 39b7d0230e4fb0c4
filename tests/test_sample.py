"""Samples: drawn as asked for, or refused in one line that helps."""

import json
from statistics import NormalDist

import numpy as np
import pytest

from escapement.base.errors import InvalidValue
from escapement.study.parse import parse_plan

GOOD = {
    "mechanism": {"slots": 4},
    "inertia": {"driver": 3e-6, "follower": 50e-6},
    "torque": 0.1,
    "friction": 0.3,
}
EVEN = {"low": 0.2, "high": 0.3}


def sample(method="latin-hypercube", size=64, **parameters):
    """The plan of a sample around `GOOD`."""
    return parse_plan(GOOD | {"sample": {"method": method, "size": size} | parameters})


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol"])
def test_every_stratum_of_every_parameter_holds_one_case(method):
    drawn = sample(
        method,
        friction=EVEN,
        torque={"relative_tolerance": 0.1},
        driver_inertia={"low": 1e-6, "high": 8e-6, "log": True},
        follower_inertia={"relative_standard_deviation": 0.02},
        initial_speed={"low": 0.0, "high": 5.0},
    )
    values = drawn.sampled
    normal = NormalDist(50e-6, 1e-6)
    shares = {
        "friction": (values["friction"] - 0.2) / 0.1,
        "torque": (values["torque"] - 0.09) / 0.02,
        "driver_inertia": np.log(values["driver_inertia"] / 1e-6) / np.log(8.0),
        "follower_inertia": np.array([normal.cdf(v) for v in values["follower_inertia"]]),
        "initial_speed": values["initial_speed"] / 5.0,
    }
    for name, share in shares.items():
        assert sorted(np.floor(share * 64).astype(int)) == list(range(64)), name


def test_a_normal_distribution_can_be_cut_off():
    cut = {"standard_deviation": 0.1, "low": 0.25, "high": 0.5}
    values = sample(friction=cut).sampled["friction"]
    normal = NormalDist(0.3, 0.1)
    below, above = normal.cdf(0.25), normal.cdf(0.5)
    share = (np.array([normal.cdf(v) for v in values]) - below) / (above - below)
    assert sorted(np.floor(share * 64).astype(int)) == list(range(64))
    assert values.min() >= 0.25
    assert values.max() <= 0.5


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"relative_tolerance": 0.1}, {"tolerance": 0.03}),
        ({"tolerance": 0.03}, {"low": 0.27, "high": 0.33}),
        ({"relative_standard_deviation": 0.1}, {"standard_deviation": 0.03}),
    ],
)
def test_two_ways_to_say_the_same(one, other):
    values = [sample(friction=form).sampled["friction"] for form in (one, other)]
    np.testing.assert_allclose(*values, rtol=1e-14)


def test_the_seed_decides_and_is_always_recorded():
    one, again, other = (sample(friction=EVEN, **seed) for seed in ({}, {"seed": 0}, {"seed": 1}))
    assert one.configuration["sample"]["seed"] == 0
    np.testing.assert_array_equal(one.sampled["friction"], again.sampled["friction"])
    assert not np.isin(one.sampled["friction"], other.sampled["friction"]).any()
    assert one.fingerprint == again.fingerprint != other.fingerprint


def test_a_list_is_taken_case_by_case():
    lists = {"friction": [0.1, 0.2, 0.3], "slots": [4, 3, 6], "torque": [0.1, 0.2, 0.4]}
    plan = parse_plan(GOOD | {"sample": {"method": "list"} | lists})
    assert plan.shape == (3,)
    assert [plan.escapement(i).mechanism.slots for i in range(3)] == lists["slots"]
    assert [plan.escapement(i).torque for i in range(3)] == lists["torque"]
    even = {"method": "list", "friction": {"start": 0.1, "stop": 0.3, "num": 3}, "slots": [4, 3, 6]}
    values = parse_plan(GOOD | {"sample": even}).sampled
    np.testing.assert_array_equal(values["friction"], np.linspace(0.1, 0.3, 3))


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol", "list"])
@pytest.mark.parametrize("axes", [{}, {"slots": [3, 4]}])
def test_a_plan_is_what_its_configuration_says(method, axes):
    forms = {"friction": EVEN, "torque": {"tolerance": 0.01}}
    if method == "list":
        forms = {"friction": [0.2, 0.3], "torque": [0.1, 0.2]}
    else:
        forms |= {"size": 8, "seed": 5}
    plan = parse_plan(GOOD | {"sweep": axes, "sample": {"method": method} | forms})
    again = parse_plan(json.loads(json.dumps(plan.configuration)))
    assert again.configuration == plan.configuration
    assert again.fixed_si == plan.fixed_si
    assert ("torque" in plan.configuration) == (method != "list")  # the nominal value
    for case in range(plan.cases):
        assert again.values(case) == plan.values(case)


REFUSED = [
    ({"method": "sobl", "friction": EVEN}, "sample.method must be one of random, latin-hypercube"),
    ({"size": 4}, "the sample must vary at least one parameter, got none"),
    ({"size": 0, "friction": EVEN}, "sample.size must be a whole number of at least 1, got 0"),
    ({"size": 10**8, "friction": EVEN}, "sample.size must be a whole number of at most 10000000"),
    (
        {"method": "sobol", "size": 1000, "friction": EVEN},
        "sample.size must be a power of two with method 'sobol', got 1000; only then its points "
        "are evenly spread: give 512 or 1024",
    ),
    ({"size": 4, "seed": -1, "friction": EVEN}, "sample.seed must be a whole number of at least 0"),
    ({"sise": 4, "friction": EVEN}, "unknown key 'sise' in [sample]; did you mean 'size'?"),
    ({"size": 4, "friction": 0.1}, "sample.friction must be a table that says how it varies"),
    ({"size": 4, "friction": {"low": 0.3, "high": 0.2}}, "high must be greater than low = 0.3"),
    ({"size": 4, "friction": {"low": -0.1, "high": 0.2}}, "sample.friction.low must be at least 0"),
    ({"size": 4, "friction": EVEN | {"tolerance": 1}}, "'low' in sample.friction with tolerance"),
    ({"size": 4, "friction": {"tolerance": 0.4}}, "the lowest value of sample.friction must be at"),
    (
        {"size": 4, "friction": {"low": 0.0, "high": 0.2, "log": True}},
        "sample.friction.low must be greater than 0, got 0.0; a logarithmic spread",
    ),
    ({"size": 4, "friction": {"tolerance": 0.1, "log": True}}, "'log' in sample.friction with tol"),
    (
        {"size": 4, "friction": {"tolerance": 0.1, "relative_tolerance": 0.1}},
        "unknown key 'relative_tolerance' in sample.friction with tolerance",
    ),
    (
        {"size": 64, "friction": {"standard_deviation": 0.2}},
        "cut its distribution off with low or high",
    ),
    (
        {"size": 4, "friction": {"standard_deviation": 0.1, "low": 0.4}},
        "sample.friction must have its nominal value between low and high, got 0.3",
    ),
    (
        {"size": 4, "load_torque": {"relative_tolerance": 0.1}},
        "must be a part of a nominal value other than 0, got 0; give tolerance in its own unit",
    ),
    ({"size": 4, "slots": EVEN}, "whole numbers and fractions cannot be drawn at random"),
    ({"method": "list", "size": 2, "friction": [1]}, 'in [sample] with method "list"'),
    (
        {"method": "list", "friction": [0.1, 0.2], "torque": [1.0]},
        "sample.torque must have as many values as friction, got 1 and 2",
    ),
    ({"method": "list", "slots": [3, 1000001]}, "slots[1] must be a whole number of at most"),
]  # fmt: skip


@pytest.mark.parametrize(("table", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_a_refusal_is_one_line_that_helps(table, message):
    if isinstance(table, dict) and table and "method" not in table:
        table = {"method": "latin-hypercube"} | table
    with pytest.raises(InvalidValue) as caught:
        parse_plan(GOOD | {"sample": table})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_missing_or_said_twice():
    lacking = {key: value for key, value in GOOD.items() if key != "torque"}
    drawn = {"method": "sobol", "size": 4}
    with pytest.raises(InvalidValue, match="nominal value to spread around, got none; give torque"):
        parse_plan(lacking | {"sample": drawn | {"torque": {"tolerance": 0.01}}})
    assert parse_plan(lacking | {"sample": drawn | {"torque": EVEN}}).cases == 4
    with pytest.raises(InvalidValue, match=r"friction must be in \[sweep\] or in \[sample\], got"):
        parse_plan(GOOD | {"sweep": {"friction": [0.1]}, "sample": drawn | {"friction": EVEN}})
    with pytest.raises(InvalidValue, match=r"'size' at the top level; it belongs in \["):
        parse_plan(GOOD | {"size": 4})


def test_fractions_are_not_drawn():
    machine = {"kind": "gear-driven", "curve": "hypocycloid", "stations": 5, "lobes": "1/2"}
    drawn = {"method": "sobol", "size": 4, "lobes": EVEN}
    with pytest.raises(InvalidValue, match=r"sample\.lobes must be left out, whole numbers"):
        parse_plan(GOOD | {"mechanism": machine, "sample": drawn})
