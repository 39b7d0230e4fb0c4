"""Command lines on which every option of a command can be tried, and what each option is given.

A scene is the options of one command line by name. Every number needs a scene of its command and
kind in which it can change a result: one with its partner, as a bearing's radius has friction.
"""

import io
import math
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import ezdxf
import numpy as np

import escapement as esc
from escapement.base.quantity import declared
from escapement.cli import COMMANDS, main
from escapement.cli._arguments import parser_of
from escapement.engines.solver import Solver
from escapement.mechanisms import KINDS

_CLOCK = {
    **{"teeth": 30, "wheel_radius": 0.01, "tooth_depth": 0.002, "back": 35, "tip_radius": 2e-5},
    **{"span": 7.5, "lift": 2, "drop": 1},
}
WHEELS = {
    "geneva": {"slots": 6, "pins": 2, "crank_radius": 0.02, "pin_radius": 0.001},
    "gear-driven": {
        **{"stations": 6, "lobes": 0, "curve": "epicycloid", "pins": 1, "unused_lobes": 0},
        "fixed_radius": 0.05,
    },
    "elliptical-planetary": {"sun_radius": 0.016, "planet_radius": 0.009},
    "tabulated": {"table": "cells.csv", "measured": True, "cell_angle": 120, "follower_step": 60},
    "cam-indexer": {"stations": 8, "index_angle": 120, "law": "cycloidal"},
    "runaway": {
        **{"teeth": 12, "wheel_radius": 0.01, "tooth_depth": 0.0022, "lead": 45, "back": 15},
        **{"tip_radius": 1e-4, "span": 2.5, "pallet_radius": 0.0102, "pin_radius": 5e-4},
        "centre_distance": 0.0129,
    },
    "deadbeat": {**_CLOCK, "lead": -8, "lock": 0.5},
    "recoil": {**_CLOCK, "lead": -8, "lock": 0.5, "recoil_angle": 10},
    "outlines": {"drawing": "bodies.dxf", "driver_start": 3, "follower_start": 1},
}
TOUCHING = ("runaway", "deadbeat", "recoil", "outlines")
"""Kinds of two bodies that touch anywhere."""
WITHOUT_PARTS = ("tabulated", "cam-indexer")
"""Kinds of which only the transmission is known."""
FLAT = {
    **{"teeth": 20, "tooth_depth": 0.002, "lead": -5, "back": 30, "pallets": "flat", "span": 3.5},
    **{"pallet_angle": 45, "pallet_length": 0.002, "pallet_thickness": 8e-4},
}
"""A runaway with flat pallets, without its radii."""
EXACT = {"table": "cell.csv"}
"""Another table, of one whole cell without scatter."""
ROLLER = {"pin_radius": 0.0016, "roller_radius": 0.0018}
BODIES = {"driver_inertia": 1e-6, "follower_inertia": 5e-6}
DRIVE = {"torque": 0.0113, "load_torque": 2e-4, "initial_speed": 1.0, **BODIES}
LOSSES = {"driver_drag": 1e-8, "follower_drag": 1e-8, "driver_bearing_torque": 1e-5}
TRAINS = {
    **{"barrel_ratio": 2, "barrel_efficiency": 0.9, "barrel_inertia": 1e-5},
    **{"load_train_ratio": 2, "load_train_efficiency": 0.9, "load_train_inertia": 1e-7},
}
OIL = {"driver_viscous": 1e-6, "follower_viscous": 1e-6, "spring_rate": 1e-4}
_BEHIND = {"driver_viscous": 1e-6, "follower_viscous": 1e-6}
_FOLLOWER = {"follower_bearing_friction": 0.1, "follower_bearing_radius": 0.001}
_DRIVER = {"driver_bearing_friction": 0.1, "driver_bearing_radius": 0.001}
SWING = {"follower_spring": 1e-4, "follower_gravity": 1e-4, "follower_rest_angle": 0.1}
_CLOCKWORK = {
    **{"torque": 0.006, "load_torque": 1e-5, "initial_speed": 0.1, "driver_inertia": 1e-4},
    **{"follower_inertia": 1.0, "follower_gravity": 1.0, "follower_rest_angle": 0.1},
    **dict.fromkeys(("driver_drag", "follower_drag"), 1e-3),
}
TOUCHING_DRIVES = {
    "runaway": DRIVE, "deadbeat": _CLOCKWORK, "recoil": _CLOCKWORK,
    "outlines": {
        **DRIVE, "follower_start": 40, "follower_spring": 0.1, "follower_rest_angle": 40,
    },
}  # fmt: skip
"""Torques and inertias with which two bodies move."""
FRICTION = {
    **{kind: {"friction": 0.1, **_DRIVER, **_FOLLOWER} for kind in TOUCHING},
    "geneva": {"friction": 0.2, **_DRIVER, **_FOLLOWER},
    "gear-driven": {"friction": 0.1, **_FOLLOWER},
    "elliptical-planetary": {"efficiency": 0.9},
    **{kind: {"efficiency": 0.9} for kind in WITHOUT_PARTS},
}
"""What each kind may lose where driver and follower meet."""
PLAY = {"clearance": 1e-4, "restitution": 0.3}
WALLS = {"stiffness": 1e5, "damping": 1.0, "contact_law": "linear", "slip_speed": 0.01}
ERRORS = {
    "geneva": {
        **{"pin_angle_errors": "0,0.001", "crank_radius_errors": "0,1e-5"},
        **{"slot_angle_errors": "0,0,0,0,0,0.001", "slot_offsets": "0,0,0,0,0,1e-5"},
    },
    "gear-driven": {"slot_offsets": "0,0,1e-5"},
}
TOO_FAR = {"centre_distance_error": 1e-4, "tried": ["centre_distance_error"]}
"""Such a wheel is picked up late, which hides small errors of its slots."""
SIZES = {
    "geneva": [
        {"slots": 6, "crank_diameter": 0.04, "pin_diameter": 0.0032, "roller_diameter": 0.0036},
        {"slots": 6, "centre_distance": 0.04, "pin_diameter": 0.002},
        {"slots": 6, "wheel_radius": 0.035, "pin_diameter": 0.002},
        {"slots": 6, "wheel_diameter": 0.07, "pin_diameter": 0.002},
    ],
    "gear-driven": [
        {"stations": 6, "lobes": 0, "curve": "epicycloid", "pins": 1, "fixed_diameter": 0.1,
         "pin_diameter": 0.0032, "roller_diameter": 0.0036},
    ],
    "elliptical-planetary": [{"sun_diameter": 0.032, "planet_diameter": 0.018}],
    **{kind: [] for kind in (*WITHOUT_PARTS, "deadbeat", "recoil", "outlines")},
    "runaway": [
        {**FLAT, "wheel_diameter": 0.02, "tip_diameter": 2e-4, "pallet_diameter": 0.019,
         "corner_diameter": 2e-4},
    ],
}  # fmt: skip
"""The same sizes as drawings give them."""


def sized(kind, without=(), **others):
    """Scenes of a command with the sizes of drawings, which are the only options to try there."""
    for sizes in SIZES[kind]:
        given = {name: x for name, x in sizes.items() if name not in without}
        tried = [name for name in given if name.endswith(("_diameter", "_distance", "_radius"))]
        yield {**given, **others, "tried": tried}


IVP = {"engine": "ivp", "rtol": 1e-6, "atol": 1e-9, "method": "DOP853", "max_step": 0.01}
SOLVER = [name for name in declared(Solver) if name != "engine"]
BY_DEFAULT = ("engine", "method")
"""Words that are tried only where a scene says so, because a scene may have them by itself."""
SHAFTS = {"driver_shaft_radius": 0.002, "follower_shaft_radius": 0.002}
FITS = {"pin_fit": 1e-5, "shaft_fit": 1e-5, "kerf": 1e-4}
DISCS = {"thickness": 0.002, "density": 7800}


def motions(kind, length, **solver):
    """Scenes in which every number of a motion acts."""
    wheel, lost = WHEELS[kind], FRICTION[kind]
    if kind in TOUCHING:
        base = {**wheel, **lost, **length}
        trains = {name: x for name, x in TRAINS.items() if "efficiency" not in name}
        drive, loose = TOUCHING_DRIVES[kind], {**trains, "restitution": 0.2}
        if drive is _CLOCKWORK:  # a swing takes long; the numbers of any drive are tried elsewhere
            acting = {*WHEELS[kind], "follower_gravity"} - {"tooth_depth", "back"}
            return [{**base, **drive, "tried": sorted(acting)}]
        turned = {**OIL, **SWING, **drive}
        # steps of rigid bodies follow from their motion, whatever error is asked for
        every = {**options_of("run"), **options_of("rundown")}.keys() - {*BY_DEFAULT, "rtol"}
        every -= {"tooth_depth", "back"}  # nothing comes so deep between teeth
        scenes = [
            {**base, **LOSSES, **drive, **loose, "tried": sorted(every)},
            {**base, **turned, "tried": [*turned]},
        ]
        return [*scenes, *sized(kind, **drive, **lost, **length)]
    base = {**wheel, **DRIVE, **lost, **length}
    scenes = [{**base, **LOSSES, **TRAINS, **solver}, {**base, **OIL}]
    if kind in ERRORS:
        scenes += [{**base, **ERRORS[kind]}, {**base, **TOO_FAR}]
    if kind == "geneva":
        scenes += [{**base, **ROLLER}, {**base, **PLAY}]
        scenes += [{**base, "clearance": 1e-4, **WALLS, "tried": [*WALLS, "clearance"]}]
    if kind == "gear-driven":
        scenes += [{**base, **ROLLER}]
    if kind == "tabulated":
        scenes.append({**DRIVE, **lost, **length, **EXACT})
    if kind == "geneva":
        inside = {"slots": 6, "pins": 1, "internal": True, "crank_radius": 0.02}
        scenes.append({**base, **inside, "tried": ["internal"]})
    return [*scenes, *sized(kind, **DRIVE, **lost, **length)]


def _lasting(kind):
    """A scene that ends by its duration."""
    duration = {"outlines": 0.005, "deadbeat": 3.0, "recoil": 3.0}.get(kind, 0.1)
    drive = {**TOUCHING_DRIVES.get(kind, DRIVE), "duration": duration, "tried": ["duration"]}
    return {**WHEELS[kind], **drive, **FRICTION[kind]}


def _run(kind):
    lasting = _lasting(kind)
    ivp = [{**lasting, **IVP, "tried": SOLVER}] if kind == "geneva" else []
    return [*motions(kind, {"engagements": 2}, rtol=1e-8), lasting, *ivp]


def _rundown(kind):
    # compliant walls take seconds, and `run` has them
    rigid = [one for one in motions(kind, {"turns": 2}, rtol=1e-8) if "stiffness" not in one]
    return [*rigid, _lasting(kind)]


def _explore(kind):
    if kind != "geneva":  # the page computes only these
        return []
    length = {"spring_rate": 1e-4, "engagements": 2}
    return [{**WHEELS[kind], **DRIVE, **FRICTION[kind], **LOSSES, **length}]


def _wheels(kind):
    """The mechanism, also with a roller and with errors where it can have them."""
    wheel = WHEELS[kind]
    found = [wheel]
    if kind == "runaway":
        flat = {"wheel_radius": 0.01, "tip_radius": 1e-4, "pallet_radius": 0.0095}
        tried = ["pallet_angle", "pallet_length", "pallet_thickness", "corner_radius"]
        found += [{**FLAT, **flat, "corner_radius": 1e-4, "tried": tried}]
    if kind in ERRORS:
        found += [{**wheel, **ROLLER}, {**wheel, **ERRORS[kind]}, {**wheel, **TOO_FAR}]
    return [*found, EXACT] if kind == "tabulated" else found


def _mechanism(kind):
    shaft = {"follower_shaft_radius": 0.03} if kind == "geneva" else {}
    bodies = BODIES if kind in ERRORS else {}
    found = [{**one, **bodies, **shaft} for one in _wheels(kind)]
    if kind == "gear-driven":
        second = {"stations": 12, "lobes": 4, "curve": "epicycloid", "solution": 1}
        found.append({**second, "tried": ["solution"]})
    found += sized(kind, **bodies)
    if kind not in WITHOUT_PARTS:  # there are no bodies to turn
        found.append({**WHEELS[kind], "angle": 10, "plot": "out.svg", "tried": ["angle"]})
    return found


def _export(kind):
    if kind in WITHOUT_PARTS:
        return []
    thick = {"pin_radius": 0.001, "clearance": 1e-4} if kind in ERRORS else {}
    wheel = {name: x for name, x in WHEELS[kind].items() if name != "unused_lobes"}
    fits = {"shaft_fit": 1e-5, "kerf": 1e-4} if kind == "elliptical-planetary" else FITS
    scenes = [{**wheel, **thick, **SHAFTS, **fits, **DISCS}]
    if kind == "geneva":
        dwell = {"slots": 6, "pins": 1, "crank_radius": 0.02, "pin_radius": 0.001}
        given = {"locking_radius": 0.0165, "least_wall": 0.02}
        scenes.append({**dwell, "clearance": 1e-4, **given, "tried": [*given]})
        built = {"dowel_radius": 1e-3, "washer_radius": 2e-3, "screw_radius": 1e-3}
        built |= {"coupon_step": 1e-4, "bore": "D", "bore_flat": 5e-4}
        scenes.append({**dwell, "clearance": 1e-4, **built, "tried": [*built]})
    if kind in TOUCHING:
        shafts = SHAFTS if kind != "outlines" else {"driver_shaft_radius": 0.002}
        pins = {"pin_fit": 1e-5} if kind == "runaway" else {}
        scenes = [{**one, **shafts, "shaft_fit": 1e-5, **DISCS} for one in _wheels(kind)]
        return [{**scenes[0], **pins}, *scenes[1:]]
    if kind == "elliptical-planetary":
        # rolling the teeth takes seconds; sizes of wheels and shafts are tried elsewhere
        return [{**scenes[0], "tried": ["planet_radius", "teeth", "shaft_fit", "kerf", "density"]}]
    return [*scenes, *sized(kind, clearance=1e-4)]


def _old_name(kind):
    case = {"speed": 10, "load_torque": 0.01, "follower_inertia": 1e-4}
    return [{**_wheels(kind)[0], **case, "friction": 0.1}] if kind == "geneva" else []


def _index(kind):
    if kind in TOUCHING:
        return []
    case = {"speed": 10, "load_torque": 0.01, "follower_inertia": 1e-4, "efficiency": 0.9}
    case |= {n: x for n, x in LOSSES.items() if n != "driver_inertia"} | _BEHIND
    rings = {"load_frequency": 7, "load_damping": 0.1, "load_tolerance": 1e-3}
    if kind not in ERRORS:
        return [{**one, **case} for one in _wheels(kind)]
    stress = {"pin_length": 0.01, "pin_gap": 1e-3, "pressure_pin_radius": 1e-3}
    stress |= {"pressure_limit": 1e8, "running_time": 3600}
    stress |= {"pin_material": "brass", "wheel_material": "206e9,0.3"}
    found = [{**WHEELS[kind], **case, **stress, **FRICTION[kind]}]
    if kind == "geneva":
        wheel = {"slots": 6, "pins": 1, "crank_radius": 0.02, "clearance": 1e-4}
        lock = {"locking_radius": 0.01, "locking_friction": 0.1, "locking_angle": 0.3}
        tried = ["clearance", *rings, *lock]
        found.append({**wheel, **case, **rings, **lock, "tried": tried})
        inside = {"slots": 6, "pins": 1, "internal": True, "crank_radius": 0.02}
        found.append({**inside, **case, "tried": ["internal"]})
    pressed = FRICTION[kind] | {"pin_length": 0.01}
    return [*found, *sized(kind, **case, **pressed)]


def _measure(kind):
    if kind in TOUCHING:
        return []
    words = {"input_column": "input_deg", "output_column": "output_deg", "angle_unit": "deg"}
    read = {"data": "readings.csv", "bins": 8, "confidence": 0.95, **words}
    zeros = {"phase": 0.1, "offset": 0.1, "resolution": 4096, "linearity": 0.001}
    fitted = {**read, **zeros, "data": "motion.csv", "fit": "torque", "time_column": "time_s"}
    # without a motion sizes and errors are refused; with one only a few numbers are tried, as fits
    # take long, and the model is read as for `run`; a fitted number is only a first guess
    sizes = {"crank_radius", "fixed_radius", "pin_radius", *ROLLER, *ERRORS["geneva"]}
    wheels = [{n: x for n, x in one.items() if n not in sizes} for one in _wheels(kind)]
    still = [{**one, **read, **zeros} for one in wheels if one is wheels[0] or one == EXACT]
    moving = motions(kind, fitted)[0]
    del moving["initial_speed"]
    tried = ["fit", "follower_inertia", "time_column", "crank_radius"]
    tried = [name for name in tried if name in moving]
    rated = {"nominal_rate": 18000, "pattern": 3, "confidence": 0.8, "time_unit": "ms"}
    beats = {"data": "beats.csv", "beats": True, **rated}
    beats["tried"] = ["nominal_rate", "pattern", "confidence"]
    return [*still, {**moving, "tried": tried}, *[beats] * (kind == "geneva")]


OF_KINDS = {
    "run": _run, "rundown": _rundown, "explore": _explore, "mechanism": _mechanism,
    "export": _export, "index": _index, "drive-torque": _old_name, "measure": _measure,
}  # fmt: skip
OTHERS = {
    "sweep": [],
    "budget": [{"config": "sample.toml", "indices": 4}],
    "compare": [],
    "design": [{"wish": "wish.toml", "count": 3}],
    "plot": [
        {"file": "study.h5", "output": "out.svg", "select": "friction=0.1", "result": "period"}
    ],
    "reproduce": [],
    "bench": [],
    "compile": [],
}
"""Scenes of the commands without a mechanism; `tried` are the only options to change."""


def scenes_of(command, kind):
    """The scenes of a command, with a mechanism of a kind where it has one."""
    return OF_KINDS[command](kind) if command in OF_KINDS else OTHERS[command]


CHANGED = {
    **{"curve": "hypocycloid", "table": "other.csv", "engine": "energy", "method": "RK45"},
    **{"contact_law": "hunt-crossley", "atol": 1e-6, "rtol": 1e-11, "max_step": 1e-3},
    **{"duration": 0.2, "confidence": 0.9},
    **{"select": "friction=0.2", "result": "rise_time", "angle_unit": "rad", "bins": 9},
    **{"fit": "driver_inertia", "input_column": "again_deg", "output_column": "again_deg"},
    **{"indices": 8, "lobes": "1/2", "time_column": "later_s", "law": "modified-sine"},
    **{"span": 5.5, "drawing": "other.dxf", "tooth_depth": 0.0021, "wheel_radius": 0.0101},
    **{"wheel_diameter": 0.0201, "pallet_radius": 0.01021, "pallet_diameter": 0.0191},
    **{"pin_material": "steel", "wheel_material": "acetal", "bore": "square"},
}
"""What an option is given instead, where a number a little greater will not do."""
ADDED = {
    **{"table": "cell.csv", "curve": "epicycloid", "contact_law": "hunt-crossley", "speed": 10},
    **{"bore": "square", "lobes": 1, "solution": 2, "stations": 8, "slots": 6, "angle": 5},
    **{"fit": "friction", "bins": 8},
    **{"input_column": "input_deg", "output_column": "output_deg", "time_column": "time_s"},
    **{"angle_unit": "deg", "confidence": 0.9, "resolution": 4096, "efficiency": 0.8},
    **{"pin_angle_errors": "0,0.001", "crank_radius_errors": "0,1e-5", "friction": 0.25},
    **{"slot_angle_errors": "0,0,0,0,0,0.001", "slot_offsets": "0,0,0,0,0,1e-5"},
    **{"barrel_ratio": 3, "load_train_ratio": 3, "engine": "ivp", "method": "RK45"},
    **{"pallets": "flat", "drawing": "bodies.dxf"},
    **{"least_wall": 1.0, "teeth": 25, "load_curve": "load.csv"},
}
"""What an option is given that a scene does not have; another number is small."""
NOT_TRIED = {
    *("help", "json", "log", "units", "output", "force", "plot", "report", "resume", "quiet"),
    *("scheduler", "workers", "quick", "skip_rows", "serve", "study", "config", "wish", "file"),
    *("data", "source", "kind", "segments", "r12", "format", "jam_rule"),
}
"""Options that say how or where something is written or computed, and whole inputs."""


def options_of(command):
    """The options of a command that must act: argparse's own list, by name."""
    _, parser = parser_of(command)
    return {action.dest: action for action in parser._actions if action.dest not in NOT_TRIED}


def changed(action, scene):
    """The scene with another value of an option, or with it where it was not."""
    name, entry = action.dest, getattr(action.type, "entry", None)
    if action.nargs == 0:
        return {**scene, name: not scene.get(name, False)}
    if name not in scene:
        small = 1 if getattr(entry, "whole", False) else 1e-4
        return {**scene, name: ADDED.get(name, small)}
    if name in CHANGED:
        return {**scene, name: CHANGED[name]}
    value = scene[name]
    if isinstance(value, str):  # of a list of numbers the last
        *first, last = value.split(",")
        return {**scene, name: ",".join([*first, str(1.3 * float(last))])}
    return {**scene, name: value + 1 if isinstance(value, int) else 1.1 * value}


def argv_of(command, kind, scene):
    """The command line of a scene."""
    options, files = [], []
    for name, value in scene.items():
        if name in POSITIONAL:
            files += [value] if isinstance(value, str) else value
        elif value is True:
            options.append("--" + name.replace("_", "-"))
        elif value is not False and name != "tried":
            options += ["--" + name.replace("_", "-"), str(value)]
    return [command, *files, *([kind] if command in OF_KINDS else []), *options]


POSITIONAL = ("config", "wish", "file", "data", "source")
COMMAND_KINDS = [
    (name, kind) for name in COMMANDS for kind in (KINDS if name in OF_KINDS else ("geneva",))
]
"""Every command with every kind of mechanism, if it has one."""
STUDY = """
torque = 0.0113
friction = 0.2
results = ["period", "rise_time"]
inertia = { driver = 3e-6, follower = 5e-6 }
mechanism = { slots = 4, crank_radius = 0.02, pin_radius = 0.001 }
"""
FILES = {
    "study.toml": STUDY.replace("friction = 0.2\n", "")
    + "sweep = { friction = [0.1, 0.2], load_torque = [0.0, 1e-4, 2e-4] }\n",
    "sample.toml": STUDY + "[sample]\nmethod = 'random'\nsize = 100\n"
    "friction = { tolerance = 0.05 }\ntorque = { tolerance = 0.001 }\n"
    "[limits]\nperiod = [0.01, 0.2]\n",
    "timer.toml": STUDY.replace('results = ["period", "rise_time"]\n', ""),
    "load.csv": "angle_deg,torque\n0,0\n90,1e-4\n180,0\n270,-1e-4\n360,0\n",
    "wish.toml": "period = 0.05\ntorque = 0.01\nslots = 4\nfriction = [0.2, 0.3]\n"
    "bounds = { size = 0.1 }\n",
}


def write_inputs(command, kind):
    """Write the files that the scenes of a command and a kind name into this folder."""
    for name, text in FILES.items():
        Path(name).write_text(text)
    for name, rows, wave in (("cells", 60, 0.1), ("other", 60, 0.12), ("cell", 40, 0.1)):
        cells = 1.0 if name == "cell" else 2.0
        angles = np.linspace(0.0, cells * 2.0 * math.pi / 3.0, rows)
        turned = 0.5 * angles + wave * np.sin(3.0 * angles)
        text = "".join(f"{x!r},{y!r}\n" for x, y in np.degrees([angles, turned]).T.tolist())
        Path(f"{name}.csv").write_text(text)
    if kind == "outlines":
        for name, size in (("bodies", 1.0), ("other", 1.1)):
            write_bodies(f"{name}.dxf", size)
    if command == "plot":
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            main(["sweep", "study.toml", "--quiet"])
    if command != "measure" or kind not in MACHINES:  # two bodies have no readings to compare
        return
    ticks = np.cumsum(200.0 + np.random.default_rng(1).normal(size=60))
    Path("beats.csv").write_text("time\n" + "\n".join(map(repr, ticks.tolist())))
    machine = MACHINES[kind]()
    readings = esc.synthetic_readings(machine, seed=3, samples=120, turns=4, noise=1e-3)
    _write("readings.csv", np.arange(readings.input.size), readings.input, readings.output)
    timer = esc.Escapement(machine, esc.Inertia(1e-6, 5e-6), 0.01)
    motion = esc.simulate(timer, 3)
    times = np.linspace(0.0, motion.end_time, 120)
    state = motion.at(times)
    noise = 1e-3 * np.random.default_rng(5).standard_normal((2, times.size))
    _write("motion.csv", times + 0.5, state.theta + noise[0], state.phi + noise[1])


def write_bodies(path, size):
    """A drawing of a star that turns a round pin aside."""
    drawing = ezdxf.new(units=4)
    space, layers = drawing.modelspace(), ({"layer": "DRIVER"}, {"layer": "FOLLOWER"})
    radii = size * np.array([10.0, 7.0] * 6)
    axis = 13.0 * size
    star = radii * np.exp(1j * np.pi / 6.0 * np.arange(12))
    corners = [(z.real, z.imag) for z in star.tolist()]
    space.add_lwpolyline(corners, close=True, dxfattribs=layers[0])
    space.add_circle((axis, 9.0 * size), size, dxfattribs=layers[1])
    for centre, layer in zip(((0.0, 0.0), (axis, 0.0)), layers, strict=True):
        space.add_point(centre, dxfattribs=layer)
    drawing.saveas(path)


def _write(name, *columns):
    time, driver, follower = columns
    again = 0.9 * follower
    turned = np.column_stack([time, 1.1 * time, *np.degrees([driver, follower, again])])
    lines = [",".join(map(repr, row)) for row in turned.tolist()]
    Path(name).write_text("\n".join(["time_s,later_s,input_deg,output_deg,again_deg", *lines]))


MACHINES = {
    "geneva": lambda: esc.Geneva(6, pins=2),
    "gear-driven": lambda: esc.GearDriven(6, 0, curve="epicycloid"),
    "elliptical-planetary": lambda: esc.EllipticalPlanetary(0.016, 0.009),
    "tabulated": lambda: esc.Tabulated.from_csv("cell.csv"),
    "cam-indexer": lambda: esc.CamIndexer(8, math.radians(120.0), "cycloidal"),
}
