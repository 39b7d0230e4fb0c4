"""A second way to follow a runaway escapement, which shares nothing with the package.

Tooth and pallets are straight cores within rounded edges. The gap is the distance of the cores less
both radii. Time goes on in equal small steps; after each one, bodies that overlap and approach get
an impulse. Nothing distinguishes a lasting contact from many small blows. The error of a period is
in proportion to the step.
"""

import cmath
import math

import numpy as np
from numba import njit

PLASTIC = 1e-4  # slower blows do not rebound


def cores(teeth, span, lead, back, tip, pallet_radius, pin=0.0, face=None):
    """Cores of tooth and pallets, the sum of their radii, and the distance of the axes.

    face : angle, length, thickness and corner radius of flat pallets; else there are pins.
    """
    apex = 1.0 - tip
    tooth = np.array([apex, apex - 0.3 * cmath.exp(-1j * lead), apex - 0.3 * cmath.exp(1j * back)])
    half = span * math.pi / teeth
    centre, pallets = pallet_radius / math.cos(half), []
    for radial in (cmath.exp(-1j * half), cmath.exp(1j * half)):
        corner = pallet_radius * radial
        outline = [corner]
        if face:
            beta, length, thickness, pin = face
            along, across = radial * cmath.exp(-1j * beta), 1j * radial * cmath.exp(-1j * beta)
            first = corner + pin * (along + across)
            far, deep = (length - 2 * pin) * along, (thickness - 2 * pin) * across
            outline = [first, first + far, first + far + deep, first + deep]
        pallets.append(np.array(outline) - centre)
    return tooth, np.array(pallets), tip, pin, centre


@njit
def foot(point, start, end):
    """The point of a straight line that is nearest to a point."""
    u = end - start
    if u == 0.0:
        return start
    share = ((point - start) * u.conjugate()).real / abs(u) ** 2
    return start + min(1.0, max(0.0, share)) * u


@njit
def nearest(tooth, pallet, pitch, theta, phi, centre):
    """The nearest points of a tooth's core and of a pallet's core."""
    turned = centre + pallet * np.exp(1j * phi)
    first, best = np.floor((np.angle(turned[0]) - theta) / pitch), (1e9, 0j, 0j)
    for k in range(3):
        here = tooth * np.exp(1j * (theta + (first - 1 + k) * pitch))
        for j in range(1, 3):
            for i in range(turned.size):
                a = foot(turned[i], here[0], here[j])
                if abs(turned[i] - a) < best[0]:
                    best = abs(turned[i] - a), a, turned[i]
                b = foot(here[0], turned[i], turned[(i + 1) % turned.size])
                if abs(b - here[0]) < best[0]:
                    best = abs(b - here[0]), here[0], b
    return best


@njit
def struck(speeds, inertias, normal, arms, friction, restitution):
    """Speeds after a blow: normal impulse, friction and slip go on together (Routh, Poisson)."""
    sense = np.array([-1.0, 1.0])
    g = sense * (arms.conjugate() * normal).imag
    h = sense * (arms.conjugate() * normal * 1j).imag
    opening, slip = (g * speeds).sum(), (h * speeds).sum()
    if opening >= 0.0:
        return speeds
    restitution = restitution if opening < -PLASTIC else 0.0
    nn, nt, tt = (g * g / inertias).sum(), (g * h / inertias).sum(), (h * h / inertias).sum()
    impulse, along, end = 0.0, 0.0, -1.0
    while True:
        sticks = slip == 0.0 and abs(nt) <= friction * tt
        sign = np.sign(slip) if slip != 0.0 else np.sign(nt)
        share = -nt / tt if sticks else -friction * sign
        rate, change = nn + nt * share, nt + tt * share
        step = -opening / rate if end < 0.0 else end - impulse
        stops = slip * change < 0.0 and -slip / change < step
        step = -slip / change if stops else step
        impulse, along, opening = impulse + step, along + share * step, opening + rate * step
        slip = 0.0 if stops or sticks else slip + change * step
        if stops:
            continue
        if end >= 0.0 or restitution == 0.0:
            return speeds + (g * impulse + h * along) / inertias
        end, opening = (1.0 + restitution) * impulse, 0.0


@njit
def marks(shape, teeth, inertias, friction, restitution, start, count, step):
    """Times at which the wheel has turned by whole pitches, from rest under a torque of 1."""
    tooth, pallets, tip, pin, centre = shape
    pitch, theta, phi, t = 2.0 * np.pi / teeth, start, 0.0, 0.0
    speeds, found, times = np.zeros(2), 0, np.full(count, np.nan)
    while found < count and t < 3.0 * count:
        theta += speeds[0] * step + 0.5 * step * step / inertias[0]
        phi += speeds[1] * step
        speeds[0] += step / inertias[0]
        t += step
        for _ in range(2):
            for k in range(2):
                distance, a, b = nearest(tooth, pallets[k], pitch, theta, phi, centre)
                if distance < tip + pin:
                    normal = (b - a) / distance
                    point = a + tip * normal
                    arms = np.array([point, point - centre])
                    speeds = struck(speeds, inertias, normal, arms, friction, restitution)
        if theta >= (found + 1) * pitch:
            times[found] = t - (theta - (found + 1) * pitch) / max(speeds[0], 1e-9)
            found += 1
    return times
