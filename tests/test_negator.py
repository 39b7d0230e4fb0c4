"""The torque of a constant-force spring, judged by the energy that its strip gives back."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import escapement as esc
from escapement.base.errors import InvalidValue

STRIP = {"width": 0.006, "thickness": 8e-5, "natural_radius": 0.006}


def bending_energy(length, curvature, modulus=200e9):
    """Of a straight bar's bending from the curl, by layers of fibres across the thickness."""
    places, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * STRIP["thickness"]
    strain = half * places * (curvature - 1.0 / STRIP["natural_radius"])
    density = 0.5 * modulus * strain**2
    return length * STRIP["width"] * half * float(weights @ density)


@given(output=st.floats(0.004, 0.05), storage=st.floats(1.0, 5.0), turned=st.floats(0.01, 50.0))
def test_the_work_is_the_energy_of_bending(output, storage, turned):
    store = storage * STRIP["natural_radius"]
    length = output * turned
    spent = bending_energy(length, -1.0 / output) - bending_energy(length, 1.0 / store)
    torque = esc.negator_torque(**STRIP, output_radius=output, storage_radius=store)
    assert torque * turned == pytest.approx(spent, rel=1e-12)


def test_a_very_wide_output_drum_pulls_like_a_straight_strip():
    """The force of a strip drawn out straight is E b t^3/(24 Rn^2)."""
    radius = 1e6 * STRIP["natural_radius"]
    stiffness = 200e9 * STRIP["width"] * STRIP["thickness"] ** 3
    pull = stiffness / (24.0 * STRIP["natural_radius"] ** 2)
    assert esc.negator_torque(**STRIP, output_radius=radius) / radius == pytest.approx(pull, 3e-6)


def test_layers_change_the_torque_a_little():
    """The work over many turns, the drum growing by a layer each, is still the energy."""
    turns, t = 50, STRIP["thickness"]
    angle = np.linspace(0.0, 2.0 * math.pi * turns, 2001)
    radius = 0.012 + t * angle / (2.0 * math.pi)
    torque = np.array([esc.negator_torque(**STRIP, output_radius=r) for r in radius])
    steps = np.diff(angle)
    work = float(steps @ (0.5 * (torque[1:] + torque[:-1])))
    middle = 0.5 * (radius[1:] + radius[:-1])
    stored = sum(map(bending_energy, middle * steps, -1.0 / middle))
    assert work == pytest.approx(stored, rel=1e-6)


@pytest.mark.parametrize("name", ["width", "thickness", "natural_radius", "output_radius"])
def test_nothing_must_be_zero(name):
    with pytest.raises(InvalidValue, match=f"{name} must be"):
        esc.negator_torque(**({"output_radius": 0.01} | STRIP | {name: 0.0}))


def test_a_storage_drum_is_not_below_the_curl():
    with pytest.raises(InvalidValue, match="storage_radius must be at least the natural_radius"):
        esc.negator_torque(**STRIP, output_radius=0.01, storage_radius=0.005)
