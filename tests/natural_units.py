"""Escapements in natural units: the follower's inertia and, if not said, the torque are 1."""

import escapement as esc


def drive(slots=4, pins=None, rho=0.06, mu=0.35, load=0.0, torque=1.0, **wheel):
    """A Geneva wheel's escapement; rho is the driver's inertia."""
    mechanism = esc.Geneva(slots, pins, **wheel)
    return esc.Escapement(mechanism, esc.Inertia(rho, 1.0), torque, mu, load)
