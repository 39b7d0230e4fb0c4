"""What readings may show: errors of shafts and parts, backlash, changes and single readings.

Each kind of finding has its size, what is certain about it, and its words.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from escapement.base.text import Shown

ORDERS = (1, 2)
"""Cycles per turn: of an eccentric disc, and of a tilted or an oval one."""
DOUBT = 1.5e-2
"""Below this probability for its whole search, a change for good or a reading far out keeps a drive
from being called good: nothing else shows them."""
DOUBT_PARTS = 2e-3
"""The same for slots and pins, whose errors show as waves too. With six waves, each at `SURE`, the
probabilities add up to 4 %: so many good drives may be doubted (benchmarks/planted_errors.py)."""
IN_95 = 1.96  # standard errors to either side of the mean, for 95 % of a normal distribution
_TELLING = 3.0  # the size of an error with fewer standard errors than this is called hidden
Key = tuple[str, int | str]
"""An error that is looked for: its shaft, and its order, "parts", "lag" or "change"."""


class ShaftError(NamedTuple):
    """A sinusoidal error of one shaft, fitted together with all others that are significant.

    An eccentric gear or encoder disc causes an error that repeats once a turn of its shaft, a
    tilted one an error that repeats twice.

    shaft : "input", "output", or "cell" for an error that repeats with each cell.
    order : how often the error repeats in one turn of the shaft, or in one cell.
    amplitude : amplitude of the error of that shaft's angle [rad]. An error of the input
        reaches the output multiplied by the transmission.
    standard_error : standard error of the amplitude [rad].
    p_value : probability that independent normal errors cause this amplitude or more (F test).
    turns : turns of the shaft, or cells, from the first sample to the last. If they and one mean
        step are less than 1, and there are less than two cells, the error is not judged: the
        three numbers above are NaN. A size beyond half a step of its shaft is NaN too.
    """

    shaft: str
    order: int
    amplitude: float
    standard_error: float
    p_value: float
    turns: float

    @property
    def text(self) -> str:
        """What is said of this error."""
        where = "cell" if self.shaft == "cell" else f"turn of the {self.shaft}"
        when = f"repeats {('once', 'twice')[self.order - 1]} a {where}"
        size = interval(self.amplitude, self.standard_error)
        if _TELLING * self.standard_error < self.amplitude:
            return f"an error of {size} {when}"
        return f"an error {when}, but phase, offset and other errors hide its size ({size})"


class SlotError(NamedTuple):
    """The part of a shaft that is farthest from where the others say it should be.

    A slot whose angle is wrong moves the follower while a pin is in it, and in the dwell behind it.
    A pin whose angle is wrong acts as an error of the input.

    shaft : "output" for a slot, "input" for a pin.
    number : the part, counted from the one that is engaged at the first sample, which is 1.
    parts : how many of them were seen.
    size : its angle ahead of the mean of the others [rad].
    standard_error : standard error of the size [rad].
    p_value : probability that independent normal errors show so great an error of any part.
    """

    shaft: str
    number: int
    parts: int
    size: float
    standard_error: float
    p_value: float

    @property
    def text(self) -> str:
        """What is said of this part."""
        part = "pin" if self.shaft == "input" else "slot"
        side = "behind" if self.size < 0.0 else "ahead of"
        return (
            f"{part} {self.number} of {self.parts}, counted from the one at the first sample, is "
            f"{side} the others by {interval(self.size, self.standard_error)}"
        )


class Backlash(NamedTuple):
    """Free play of a shaft, fitted together with all errors that are significant.

    shaft : "input" or "output".
    width : width of the backlash, as an angle of that shaft [rad]. If it is negative, the output
        leads, as it does if the input's encoder is loose.
    standard_error : standard error of the width [rad].
    p_value : probability that independent normal errors cause this width or more (F test).
    """

    shaft: str
    width: float
    standard_error: float
    p_value: float

    @property
    def text(self) -> str:
        """What is said of the backlash."""
        size = interval(self.width, self.standard_error)
        if self.width < 0.0:
            return (
                f"the {self.shaft} leads by {size} where it turns back, as if its encoder were "
                "loose"
            )
        return f"the {self.shaft} has a backlash of {size}"


class Change(NamedTuple):
    """A change of the errors that lasts to the last sample, as a lost step leaves it behind.

    shaft : "input" or "output", whose slip would cause it.
    line : line of the last sample before it.
    size : angle by which this shaft seems to have slipped [rad].
    standard_error : standard error of the size [rad].
    p_value : probability that independent normal errors show such a change behind any sample.
    """

    shaft: str
    line: int
    size: float
    standard_error: float
    p_value: float

    @property
    def text(self) -> str:
        """What is said of the change."""
        return (
            f"the errors change for good behind line {self.line}, as if the {self.shaft} had "
            f"slipped by {interval(self.size, self.standard_error)}"
        )


class Glitch(NamedTuple):
    """A reading far from all others, which noise practically never causes.

    line : line of the sample.
    size : its error after all errors that were found are removed [rad].
    p_value : probability that the greatest of as many normal errors is as great.
    """

    line: int
    size: float
    p_value: float


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Found(Shown):
    """Errors with a cause, and what they leave.

    shaft_errors : sinusoidal errors, one for each shaft and order.
    backlash : one for each shaft that turns both ways far enough.
    slot_errors : of the worst slot and of the worst pin, where several were seen.
    changes : changes for good that noise hardly causes, by their line.
    glitches : readings far out, by their line.
    rounded : errors that noise cannot cause, but the rounding of the encoders can; a change by
        its line.
    hidden : amplitude of an error of the output that rounding can hide [rad].
    spread : standard deviation of the errors, without readings far out [rad].
    scatter : standard deviation of what is left, likewise [rad].
    rest_autocorrelation : correlation of neighbouring errors in what is left [-].
    """

    shaft_errors: tuple[ShaftError, ...] = field(repr=False)
    backlash: tuple[Backlash, ...] = field(repr=False)
    slot_errors: tuple[SlotError, ...] = field(repr=False)
    changes: tuple[Change, ...] = field(repr=False)
    glitches: tuple[Glitch, ...] = field(repr=False)
    rounded: frozenset[Key] = field(repr=False)
    hidden: float = field(repr=False)
    spread: float = field(repr=False)
    scatter: float = field(repr=False)
    rest_autocorrelation: float = field(repr=False)


def interval(size: float, error: float) -> str:
    """The magnitude of a size in degrees with its interval, in words."""
    if math.isnan(size):
        return "an angle that cannot be told"
    size, half = math.degrees(abs(size)), math.degrees(IN_95 * error)
    return f"{size:.3g} degrees (95 % interval {size - half:.3g} to {size + half:.3g})"
