"""The explorer in a notebook: the same page in a frame, whose design Python reads and sets."""

from functools import cache
from typing import Any

from escapement.base import validate
from escapement.dynamics.motion import Motion
from escapement.explorer import page, player
from escapement.model.escapement import Escapement

_FRAME = """
export default { render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.title = "Escapement explorer";
  frame.sandbox = "allow-scripts allow-downloads allow-popups";
  frame.style = `width: 100%; height: ${model.get("height")}px; border: 0`;
  frame.srcdoc = model.get("page");
  const hear = (event) => {
    if (event.source !== frame.contentWindow || !event.data?.explorer) return;
    model.set("design", event.data.explorer);
    model.save_changes();
  };
  const tell = () => frame.contentWindow?.postMessage({ explorer: model.get("design") }, "*");
  addEventListener("message", hear);
  model.on("change:design", tell);
  el.append(frame);
  return () => {
    removeEventListener("message", hear);
    model.off("change:design", tell);
  };
} };
"""


def explore(
    subject: Escapement | Motion,
    *,
    initial_speed: float = 0.0,
    engagements: int = 20,
    height: int = 900,
) -> Any:
    """The explorer of an escapement in a notebook, or a motion that is played there.

    Parameters
    ----------
    subject : Escapement or Motion
        A design of a Geneva wheel, or a motion of any mechanism.
    initial_speed, engagements : float, int
        For a design, as in `explorer.page`.
    height : int
        Height of the frame [pixels].

    Returns
    -------
    anywidget.AnyWidget
        Its `design` holds the numbers in SI as they are dragged, by the names of studies; setting
        it changes the page.

    Raises
    ------
    MissingPackage
        If anywidget is not installed.
    InvalidValue
        As raised by `explorer.page` and `explorer.player`.
    """
    if isinstance(subject, Motion):
        text = player(subject)
    elif isinstance(subject, Escapement):
        text = page(subject, initial_speed, engagements)
    else:
        remedy = "give the design or motion to be shown"
        raise validate.fail("subject", "an Escapement or a Motion", subject, remedy)
    tall = validate.integer("height", height, 200, "900 shows the mechanism and its figures")
    return _widget()(page=text, height=tall)


@cache
def _widget() -> Any:
    """The widget's class; it is made when a notebook needs it."""
    anywidget: Any = validate.package("anywidget", "the explorer in a notebook", "notebook")
    traitlets: Any = validate.package("traitlets", "the explorer in a notebook", "notebook")

    class Explorer(anywidget.AnyWidget):  # type: ignore[misc]
        """The page in a frame, whose script has no access to the rest of the notebook."""

        _esm = _FRAME
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int().tag(sync=True)
        design = traitlets.Dict().tag(sync=True)

    return Explorer
