"""Random Geneva escapements over the whole range of every number, limits included."""

import math
from typing import NamedTuple

import independent

import escapement as esc


class Problem(NamedTuple):
    """One case in natural units: follower inertia and torque are 1."""

    slots: int
    pins: int
    internal: bool
    rho: float
    mu: float
    load: float
    speed: float
    rtol: float
    share: float  # friction over the Painleve limit

    @property
    def physics(self):
        return self[:7]

    @property
    def model(self):
        wheel = esc.Geneva(slots=self.slots, pins=self.pins, internal=self.internal)
        inertia = esc.Inertia(driver=self.rho, follower=1.0)
        return esc.Escapement(wheel, inertia, 1.0, self.mu, self.load)


def draw(random, smallest_rtol=1e-13):
    """A random case; a share of the cases lies at each limit of the range."""
    internal = bool(random.random() < 0.15)
    few = random.random() < 0.9
    slots = int(random.integers(3, 41) if few else round(10 ** random.uniform(1.6, 3)))
    most = 1 if internal else 2 * slots // (slots - 2)
    pins = int(random.integers(1, most + 1))
    decades = 3 if random.random() < 0.75 else 8
    rho = 10 ** random.uniform(-decades, decades)
    case = independent.case_of(slots, pins, internal, rho, 0.0, 0.0)
    limit = independent.critical_friction(case)
    kind = random.random()
    if kind < 0.4:
        mu = random.uniform(0.0, 1.0) * limit
    elif kind < 0.65:
        mu = 10 ** random.uniform(-6, 0) * limit
    elif kind < 0.8:
        mu = 10 ** random.uniform(-12, 0)
    elif kind < 0.95:
        mu = (1.0 - 10 ** random.uniform(-6, -1)) * limit
    else:
        mu = 0.0
    mu = min(mu, 0.999999 * limit)
    # the load whose work over a cell equals that of the drive
    bearable = (2.0 * case.beta + case.dwell) * slots / (2.0 * math.pi)
    kind = random.random()
    if kind < 0.5:
        load = 0.0
    elif kind < 0.8:
        load = random.uniform(0.0, 1.0) * bearable
    elif kind < 0.9:
        load = 10 ** random.uniform(-6, 0) * bearable
    else:
        load = random.uniform(0.9, 1.3) * bearable
    kind = random.random()
    speed = 0.0 if kind < 0.5 else 10 ** random.uniform(-3 if kind < 0.9 else -8, 3)
    rtol = 10 ** random.uniform(math.log10(smallest_rtol), -3)
    return Problem(slots, pins, internal, rho, mu, load, speed, rtol, mu / limit)
