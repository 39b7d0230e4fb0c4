"""Time-domain simulation of Geneva escapements and intermittent motion.

    import escapement as esc
    timer = esc.Escapement(
        mechanism=esc.Geneva(slots=4),
        inertia=esc.Inertia(driver=3.39e-7, follower=5.65e-6),
        friction=0.35,
        torque=0.0113,
    )
    motion = esc.simulate(timer, engagements=20)

Names are imported on first use, so that importing the package loads and compiles nothing.
"""

__version__ = "0.2.0"

# The stub is the only list of public names. It has one line for each, such as
# "from escapement.model.escapement import Inertia as Inertia".
with open(f"{__file__}i", encoding="utf-8") as _stub:
    _HOMES = {words[3]: words[1] for line in _stub if len(words := line.split()) == 6}
__all__ = sorted([*_HOMES, "__version__"])

_FORMER = {
    "BeatTimes": "Readings",
    "Rungs": "Fidelity",
    "Wish": "Requirement",
    "compare_rungs": "compare_fidelity",
    "fit_run_up": "fit_motion",
    "load_wish": "load_requirement",
    "write_beats": "write_readings",
}
"""Names that go with the next release, and those that replace them."""

_PICTURES = {
    "escapement.mechanisms.kind": ("Kind", "drawing_above"),
    "escapement.mechanisms.from_functions": ("FunctionDrive", "drawing_above"),
    "escapement.dynamics.motion": ("Motion", "film_above"),
}
"""Classes by their homes, and the function of `plots.cells` for what a notebook shows of them."""


def _hang_pictures():
    """Let notebooks show mechanisms and motions, whose rooms lie below those that draw them."""
    import sys

    for home, (owner, picture) in [*_PICTURES.items()]:
        if shown := getattr(sys.modules.get(home), owner, None):
            shown._repr_html_ = _with_picture(picture, shown._repr_html_)
            _PICTURES.pop(home, None)


def _with_picture(name, table):
    """A method that shows a picture above a table, and loads what draws when it is called."""

    def show(self):
        from importlib import import_module

        return getattr(import_module("escapement.plots.cells"), name)(self) + table(self)

    return show


def __getattr__(name):
    if name in _FORMER:
        import warnings

        text = f"escapement.{name} is called escapement.{_FORMER[name]}; use this name"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        name = _FORMER[name]
    if name not in _HOMES:
        raise AttributeError(f"module 'escapement' has no attribute {name!r}")
    from importlib import import_module

    home = _HOMES[name]
    # names of the package itself and of its lowest room are those of modules
    is_module = home in ("escapement", "escapement.base")
    value = import_module(f"{home}.{name}") if is_module else getattr(import_module(home), name)
    _hang_pictures()
    globals()[name] = value
    return value


def __dir__():
    return __all__
