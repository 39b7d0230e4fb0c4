"""Notebooks: stored without results, and executed from top to bottom without a complaint."""

import json
import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))
assert NOTEBOOKS
LONGEST = 600  # s: all take a few, and far more where kernels are compiled on a busy machine

# In a process of its own: what a notebook server warns of is none of our business
EXECUTE = """
import asyncio
import sys
from pathlib import Path
import matplotlib.font_manager  # the first to need it builds a cache, and says so
import nbformat
from nbclient import NotebookClient

folder, *paths = map(Path, sys.argv[1:])

async def execute(path, turns):
    notebook = nbformat.read(path, as_version=4)
    place = {"metadata": {"path": str(folder)}}
    client = NotebookClient(notebook, timeout=500, kernel_name="this", resources=place)
    async with turns:
        try:
            await client.async_execute()
        except Exception as error:
            (folder / f"{path.stem}.error").write_text(str(error))
    nbformat.write(notebook, folder / path.name)

async def all_of_them():
    turns = asyncio.Semaphore(2)
    await asyncio.gather(*(execute(path, turns) for path in paths))

asyncio.run(all_of_them())
"""


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """A folder with every notebook as executed, and what stopped one."""
    folder = tmp_path_factory.mktemp("notebooks")
    # kernel "this": the interpreter that runs the tests, whatever kernels are installed
    kernels = folder / "jupyter" / "kernels" / "this"
    kernels.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    kernel = {"argv": command, "display_name": "this", "language": "python"}
    (kernels / "kernel.json").write_text(json.dumps(kernel))
    environment = os.environ | {
        "JUPYTER_PATH": str(folder / "jupyter"),
        "IPYTHONDIR": str(folder / "ipython"),
    }
    for name in ("MPLBACKEND", "PYTHONWARNINGS"):
        environment.pop(name, None)
    run = subprocess.run(
        [sys.executable, "-c", EXECUTE, str(folder), *map(str, NOTEBOOKS)],
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
        env=environment,
    )
    assert run.returncode == 0, run.stderr
    return folder


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_stored_without_results(path):
    text = path.read_text(encoding="utf-8")
    notebook = nbformat.reads(text, as_version=4)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    assert text == json.dumps(json.loads(text), indent=1, ensure_ascii=False) + "\n"
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    for cell in notebook.cells:
        assert cell.metadata == {}
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_without_a_complaint(path, executed):
    stopped = executed / f"{path.stem}.error"
    assert not stopped.exists(), stopped.read_text()
    notebook = nbformat.read(executed / path.name, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in cells)
    outputs = [output for cell in cells for output in cell.outputs]
    complaints = [output.text for output in outputs if output.get("name") == "stderr"]
    assert complaints == []
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 10
