"""Kernels that run as Python source until compiling pays: same results, and a change over."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import escapement as esc
from escapement.study import running
from escapement.study.parse.design import plan_from

RUN = [
    *("-m", "escapement", "run", "--units", "in-lbf-s", "--torque", ".1", "--friction", ".35"),
    *("--driver-inertia", "3e-6", "--follower-inertia", "50e-6", "--json"),
]
SCENES = """
import escapement as esc
inertia, torque = esc.Inertia(3.39e-7, 5.65e-6), 0.0113
wheel = esc.Geneva(4, crank_radius=0.01, pin_radius=0.001, clearance=1e-5)
uneven = esc.Geneva(4, crank_radius=0.01, slot_offsets=(1e-5, 0.0, 0.0, 0.0))
curve = esc.TorqueCurve([0.0, 0.7, 1.6], [torque, 0.009, torque], periodic=True)
scenes = [
    esc.Escapement(esc.Geneva(4), inertia, torque, friction=0.35),
    esc.Escapement(esc.Geneva(6), inertia, curve, friction=0.2, follower_drag=1e-9),
    esc.Escapement(esc.Geneva(4), inertia, torque, friction=0.2, driver_viscous=1e-6),
    esc.Escapement(uneven, inertia, torque, friction=0.2),
    esc.Escapement(wheel, inertia, torque, friction=0.2, restitution=0.3),
]
def results():
    for scene in scenes:
        motion, cycle = esc.simulate(scene, 2), esc.terminal(scene)
        yield [*motion.handoff_times, *motion.handoff_velocities, cycle.period, cycle.rise_time]
"""


def ask(arguments, folder, **environment):
    """Output and messages of a new process that finds nothing compiled."""
    known = {name: x for name, x in os.environ.items() if not name.startswith("ESCAPEMENT")}
    done = subprocess.run(
        [sys.executable, "-W", "error", *arguments],
        capture_output=True, text=True, timeout=120, check=True,
        env=known | {"NUMBA_CACHE_DIR": str(folder)} | environment,
    )  # fmt: skip
    return done.stdout, done.stderr


def test_a_first_answer_needs_no_compiling(tmp_path):
    printed, said = ask(RUN, tmp_path)
    found = json.loads(printed)
    assert found["status"] == "ok"
    assert found["period"] == pytest.approx(0.0439239, rel=1e-5)
    assert "not compiled" in said
    assert "escapement compile" in said
    assert said.count("\n") == 1
    assert not list(tmp_path.rglob("*.nb?"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "call",
    [
        *("terminal(timer)", "simulate(timer, 2).reversals", "simulate(timer, 1, engine='ivp')"),
        *("terminal(uneven)", "simulate(loose, 2)", "critical_friction(wheel, timer.inertia)"),
        *("index(wheel, 6.0, follower_inertia=0.4).torque_max", "rundown(wound, turns=1)"),
    ],
)
def test_any_call_may_be_the_first(tmp_path, call):
    """What is imported first must not matter."""
    code = (
        "import escapement as esc\nfrom dataclasses import replace\n"
        "wheel = esc.Geneva(4, pins=1, crank_radius=0.01)\n"
        "timer = esc.Escapement(wheel, esc.Inertia(3.39e-7, 5.65e-6), 0.0113, friction=0.2)\n"
        "uneven = replace(timer, mechanism=replace(wheel, slot_offsets=(1e-5, 0.0, 0.0, 0.0)))\n"
        "loose = replace(timer, mechanism=replace(wheel, clearance=1e-5))\n"
        f"wound = replace(timer, spring_rate=1e-4)\n_ = esc.{call}"
    )
    said = ask(["-c", code], tmp_path)[1]
    assert "not compiled" in said
    assert not list(tmp_path.rglob("*.nb?"))


def test_interpreted_and_compiled_results_agree(tmp_path):
    """And nothing is said where silence is asked for."""
    code = SCENES + "import json\nprint(json.dumps(list(results())))"
    printed, said = ask(["-c", code], tmp_path, ESCAPEMENT_QUIET="1")
    interpreted = json.loads(printed)
    assert said == ""
    assert not list(tmp_path.rglob("*.nb?"))
    names = {}
    exec(SCENES, names)
    for found, wanted in zip(interpreted, names["results"](), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-12)


@pytest.mark.parametrize(("frictions", "compiles"), [(64, False), (65, True)])
def test_a_study_of_many_scenes_is_compiled(monkeypatch, frictions, compiles):
    """From rest without a load the torque only changes the unit of time."""
    asked = []
    monkeypatch.setattr(running, "compile_from_now_on", lambda: asked.append(True))
    monkeypatch.setattr(running, "interprets", lambda: True)
    timer = esc.Escapement(esc.Geneva(4), esc.Inertia(3.39e-7, 5.65e-6), 0.0113)
    axes = {"friction": np.linspace(0.1, 0.3, frictions), "torque": [0.01, 0.011]}
    running.run_plan(plan_from(timer, axes))
    assert bool(asked) == compiles


CHANGE = """
import numpy as np
from escapement.numerics import interpreted
from escapement.numerics.jit import inner_jit, jit

interpreted.PATIENCE = %d

@inner_jit
def one_more(x):
    return x + 1.0

@jit
def count_up(memory, zero):
    for _ in range(20):
        memory[0] = one_more(memory[0])
    return 25.0 / zero

for zero in (2.0, 0.0):
    memory = np.array([5.0])
    print(count_up(memory, zero), memory[0], interpreted.interprets())
"""


@pytest.mark.parametrize(
    ("patience", "told"),
    [
        # NumPy's numbers give infinity, and Python's are refused
        (100, ["12.5 25.0 True", "inf 25.0 False"]),
        (10, ["12.5 25.0 False", "inf 25.0 False"]),  # its patience ends within the call
    ],
)
def test_a_call_is_repeated_from_its_start_when_it_is_compiled(tmp_path, patience, told):
    file = tmp_path / "toy.py"
    file.write_text(CHANGE % patience)
    assert ask([str(file)], tmp_path / "cache")[0].splitlines() == told


def test_what_is_inlined_is_inlined_after_the_change_over(tmp_path):
    """Code that is compiled alone where it was to be inlined would release memory of its caller."""
    toy = tmp_path / "toy.py"
    toy.write_text(
        "from escapement.numerics import interpreted\n"
        "from escapement.numerics.jit import inner_jit, jit\n"
        "interpreted.PATIENCE = 0\n"
        "@inner_jit(inlined=True)\ndef one_more(x):\n    return x + 1.0\n"
        "@jit\ndef two_more(x):\n    return one_more(one_more(x))\n"
        "print(two_more(1.0), interpreted.interprets())\n"
    )
    assert ask([str(toy)], tmp_path / "cache")[0].strip() == "3.0 False"
    (only,) = (tmp_path / "cache").rglob("*.nbi")
    assert "two_more" in only.name


def test_compiling_can_be_asked_for_before_there_are_kernels(tmp_path):
    """As the second process of `escapement compile` does."""
    code = (
        "from escapement.numerics.interpreted import compile_from_now_on, interprets\n"
        "compile_from_now_on()\nimport escapement.numerics.jit\nprint(interprets())"
    )
    assert ask(["-c", code], tmp_path)[0] == "False\n"


OTHERS = """
from dataclasses import replace
plain, pins = scenes[0], {"pallets": "pins", "span": 2.5, "pallet_radius": 1.02, "pin_radius": 0.05}
teeth = {"teeth": 12, "wheel_radius": 1.0, "tooth_depth": 0.22, "lead": 0.785, "back": 0.262}
runaway = esc.Runaway(**teeth, **pins, tip_radius=0.01)
scenes += [
    replace(plain, torque=esc.TorqueCurve(speed=[0.0, 200.0], torque=[torque, 0.0])),
    replace(scenes[-1], stiffness=1e6, restitution=0.0),
    esc.Escapement(runaway, esc.Inertia(1.0, 0.3), 1.0, friction=0.15),
]
for scene in scenes:
    motion = esc.simulate(scene, 2)
    motion.reversals, motion.samples, motion.balance(), esc.terminal(scene)
esc.sweep(plain, results=["period", "contact_moment_max"], friction=[0.1, 0.2])
"""


def test_the_command_compiles_what_the_others_need():
    """The suite's cache is filled by it, so that a command in a new process compiles nothing."""
    code = "from escapement.base.notice import notice\nfrom escapement.cli import main\n"
    code += f"main({RUN[2:]!r})\n{SCENES}{OTHERS}print(notice.done, end='')"
    assert esc  # the package of this process is that of the new one
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.endswith("}\n0")
