"""Draw the figures of these pages: `python docs/make_figures.py [FOLDER]`.

One function a figure in `pages/`, named like its file; those of accuracy are in
`benchmarks/figures.py`. Without FOLDER they go to docs/images.
"""

import io
import sys
from importlib import import_module
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import figures
from pages import FIGURES

HERE = Path(__file__).resolve().parent
DPI = 200
COLOURS = 192  # a palette keeps the files small; the eye sees no difference
ACCURACY = ("work_precision", "tolerance", "order", "painleve", "long_run", "conditioning")

_PAGES = (
    *("motions", "studies", "drives", "gears", "effects", "imperfect", "rundown", "tolerances"),
    *("drawings", "designs", "clearance"),
)
for _page in _PAGES:
    import_module(f"pages.{_page}")  # enters its figures
FIGURES |= {f"accuracy_{name}.png": getattr(figures, name) for name in ACCURACY}


def main(folder: Path) -> None:
    """Draw every figure into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in FIGURES.items():
        image = io.BytesIO()
        make().savefig(image, dpi=DPI)
        Image.open(image).convert("RGB").quantize(COLOURS).save(folder / name, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "images")
