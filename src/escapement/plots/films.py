"""Films as files: how each format is written, and a page that plays one by itself."""

import io
import json
import subprocess
from base64 import b64encode
from importlib.resources import files
from pathlib import Path
from typing import Any

from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation
from PIL import Image

from escapement.base.errors import StorageError

_DPI = 150
_COLOURS = 64
# the same pictures give the same bytes, and players want even numbers of pixels
_COMMON = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-pix_fmt", "yuv420p"]
_COMMON += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
_VIDEOS = {
    ".mp4": ("libx264", ["-crf", "18", "-movflags", "+faststart"]),
    ".webm": ("libvpx-vp9", ["-crf", "24", "-b:v", "0"]),
}


class _PageWriter(AbstractMovieWriter):
    """Writes a page that holds every picture and asks for nothing else."""

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin a film."""
        super().setup(fig, outfile, dpi)
        self.pictures: list[str] = []

    def grab_frame(self, **options: Any) -> None:
        """Add the figure as it is."""
        drawn, content = io.BytesIO(), io.BytesIO()
        self.fig.savefig(drawn, format="rgba", dpi=self.dpi)
        picture = Image.frombytes("RGBA", self.frame_size, drawn.getvalue()).convert("RGB")
        # a drawing has few colours, and a quarter of the bytes keeps a long film small
        picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(content, "png", optimize=True)
        self.pictures.append(b64encode(content.getvalue()).decode())

    def finish(self) -> None:
        """Write the page."""
        page = files(__package__).joinpath("film.html").read_text(encoding="utf-8")
        page = page.replace("RATE", f"{self.fps:g}").replace("PICTURES", json.dumps(self.pictures))
        Path(self.outfile).write_text(page, encoding="utf-8")


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
        film.save(path, writer=_PageWriter(fps=rate), dpi=_DPI, progress_callback=note)
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
