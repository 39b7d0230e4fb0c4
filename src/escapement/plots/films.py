"""Films as files, by Matplotlib's writers."""

import subprocess
from pathlib import Path

from matplotlib.animation import FFMpegWriter, FuncAnimation

from escapement.base.errors import StorageError
from escapement.base.progress import set_stage

_DPI = 150
# the same pictures give the same bytes, and players want even numbers of pixels
_COMMON = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-pix_fmt", "yuv420p"]
_COMMON += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
_VIDEOS = {
    ".mp4": ("libx264", ["-crf", "18", "-movflags", "+faststart"]),
    ".webm": ("libvpx-vp9", ["-crf", "24", "-b:v", "0"]),
}


def write_film(film: FuncAnimation, path: Path) -> None:
    """Write a film to a file, whose suffix is one of `escapement.base.files.FILMS`."""

    def note(done: int, total: int) -> None:
        set_stage(f"picture {done + 1} of {total}")

    if path.suffix == ".gif":
        film.save(path, writer="pillow", progress_callback=note)
        return
    codec, choices = _VIDEOS[path.suffix]
    rate = 1e3 / film._interval  # type: ignore[attr-defined]
    writer = FFMpegWriter(fps=rate, codec=codec, extra_args=_COMMON + choices)
    try:
        film.save(path, writer=writer, dpi=_DPI, progress_callback=note)
    except subprocess.CalledProcessError:
        raise StorageError(
            f"ffmpeg failed to write a film with its encoder {codec}; install an ffmpeg that "
            "has it, or end the name in .gif"
        ) from None
