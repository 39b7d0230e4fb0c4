"""The digest that decides whether results may be mixed covers all code that computes them."""

import os
import subprocess
import sys
from pathlib import Path

import escapement
from escapement.study.solving import numerics, sources

PACKAGE = Path(escapement.__file__).parent
DECIDE_NOTHING = {"__init__.py"}
"""The names of the package: results do not depend on them."""

LOADED = """
import sys
from importlib import import_module
import escapement.engines.simulate
for name in ("energy.simulate", "energy.batch", "energy.terminal", "ivp.terminal"):
    import_module(f"escapement.engines.{name}")
print(*(m.__file__ for n, m in sys.modules.items() if n.startswith("escapement")), sep="\\n")
"""


def test_every_module_an_answer_comes_from_is_in_the_digest():
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True, env=os.environ
    )
    loaded = {Path(line) for line in done.stdout.split()}
    assert {PACKAGE / "engines/simulate.py", PACKAGE / "dynamics/motion.py"} <= loaded
    assert loaded - {*sources()} <= {PACKAGE / name for name in DECIDE_NOTHING}
    assert len(numerics()) == 12
