"""How often the 95 % intervals of a budget contain the true value.

``python benchmarks/budget_coverage.py [SEEDS]`` draws samples of a log-normal torque. The
period is proportional to torque^(-1/2), so it is log-normal too, and there are formulas for its
mean, deviation, quantiles, share within limits and C_pk. It does the same for the Sobol' indices of
the Ishigami function. The share of seeds whose interval contains the true value goes to
``results/budget_coverage.csv``; 200 seeds of a true 95 % give 90.5 to 98.5 % in 99 of 100 runs.
"""

import math
import sys
from functools import partial

import numpy as np
from common import write_rows
from scipy.stats import norm

import escapement as esc
from escapement.study.parse import plan_from
from escapement.study.running import run_plan
from escapement.tolerance import intervals
from escapement.tolerance.indices import sobol_indices
from escapement.tolerance.scatter import LEVELS

SIGMA, HYPERCUBES = 0.1, 20
SIZE = 51 * HYPERCUBES
"""With this size no quantile is at the edge of a stratum, where hypercubes have no error."""


def of_log_normal(seeds):
    """Coverage by method and statistic."""
    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113, friction=0.3)
    period, own = esc.terminal(timer).period, 0.5 * SIGMA
    mean = period * math.exp(0.5 * own**2)
    deviation = mean * math.sqrt(math.expm1(own**2))
    low, high = 0.93 * period, 1.08 * period
    inside = norm.cdf(math.log(1.08) / own) - norm.cdf(math.log(0.93) / own)
    true = {"mean": mean, "deviation": deviation, "inside": inside}
    true["capability"] = min(mean - low, high - mean) / (3.0 * deviation)
    true |= {f"quantile {x:g}": period * math.exp(own * norm.ppf(x)) for x in LEVELS}
    found = {}
    for method, groups in (("random", 1), ("latin-hypercube", HYPERCUBES)):
        held = dict.fromkeys(true, 0)
        for seed in range(seeds):
            sample = {"method": method, "size": SIZE, "seed": seed}
            sample |= {"torque": {"log_standard_deviation": SIGMA}}
            sample |= {"hypercubes": groups} if groups > 1 else {}
            values = run_plan(plan_from(timer, {}, sample=sample, results=["period"])).results
            x = values["period"]
            capable = partial(intervals.capability, low=low, high=high)
            told = {name: intervals.estimate(statistic, x, groups) for name, statistic in {
                "mean": intervals.mean, "deviation": intervals.deviation, "capability": capable,
            }.items()}  # fmt: skip
            told["inside"] = intervals.share((x >= low) & (x <= high), groups)
            told |= {f"quantile {p:g}": intervals.quantile(x, p, groups) for p in LEVELS}
            for name, value in true.items():
                held[name] += told[name].low <= value <= told[name].high
        found |= {(method, name): count / seeds for name, count in held.items()}
    return found


def of_ishigami(seeds, size=1024):
    """Coverage of first and total indices, a = 7 and b = 0.1."""
    a, b = 7.0, 0.1
    one, both = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, 8.0 * b**2 * math.pi**8 / 225.0
    two = a**2 / 8.0
    variance = one + two + both
    true = [one, two, 0.0, one + both, two, both]

    def ishigami(shares):
        x = math.pi * (2.0 * shares - 1.0)
        return np.sin(x[0]) + a * np.sin(x[1]) ** 2 + b * x[2] ** 4 * np.sin(x[0])

    held = np.zeros(6)
    for seed in range(seeds):
        first, total = sobol_indices(ishigami, 3, size, seed)
        held += [
            x.low <= value / variance <= x.high
            for x, value in zip([*first, *total], true, strict=True)
        ]
    names = [f"{kind} index {i + 1}" for kind in ("first", "total") for i in range(3)]
    return {("Ishigami", name): share for name, share in zip(names, held / seeds, strict=True)}


def main():
    """Count, print and write."""
    seeds = int((sys.argv[1:] or ["200"])[0])
    rows = [(*key, share) for key, share in (of_log_normal(seeds) | of_ishigami(seeds)).items()]
    write_rows("budget_coverage", rows, ("case", "statistic", "share_of_seeds"))
    for row in rows:
        print(*row)


if __name__ == "__main__":
    main()
