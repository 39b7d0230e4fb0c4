"""How often the intervals of backlash, eccentricity, friction and torque are right.

``python benchmarks/lab_coverage.py [--seeds 100]``

An interval is right if it contains the true value. The readings are made here and not by the
package. In one set a shaft is turned unevenly there and back, with free play, an eccentric disc and
rounding to counts of an encoder; the other set is a noisy run-up.
"""

import numpy as np
from common import asked, tell

import escapement as esc
from escapement.measurement import position
from escapement.measurement.estimate import SURE

DEG = np.pi / 180.0
COUNT = 2.0 * np.pi / 16384
PLAY, ECCENTRICITY = 0.4 * DEG, 0.3 * DEG
DRIVES = {"four slots": esc.Geneva(4), "six slots": esc.Geneva(6)}
FRICTION, TORQUE = 0.30, 0.0113
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)


def rows_of(case, names, seeds, inside, right, widths):
    """For each number, for how many seeds its interval contained the true value.

    right : for how many the error was found on the right shaft alone, or the fit converged.
    half_width_percent : the greatest half-width of an interval over the true value.
    """
    for name, count, most in zip(names, inside, np.max(widths, axis=0), strict=True):
        yield {
            "case": case, "number": name, "seeds": seeds, "inside": count, "right": right,
            "half_width_percent": most,
        }  # fmt: skip


def behind(angles, play):
    """Angle of a shaft with free play: it stands still until it is pushed from one side."""
    at, found = angles[0], []
    for angle in angles:
        if angle - at > play / 2:
            at = angle - play / 2
        elif at - angle > play / 2:
            at = angle + play / 2
        found.append(at)
    return np.array(found)


def readings_of(drive, shaft, seed):
    """Both encoders while the input is turned there and back."""
    random = np.random.default_rng(seed)
    there = np.cumsum(random.uniform(0.5, 1.5, 600))
    travel = np.concatenate([there, there[-1] - np.cumsum(random.uniform(0.5, 1.5, 600))])
    theta = 18.0 * np.pi * travel / there[-1]
    plays = {shaft: PLAY}
    driver = behind(theta, plays.get("input", 0.0))
    phi = behind(position(drive, driver), plays.get("output", 0.0))
    wave = {shaft: ECCENTRICITY}
    start = random.uniform(0.0, 2.0 * np.pi)
    read_in = theta - wave.get("input", 0.0) * np.sin(theta + start)
    read_out = phi + wave.get("output", 0.0) * np.sin(phi + start)
    read_out += 0.1 * DEG * random.standard_normal(theta.size)
    return esc.Readings(*(COUNT * np.round(one / COUNT) for one in (read_in, read_out)))


def of_shafts(case, drive, shaft, seeds):
    """Backlash and eccentricity of one shaft."""
    inside, right, widths = np.zeros(2, int), 0, []
    for seed in range(seeds):
        found = esc.measure(readings_of(drive, shaft, seed), drive)
        (wave,) = (e for e in found.shaft_errors if (e.shaft, e.order) == (shaft, 1))
        (play,) = (b for b in found.backlash if b.shaft == shaft)
        halves = 1.96 * np.array([wave.standard_error, play.standard_error])
        truth = np.array([ECCENTRICITY, PLAY])
        inside += np.abs([wave.amplitude, play.width] - truth) <= halves
        told = [(e.shaft, e.order) for e in found.shaft_errors if e.p_value < SURE]
        told += [(b.shaft, 0) for b in found.backlash if b.p_value < SURE]
        right += told == [(shaft, 1), (shaft, 0)]
        widths.append(100.0 * halves / truth)
    names = ("eccentricity", "backlash")
    return rows_of(f"{case}, {shaft}", names, seeds, inside, right, widths)


def of_run_up(seeds):
    """Friction and torque from 400 noisy angles of a run-up; the fit starts from wrong numbers."""
    truth = esc.Escapement(DRIVES["four slots"], INERTIA, TORQUE, FRICTION)
    guess = esc.Escapement(DRIVES["four slots"], INERTIA, 0.02, 0.15)
    motion = esc.simulate(truth, 20)
    inside, right, widths = np.zeros(2, int), 0, []
    values = np.array([FRICTION, TORQUE])
    for seed in range(seeds):
        random = np.random.default_rng(seed)
        time = np.sort(random.uniform(-0.02, 1.0, 400)) * motion.end_time
        theta = motion.at(np.clip(time, 0.0, motion.end_time)).theta
        angle = theta + 0.3 * DEG * random.standard_normal(time.size)
        nothing = np.full(time.size, np.nan)
        fit = esc.fit_motion(esc.Readings(angle, nothing, time=time), guess)
        inside += np.abs(fit.values - values) <= fit.half_widths
        right += fit.verdict.good is True
        widths.append(100.0 * fit.half_widths / values)
    return rows_of("run-up", ("friction", "torque"), seeds, inside, right, widths)


def main():
    """Run all cases, print and write them."""
    seeds, whole = asked(__doc__, seeds=100)
    rows = [*of_run_up(seeds)]
    for case, drive in DRIVES.items():
        for shaft in ("output", "input"):
            rows += of_shafts(case, drive, shaft, seeds)
    tell("lab_coverage", rows, whole)


if __name__ == "__main__":
    main()
