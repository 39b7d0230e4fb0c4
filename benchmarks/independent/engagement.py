"""One engagement, from pin entry to the handoff, or to a stop before it."""

from .compiling import compiled
from .equation import advance_source, expand
from .series import first_fall, integral, root_integral, turning_points, value

OK, STALL, PAINLEVE, LOST = 0, 2, 3, 4
REVERSALS = 4
LONGEST = 4000  # steps of one engagement
# what an engagement returns: status, W (angle on a stall), time, l, S, greatest W,
# least W, number of reversals, steps, total variation of l, then angle and time of each
# reversal
HEAD = 10
VARIATION = 9
ROW = HEAD + 2 * REVERSALS


@compiled
def engage(case, w, work, turns, out):
    """One engagement from pin entry with squared speed w; fills out (a row)."""
    beta, rho = case[1], case[4]
    out[:] = 0.0
    time, lost_time = 0.0, 0.0
    log, source, variation = 0.0, 0.0, 0.0
    top, bottom = w, w
    sense = 1.0  # at entry g = 0 and g' > 0
    reversals, steps = 0, 0
    unit = 0.05
    if w > 0.0:
        unit = min(unit, max(0.1 * w * rho, 1e-280))
    for half in (-1.0, 1.0):
        angle = -beta if half < 0.0 else 0.0
        end = 0.0 if half < 0.0 else beta
        while angle < end:
            steps += 1
            j, far, far_slow = expand(case, angle, half, sense, w, unit, work)
            if not j > 0.0:
                out[0] = PAINLEVE
                return
            reach = min(far, far_slow)
            if reach < 1e-4 and steps < LONGEST:
                unit *= max(reach * 2.0, 1e-8)
                continue
            if not reach > 0.0 or steps >= LONGEST:
                out[0] = LOST
                return
            if w == 0.0 and work[10][1] <= 0.0:
                out[0], out[1], out[2] = STALL, angle, time
                return
            final = (end - angle) / unit
            fall = first_fall(work[11], min(far, final), sense, turns)
            within = min(far, final) if fall < 0.0 else fall
            stop = first_fall(work[10], within, 1.0, turns)
            if stop >= 0.0:
                # the time back from the stop, if its series is valid so far
                length = stop * unit
                _j, back, back_slow = expand(case, angle + length, half, sense, 0.0, unit, work)
                if stop <= min(back, back_slow) and work[10][1] < 0.0:
                    elapsed = unit * root_integral(work[12], stop, -1.0)
                    out[0], out[1], out[2] = STALL, angle + length, time + elapsed
                    out[7], out[8] = reversals, steps
                    return
                expand(case, angle, half, sense, w, unit, work)
            h = min(reach, final)
            reverses = 0.0 <= fall <= h
            if reverses:
                h = fall
            for k in range(turning_points(work[10], h, turns)):
                here = value(work[10], turns[k])
                top, bottom = max(top, here), min(bottom, here)
            if w > 0.0:
                elapsed = unit * integral(work[12], h)
            else:
                elapsed = unit * root_integral(work[12], h, 1.0)
            # compensated sum
            y = elapsed - lost_time
            t = time + y
            lost_time = (t - time) - y
            time = t
            change = integral(work[13], h)
            log += change
            variation += abs(change)
            source = advance_source(work, h, source)
            w = value(work[10], h)
            top, bottom = max(top, w), min(bottom, w)
            angle = end if h == final else angle + h * unit
            if not w > 0.0:
                out[0] = LOST
                return
            if reverses:
                if reversals < REVERSALS:
                    out[HEAD + 2 * reversals] = angle
                    out[HEAD + 2 * reversals + 1] = time
                reversals += 1
                sense = -sense
            unit = max(min(unit * reach, 0.5), 1e-290)
    out[0], out[1], out[2], out[3], out[4] = OK, w, time, log, source
    out[5], out[6], out[7], out[8], out[9] = top, bottom, reversals, steps, variation
