"""The Pareto front: designs of which none is better than another in every objective."""

import numpy as np

from escapement.mechanisms.protocol import FloatArray


def undominated(costs: FloatArray) -> np.ndarray:
    """Indices of the rows that no other row beats or equals in everything and beats in something.

    Parameters
    ----------
    costs : ndarray, shape (n, k)
        Costs of each design, which should be small.

    Returns
    -------
    ndarray of int
        Ascending; of equal rows the first.
    """
    # a row can only be dominated by one with a smaller sum, so one pass in that order does
    left = np.argsort(costs.sum(axis=1), kind="stable")
    kept = []
    while left.size:
        best, rest = left[0], left[1:]
        kept.append(best)
        left = rest[(costs[rest] < costs[best]).any(axis=1)]
    return np.sort(np.array(kept, dtype=int))


def spread_out(costs: FloatArray, count: int) -> np.ndarray:
    """Indices of so many rows that lie far apart: the best in each column, then the farthest."""
    if len(costs) <= count:
        return np.arange(len(costs))
    low, high = costs.min(axis=0), costs.max(axis=0)
    scaled = (costs - low) / np.where(high > low, high - low, 1.0)
    chosen = [*dict.fromkeys(costs.argmin(axis=0).tolist())][:count]
    far = np.min([np.abs(scaled - scaled[i]).max(axis=1) for i in chosen], axis=0)
    while len(chosen) < count:
        chosen.append(int(far.argmax()))
        far = np.minimum(far, np.abs(scaled - scaled[chosen[-1]]).max(axis=1))
    return np.sort(np.array(chosen))
