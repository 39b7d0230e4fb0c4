"""Searches in a bracket for kernels: a root by Newton's method, a greatest value by golden section.

Each function is one step, so that the loop of its caller holds the function that is searched.
"""

from escapement.numerics.jit import inner_jit


@inner_jit(inlined=True)
def newton_in_bracket(x, value, slope, low, high, rising):
    """One step towards a root between `low` and `high`.

    Parameters
    ----------
    x, value, slope : float
        A point in the bracket, and the function and its derivative there.
    low, high : float
        The bracket. A slope that is zero or NaN does no harm.
    rising : bool
        Whether the function goes from negative to positive.

    Returns
    -------
    x, low, high : the next point, and the remaining bracket.
    """
    if (value < 0.0) == rising:
        low = x
    else:
        high = x
    guess = x - value / slope
    # NaN is not inside either
    if not low <= guess <= high:
        guess = 0.5 * (low + high)
    return guess, low, high


GOLDEN = 0.6180339887498949
"""The golden ratio less 1."""


@inner_jit(inlined=True)
def golden_point(low, high):
    """The first point of a search by golden section between `low` and `high`."""
    return high - GOLDEN * (high - low)


@inner_jit(inlined=True)
def golden_trial(low, high, best):
    """The next point of a search whose best point so far is `best`: the one on its other side."""
    # low + high - best, but its rounding errors would grow from step to step
    if best - low < high - best:
        return low + GOLDEN * (high - low)
    return high - GOLDEN * (high - low)


@inner_jit(inlined=True)
def golden_step(low, high, best, greatest, trial, value):
    """One step of golden section towards the greatest value of a function with one maximum.

    Parameters
    ----------
    low, high : float
        The bracket.
    best, greatest : float
        The point in it with the greatest value so far, and that value.
    trial, value : float
        The point of `golden_trial`, and the value there.

    Returns
    -------
    low, high, best, greatest : the remaining bracket, and the best point in it.
    """
    if value > greatest:
        if trial > best:
            return best, high, trial, value
        return low, best, trial, value
    if trial > best:
        return low, trial, best, greatest
    return trial, high, best, greatest
