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
    "Rungs": "Fidelity",
    "Wish": "Requirement",
    "compare_rungs": "compare_fidelity",
    "load_wish": "load_requirement",
}
"""Names of version 0.2 that go with the next release, and those that replace them."""

_PICTURES = {
    "escapement.mechanisms.protocol": ("Mechanism", "_repr_svg_", "mechanism_svg"),
    "escapement.dynamics.motion": ("Motion", "_repr_html_", "motion_html"),
}
"""Classes by their homes, what a notebook asks of them, and what `plots.cells` answers."""


def _hang_pictures():
    """Let notebooks show mechanisms and motions, whose rooms lie below those that draw them."""
    import sys

    for home, (owner, asked, answer) in [*_PICTURES.items()]:
        if shown := getattr(sys.modules.get(home), owner, None):
            setattr(shown, asked, _drawn_when_shown(answer))
            _PICTURES.pop(home, None)


def _drawn_when_shown(answer):
    """A method that loads what draws only when a notebook shows something."""

    def show(self):
        from importlib import import_module

        return getattr(import_module("escapement.plots.cells"), answer)(self)

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
