"""What the bodies do behind an event: the next mode.

`settle` decides whether a contact whose gap does not change is kept, `close` takes the blow of a
contact that begins, and `behind_event` goes on behind the event of a step.
"""

from typing import NamedTuple

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.engines.two_bodies.blow import strike
from escapement.engines.two_bodies.law import Mode, free, pushed, torques, touching
from escapement.engines.two_bodies.step import (
    DRIVER_STOPS,
    FOLLOWER_STOPS,
    JAMS,
    LIFTS,
    SLIPS,
)
from escapement.engines.two_bodies.touch import images, place, touch_at
from escapement.engines.two_bodies.watch import STILL
from escapement.numerics.jit import inner_jit

AT_REST = 1e-9
"""Bodies slower than this are at rest where both turn back."""
BESIDE, STAYS = 1e-8, 1e-7
"""A neighbour on a chain has a smaller gap than this, whose rate is slower than that."""


class Next(NamedTuple):
    """The next mode, and an `Ending` where there is none.

    approach, impulse, energy : of the blow before it, that of a kept contact included.
    """

    mode: Mode
    ending: Ending
    approach: float
    impulse: float
    energy: float


@inner_jit
def contact_of(pair, nose, track):
    """The mode in which a pair is closed, whose signs are still to be found."""
    return Mode(pair=pair, nose=nose, track=track, sigma=0.0, driver_sense=0.0, follower_sense=0.0)


@inner_jit
def _next(mode, ending):
    return Next(mode=mode, ending=ending, approach=0.0, impulse=0.0, energy=0.0)


@inner_jit
def _sense(speed, torque, held):
    """Sense of a body in a flight, of which friction holds a torque while it is at rest."""
    if speed != 0.0:
        return np.sign(speed)
    return np.sign(torque) if abs(torque) > held else 0.0


@inner_jit
def flight(law, y):
    """The mode of a flight, and whether nothing moves in it."""
    driver, follower = torques(law, y)
    mode = Mode(
        pair=-1, nose=0, track=0, sigma=0.0, driver_sense=_sense(y[2], driver, law.bearing),
        follower_sense=_sense(y[3], follower, law.load),
    )  # fmt: skip
    push = free(law, mode, y)
    stands = y[2] == 0.0 and y[3] == 0.0 and push.driver == 0.0 and push.follower == 0.0
    return _next(mode, Ending.STANDS if stands else Ending.RUNNING)


@inner_jit
def settle(law, pairs, contact, y):
    """The mode behind an instant at which a pair is closed.

    `contact` is the mode in which it is kept, whose signs are still to be found.
    """
    touch = touching(law, pairs, contact, y)
    if touch.g0 * y[2] + touch.g1 * y[3] > STILL:
        return flight(law, y)
    if abs(y[2]) + abs(y[3]) < AT_REST:
        return from_rest(law, pairs, contact, y)
    slip = touch.h0 * y[2] + touch.h1 * y[3]
    kept = Mode(
        pair=contact.pair, nose=contact.nose, track=contact.track, sigma=np.sign(slip),
        driver_sense=np.sign(y[2]), follower_sense=np.sign(y[3]),
    )  # fmt: skip
    push = pushed(law, kept, touch, y)
    if not push.yielding > 0.0:
        return _next(kept, Ending.JAM)
    return _next(kept, Ending.RUNNING) if push.force > 0.0 else flight(law, y)


@inner_jit
def from_rest(law, pairs, contact, y):
    """The mode of bodies at rest with a pair closed: they may turn in either sense, or fly."""
    touch, found, count, presses = touching(law, pairs, contact, y), contact, 0, False
    size = np.sqrt(touch.g0 * touch.g0 + touch.g1 * touch.g1)
    for way in (1.0, -1.0):
        driver, follower = way * touch.g1 / size, -way * touch.g0 / size
        mode = Mode(
            pair=contact.pair, nose=contact.nose, track=contact.track,
            sigma=np.sign(touch.h0 * driver + touch.h1 * follower),
            driver_sense=_sense(driver if abs(driver) > STILL else 0.0, 0.0, 0.0),
            follower_sense=_sense(follower if abs(follower) > STILL else 0.0, 0.0, 0.0),
        )  # fmt: skip
        push = pushed(law, mode, touch, y)
        if not push.yielding > 0.0:
            return _next(contact, Ending.JAM)
        presses = presses or push.force > 0.0
        if push.force > 0.0 and push.driver * driver + push.follower * follower > STILL:
            found, count = mode, count + 1
    if count == 1:
        return _next(found, Ending.RUNNING)
    if not presses:
        return flight(law, y)
    return _next(contact, Ending.STANDS if count == 0 else Ending.JAM)


@inner_jit
def _opens(law, pairs, of, mode, y):
    """gap'' of a pair in the mode of another one, or of a flight."""
    touch = touching(law, pairs, of, y)
    if mode.pair < 0:
        push = free(law, mode, y)
    else:
        push = pushed(law, mode, touching(law, pairs, mode, y), y)
    return touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower


@inner_jit
def _restart(law, pairs, old, new, y):
    """The mode of bodies at rest with two pairs closed, of which at most one stays so."""
    for kept, other in ((old, new), (new, old)):
        found = from_rest(law, pairs, kept, y)
        runs = found.ending == Ending.RUNNING and found.mode.pair >= 0
        if runs and _opens(law, pairs, other, found.mode, y) > 0.0:
            return found
    found = flight(law, y)
    if found.ending == Ending.RUNNING:
        first = _opens(law, pairs, old, found.mode, y)
        if first > 0.0 and _opens(law, pairs, new, found.mode, y) > 0.0:
            return found
    return _next(new, Ending.STALL)


@inner_jit
def _hit(law, pairs, contact, y, restitution):
    """Take the blow of a pair; returns it."""
    blow = strike(law, touching(law, pairs, contact, y), y[2], y[3], restitution)
    y[2], y[3] = blow.driver, blow.follower
    return blow


@inner_jit
def _rate(law, pairs, contact, y):
    touch = touching(law, pairs, contact, y)
    return touch.g0 * y[2] + touch.g1 * y[3]


@inner_jit
def kinetic(law, y):
    """Kinetic energy of both bodies."""
    return 0.5 * (law.rho * y[2] * y[2] + y[3] * y[3])


@inner_jit
def close(law, pairs, mode, y, new):
    """The mode behind the blow of a pair that closes, perhaps while another one is closed."""
    before = kinetic(law, y)
    blow = _hit(law, pairs, new, y, law.restitution)
    if not blow.sound:
        return _next(new, Ending.JAM)
    tiny = STILL * (1.0 + blow.approach)
    rate = _rate(law, pairs, mode, y) if mode.pair >= 0 else np.inf
    if rate > tiny:
        found = settle(law, pairs, new, y)
    else:
        if rate < -tiny and not _hit(law, pairs, mode, y, 0.0).sound:
            return _next(mode, Ending.JAM)
        again = _rate(law, pairs, new, y)
        if again > tiny:
            found = settle(law, pairs, mode, y)
        else:
            # alternating blows would go on for ever, until both bodies are at rest
            y[2], y[3] = 0.0, 0.0
            found = _restart(law, pairs, mode, new, y)
    return Next(
        mode=found.mode, ending=found.ending, approach=blow.approach, impulse=blow.impulse,
        energy=before - kinetic(law, y),
    )  # fmt: skip


@inner_jit
def _pass_on(law, pairs, mode, y):
    """The mode behind the end of a feature: its neighbour on the chain, or a flight."""
    old = pairs[mode.pair]
    for i in range(len(pairs)):
        pair = pairs[i]
        nose, track = images(pair, law.centre, y[0], y[1])
        if (
            pair.nose == old.nose and pair.nose_feature == old.nose_feature
            and pair.track_feature == old.track_feature
            and (nose - mode.nose) % pair.nose_images == 0
            and (track - mode.track) % pair.track_images == 0
        ):  # fmt: skip
            continue
        touch = touch_at(pair, place(pair, law.centre, y, nose, track))
        if min(touch.on_track, touch.on_nose) < -BESIDE or abs(touch.gap) > BESIDE:
            continue
        if abs(touch.g0 * y[2] + touch.g1 * y[3]) > STAYS:
            continue
        found = settle(law, pairs, contact_of(i, nose, track), y)
        if found.mode.pair >= 0:
            return found
    return flight(law, y)


@inner_jit
def behind_event(law, pairs, mode, y, event):
    """The mode behind the event that ends a step."""
    at_rest = abs(y[2]) + abs(y[3]) < AT_REST
    if event == JAMS:
        return _next(mode, Ending.JAM)
    if event == LIFTS:
        return flight(law, y)
    if event in (DRIVER_STOPS, FOLLOWER_STOPS):
        if event == DRIVER_STOPS:
            y[2] = 0.0
        else:
            y[3] = 0.0
        if mode.pair < 0:
            return flight(law, y)
    if event in (SLIPS, DRIVER_STOPS, FOLLOWER_STOPS):
        if at_rest:
            y[2], y[3] = 0.0, 0.0
            return from_rest(law, pairs, mode, y)
        return _turned(law, pairs, mode, y, event)
    return _pass_on(law, pairs, mode, y)


@inner_jit
def _turned(law, pairs, mode, y, event):
    """The mode behind an instant at which the slip, or one of the bodies, turns back."""
    driver, follower, sigma = mode.driver_sense, mode.follower_sense, mode.sigma
    if event == DRIVER_STOPS:
        driver = -driver
    elif event == FOLLOWER_STOPS:
        follower = -follower
    else:
        sigma = -sigma
    mode = Mode(
        pair=mode.pair, nose=mode.nose, track=mode.track, sigma=sigma, driver_sense=driver,
        follower_sense=follower,
    )  # fmt: skip
    push = pushed(law, mode, touching(law, pairs, mode, y), y)
    if not push.yielding > 0.0:
        return _next(mode, Ending.JAM)
    return _next(mode, Ending.RUNNING) if push.force > 0.0 else flight(law, y)
