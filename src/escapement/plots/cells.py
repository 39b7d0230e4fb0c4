"""What a notebook shows above the table of a mechanism or a motion: a drawing, or a film.

The package's `__init__` hangs these functions on to the classes, whose rooms lie below this one.
"""

import html
from typing import cast

from matplotlib.figure import Figure

from escapement.base.errors import InvalidValue
from escapement.dynamics.motion import Motion
from escapement.explorer import film
from escapement.mechanisms.protocol import Mechanism
from escapement.plots.drawing import plot_mechanism
from escapement.plots.saving import as_svg

_FRAME = (
    '<iframe title="Film of a motion" sandbox="allow-scripts allow-downloads" '
    'style="width: 100%; height: 42rem; border: 0" srcdoc="{}"></iframe>'
)


def drawing_above(mechanism: Mechanism) -> str:
    """The mechanism to scale, or its transmission; nothing if there is too much to draw."""
    try:
        return as_svg(cast(Figure, plot_mechanism(mechanism).figure))
    except InvalidValue:
        return ""


def film_above(motion: Motion) -> str:
    """A film of the motion, or why there is none."""
    try:
        return _FRAME.format(html.escape(film(motion)))
    except InvalidValue as error:
        return f"<p>No film: {html.escape(str(error))}</p>"
