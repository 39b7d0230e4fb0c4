"""Engagements one after the other, and the terminal cycle that they approach."""

import math

import numpy as np

from .compiling import compiled
from .engagement import HEAD, LOST, OK, REVERSALS, STALL, VARIATION, engage
from .series import SIZE


@compiled
def motion(case, w, rows):
    """Engagements until `rows` is full; returns status and how many are complete.

    Row k is as `engage` returns it, but W and time are those of the handoff, after the dwell.
    """
    work, turns = np.empty((24, SIZE)), np.empty(16)
    dwell, rho = case[2], case[4]
    time, lost = 0.0, 0.0
    for k in range(rows.shape[0]):
        engage(case, w, work, turns, rows[k])
        row = rows[k]
        start = time
        row[HEAD + 1 : HEAD + 2 * REVERSALS : 2] += start
        spent = row[2]
        if row[0] != OK:
            row[2] = time + spent
            return int(row[0]), k
        w = row[1]
        if dwell > 0.0:
            after = w + 2.0 * dwell / rho
            spent += 2.0 * dwell / (math.sqrt(w) + math.sqrt(after))
            w = after
            row[5] = max(row[5], w)
        y = spent - lost
        t = time + y
        lost = (t - time) - y
        time = t
        row[1], row[2] = w, time
    return OK, rows.shape[0]


@compiled
def terminal(case, w, out):
    """Terminal cycle as a fixed point; `out` is as a row of `motion`, with out[8] the iterations.

    Below the first pin reversal l is zero and every engagement gains the same; above it
    the gain falls as W rises, so there is one fixed point or, where that gain is
    negative, none: then the motion stops sooner or later.
    """
    work, turns = np.empty((24, SIZE)), np.empty(16)
    dwell, rho = case[2], case[4]
    free = 2.0 * dwell / rho
    low, high = 0.0, np.inf
    moving, before = w, np.inf
    for k in range(400):
        engage(case, moving, work, turns, out)
        if out[0] == STALL:
            if k == 0:
                return STALL
            low = max(low, moving)
            if high - low <= 1e-13 * high:
                return STALL
            moving = 0.5 * (low + min(high, 4.0 * low + 1e-300))
            continue
        if out[0] != OK:
            return int(out[0])
        gap = -math.expm1(out[3])
        source = out[4] / rho + free
        gain = source - moving * gap
        dissipates = gap > 1e-12 * out[VARIATION]
        if not dissipates:
            if source <= 0.0:
                return STALL
            low, better = max(low, moving), 4.0 * moving + source
        else:
            if gain > 0.0:
                low = max(low, moving)
            else:
                high = min(high, moving)
            better = source / gap
        change = abs(better - moving)
        if dissipates and (change <= 1e-15 * moving or 0.5 * before < change <= 1e-11 * moving):
            after = out[1] + free
            if dwell > 0.0:
                out[2] += 2.0 * dwell / (math.sqrt(out[1]) + math.sqrt(after))
                out[5] = max(out[5], after)
            out[1] = after
            out[8] = k + 1
            return OK
        before = change
        if change > 1e-11 * moving and not low < better < high:
            if high < np.inf:
                better = 0.5 * (low + high) if low < 1e-3 * high else math.sqrt(low * high)
            else:
                better = 4.0 * moving + source
        moving = better
    return LOST
