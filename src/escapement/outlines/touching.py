"""Bodies of the kinds whose outlines touch anywhere, in any pose, and the room between them.

The driver's axis is the origin, and the follower's lies on the x axis; lengths are in the
mechanism's unit.
"""

import cmath
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from escapement.mechanisms.chains import Chain
from escapement.mechanisms.escape_wheel import EscapeWheel
from escapement.mechanisms.protocol import FloatArray
from escapement.mechanisms.two_bodies import TwoBodies
from escapement.outlines.bodies import Body, Disc
from escapement.outlines.curves import Curve, chain
from escapement.outlines.gaps import gap, segments_of
from escapement.outlines.interference import Nearest

PLATE = 0.06  # width of the verge's plate around its axis and pallets, in wheel radii
_SAMPLES = 33  # poses of each pallet
_POINTS = 96  # points of each line and arc of a pallet


class Turn(NamedTuple):
    """Poses over a pitch, in which the wheel pushes one pallet after the other.

    theta, phi : angles of wheel and verge [rad].
    free : the pallet that is not pushed: 0 for entry, 1 for exit.
    """

    theta: FloatArray
    phi: FloatArray
    free: FloatArray


def edges_of(chains: Sequence[Chain], fold: int = 1) -> tuple[Curve, ...]:
    """The edges of a whole body from the chains of one of its equal sectors."""
    found = []
    for one in chains:
        turns = np.exp(2j * np.pi * np.arange(fold) / fold)
        if one.closed:
            found += [Curve(one.points, one.bulges).moved(turn) for turn in turns.tolist()]
        elif fold > 1 and abs(one.points[-1] - one.points[0] * turns[1]) <= 1e-9 * abs(
            one.points[0]
        ):
            corners = np.concatenate([one.points[:-1] * turn for turn in turns])
            found.append(Curve(corners, np.tile(one.bulges, fold)))
        else:
            # an open chain is drawn there and back
            points = np.concatenate([one.points, one.points[-2:0:-1]])
            bulges = np.concatenate([one.bulges, -one.bulges[::-1]])
            found += [Curve(points, bulges).moved(turn) for turn in turns.tolist()]
    return tuple(found)


def turn_of(mechanism: EscapeWheel) -> Turn:
    """One pitch of an escape wheel that pushes the verge to and fro."""
    ends, columns = mechanism.alternation, []
    swing = np.linspace(ends.exit_release, ends.entry_release, _SAMPLES)
    for pallet, phi in ((0, swing), (1, swing[::-1])):
        theta = mechanism.blocked(phi, _POINTS)[:, pallet, 0]
        # the pallet leaves the wheel at the last angle
        leaving = cmath.phase(mechanism.innermost(pallet, float(phi[-1])))
        theta = np.where(np.isnan(theta), leaving, theta)
        columns.append((theta, phi, np.full(phi.size, 1.0 - pallet)))
    (entry, *_), (exit_, *_) = columns
    # the exit pallet meets the first tooth that comes after the entry pallet's release
    ahead = (entry[-1] - exit_[0]) / mechanism.pitch
    exit_ += mechanism.pitch * math.ceil(ahead - 1e-9)
    return Turn(*(np.concatenate(column) for column in zip(*columns, strict=True)))


def verge_angle(mechanism: TwoBodies, theta: float) -> float:
    """Follower angle to draw at a driver angle [rad]: that at which the wheel pushes a pallet."""
    if not isinstance(mechanism, EscapeWheel):
        return float(mechanism.start[1])
    turn = turn_of(mechanism)
    from_start = turn.theta[0] + (theta - turn.theta[0]) % mechanism.pitch
    return float(np.interp(from_start, turn.theta, turn.phi))


def bodies(mechanism: TwoBodies, theta: float, phi: float) -> list[Body | Disc]:
    """All bodies at angles of driver and follower [rad]: shafts, plate, driver and follower."""
    axis = mechanism.axes_distance
    driver = Body("driver", edges_of(mechanism.driver_chains, mechanism.driver_fold))
    follower = Body("follower", edges_of(mechanism.follower_chains, mechanism.follower_fold))
    found: list[Body | Disc] = []
    if isinstance(mechanism, EscapeWheel):
        found.append(Body("plate", (plate(mechanism),)).rotated(phi, axis))
    found += [driver.rotated(theta), follower.rotated(phi, axis)]
    return [*found, Disc("shaft", 0.0, 0.5 * PLATE), Disc("shaft", axis, 0.5 * PLATE)]


def pallet_centres(mechanism: EscapeWheel) -> list[complex]:
    """The middles of the entry and the exit pallet, from the verge's axis."""
    boxes = [Curve(one.points, one.bulges).box for one in mechanism.follower_chains]
    return [0.5 * (low + high) for low, high in boxes]


def plate(mechanism: EscapeWheel, width: float = PLATE) -> Curve:
    """Edge of the plate that carries the pallets, behind the wheel, from the verge's axis.

    width : from the axis and the middles of the pallets to the edge.
    """
    entry, exit_ = pallet_centres(mechanism)
    return chain([0.0, exit_, entry], [0.0, 0.0, 0.0]).grown(width)


def least_gaps(mechanism: TwoBodies) -> list[Nearest]:
    """The gap of the bodies at the start of a motion, and the least gaps of two pallets.

    The latter are those of each pallet to the wheel while this pushes the other one.
    """
    wheel = edges_of(mechanism.driver_chains, mechanism.driver_fold)
    theta, phi = mechanism.start
    follower = edges_of(mechanism.follower_chains, mechanism.follower_fold)
    size, point = _gap(mechanism, wheel, follower, theta, phi)
    found = [Nearest(("follower", "driver"), size, theta, point)]
    if not isinstance(mechanism, EscapeWheel):
        return found
    turn = turn_of(mechanism)
    for number, name in enumerate(("entry pallet", "exit pallet")):
        pallet = edges_of(mechanism.follower_chains[number : number + 1])
        rows = [
            (*_gap(mechanism, wheel, pallet, theta, phi), theta)
            for theta, phi, free in zip(*(column.tolist() for column in turn), strict=True)
            if free == number
        ]
        size, point, theta = min(rows, key=lambda row: row[0])
        found.append(Nearest((name, "driver"), size, theta, point))
    return sorted(found, key=lambda pair: pair.gap)


def _gap(
    mechanism: TwoBodies, wheel: Sequence[Curve], pallet: Sequence[Curve], theta: float, phi: float
) -> tuple[float, complex]:
    """Gap of two bodies, and its place from the follower's axis with the driver's on the right."""
    turn, axis = cmath.exp(1j * phi), mechanism.axes_distance
    driver = segments_of([edge.moved(cmath.exp(1j * theta)) for edge in wheel])
    size, point = gap(segments_of([edge.moved(turn, axis) for edge in pallet]), driver)
    return size, axis - point
