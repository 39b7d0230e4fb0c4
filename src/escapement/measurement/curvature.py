"""Whether intervals of a fit of beats, which come from its tangent, hold where beats are curved."""

import numpy as np

from escapement.measurement.beat_unknowns import Parts
from escapement.measurement.estimate import Doubt
from escapement.measurement.rounds import Rounds
from escapement.mechanisms.protocol import FloatArray

_RISE = 0.5  # the sum of squares rises at the end of an interval by this share of what it should


def curved(parts: Parts, unknowns: FloatArray, rounds: Rounds, doubt: Doubt) -> np.ndarray:
    """Which unknowns may lie beyond the intervals of the tangent: bool, shape (m,).

    Along the line on which an unknown is most uncertain, the sum of squares should rise by (reach
    times noise)^2 up to the end of its interval. If it rises much less, for example because there
    is a kink in between, values beyond that end are likely too.

    Parameters
    ----------
    parts : Parts
        Meaning of the unknowns.
    unknowns : ndarray, shape (m,)
        Those that were found.
    rounds : Rounds
        The measured beats.
    doubt : Doubt
        Uncertainty of the unknowns by the tangent.
    """
    low, high = parts.bounds(unknowns[0])

    def squares(at: FloatArray) -> float:
        computed = parts.beats(at)
        if computed is None:
            return np.inf
        return float(np.sum((rounds.root @ (computed - rounds.means)) ** 2))

    least, found = squares(unknowns), np.zeros(unknowns.size, dtype=bool)
    unit = (doubt.reach * doubt.noise) ** 2
    for index, row in enumerate(doubt.root):
        width = float(np.linalg.norm(row))
        if width == 0.0:
            continue
        forward = doubt.root @ row / width
        for at in (unknowns + forward, unknowns - forward):
            # bounds are physical, and `estimate` allows for those of impacts
            inside = (at >= low).all() and (at <= high).all()
            found[index] |= inside and squares(at) - least < _RISE * unit
    return found
