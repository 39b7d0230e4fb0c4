"""The effect of real parts on the period: table and figure of the page on effects.

`python -m pages.effects`, called in docs, prints the table.
"""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

import escapement as esc
from escapement.base.units import INCH_POUND
from escapement.plots import style
from escapement.sources import meyer
from pages import drawn

CRANK = 0.020  # m
TORQUES = {3: 0.06, 4: 0.10, 6: 0.10}
"""Torque from the middle of Meyer's range, by slots [in-lbf]."""
FRICTIONS = (0.20, 0.35)
"""The ends of Meyer's range."""

PIN = 0.001  # m, a twentieth of the crank radius
JOURNAL, RUBBING = 0.001, 0.15
AIR = 1.2e-9  # N m s^2, five times the drag of a smooth disc of 20 mm
OIL, FILM = 3.8e-8, 7.5e-6  # N m s: Petroff's law of a journal, and of a disc 1 mm from a plate

Numbers = dict[str, float]
"""Numbers of the wheel or of the escapement, by name; `SHARED` says which are relative."""
SHARED = {"driver_bearing_torque": "torque", "friction": "friction"}
"""Numbers given relative to another number of the ideal mechanism, and that number."""


class Effect(NamedTuple):
    """One row of the table: numbers of real parts, in addition to Meyer's numbers."""

    name: str
    wheel: Numbers
    model: Numbers


def journal(body: str, product: float) -> Numbers:
    """A bearing of which friction times radius is `product` [m]."""
    return {f"{body}_bearing_friction": RUBBING, f"{body}_bearing_radius": product / RUBBING}


DRIVER, FOLLOWER = (journal(body, RUBBING * JOURNAL) for body in ("driver", "follower"))
DRAG = {"driver_drag": AIR, "follower_drag": AIR}
OILED = {"driver_viscous": OIL, "follower_viscous": OIL}
TORQUE = {"driver_bearing_torque": 0.01}
EFFECTS = (
    Effect("pins of 1 mm radius", {"pin_radius": PIN}, {}),
    Effect("rollers of 2 mm on them", {"pin_radius": PIN, "roller_radius": 2.0 * PIN}, {}),
    Effect("driver's journal of 1 mm, µ 0.15", {}, DRIVER),
    Effect("follower's journal of 1 mm, µ 0.15", {}, FOLLOWER),
    Effect("constant bearing torque, 1 % of the drive", {}, TORQUE),
    Effect("air on both bodies", {}, DRAG),
    Effect("oil in both journals", {}, OILED),
    Effect("a face of the follower in oil", {}, {"follower_viscous": FILM}),
    Effect(
        "pins, journals, bearing torque, air and oil in journals",
        {"pin_radius": PIN}, {**DRIVER, **FOLLOWER, **TORQUE, **DRAG, **OILED},
    ),
    Effect("for comparison: 10 % more friction", {}, {"friction": 1.1}),
)  # fmt: skip


def real(slots: int, friction: float, wheel: Numbers, model: Numbers) -> esc.Escapement:
    """A mechanism of Meyer's thesis with some real parts."""
    mechanism = esc.Geneva(slots, crank_radius=CRANK, **wheel)
    inertia = esc.Inertia(*(value * INCH_POUND for value in meyer.INERTIAS[slots]))
    ideal: Any = {"torque": TORQUES[slots] * INCH_POUND, "friction": friction}
    own = {n: v * ideal[SHARED[n]] if n in SHARED else v for n, v in model.items()}
    return esc.Escapement(mechanism, inertia, **{**ideal, **own})


def ratio(slots: int, friction: float, wheel: Numbers, model: Numbers) -> float:
    """Period over that of ideal parts; NaN where there is none."""
    ideal, changed = ({}, {}), (wheel, model)
    one, two = (esc.terminal(real(slots, friction, *parts)) for parts in (ideal, changed))
    return two.period / one.period


def table() -> str:
    """Change of the period by every effect, as the page has it."""
    columns = [(slots, friction) for slots in TORQUES for friction in FRICTIONS]
    heads = [f"n = {slots}, µ = {friction:.2f}" for slots, friction in columns]
    lines = [["change of the period (%)", *heads], ["---"] * (1 + len(heads))]
    for name, *parts in EFFECTS:
        changes = (100.0 * (ratio(*column, *parts) - 1.0) for column in columns)
        lines.append([name, *(f"{change:+.2f}" for change in changes)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


@drawn
def effects() -> Figure:
    """Period of the four-slot mechanism against the size of each effect."""
    figure = style.new_figure(style.TWO_COLUMN, 3.2)
    left, right = style.new_panels(figure, 1, 2)
    inertia = meyer.INERTIAS[4][1] * INCH_POUND
    torque = TORQUES[4] * INCH_POUND
    viscous = (inertia * torque) ** 0.5
    # each curve has a name, the size in the table over its unit, and the numbers at abscissa x
    lengths = (
        ("pin radius", PIN / CRANK, lambda x: ({"pin_radius": x * CRANK}, {})),
        *(
            (
                f"{body}'s journal, $\\mu_b\\,r_b$",
                RUBBING * JOURNAL / CRANK,
                lambda x, body=body: ({}, journal(body, x * CRANK)),
            )
            for body in ("driver", "follower")
        ),
    )
    torques = (
        ("bearing torque / $\\tau$", 0.01, lambda x: ({}, {"driver_bearing_torque": x})),
        *(
            (
                f"{medium}, {body} / {unit}",
                usual / size,
                lambda x, name=f"{body}_{kind}", size=size: ({}, {name: x * size}),
            )
            for medium, kind, unit, size, usuals in (
                ("air", "drag", "$I_f$", inertia, (AIR, AIR)),
                ("oil", "viscous", "$\\sqrt{I_f\\,\\tau}$", viscous, (OIL, FILM)),
            )
            for body, usual in zip(("driver", "follower"), usuals, strict=True)
        ),
    )
    sizes = np.linspace(0.0, 0.1, 41)
    for ax, curves in ((left, lengths), (right, torques)):
        for (name, usual, numbers), look in zip(curves, style.LOOKS, strict=False):
            at = [ratio(4, 0.30, *numbers(x)) for x in (*sizes, usual)]
            ax.plot(100.0 * sizes, at[:-1], color=look.color, ls=look.linestyle, label=name)
            ax.plot(
                100.0 * usual, at[-1], color=look.color, marker=look.marker, ms=6, mfc="white",
                clip_on=False, zorder=4,
            )  # fmt: skip
        ax.axhline(1.0, **style.ZERO)
        ax.set(xlim=(0, 10), ylim=(0.94, 1.18), ylabel="Period / period of ideal parts")
        style.add_legend(ax, 1, loc="upper left", handlelength=style.HANDLE)
    # beyond the last point of the driver's journal there is no motion
    end = left.lines[2].get_xydata()[np.isfinite(left.lines[2].get_ydata())][-1]
    left.plot(*end, "x", color=style.LOOKS[1].color, ms=7, mew=1.6, zorder=5)
    style.annotate(left, "Painlevé limit", tuple(end), (1.0, 11.0), "right")
    left.set_xlabel("Length / crank radius (%)")
    right.set_xlabel("Number / its natural unit (%)")
    return figure


if __name__ == "__main__":
    print(table())
