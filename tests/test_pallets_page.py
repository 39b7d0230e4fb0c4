"""The numbers of the page on pallets are those that compare finds."""

import json
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import escapement as esc
from escapement.study.parse import load_plan

pytestmark = pytest.mark.slow
ROOT = Path(__file__).resolve().parents[1]
FILES = ("pallets_geneva", "pallets_light_verge", "pallets_heavy_verge")
ROWS = {
    "period by torque": ("period_by_torque", "{:.3f}"),
    "period by friction": ("period_by_friction", "{:.3f}"),
    "period by driver inertia": ("period_by_driver_inertia", "{:.3f}"),
    "work lost in blows": ("blow_share", "{:.1%}"),
    "period with a restitution of .25": ("period_with_rebound", "{:+.1%}"),
    "turn of the driver in a period": ("turn_deg", "{:.0f}°"),
    "greatest driver acceleration [rad/s²]": ("acceleration_max", "{:.3g}"),
    "greatest follower acceleration [rad/s²]": ("follower_acceleration_max", "{:.3g}"),
}
"""What a row of the page's table tells, and with how many figures."""


OTHER_LAWS = """
import json, sys
import numpy as np
from escapement.engines.two_bodies import change
import escapement as esc
from escapement.study.parse import load_plan

own = change.strike

def struck(friction):
    # plastic blows whose ratio of friction to normal force is that of their first slip, or zero
    def strike(law, touch, y, _):
        gap, slip = (a * y[2] + b * y[3] for a, b in ((touch.g0, touch.g1), (touch.h0, touch.h1)))
        f = friction * law.mu_plus * np.sign(slip)
        driver, follower = (touch.g0 - f * touch.h0) / law.rho, touch.g1 - f * touch.h1
        impulse = -gap / (touch.g0 * driver + touch.g1 * follower)
        y[2], y[3] = y[2] + impulse * driver, y[3] + impulse * follower
        return impulse
    return strike

for path in sys.argv[1:]:
    timer, periods = load_plan(path).escapement(0), []
    for strike in (own, struck(0.0), struck(1.0)):
        change.strike = strike
        periods.append(float(np.diff(esc.simulate(timer, 9).handoff_times)[-1]))
    print(json.dumps([x / periods[0] - 1.0 for x in periods[1:]]))
"""


def cells_of(text, name):
    line = next(one for one in text.splitlines() if one.startswith(f"| {name} |"))
    return [cell.strip().replace(" %", "%") for cell in line.strip("|").split("|")[1:]]


def test_the_scatter_and_the_best_of_each_are_computed():
    text = (ROOT / "docs/pallets.md").read_text(encoding="utf-8")
    friction = np.linspace(0.05, 0.35, 7)
    designs = [load_plan(ROOT / "runs" / f"{name}.toml").escapement(0) for name in FILES]

    def scatter(timer):
        periods = [esc.terminal(replace(timer, friction=mu)).period for mu in friction]
        return 0.5 * np.ptp(periods) / periods[3]

    told = cells_of(text, "scatter, friction .05 to .35")
    assert told == [f"{scatter(one):.1%}" for one in designs]
    best = best_of_each()
    told = re.search(
        r"at best ([\d.]+) % for the Geneva.* ([\d.]+) % for .* ([\d.]+) % for",
        " ".join(text.split()),
    )
    assert told is not None
    for design, percents in zip(
        ("Geneva", "Geneva with rollers", "pallets"), told.groups(), strict=True
    ):
        mechanism, ratio = best[design]
        found = {}
        for change in (0.8, 1.0, 1.25):
            inertia = esc.Inertia(change * ratio * 1e-6, 1e-6)
            found[change] = scatter(esc.Escapement(mechanism, inertia, designs[0].torque))
        assert f"{100 * found[1.0]:.2g}" == percents
        # nan: below its best ratio the Geneva jams
        assert not found[0.8] < found[1.0]
        assert found[1.25] > found[1.0]


def test_restitution_changes_the_best_pallets_by_what_the_page_says():
    mechanism, ratio = best_of_each()["pallets"]
    timer = esc.Escapement(mechanism, esc.Inertia(ratio, 1.0), 1.0, friction=0.2)
    longer = esc.terminal(replace(timer, restitution=0.25)).period / esc.terminal(timer).period
    text = (ROOT / "docs/pallets.md").read_text(encoding="utf-8")
    assert f".25 changes the best pallets by {longer - 1.0:.0%}".replace("%", " %") in text


def best_of_each():
    """What the notebook found, a mechanism and a ratio of inertias for each name."""
    cells = json.loads((ROOT / "notebooks/geneva_or_pallets.ipynb").read_text("utf-8"))["cells"]
    outputs = [one for cell in cells for one in cell.get("outputs", []) if "text" in one]
    text = "".join("".join(one["text"]) for one in outputs)
    found = {}
    for name, ratio, kind, numbers in re.findall(
        r"(.*): driver over follower ([\d.]+), .*\n *(\w+)\((.*)\)", text
    ):
        given = {}
        for key, value, unit in re.findall(r"(\w+)=([-\d.]+)( deg)?", numbers):
            given[key] = math.radians(float(value)) if unit else float(value)
            given[key] = int(value) if value.isdigit() else given[key]
        found[name] = getattr(esc, kind)(**given), float(ratio)
    return found


def test_the_periods_by_other_laws_of_impact_are_computed():
    text = (ROOT / "docs/pallets.md").read_text(encoding="utf-8")
    paths = [str(ROOT / "runs" / f"{name}.toml") for name in FILES[1:]]
    # the blow of uncompiled kernels can be replaced
    run = subprocess.run(
        [sys.executable, "-c", OTHER_LAWS, *paths], capture_output=True, text=True, check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    found = np.array([json.loads(line) for line in run.stdout.splitlines()]).T
    names = "period with blows without friction", "period with the friction of the first slip"
    for name, changes in zip(names, found, strict=True):
        assert cells_of(text, name) == ["no blows", *(f"{round(x, 3) + 0.0:+.1%}" for x in changes)]


def test_every_number_of_the_table_is_computed():
    text = (ROOT / "docs/pallets.md").read_text(encoding="utf-8")
    told = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| ") and cells[0] in ROWS:
            told[cells[0]] = cells[1:]
    assert told.keys() == ROWS.keys()
    designs = [load_plan(ROOT / "runs" / f"{name}.toml").escapement(0) for name in FILES]
    found = esc.compare(*designs, equal_period=True)
    assert f"{1e3 * found[0].values['period']:.1f} ms" in text
    for name, (key, form) in ROWS.items():
        for cell, one in zip(told[name], found, strict=True):
            if key in one.reasons:
                assert cell == "no blows"
            elif form == "{:.3g}":
                assert float(cell.replace(" ", "")) == pytest.approx(one.values[key], rel=2e-3)
            else:
                assert cell.replace(" %", "%") == form.format(one.values[key])
