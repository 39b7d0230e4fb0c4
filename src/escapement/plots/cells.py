"""What a notebook shows for mechanisms and motions: a drawing, and a film that it plays.

The package's `__init__` hangs these functions on to the classes, whose rooms lie below this one.
"""

import html
from typing import cast

from matplotlib.figure import Figure

from escapement.base.errors import InvalidValue
from escapement.base.text import Shown
from escapement.dynamics.motion import Motion
from escapement.explorer import film
from escapement.mechanisms.protocol import Mechanism
from escapement.plots.drawing import plot_mechanism
from escapement.plots.saving import as_svg

_FRAME = (
    '<iframe title="Film of a motion" sandbox="allow-scripts allow-downloads" '
    'style="width: 100%; height: 42rem; border: 0" srcdoc="{}"></iframe>'
)


def mechanism_svg(mechanism: Mechanism) -> str | None:
    """The mechanism to scale, or its transmission; None if there is too much to draw."""
    try:
        return as_svg(cast(Figure, plot_mechanism(mechanism).figure))
    except InvalidValue:
        return None


def motion_html(motion: Motion) -> str:
    """A film of the motion, or why there is none, above the table of its numbers."""
    try:
        shown = _FRAME.format(html.escape(film(motion)))
    except InvalidValue as error:
        shown = f"<p>No film: {html.escape(str(error))}</p>"
    return shown + Shown._repr_html_(motion)
