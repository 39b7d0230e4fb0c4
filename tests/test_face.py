"""The names of `import escapement as esc`, as type checkers and editors see them."""

import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import escapement as esc

PACKAGE = Path(esc.__file__).parent


def test_every_public_name_is_there():
    assert set(esc.__all__) == set(dir(esc))
    assert {"__version__", "simulate", "Study", "units"} < set(esc.__all__)
    for name in esc.__all__:
        assert getattr(esc, name) is not None
    assert esc.units is import_module("escapement.base.units")


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match="module 'escapement' has no attribute 'nonsense'"):
        esc.nonsense  # noqa: B018


@pytest.mark.parametrize(
    ("former", "name"),
    [
        ("Rungs", "Fidelity"),
        ("Wish", "Requirement"),
        ("compare_rungs", "compare_fidelity"),
        ("load_wish", "load_requirement"),
    ],
)
def test_a_former_name_warns_of_the_one_that_replaces_it(former, name):
    with pytest.warns(DeprecationWarning, match=f"escapement.{former} is called escapement.{name}"):
        assert getattr(esc, former) is getattr(esc, name)
    assert former not in dir(esc)


def test_the_former_attribute_of_designs_warns_too():
    found = esc.design(esc.Requirement(period=0.04, torque=0.01, slots=4, friction=3.0))
    with pytest.warns(DeprecationWarning, match="requirement"):
        assert found.wish is found.requirement


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """What mypy says of a user's file with every public name and one that does not exist."""
    folder = tmp_path_factory.mktemp("user")
    lines = ["import escapement as esc", *(f"reveal_type(esc.{name})" for name in esc.__all__)]
    (folder / "user.py").write_text("\n".join([*lines, "esc.nonsense", ""]))
    # beside the user's file and without NumPy's own types, which take most of the time
    (folder / "escapement").symlink_to(PACKAGE, target_is_directory=True)
    environment = {name: text for name, text in os.environ.items() if name != "MYPYPATH"}
    done = subprocess.run(
        [
            *(sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports"),
            *("--follow-imports=silent", "--config-file=", "--cache-dir=cache"),
            *("--no-site-packages", "user.py"),
        ],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert not done.stderr
    return done.stdout


def test_a_type_checker_knows_every_public_name(checked):
    assert (PACKAGE / "py.typed").is_file()  # without it no checker looks into a package
    revealed = re.findall(r'user\.py:\d+: note: Revealed type is "(.*)"', checked)
    types = dict(zip(esc.__all__, revealed, strict=True))
    assert not [name for name, said in types.items() if said == "Any"]
    signature = types["simulate"]
    assert "escapement: escapement.model.escapement.Escapement" in signature
    assert "solver: escapement.engines.solver.Solver | None =" in signature
    assert signature.endswith("-> escapement.dynamics.motion.Motion")
    assert types["terminal"].endswith("-> escapement.dynamics.figures_of_merit.Figures")
    assert types["sweep"].endswith("-> escapement.study.result.Study")
    assert types["run_plan"].endswith("-> escapement.study.result.Study")


def test_a_type_checker_refuses_what_does_not_exist(checked):
    (error,) = [line for line in checked.splitlines() if ": error:" in line]
    assert 'Module has no attribute "nonsense"' in error
