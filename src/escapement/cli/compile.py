"""compile all numerical code for this machine, so that later work begins at once"""

from collections.abc import Callable, Iterable
from math import radians
from typing import Any

import escapement as esc
from escapement.cli import _output
from escapement.cli._arguments import Arguments, Parser

_TORQUE, _INERTIAS = 0.0113, (3.39e-7, 5.65e-6)


def configure(parser: Parser) -> None:
    """Nothing can be chosen."""


def execute(args: Arguments) -> int:
    """Compile, and tell how many functions there were."""
    import time

    start = time.monotonic()
    done = compile_all(processes=2)
    spent = time.monotonic() - start
    lines = f"functions compiled  {done}\ntime                {spent:.0f} s"
    found = {"functions": done, "time": spent}
    _output.tell(args, found, table=lambda: print(lines))
    return 0


def compile_all(processes: int = 1) -> int:
    """Solve a small case of each kind, and note that all is compiled.

    Returns the number of functions that were compiled. Two processes share the work where
    kernels can be saved by one of them at a time.
    """
    from multiprocessing import get_context

    from escapement.numerics import jit

    apart, found = None, None
    if processes > 1 and jit.fcntl is not None:
        context = get_context("spawn")
        found = context.Value("i", 0)
        apart = context.Process(target=_compile, args=(_APART, found), daemon=True)
        apart.start()
    done = _compile(_FIRST)
    if apart is not None:
        apart.join()
    if apart is None or apart.exitcode != 0:
        done = _compile(_APART)
    jit.note_all_compiled()
    return done + (found.value if found else 0)


def _compile(solvers: Iterable[Callable[[], None]], found: Any = None) -> int:
    """Call functions that solve cases, and tell how many kernels this process has compiled."""
    from escapement.base.notice import notice
    from escapement.numerics.interpreted import compile_from_now_on

    compile_from_now_on()
    for solve in solvers:
        solve()
    if found is not None:
        found.value = notice.done
    return notice.done


def _solve(timer: "esc.Escapement", *engines: str) -> None:
    """A motion, with all that can be asked of it, and the terminal cycle."""
    for engine in engines:
        motion = esc.simulate(timer, engagements=2, engine=engine)
        _ = motion.extrema, motion.reversals, motion.samples, motion.balance()
        esc.terminal(timer, engine=engine)


def _solve_free() -> None:
    """A timer without contact of every kind that has numerical code of its own."""
    inertia, plain = esc.Inertia(*_INERTIAS), esc.Geneva(slots=4)
    curve = esc.TorqueCurve([0.0, 1.0, 2.0], [_TORQUE, 0.9 * _TORQUE, _TORQUE], periodic=True)
    uneven = esc.Geneva(slots=4, crank_radius=0.01, slot_offsets=(1e-5, 0.0, 0.0, 0.0))
    for timer in (
        esc.Escapement(plain, inertia, _TORQUE, friction=0.35),
        esc.Escapement(plain, inertia, _TORQUE, follower_viscous=1e-6),
        esc.Escapement(plain, inertia, curve, friction=0.2),
        esc.Escapement(uneven, inertia, _TORQUE, friction=0.2),
        esc.Escapement(esc.GearDriven(8, 1, "epicycloid"), inertia, _TORQUE, friction=0.1),
    ):
        _solve(timer, "energy", "ivp")


def _solve_others() -> None:
    """Run-downs, studies, and limits."""
    inertia, wheel = esc.Inertia(*_INERTIAS), esc.Geneva(slots=4, crank_radius=0.01)
    timer = esc.Escapement(wheel, inertia, _TORQUE, friction=0.2, spring_rate=6e-4)
    esc.rundown(timer)
    _solve(timer, "ivp")
    esc.sweep(timer, results=["period", "contact_force_max"], friction=[0.2, 0.3])
    uneven = {"slot_offsets": {"tolerance": 1e-5}}
    esc.budget(esc.Escapement(wheel, inertia, _TORQUE, friction=0.2), uneven, size=32)
    esc.critical_friction(wheel, inertia)
    esc.terminal(esc.Escapement(wheel, inertia, _TORQUE, friction=2.0))


def _compile_for_speed() -> None:
    """The long kernels for torques over the speed."""
    from escapement.engines.energy.calls import kernel_addresses

    kernel_addresses()


def _solve_contact() -> None:
    """A case of each kind of contact."""
    inertia = esc.Inertia(*_INERTIAS)
    wheel = esc.Geneva(slots=4, crank_radius=0.01, pin_radius=0.001, clearance=1e-5)
    rigid = esc.Escapement(wheel, inertia, _TORQUE, friction=0.2)
    for timer in (rigid, esc.Escapement(wheel, inertia, _TORQUE, friction=0.2, stiffness=1e6)):
        _solve(timer, "contact")


def _solve_two_bodies() -> None:
    """Pallets on an escape wheel, rigid ones and ones that yield."""
    wheel = esc.Runaway(
        teeth=12, wheel_radius=1.0, tooth_depth=0.22, lead=radians(45), back=radians(15),
        tip_radius=0.01, pallets="pins", span=2.5, pallet_radius=1.02, pin_radius=0.05,
    )  # fmt: skip
    inertia = esc.Inertia(1.0, 0.3)
    for stiffness in (0.0, 1e5):
        timer = esc.Escapement(wheel, inertia, 1.0, friction=0.15, stiffness=stiffness)
        _solve(timer, "two_bodies")


def _solve_drives() -> None:
    """Drives at constant speed, a study of them, and the printed program of 1973."""
    from escapement.sources.meyer.program import program_1973

    wheel = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
    drive = esc.index(wheel, 6.0, follower_inertia=0.4, load_frequency=15.0)
    _ = drive.torque_max, drive.entry_impact_speed, drive.deflection_max, drive.at(0.0)
    esc.sweep(drive, speed=[6.0, 7.0])
    esc.reversal_study(4, 1.0)
    program_1973(4, 0.35, 0.1, 3e-6, 5e-5, duration=0.001)


_FIRST = _solve_free, _solve_others
_APART = _compile_for_speed, _solve_contact, _solve_two_bodies, _solve_drives
"""What two processes solve, which takes both about as long."""
