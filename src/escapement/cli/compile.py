"""compile all numerical code for this machine, so that later work begins at once"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from escapement.cli import _output
from escapement.cli._arguments import Arguments, Parser

if TYPE_CHECKING:
    from escapement import Escapement, Inertia

_TORQUE = 0.0113


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

    from escapement.base.notice import notice
    from escapement.numerics import jit
    from escapement.numerics.interpreted import compile_from_now_on

    compile_from_now_on()
    apart, other = None, 0
    if processes > 1 and jit.fcntl is not None:
        context = get_context("spawn")
        found = context.Value("i", 0)
        apart = context.Process(target=_solve_apart, args=(found,), daemon=True)
        apart.start()
    for timer in (free := [*_timers()]):
        _solve(timer, ("energy", "ivp"))
    _solve_others(free[0])
    if apart is not None:
        apart.join()
        other = found.value
    if apart is None or apart.exitcode != 0:
        _solve_apart()
    jit.note_all_compiled()
    return notice.done + other


def _solve_apart(found: Any = None) -> None:
    """Solve what shares little code with the rest, and tell how many functions that took.

    These are a case of each kind of contact, and drives at constant speed.
    """
    import escapement as esc
    from escapement.base.notice import notice
    from escapement.numerics.interpreted import compile_from_now_on

    compile_from_now_on()
    wheel = esc.Geneva(slots=4, crank_radius=0.01, pin_radius=0.001, clearance=1e-5)
    rigid = esc.Escapement(wheel, _inertia(), _TORQUE, friction=0.2)
    compliant = esc.Escapement(wheel, _inertia(), _TORQUE, friction=0.2, stiffness=1e6)
    for timer in (rigid, compliant):
        _solve(timer, ("contact",))
    _solve_drives()
    if found is not None:
        found.value = notice.done


def _inertia() -> "Inertia":
    import escapement as esc

    return esc.Inertia(3.39e-7, 5.65e-6)


def _timers() -> Iterator["Escapement"]:
    """A timer without contact of every kind that has numerical code of its own."""
    import escapement as esc

    inertia = _inertia()
    curve = esc.TorqueCurve([0.0, 1.0, 2.0], [_TORQUE, 0.9 * _TORQUE, _TORQUE], periodic=True)
    plain = esc.Geneva(slots=4)
    uneven = esc.Geneva(slots=4, crank_radius=0.01, slot_offsets=(1e-5, 0.0, 0.0, 0.0))
    rolling = esc.GearDriven(8, 1, "epicycloid")
    yield esc.Escapement(plain, inertia, _TORQUE, friction=0.35)
    yield esc.Escapement(plain, inertia, _TORQUE, follower_drag=1e-9)
    yield esc.Escapement(plain, inertia, _TORQUE, follower_viscous=1e-6)
    yield esc.Escapement(plain, inertia, curve, friction=0.2)
    yield esc.Escapement(uneven, inertia, _TORQUE, friction=0.2)
    yield esc.Escapement(rolling, inertia, _TORQUE, friction=0.1)


def _solve(timer: "Escapement", engines: tuple[str, ...]) -> None:
    """A motion, with all that can be asked of it, and the terminal cycle."""
    import escapement as esc

    for engine in engines:
        motion = esc.simulate(timer, engagements=2, engine=engine)
        _ = motion.extrema, motion.reversals, motion.samples, motion.balance()
        esc.terminal(timer, engine=engine)


def _solve_others(timer: "Escapement") -> None:
    """A run-down, a study, and limits."""
    from dataclasses import replace

    import escapement as esc

    esc.rundown(replace(timer, spring_rate=6e-4))
    esc.sweep(timer, friction=[0.2, 0.3])
    esc.critical_friction(timer.mechanism, timer.inertia)


def _solve_drives() -> None:
    """Drives at constant speed, and a study of them."""
    import escapement as esc

    for mechanism in (esc.Geneva(slots=4), esc.Geneva(slots=6, internal=True)):
        esc.drive_torque(mechanism, 10.0, 0.1, 1e-4, friction=0.1)
    wheel = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
    drive = esc.index(wheel, 6.0, follower_inertia=0.4, load_frequency=15.0)
    _ = drive.torque_max, drive.entry_impact_speed, drive.deflection_max, drive.at(0.0)
    esc.sweep(drive, speed=[6.0, 7.0])
