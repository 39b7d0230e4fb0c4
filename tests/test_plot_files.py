"""Labels, style, and figure files that are written whole or not at all."""

import errno
import os
import subprocess
import sys

import numpy as np
import pytest

from escapement import plots
from escapement.base.errors import StorageError
from escapement.base.units import spelt
from escapement.plots import style
from escapement.plots.style import label, number_text, scaled


@pytest.mark.parametrize(
    ("udunits", "shown"),
    [
        ("rad s-1", "rad/s"),
        ("in lbf", "in-lbf"),
        ("in lbf s2", "in-lbf-s²"),
        ("s-1", "1/s"),
        ("1", ""),
    ],
)
def test_units_are_printed_as_is_customary(udunits, shown):
    assert spelt(udunits) == shown


def test_prefixes_keep_numbers_readable():
    assert scaled("s", [0.04, np.nan]) == (1e3, "ms")
    assert scaled("s", [1.0]) == (1.0, "s")
    assert scaled("s", [3e-5]) == (1e6, "µs")
    assert scaled("N m", [-0.2]) == (1e3, "mN m")
    assert scaled("s", [np.nan]) == (1.0, "s")
    assert scaled("rad s-1", [1e-4]) == (1.0, "rad/s")
    assert number_text(5.65e-6) == "5.65×10⁻⁶"
    assert label("moment of inertia of the driving wheel", "in-lbf-s²").count("\n") == 1


def test_palette_is_distinct_in_grey_print():
    assert len({look.marker for look in style.LOOKS}) == len(style.LOOKS)
    assert len({str(look.linestyle) for look in style.LOOKS}) == len(style.LOOKS)


def test_nothing_imports_pyplot():
    """And pictures of cells of a notebook are loaded when they are shown."""
    code = (
        "import sys, escapement as esc\n"
        "wheel = esc.Geneva(4)\n"
        "assert not {'matplotlib', 'escapement.plots', 'escapement.explorer'} & {*sys.modules}\n"
        "assert '<svg' in wheel._repr_html_()\n"
        "esc.plots.plot_configurations()\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True)


@pytest.fixture
def figure():
    ax = plots.new_axes()
    ax.plot([0, 1], [0, 1])
    return ax.figure


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("SVG", b"<?xml")]
)
def test_files_are_complete_and_reproducible(figure, tmp_path, suffix, magic):
    first, second = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    plots.save(figure, first)
    plots.save(figure, str(second))
    plots.save(figure, second)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(magic)
    assert sorted(os.listdir(tmp_path)) == sorted([first.name, second.name])


def test_a_halo_is_back_when_an_svg_is_written(figure, tmp_path):
    """In an SVG it would turn letters into curves."""
    style.annotate(figure.axes[0], "n = 6", (0.5, 0.5))
    for name in ("before.png", "text.svg", "after.png"):
        plots.save(figure, tmp_path / name)
    assert ">n = 6</text>" in (tmp_path / "text.svg").read_text("utf-8")
    before, after = ((tmp_path / f"{name}.png").read_bytes() for name in ("before", "after"))
    assert before == after


def test_full_disk_keeps_the_old_file(figure, tmp_path, monkeypatch):
    def full(_descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    target = tmp_path / "x.png"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        plots.save(figure, target)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["x.png"]
