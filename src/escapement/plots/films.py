"""Films as files, by Matplotlib's writers, and figures that are drawn quickly many times."""

import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation, HTMLWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import RendererAgg

from escapement.base.errors import StorageError
from escapement.plots.style import Picture

_DPI = 150
# the same pictures give the same bytes, and players want even numbers of pixels
_COMMON = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-pix_fmt", "yuv420p"]
_COMMON += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
_VIDEOS = {
    ".mp4": ("libx264", ["-crf", "18", "-movflags", "+faststart"]),
    ".webm": ("libvpx-vp9", ["-crf", "24", "-b:v", "0"]),
}
_LARGEST = 1024  # greatest size of a page with its pictures [MB]
# letters in place of a font from the network; who asks for less motion starts the film by hand
_SIGNS = {
    "minus": "−", "plus": "+", "play": "▶", "pause": "❚❚", "fast-backward": "|◀◀",
    "step-backward": "|◀", "step-forward": "▶|", "fast-forward": "▶▶|",
}  # fmt: skip
_HEAD = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Film of a motion</title>
<style>
.animation img { max-width: 100% } .animation button { min-width: 3.2em }
.fa { font: 1em sans-serif } .fa-flip-horizontal { display: inline-block; transform: scaleX(-1) }
SIGNS</style></head><body>
"""
_FOOT = """<script>
addEventListener("load", () => setTimeout(() => {
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) animFILM.play_animation();
}));
</script></body></html>
"""


class FilmFigure(Picture):
    """A figure of which only some artists change from picture to picture.

    The others are drawn once for each size of the picture, and lie beneath.

    Attributes
    ----------
    moving : list of Artist
        Artists that change, the lowest first.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.moving: list[Artist] = []
        self._beneath: dict[tuple[float, float], Any] = {}

    def draw(self, renderer: Any) -> None:
        """Draw the figure."""
        if not (self.moving and isinstance(renderer, RendererAgg)):
            super().draw(renderer)
            return
        surface: Any = renderer
        size = renderer.width, renderer.height
        if size in self._beneath:
            surface.restore_region(self._beneath[size])
        else:
            for artist in self.moving:
                artist.set_visible(False)
            super().draw(renderer)
            for artist in self.moving:
                artist.set_visible(True)
            # a renderer that only measures leaves the paper transparent
            if np.asarray(surface.buffer_rgba())[0, 0, 3]:
                self._beneath[size] = surface.copy_from_bbox(self.bbox)
        for artist in self.moving:
            artist.draw(renderer)


def write_film(film: FuncAnimation, path: Path) -> None:
    """Write a film to a file, whose suffix is one of `escapement.base.files.FILMS`."""
    # what makes a motion has loaded this already; figures of files do without it
    from escapement.base.progress import set_stage

    def note(done: int, total: int) -> None:
        set_stage(f"picture {done + 1} of {total}")

    rate = 1e3 / film._interval  # type: ignore[attr-defined]
    if path.suffix == ".gif":
        film.save(path, writer="pillow", progress_callback=note)
    elif path.suffix == ".html":
        writer: AbstractMovieWriter = HTMLWriter(rate, embed_frames=True, embed_limit=_LARGEST)
        film.save(path, writer=writer, dpi=_DPI, progress_callback=note)
        path.write_text(_alone(path.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        codec, choices = _VIDEOS[path.suffix]
        writer = FFMpegWriter(fps=rate, codec=codec, extra_args=_COMMON + choices)
        try:
            film.save(path, writer=writer, dpi=_DPI, progress_callback=note)
        except subprocess.CalledProcessError:
            raise StorageError(
                f"ffmpeg failed to write a film with its encoder {codec}; install an ffmpeg that "
                "has it, or end the name in .html"
            ) from None


def _alone(page: str) -> str:
    """Matplotlib's page as one that asks for no other file, the same for the same film."""
    page = re.sub(r"<link[^>]*>", "", page)
    name = re.search(r"_anim_img(\w+)", page)[1]  # type: ignore[index]
    signs = "".join(f'.fa-{key}::before {{ content: "{it}" }}\n' for key, it in _SIGNS.items())
    head, foot = _HEAD.replace("SIGNS", signs), _FOOT.replace("FILM", name)
    # the name is drawn at random
    return (head + page + foot).replace(name, "film")
