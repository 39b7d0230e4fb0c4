"""Figure of a sheet of parts for cutting."""

from matplotlib.figure import Figure

import escapement as esc
from escapement.outlines.sheet import LAYERS, lay_out
from escapement.outlines.title_block import title_block
from pages import drawn


@drawn
def exported_sheet() -> Figure:
    """The parts of a wheel with five slots and all that it is built with, as in the file."""
    wheel = esc.Geneva(5, 1, crank_radius=0.03, pin_radius=0.002, clearance=1.5e-4)
    fits = esc.Fits(
        **dict.fromkeys(("driver_shaft_radius", "follower_shaft_radius"), 0.0025),
        **{"kerf": 2e-4, "bore": "D", "dowel_radius": 0.0015, "washer_radius": 0.0045},
        **{"screw_radius": 0.0016, "coupon_step": 5e-5},
    )
    parts, gaps = esc.parts_of(wheel, fits), esc.motion_check(wheel, fits)
    block = title_block("Acrylic 3 mm", 1e-4, wheel, fits, parts, gaps, (1e-3, "mm"))
    sheet = lay_out(parts, fits.kerf, 1e3, stock=0.3 + 0.21j, crosses=False, block=block)
    wide, high = sheet.size.real, sheet.size.imag
    figure = Figure(figsize=(7.2, 7.2 * high / wide))
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    for layer, curve in sheet.curves:
        z = curve.drawn()
        ax.plot(z.real, z.imag, color=LAYERS[layer][1], lw=0.9)
    for layer, a, b in sheet.lines:
        ax.plot([a.real, b.real], [a.imag, b.imag], color=LAYERS[layer][1], lw=0.6)
    for layer, at, text in sheet.texts:
        ax.text(at.real, at.imag, text, color=LAYERS[layer][1], fontsize=4.5)
    ax.set(xlim=(0.0, wide), ylim=(0.0, high), aspect="equal")
    ax.set_axis_off()
    return figure
