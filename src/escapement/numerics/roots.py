"""Root finding in a bracket for kernels: Newton's method, kept inside by bisection."""

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
