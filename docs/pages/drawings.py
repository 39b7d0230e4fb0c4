"""Figure of a sheet of parts for cutting."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.outlines.sheet import LAYERS, lay_out
from pages import drawn


@drawn
def exported_sheet() -> Figure:
    """The parts of a wheel with six slots, as in the file."""
    wheel = esc.Geneva(6, 1, crank_radius=0.02, pin_radius=0.0015, clearance=3e-5)
    sheet = lay_out(esc.parts_of(wheel), kerf=0.0, scale=1e3, segments=False)
    wide, high = sheet.size.real, sheet.size.imag
    figure = Figure(figsize=(7.2, 7.2 * high / wide))
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    for layer, curve in sheet.curves:
        z = curve.drawn()
        ax.plot(z.real, z.imag, color=LAYERS[layer][1], lw=0.9)
    look = {"color": LAYERS["CENTRE"][1], "lw": 0.6}
    for a, b in sheet.lines:
        ax.plot([a.real, b.real], [a.imag, b.imag], **look)
    for at, name in sheet.names:
        ax.text(at.real, at.imag, name, color=look["color"], fontsize=8)
    ax.set(xlim=(0.0, wide), ylim=(0.0, high), aspect="equal")
    ax.set_axis_off()
    return figure
