"""Start-up and the cache of compiled kernels."""

import os
import subprocess
import sys
import textwrap

import escapement

PACKAGE = os.path.dirname(escapement.__file__)

CALLER = (
    "from toy._jit import jit\nfrom toy.callee import gain\n\n@jit\ndef f(x):\n    return gain(x)\n"
)
CALLEE = "from toy._jit import jit\n\n@jit\ndef gain(x):\n    return {factor} * x\n"


def run(code, **environment):
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        capture_output=True,
        text=True,
        env=os.environ | environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def toy_package(folder, factor):
    """A package of two kernels in two files, with this package's decorator."""
    toy = folder / "toy"
    toy.mkdir(exist_ok=True)
    with open(os.path.join(PACKAGE, "_jit.py"), encoding="utf-8") as source:
        (toy / "_jit.py").write_text(source.read(), encoding="utf-8")
    (toy / "__init__.py").write_text("")
    (toy / "caller.py").write_text(CALLER)
    (toy / "callee.py").write_text(CALLEE.format(factor=factor))


def test_an_edited_callee_in_another_file_is_not_served_stale(tmp_path):
    cache = tmp_path / "cache"
    call = "from toy.caller import f; print(f(1.0))"
    here = {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(cache)}
    toy_package(tmp_path, 2.0)
    assert run(call, **here) == "2.0"
    first = len(list(cache.rglob("*.nbc")))
    assert first > 0
    assert run(call, **here) == "2.0"
    assert len(list(cache.rglob("*.nbc"))) == first  # the second run compiled nothing
    toy_package(tmp_path, 3.0)
    assert run(call, **here) == "3.0"


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    toy_package(tmp_path, 2.0)
    in_the_way = tmp_path / "file"
    in_the_way.write_text("")
    call = "from toy.caller import f; print(f(1.0))"
    assert run(call, PYTHONPATH=str(tmp_path), NUMBA_CACHE_DIR=str(in_the_way)) == "2.0"
    assert in_the_way.read_text() == ""


def test_kernels_run_without_compilation(tmp_path):
    toy_package(tmp_path, 2.0)
    call = "from toy.caller import f; print(f(1.0))"
    assert run(call, PYTHONPATH=str(tmp_path), NUMBA_DISABLE_JIT="1") == "2.0"


def test_importing_the_package_loads_and_compiles_nothing():
    heavy = "numba scipy matplotlib h5py numpy"
    code = f"""
        import sys
        import escapement
        assert escapement.__version__
        print([name for name in {heavy.split()!r} if name in sys.modules])
    """
    assert run(code) == "[]"


def test_the_fast_engine_does_without_scipy():
    code = """
        import sys
        import escapement as esc
        inertia = esc.Inertia(3.39e-7, 5.65e-6)
        timer = esc.Escapement(esc.Geneva(4), inertia, torque=0.0113, friction=0.35)
        motion = esc.simulate(timer)
        motion.at(0.1)
        esc.terminal(timer)
        # Numba looks at the version in the top package; what takes time is below it
        print(len(motion.handoff_times), "scipy.integrate" in sys.modules)
    """
    assert run(code) == "20 False"
