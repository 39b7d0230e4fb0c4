"""A study of random results, its blocks, and files compared."""

import threading

import numpy as np
import pytest

from escapement.engines import simulate as simulation
from escapement.mechanisms import Geneva
from escapement.model.escapement import Escapement, Inertia
from escapement.study.block import blocks_of, encode_block
from escapement.study.reader import read_study
from escapement.study.result import RESULTS, Study
from escapement.study.stored import LAYOUT
from escapement.study.writer import study_writer

TIMER = Escapement(Geneva(slots=4), Inertia(3.39e-7, 5.65e-6), 0.0113, 0.35)
IVP_STUDY = """
torque = 0.01
[mechanism]
slots = 4
[inertia]
driver = 3e-7
follower = 6e-6
[sweep]
friction = { start = 0.01, stop = 0.3, num = 40 }
[solver]
engine = "ivp"
"""
ATTRIBUTES = {
    "title": "a study – of µ",
    **LAYOUT,
    "package_version": "0.1.0",
    "engine": "energy",
    "rtol": 1e-12,
    "created": "2000-01-01T00:00:00+00:00",
}


def assert_as_alone(plan, results):
    """Every case is what `terminal` says of it alone."""
    for case in range(plan.cases):
        speed = plan.values(case)["initial_speed"]
        alone = simulation.terminal(plan.escapement(case), initial_speed=speed)
        for name in plan.results:
            value = results[name].reshape(-1)[case]
            assert value == pytest.approx(getattr(alone, name), rel=1e-11, nan_ok=True), name


def let_go():
    """Wait until the threads that an interrupted sweep left behind have ended their cases."""
    for thread in threading.enumerate():
        if thread.name.startswith("escapement-sweep"):
            thread.join()


def study(shape=(3, 5), seed=0, **attributes):
    """A study of random results, some of them missing."""
    rng = np.random.default_rng(seed)
    names = ("friction", "torque", "slots")[: len(shape)]
    axes = {name: np.linspace(0.1, 0.4, n) for name, n in zip(names, shape, strict=True)}
    if "slots" in axes:
        axes["slots"] = np.arange(3, 3 + shape[2])
    results = {}
    for name, result in RESULTS.items():
        values = rng.integers(0, 6, shape) if name == "status" else rng.random(shape)
        results[name] = values.astype(result.dtype)
    for name in results.keys() - {"status"}:
        results[name][results["status"] > 0] = np.nan
    fixed = {"driver_inertia": 3e-6, "pins": 1}
    units = dict.fromkeys((*axes, *fixed), "1") | {"torque": "in lbf"}
    return Study(
        axes=axes,
        results=results,
        units=units | {name: result.units for name, result in RESULTS.items()},
        long_names=dict.fromkeys(units, "a number") | {n: r.long_name for n, r in RESULTS.items()},
        configuration={"sweep": {name: values.tolist() for name, values in axes.items()}},
        attributes=ATTRIBUTES | attributes,
        fixed=fixed,
    )


def block(whole, number):
    cut = blocks_of(whole)
    span = slice(*cut.span(number))
    columns = {name: values.reshape(-1)[span] for name, values in whole.results.items()}
    return encode_block(cut, number, columns)


def write_in_blocks(path, whole, order, **options):
    """Write the missing blocks in some order; returns their numbers."""
    with study_writer(path, whole, **options) as writer:
        numbers = order(writer.missing)
        for number in numbers:
            writer.add(block(whole, number))
    return numbers


def assert_same(one, other):
    assert list(one.axes) == list(other.axes)
    for name in one.axes:
        np.testing.assert_array_equal(one.axes[name], other.axes[name])
    for name in RESULTS:
        np.testing.assert_array_equal(one.results[name], other.results[name])
    assert one.attributes == other.attributes
    assert one.fixed == other.fixed
    assert one.configuration == other.configuration


def read_whole(path):
    """A study with every array read, each at its first use."""
    study = read_study(path)
    for values in study.columns.values():
        np.asarray(values)
    return study


def a_file(tmp_path):
    (tmp_path / "file.h5").write_text("precious")
    return tmp_path / "file.h5"


def without_date(path):
    """Bytes of a study file, its date of creation blanked."""
    created = read_study(path).attributes["created"].encode()
    return path.read_bytes().replace(created, b"0" * len(created))
