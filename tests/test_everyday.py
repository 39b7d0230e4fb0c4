"""First contact with the project: its own files, notebooks, and the way values are printed."""

import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import nbformat
import pytest
import yaml

import escapement as esc
from notebook_tools import execute

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]


def test_the_project_says_who_made_it_and_under_which_licence():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert cited["version"] == project["version"] == esc.__version__
    assert cited["license"] == project["license"] == "MIT"
    assert cited["authors"] == project["authors"] == [{"name": "The escapement developers"}]
    for name in project["license-files"]:
        assert (
            (ROOT / name).read_text().startswith("MIT License\n\nCopyright (c) 2026 the escapement")
        )
    changes = (ROOT / "CHANGELOG.md").read_text()
    assert changes.index("## Unreleased") < changes.index(f"## {project['version']}\n")


TIMER = """
import escapement as esc
from escapement import plots
inertia = esc.Inertia(driver=3.39e-7, follower=5.65e-6)
timer = esc.Escapement(esc.Geneva(slots=4), inertia, torque=0.0113, friction=0.35)
motion = esc.simulate(timer, engagements=3)
"""
CELLS = {  # and how many pictures each shows
    "plots.plot_velocities(motion)": 1,
    "plots.plot_configurations()": 1,
    "ax = plots.plot_phase_portrait(motion)": 0,
    "ax": 1,
    "ax.figure": 1,
    "import matplotlib.pyplot as plt; plots.plot_mechanism(timer.mechanism)": 1,
    "plots.plot_velocities(motion, plt.subplots()[1])": 1,
    "plots.plot_study(esc.sweep(timer, friction=[0.2, 0.3]))": 1,
}


@pytest.fixture(scope="module")
def motion():
    scope = {}
    exec(TIMER, scope)
    return scope["motion"]


MODES = {"plain": "", "inline": "%matplotlib inline\n"}


@pytest.fixture(scope="module")
def notebooks(tmp_path_factory):
    """The cells above as executed, after a first one that the mode asks for."""
    folder = tmp_path_factory.mktemp("cells")
    paths = {mode: folder / f"{mode}.ipynb" for mode in MODES}
    for mode, path in paths.items():
        cells = [nbformat.v4.new_code_cell(text) for text in (MODES[mode] + TIMER, *CELLS)]
        nbformat.write(nbformat.v4.new_notebook(cells=cells), path)
    execute(folder, [str(path) for path in paths.values()])
    return {mode: nbformat.read(path, as_version=4) for mode, path in paths.items()}


@pytest.mark.parametrize("mode", MODES)
def test_a_cell_that_ends_with_a_plot_shows_it_once(notebooks, mode):
    shown = {}
    for cell in notebooks[mode].cells[1:]:
        assert [o for o in cell.outputs if o.output_type in ("error", "stream")] == []
        shown[cell.source] = sum("image/png" in o.get("data", {}) for o in cell.outputs)
    assert shown == CELLS


@pytest.mark.parametrize("layout", [None, "constrained"])
@pytest.mark.parametrize("plot", ["plot_velocities", "plot_phase_portrait", "plot_contact_moment"])
def test_a_legend_stays_within_a_figure_of_the_readers_own(plot, layout, motion):
    figure, axes = plt.subplots(1, 2, layout=layout, figsize=(8.0, 3.0))
    draw = getattr(esc.plots, plot)
    draw(motion, axes[0])
    figure.canvas.draw()
    box = axes[0].get_legend().get_window_extent()
    assert box.x0 >= 0.0 <= box.y0
    assert box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    assert draw(motion, axes[1], legend=False).get_legend() is None
    plt.close(figure)


def test_values_print_in_short_with_their_units(motion):
    cycle, timer = esc.terminal(motion.escapement), motion.escapement
    study = esc.sweep(timer, friction=[0.2, 0.3], torque=[0.01, 0.02])
    wheel = esc.Geneva(4, crank_radius=0.02, pin_radius=1e-3)
    inertia = "inertia=Inertia(driver=3.39e-07 kg m², follower=5.65e-06 kg m²)"
    parts = [
        (motion, "engagements=3, end_time=0.134541 s, handoff_velocity=74.6835 rad/s"),
        (motion.ledger, "load=0 J, friction="),
        (motion.reversals, "time=3 from 0.0427143 to 0.130553 s"),
        (motion.extrema, "maximum=6 of 12"),
        (timer, f"{inertia}, torque=0.0113 N m, friction=0.35)"),
        (wheel, "(slots=4, pins=4, crank_radius=0.02 m, pin_radius=0.001 m)"),
        (study, "torque=2 from 0.01 to 0.02 N m"),
        (cycle, "period=0.0439239 s"),
    ]
    for thing, part in parts:
        assert part in repr(thing)
        assert len(repr(thing)) <= (600 if thing is cycle else 300)
    for thing in (motion, cycle, study):
        assert f"<table><caption>{type(thing).__name__}</caption>" in thing._repr_html_()
    assert "<tr><th>period</th><td>0.0439239 s</td></tr>" in cycle._repr_html_()
    every = dict.fromkeys(["driver_drag", "follower_drag", "driver_viscous", "load_torque"], 1.1e-9)
    journals = {f"{body}_bearing_friction": 0.123456 for body in ("driver", "follower")}
    full = esc.Escapement(wheel, timer.inertia, torque=0.0113, friction=0.35, **every, **journals)
    assert len(repr(full)) == 300
