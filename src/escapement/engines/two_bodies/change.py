"""What the bodies do behind an event: the next mode.

`settle` decides whether a contact whose gap does not change is kept, `close` takes the blow of a
contact that begins, and `behind_event` goes on behind the event of a step. With a mode they return
an `Ending`, which is RUNNING unless the motion ends.
"""

from collections import namedtuple

import numpy as np

from escapement.dynamics.codes import Ending
from escapement.engines.two_bodies.blow import strike
from escapement.engines.two_bodies.law import (
    Mode,
    energy,
    free,
    push_at,
    pushed,
    torques,
    touching,
)
from escapement.engines.two_bodies.step import DRIVER_STOPS, FOLLOWER_STOPS, JAMS, LIFTS, SLIPS
from escapement.engines.two_bodies.touch import images, place, touch_at
from escapement.engines.two_bodies.watch import STILL
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit

AT_REST = 1e-9
"""Bodies slower than this are at rest where both turn back."""
BESIDE, STAYS = 1e-8, 1e-7
"""A neighbour on a chain has a smaller gap than this, whose rate is slower than that."""


Blow = namedtuple("Blow", "before approach impulse energy after")
"""A blow of a pair: the driver's speed before it, the speed of approach, which is 0 if there is no
blow, the impulse, the energy that is lost, and the speeds after it."""


@inner_jit
def contact_of(pair, nose, track):
    """The mode in which a pair is closed, whose signs are still to be found."""
    return Mode(pair, nose, track, 0.0, 0.0, 0.0)


@inner_jit
def _sense(speed, torque, held):
    """Sense of a body, of which friction holds a torque while it is at rest."""
    return np.sign(speed if speed != 0.0 else torque if abs(torque) > held else 0.0)


@inner_jit
def flight(law, y):
    """The mode of a flight; it is the end if nothing moves in it."""
    driver, follower = torques(law, y)
    senses = _sense(y[2], driver, law.bearing), _sense(y[3], follower, law.load)
    mode = Mode(-1, 0, 0, 0.0, senses[0], senses[1])
    push = free(law, mode, y)
    stands = y[2] == 0.0 and y[3] == 0.0 and push.driver == 0.0 and push.follower == 0.0
    return mode, Ending.STANDS if stands else Ending.RUNNING


@inner_jit
def settle(law, pairs, contact, y, still):
    """The mode behind an instant at which a pair is closed, whose gap does not open faster.

    Signs of `contact` that are not 0 are those of a slip or a speed that is passing zero.
    """
    touch = touching(law, pairs, contact, y)
    if touch.g0 * y[2] + touch.g1 * y[3] > still:
        return flight(law, y)
    if abs(y[2]) + abs(y[3]) < AT_REST:
        y[2], y[3] = 0.0, 0.0
        return from_rest(law, pairs, contact, y)
    slip = contact.sigma if contact.sigma != 0.0 else touch.h0 * y[2] + touch.h1 * y[3]
    driver = contact.driver_sense if contact.driver_sense != 0.0 else y[2]
    follower = contact.follower_sense if contact.follower_sense != 0.0 else y[3]
    senses = np.sign(slip), np.sign(driver), np.sign(follower)
    kept = Mode(contact.pair, contact.nose, contact.track, senses[0], senses[1], senses[2])
    push = pushed(law, kept, touch, y)
    if not push.yielding > 0.0:
        return kept, Ending.JAM
    return (kept, Ending.RUNNING) if push.force > 0.0 else flight(law, y)


@inner_jit
def from_rest(law, pairs, contact, y):
    """The mode of bodies at rest with a pair closed: they may turn in either sense, or fly."""
    touch, found, count, presses = touching(law, pairs, contact, y), contact, 0, False
    size = np.sqrt(touch.g0 * touch.g0 + touch.g1 * touch.g1)
    for way in (1.0, -1.0):
        driver, follower = way * touch.g1 / size, -way * touch.g0 / size
        sigma = np.sign(touch.h0 * driver + touch.h1 * follower)
        first = np.sign(driver) if abs(driver) > STILL else 0.0
        second = np.sign(follower) if abs(follower) > STILL else 0.0
        mode = Mode(contact.pair, contact.nose, contact.track, sigma, first, second)
        push = pushed(law, mode, touch, y)
        if not push.yielding > 0.0:
            return contact, Ending.JAM
        presses = presses or push.force > 0.0
        if push.force > 0.0 and push.driver * driver + push.follower * follower > STILL:
            found, count = mode, count + 1
    if not presses:
        return flight(law, y)
    if count == 1:
        return found, Ending.RUNNING
    return contact, Ending.STANDS if count == 0 else Ending.JAM


@inner_jit
def _opens(law, pairs, of, mode, y):
    """gap'' of a pair in the mode of another one, or of a flight."""
    touch, push = touching(law, pairs, of, y), push_at(law, pairs, mode, y)
    return touch.kappa + touch.g0 * push.driver + touch.g1 * push.follower


@inner_jit
def _restart(law, pairs, old, new, y):
    """The mode of bodies at rest with two pairs closed, of which at most one stays so."""
    for kept, other in ((old, new), (new, old)):
        mode, ending = from_rest(law, pairs, kept, y)
        runs = ending == Ending.RUNNING and mode.pair >= 0
        if runs and _opens(law, pairs, other, mode, y) > 0.0:
            return mode, ending
    mode, ending = flight(law, y)
    opens = min(_opens(law, pairs, old, mode, y), _opens(law, pairs, new, mode, y))
    return (mode, ending) if opens > 0.0 else (new, Ending.STALL)


@inner_jit
def rate_of(law, pairs, contact, y):
    """gap' of a pair."""
    touch = touching(law, pairs, contact, y)
    return touch.g0 * y[2] + touch.g1 * y[3]


@inner_jit
def _blow(law, pairs, contact, y, restitution):
    """Take the blow of a pair."""
    before, kinetic, rate = y[2], energy(law, y)[0], rate_of(law, pairs, contact, y)
    impulse = strike(law, touching(law, pairs, contact, y), y, restitution)
    return Blow(before, -rate, impulse, kinetic - energy(law, y)[0], (y[2], y[3]))


@inner_jit
def close(law, pairs, mode, y, new):
    """The mode behind the blow of a pair that closes, perhaps while another one is closed.

    Returns the mode, an `Ending`, and the blows of this pair and of the other one.
    """
    tiny = STILL * (1.0 + abs(rate_of(law, pairs, new, y)))
    first = _blow(law, pairs, new, y, law.restitution)
    second = altered(first, "approach", 0.0)
    rate = rate_of(law, pairs, mode, y) if mode.pair >= 0 else np.inf
    if rate < -tiny:
        # the other contact takes a blow as well
        second = _blow(law, pairs, mode, y, 0.0)
    if np.isnan(first.impulse) or np.isnan(second.impulse):
        return new, Ending.JAM, first, second
    moves = abs(y[2]) + abs(y[3]) > AT_REST
    if rate > tiny:
        mode, ending = settle(law, pairs, new, y, STILL)
    elif moves and rate_of(law, pairs, new, y) >= -tiny:
        mode, ending = settle(law, pairs, contact_of(mode.pair, mode.nose, mode.track), y, STILL)
    else:
        # alternating blows would go on for ever, until both bodies are at rest
        if moves:
            first, second = _alternating(law, pairs, mode, y, new, first, second)
        y[2], y[3] = 0.0, 0.0
        mode, ending = _restart(law, pairs, mode, new, y)
    return mode, ending, first, second


@inner_jit
def _alternating(law, pairs, mode, y, new, first, second):
    """Two blows with all that follow, each pair of which leaves the same share of the speeds."""
    speed = abs(y[2]) + abs(y[3])
    one, two = _blow(law, pairs, new, y, law.restitution), _blow(law, pairs, mode, y, 0.0)
    left = (abs(y[2]) + abs(y[3])) / speed
    if left < 1.0:
        whole, lost = 1.0 / (1.0 - left), 1.0 / (1.0 - left * left)
        first = altered(
            first, "impulse", first.impulse + whole * one.impulse,
            "energy", first.energy + lost * one.energy,
        )  # fmt: skip
        second = altered(
            second, "impulse", second.impulse + whole * two.impulse,
            "energy", second.energy + lost * two.energy, "after", (0.0, 0.0),
        )  # fmt: skip
    return first, second


@inner_jit
def _pass_on(law, pairs, mode, y):
    """The mode behind the end of a feature: its neighbour on the chain, or a flight."""
    old = pairs[mode.pair]
    for i in range(len(pairs)):
        pair = pairs[i]
        nose, track = images(pair, law.centre, y)
        same = pair.nose == old.nose and pair.nose_feature == old.nose_feature
        same = same and pair.track_feature == old.track_feature
        same = same and (nose - mode.nose) % pair.nose_fold == 0
        if same and (track - mode.track) % pair.track_fold == 0:
            continue
        touch = touch_at(pair, place(pair, law.centre, y, nose, track))
        inside = min(touch.on_track, touch.on_nose) >= -BESIDE and abs(touch.gap) <= BESIDE
        if inside and abs(touch.g0 * y[2] + touch.g1 * y[3]) <= STAYS:
            next_mode, ending = settle(law, pairs, contact_of(i, nose, track), y, STAYS)
            if next_mode.pair >= 0:
                return next_mode, ending
    return flight(law, y)


@inner_jit
def behind_event(law, pairs, mode, y, event):
    """The mode behind the event that ends a step."""
    if event == JAMS:
        return mode, Ending.JAM
    if event == DRIVER_STOPS:
        y[2] = 0.0
    if event == FOLLOWER_STOPS:
        y[3] = 0.0
    if mode.pair < 0 or event == LIFTS:
        return flight(law, y)
    if event not in (SLIPS, DRIVER_STOPS, FOLLOWER_STOPS):
        return _pass_on(law, pairs, mode, y)
    sigma = -mode.sigma if event == SLIPS else 0.0
    driver = -mode.driver_sense if event == DRIVER_STOPS else 0.0
    follower = -mode.follower_sense if event == FOLLOWER_STOPS else 0.0
    turned = Mode(mode.pair, mode.nose, mode.track, sigma, driver, follower)
    return settle(law, pairs, turned, y, STILL)
