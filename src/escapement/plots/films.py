"""Films as files, by Matplotlib's writers, and figures that are drawn quickly many times."""

import io
import re
import subprocess
from base64 import b64decode, b64encode
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation, HTMLWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import RendererAgg
from PIL import Image

from escapement.base.errors import StorageError
from escapement.plots.style import Picture

_DPI = 150
_COLOURS = 64
# the same pictures give the same bytes, and players want even numbers of pixels
_COMMON = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-pix_fmt", "yuv420p"]
_COMMON += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
_VIDEOS = {
    ".mp4": ("libx264", ["-crf", "18", "-movflags", "+faststart"]),
    ".webm": ("libvpx-vp9", ["-crf", "24", "-b:v", "0"]),
}
_LARGEST = 1024  # greatest size of a page with its pictures [MB]


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


def _alone(player: str) -> str:
    """Matplotlib's player as a page that asks for no other file, the same for the same film."""
    player = re.sub(r"<link[^>]*>", "", player)
    player = re.sub(r'(?<=base64,)[^"]+', _with_few_colours, player)
    # the name of the film is drawn at random
    for name in re.findall(r"_anim_img(\w+)", player)[:1]:
        player = player.replace(name, "film")
    page = files(__package__).joinpath("film.html").read_text(encoding="utf-8")
    return page.replace("FILM", player)


def _with_few_colours(found: re.Match[str]) -> str:
    """A picture in a quarter of the bytes, because a drawing has few colours."""
    content = io.BytesIO()
    with Image.open(io.BytesIO(b64decode(found[0]))) as picture:
        few = picture.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE)
    few.save(content, "png", optimize=True)
    return b64encode(content.getvalue()).decode()
