"""Films: every picture shows the mechanism where the motion has it at that instant."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

import escapement as esc
from escapement import plots
from escapement.base.errors import CannotCreate
from figure_tools import by_id

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
PLANETARY = esc.EllipticalPlanetary(16e-3, 9e-3)
DRIVES = [esc.Geneva(6, pins=1), esc.GearDriven(4, 1, "epicycloid"), PLANETARY]


def motion(mechanism, engagements=2):
    friction = 0.0 if mechanism is PLANETARY else 0.05
    return esc.simulate(esc.Escapement(mechanism, INERTIA, 0.0113, friction), engagements)


def place(ax):
    """Where the driver's pin stands, or where the ellipses touch."""
    if any(artist.get_gid() == "pin-0" for artist in ax.get_children()):
        return by_id(ax, "pin-0").center
    return np.ravel(by_id(ax, "contact").get_data())


@pytest.mark.parametrize("mechanism", DRIVES, ids=lambda drive: type(drive).__name__)
def test_the_last_picture_is_that_of_its_instant(mechanism, tmp_path):
    shown = motion(mechanism)
    start, stop = 0.2 * shown.end_time, 0.9 * shown.end_time
    film = plots.animate(shown, start, stop, frames=4)
    drawing, velocities = film._fig.axes
    limits = drawing.get_xlim()
    plots.save(film, tmp_path / "film.gif")
    assert drawing.get_xlim() == limits
    instant = start + 0.75 * (stop - start)
    state = shown.at(instant)
    alone = plots.plot_mechanism(mechanism, float(state.theta))
    assert place(drawing) == pytest.approx(place(alone))
    speeds = [state.theta_dot, state.phi_dot]
    np.testing.assert_allclose(velocities.lines[-1].get_ydata(), speeds)
    assert re.match(rf"{1e3 * instant:.0f}(\.\d+)? ms, ", drawing.get_title())
    np.testing.assert_allclose(velocities.get_xlim(), [1e3 * start, 1e3 * stop])


def test_a_loose_pin_stands_between_its_walls_as_in_the_motion(tmp_path):
    wheel = esc.Geneva(4, crank_radius=0.01, clearance=2e-5)
    cycle = esc.terminal(esc.Escapement(wheel, INERTIA, 0.0113, 0.3)).motion
    start, stop = cycle.reversals.time[0], cycle.impacts.time[-1]
    film = plots.animate(cycle, start, stop, frames=4)
    plots.save(film, tmp_path / "film.gif")
    state = cycle.at(start + 0.75 * (stop - start))
    pin = wheel.centre_distance - np.exp(-1j * state.theta)
    ahead = (pin * np.exp(-1j * state.phi)).imag
    whole, close_up, _velocities = film._fig.axes
    assert close_up.get_title() == "clearance 20 times wider\nflight"
    for ax, factor in ((whole, 1.0), (close_up, 20.0)):
        (x, further), (y, above) = by_id(ax, "slot-0").get_data()
        along = complex(further - x, above - y)
        found = (complex(*by_id(ax, "pin-0").center) - complex(x, y)) / (along / abs(along))
        assert found.imag == pytest.approx(factor * ahead, rel=1e-9)


def test_the_file_plays_for_ever_at_the_rate_asked_for(tmp_path):
    shown = motion(DRIVES[0])
    for name in "ab":
        plots.save(film := plots.animate(shown, frames=3, rate=20.0), tmp_path / f"{name}.gif")
    with Image.open(tmp_path / "a.gif") as image:
        assert (image.n_frames, image.info["duration"], image.info["loop"]) == (3, 50, 0)
    assert f"{3 / 20 / shown.end_time:.3g} times slower" in film._fig.axes[0].get_title()
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_a_video_has_every_picture(tmp_path, suffix):
    film = plots.animate(motion(DRIVES[0], 1), frames=5, rate=10.0)
    for name in "ab":
        plots.save(film, tmp_path / f"{name}{suffix}")
    a, b = (tmp_path / f"{name}{suffix}" for name in "ab")
    assert a.read_bytes() == b.read_bytes()
    shown = ["ffmpeg", "-v", "error", "-i", a, "-f", "rawvideo", "-pix_fmt", "gray", "-"]
    pictures = np.frombuffer(subprocess.run(shown, capture_output=True).stdout, "u1")
    pictures = pictures.reshape(5, 480, 1080).astype(int)
    assert np.abs(np.diff(pictures, axis=0)).max(axis=(1, 2)).min() > 100


def test_without_ffmpeg_one_line_names_what_needs_none(tmp_path, monkeypatch, refusal):
    monkeypatch.setenv("PATH", str(tmp_path))
    film = plots.animate(motion(DRIVES[0], 1), frames=2)
    with pytest.raises(CannotCreate, match=r"install ffmpeg, or end the name in \.gif"):
        plots.save(film, tmp_path / "film.mp4")
    assert list(tmp_path.iterdir()) == []
    plots.save(film, tmp_path / "film.gif")
    numbers = ["--torque", "1", "--driver-inertia", "1", "--follower-inertia", "1"]
    assert "install ffmpeg" in refusal(73, "run", *numbers, "--plot", str(tmp_path / "a.webm"))
    longer = ["--engagements", "51", "--plot", str(tmp_path / "a.gif")]
    assert "at most 50 engagements, got 51" in refusal(2, "run", *numbers, *longer)
