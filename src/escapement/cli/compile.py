"""compile all numerical code for this machine, so that later work begins at once"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from escapement.cli import _output
from escapement.cli._arguments import Arguments, Parser

if TYPE_CHECKING:
    from escapement import Escapement


def configure(parser: Parser) -> None:
    """Nothing can be chosen."""


def execute(args: Arguments) -> int:
    """Compile, and tell how many functions there were."""
    from escapement.base.notice import notice

    compile_all()
    found = {"functions": notice.done, "time": notice.spent}
    lines = f"functions compiled  {notice.done}\ntime                {notice.spent:.0f} s"
    _output.tell(args, found, table=lambda: print(lines))
    return 0


def compile_all() -> None:
    """Solve a small case of each kind, and note that all is compiled."""
    from escapement.numerics import jit
    from escapement.numerics.interpreted import compile_from_now_on

    compile_from_now_on()
    timers = [*_timers()]
    for timer, engines in timers:
        _solve(timer, engines)
    _solve_others(timers[0][0])
    jit.note_all_compiled()


def _timers() -> Iterator[tuple["Escapement", tuple[str, ...]]]:
    """A timer of every kind that has numerical code of its own, and the engines that solve it."""
    import escapement as esc

    torque, inertia = 0.0113, esc.Inertia(3.39e-7, 5.65e-6)
    curve = esc.TorqueCurve([0.0, 1.0, 2.0], [torque, 0.9 * torque, torque], periodic=True)
    plain = esc.Geneva(slots=4)
    wheel = esc.Geneva(slots=4, crank_radius=0.01, pin_radius=0.001, clearance=1e-5)
    uneven = esc.Geneva(slots=4, crank_radius=0.01, slot_offsets=(1e-5, 0.0, 0.0, 0.0))
    rolling = esc.GearDriven(8, 1, "epicycloid")
    engines, contact = ("energy", "ivp"), ("contact",)
    yield esc.Escapement(plain, inertia, torque, friction=0.35), engines
    yield esc.Escapement(plain, inertia, torque, follower_drag=1e-9), engines
    yield esc.Escapement(plain, inertia, torque, follower_viscous=1e-6), engines
    yield esc.Escapement(plain, inertia, curve, friction=0.2), engines
    yield esc.Escapement(uneven, inertia, torque, friction=0.2), engines
    yield esc.Escapement(rolling, inertia, torque, friction=0.1), engines
    yield esc.Escapement(wheel, inertia, torque, friction=0.2), contact
    yield esc.Escapement(wheel, inertia, torque, friction=0.2, stiffness=1e6), contact


def _solve(timer: "Escapement", engines: tuple[str, ...]) -> None:
    """A motion, with all that can be asked of it, and the terminal cycle."""
    import escapement as esc

    for engine in engines:
        motion = esc.simulate(timer, engagements=2, engine=engine)
        _ = motion.extrema, motion.reversals, motion.samples, motion.balance()
        esc.terminal(timer, engine=engine)


def _solve_others(timer: "Escapement") -> None:
    """A run-down, a study, limits, and a drive at constant speed."""
    from dataclasses import replace

    import escapement as esc

    esc.rundown(replace(timer, spring_rate=6e-4))
    esc.sweep(timer, friction=[0.2, 0.3])
    esc.critical_friction(timer.mechanism, timer.inertia)
    for mechanism in (timer.mechanism, esc.Geneva(slots=6, internal=True)):
        esc.drive_torque(mechanism, 10.0, 0.1, 1e-4, friction=0.1)
    wheel = esc.Geneva(6, pins=1, crank_radius=0.05, clearance=1e-4)
    drive = esc.index(wheel, 6.0, follower_inertia=0.4, load_frequency=15.0)
    _ = drive.torque_max, drive.entry_impact_speed, drive.deflection_max, drive.at(0.0)
    esc.sweep(drive, speed=[6.0, 7.0])
