"""The numbers of the page on pallets are those that compare finds."""

from pathlib import Path

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
