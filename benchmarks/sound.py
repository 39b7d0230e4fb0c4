"""Beats in synthetic recordings: how many are found, how exact, and whether intervals are honest.

``python benchmarks/sound.py [--seeds 100]`` writes results/sound.csv.

Each recording has ticks with an amplitude that varies by a tenth, at a rate from 0.5 to 100 beats a
second, each interval with a noise of a thousandth. The signal to noise ratio is that of the
amplitude with which a tick begins to the standard deviation of the noise.
"""

import numpy as np
from common import asked, tell

import escapement as esc
from escapement.base.errors import EscapementError
from escapement.measurement.onsets import find_onsets
from escapement.measurement.rhythm import find_rhythm

RATE = 48000
BEATS = {0.5: 40, 5.0: 200, 30.0: 400, 100.0: 600}
NOISES = (30.0, 20.0, 10.0, 6.0)
NEAR = 1e-3  # a sound this near to a tick is this tick [s]


def recorded(rate, snr, seed):
    """Instants of ticks, and their recording."""
    rng = np.random.default_rng(seed)
    count = BEATS[rate]
    steps = (1.0 + 1e-3 * rng.normal(size=count)) / rate
    times = 0.1 + np.cumsum(steps)
    loud = np.exp(0.1 * rng.normal(size=count))
    options = {"rate": RATE, "signal_to_noise": snr, "room": 0.05, "seed": seed}
    return times, esc.synthetic_recording(times, loud, **options)


def judged(rate, snr, seeds):
    """Figures of all recordings of a rate and a noise."""
    found = wrong = every = refused = 0
    apart, widths = [], []
    for seed in range(seeds):
        times, sound = recorded(rate, snr, seed)
        onsets = find_onsets(sound, RATE)
        try:
            rhythm = find_rhythm(onsets)
        except EscapementError:
            refused += 1
            continue
        beats = rhythm.beats[rhythm.beats >= 0]
        nearest = np.abs(onsets.times[beats][:, None] - times).argmin(axis=1)
        off = onsets.times[beats] - times[nearest]
        right = np.abs(off) < NEAR
        found += np.unique(nearest[right]).size
        wrong += int((~right).sum())
        every += times.size
        apart.append(off[right])
        widths.append(onsets.half_widths[beats][right])
    row = {"beats_per_second": rate, "snr_db": snr, "seeds": seeds, "refused": refused}
    row |= dict.fromkeys(("found", "false", "median_error_samples", "within_95"), "")
    if every:
        off, width = np.concatenate(apart), np.concatenate(widths)
        row |= {
            "found": f"{found / every:.4f}", "false": f"{wrong / every:.4f}",
            "median_error_samples": f"{np.median(np.abs(off)) * RATE:.2f}",
            "within_95": f"{np.mean(np.abs(off) <= width):.3f}",
        }  # fmt: skip
    return row


def main():
    """Write the table."""
    seeds, whole = asked(__doc__, seeds=100)
    tell("sound", [judged(rate, snr, seeds) for rate in BEATS for snr in NOISES], whole)


if __name__ == "__main__":
    main()
