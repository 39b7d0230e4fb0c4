"""The names of `import escapement as esc`: what type checkers and editors know of them."""

import ast
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

import escapement as esc

HEAD = Path(esc.__file__)
LAZY = esc._HOMES


def test_every_public_name_is_there():
    assert set(esc.__all__) == {*LAZY, "__version__"} == set(dir(esc))
    for name in esc.__all__:
        assert getattr(esc, name) is not None
    for name, home in LAZY.items():
        value = getattr(esc, name)
        if not home:
            assert isinstance(value, ModuleType)
        else:
            assert value is getattr(import_module(f"escapement.{home}"), name)


def test_an_unknown_name_is_refused():
    with pytest.raises(AttributeError, match="module 'escapement' has no attribute 'nonsense'"):
        esc.nonsense  # noqa: B018


def typed_homes():
    """Module of each name as the imports for type checkers have it."""
    (guarded,) = [
        node.body
        for node in ast.parse(HEAD.read_text()).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    ]
    found = {}
    for line in guarded:
        home = line.module.removeprefix("escapement").removeprefix(".")
        # a name imported without "as" is private to a strict type checker
        assert all(alias.name == alias.asname for alias in line.names)
        found |= dict.fromkeys((alias.name for alias in line.names), home)
    return found


def test_the_imports_for_type_checkers_are_those_of_the_lazy_table():
    assert typed_homes() == LAZY


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """What mypy says of a user's file with every public name and one that does not exist."""
    folder = tmp_path_factory.mktemp("user")
    lines = ["import escapement as esc", *(f"reveal_type(esc.{name})" for name in esc.__all__)]
    (folder / "user.py").write_text("\n".join([*lines, "esc.nonsense", ""]))
    # mypy finds an installed package itself and refuses to be told where it is
    installed = HEAD.parents[1].name == "site-packages"
    place = {} if installed else {"MYPYPATH": str(HEAD.parents[1])}
    environment = {name: text for name, text in os.environ.items() if name != "MYPYPATH"} | place
    done = subprocess.run(
        [
            *(sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports"),
            *("--follow-imports=silent", "--config-file=", "--cache-dir=cache", "user.py"),
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
    revealed = re.findall(r'user\.py:\d+: note: Revealed type is "(.*)"', checked)
    types = dict(zip(esc.__all__, revealed, strict=True))
    assert not [name for name, said in types.items() if said == "Any"]
    signature = types["simulate"]
    assert "escapement: escapement.model.Escapement" in signature
    assert "solver: escapement.solver.Solver | None =" in signature
    assert signature.endswith("-> escapement.motion.Motion")
    assert types["terminal"].endswith("-> escapement.metrics.Figures")
    assert types["sweep"].endswith("-> escapement.study.result.Study")
    assert types["run_plan"].endswith("-> escapement.study.result.Study")


def test_a_type_checker_refuses_what_does_not_exist(checked):
    (error,) = [line for line in checked.splitlines() if ": error:" in line]
    assert 'Module has no attribute "nonsense"' in error
