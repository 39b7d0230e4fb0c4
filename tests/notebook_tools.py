"""Notebooks as a reader executes them.

    python tests/notebook_tools.py notebooks/*.ipynb

executes them and keeps what they show.
"""

import base64
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

LONGEST = 600  # s: all take a few, and far more where kernels are compiled on a busy machine


def execute(folder, paths):
    """Execute notebooks in `folder` in place, errors included."""
    # kernel "this": the interpreter that runs the tests, whatever kernels are installed
    kernels = folder / "jupyter" / "kernels" / "this"
    kernels.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    kernel = {"argv": command, "display_name": "this", "language": "python"}
    (kernels / "kernel.json").write_text(json.dumps(kernel))
    folders = {"JUPYTER_PATH": str(folder / "jupyter"), "IPYTHONDIR": str(folder / "ipython")}
    folders["ESCAPEMENT_QUIET"] = "1"  # whether anything had to be compiled is no result
    hidden = ("MPLBACKEND", "PYTHONWARNINGS")
    environment = {name: text for name, text in os.environ.items() if name not in hidden} | folders
    # in a process of its own: what a notebook server warns of is none of our business; the
    # first to need Matplotlib's fonts builds a cache, and says so
    program = "import matplotlib.font_manager, nbclient.cli; nbclient.cli.main()"
    options = ["--inplace", "--allow-errors", "--timeout=500", "--kernel_name=this"]
    run = subprocess.run(
        [sys.executable, "-c", program, *options, *paths],
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
        env=environment,
    )
    assert run.returncode == 0, run.stderr


def _shrink(data):
    """Keep of a picture 128 colours, which is a third of its bytes and looks the same."""
    if "image/png" in data:
        picture = Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("RGB")
        content = io.BytesIO()
        few = picture.quantize(128, dither=Image.Dither.NONE)
        few.save(content, "png", optimize=True)
        data["image/png"] = base64.b64encode(content.getvalue()).decode()


def store(paths):
    """Execute notebooks elsewhere, and put what they show into them and nothing else."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        execute(folder, [shutil.copy(path, folder) for path in paths])
        for path in map(Path, paths):
            notebook = json.loads(path.read_text("utf-8"))
            made = json.loads((folder / path.name).read_text("utf-8"))
            for cell, done in zip(notebook["cells"], made["cells"], strict=True):
                if cell["cell_type"] == "code":
                    cell |= {key: done[key] for key in ("execution_count", "outputs")}
                    for output in cell["outputs"]:
                        _shrink(output.get("data", {}))
            text = json.dumps(notebook, indent=1, ensure_ascii=False)
            path.write_text(text + "\n", "utf-8")


if __name__ == "__main__":
    store(sys.argv[1:])
