"""Draw the figures of these pages, and their films: `python docs/make_figures.py [FOLDER]`.

Each figure is drawn by a function in `pages/` that has its name; the figures of accuracy
are in `benchmarks/figures.py`. Without FOLDER they are written to docs/images.
"""

import io
import sys
from importlib import import_module
from pathlib import Path

from matplotlib.animation import FuncAnimation
from PIL import Image, ImageSequence

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import figures
from pages import FIGURES

HERE = Path(__file__).resolve().parent
DPI = 200
COLOURS = 192  # a palette of so many colours keeps the files small without a visible difference
FILM_COLOURS = 64
ACCURACY = ("work_precision", "tolerance", "painleve", "long_run", "conditioning")

_PAGES = (
    *("motions", "studies", "drives", "gears", "effects", "imperfect", "rundown", "tolerances"),
    *("drawings", "designs", "clearance"),
)
for _page in _PAGES:
    import_module(f"pages.{_page}")  # adds its figures to FIGURES
FIGURES |= {f"accuracy_{name}.png": getattr(figures, name) for name in ACCURACY}


def film(made: FuncAnimation, path: Path) -> None:
    """Write a film with few colours, which are the same in all pictures."""
    made.save(path, writer="pillow", dpi=0.4 * DPI)
    with Image.open(path) as image:
        time, plain = image.info["duration"], Image.Dither.NONE
        frames = [frame.convert("RGB") for frame in ImageSequence.all_frames(image)]
    palette = frames[0].quantize(FILM_COLOURS, dither=plain)
    first, *others = [frame.quantize(palette=palette, dither=plain) for frame in frames]
    first.save(path, save_all=True, append_images=others, duration=time, loop=0, optimize=True)


def main(folder: Path) -> None:
    """Draw every figure into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in FIGURES.items():
        if name.endswith(".gif"):
            film(make(), folder / name)
            continue
        image = io.BytesIO()
        make().savefig(image, dpi=DPI)
        Image.open(image).convert("RGB").quantize(COLOURS).save(folder / name, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "images")
