"""An indexing drive at constant speed: `escapement.index`.

The two worked examples were computed elsewhere, by quadrature and by SciPy's DOP853; everything
else is judged by another engine, a closed form or an integrator of SciPy.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import minimize_scalar

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.model.materials import MATERIALS

TABLE = {"slots": 6, "pins": 1, "crank_radius": 0.05}
PIN = {"pressure_pin_radius": 0.008, "pin_length": 0.012}
LOAD = {"load_frequency": 15.0, "load_damping": 0.02, "load_tolerance": 1e-4}


def table_drive(wheel=None, **more):
    """The first worked example: six slots at 60 rpm."""
    mechanism = esc.Geneva(**TABLE | {"clearance": 1e-4} | (wheel or {}))
    numbers = {"follower_inertia": 0.4, "friction": 0.08} | PIN | LOAD | more
    return esc.index(mechanism, 2.0 * math.pi, 2.0, **numbers)


def fast_drive(**more):
    """The second one: four slots at 120 rpm, nothing but inertia."""
    wheel = esc.Geneva(4, pins=1, crank_radius=0.03, clearance=1e-4)
    return esc.index(wheel, 4.0 * math.pi, follower_inertia=0.02, load_frequency=20.0, **more)


FIRST = {
    "index_time": 0.333333, "dwell_time": 0.666667, "contact_moment_max": 23.3126176,
    "contact_force_max": 413.546987, "pressure_max": 393.957882e6, "torque_max": 18.0618299,
    "torque_mean_index": 1.67757672, "torque_mean_cycle": 0.559192241, "torque_rms": 5.48188039,
    "power_max": 113.485824, "power_mean": 3.51350848, "entry_impact_speed": 0.0140461191,
    "entry_impact_energy": 0.00554366526, "reversal_flight_time": 20.19032e-3,
    "reversal_impact_speed": 0.0147626, "reversal_impact_energy": 0.0167011,
    "deflection_max": 0.00831267, "residual_amplitude": 0.00395486, "settling_time_load": 1.95099,
}  # fmt: skip
FIRST_ANGLES = {
    "contact_moment_max_angle": -22.9031, "contact_force_max_angle": -19.7396,
    "torque_max_angle": -16.1839, "entry_impact_angle": -57.4374413, "lift_off_angle": 1.23081,
    "reversal_impact_angle": 8.499326,
}  # fmt: skip
SECOND = {
    "contact_force_max": 1212.65914, "torque_rms": 8.05104566, "entry_impact_speed": 0.0217565555,
    "entry_impact_energy": 0.00592336011, "reversal_flight_time": 7.99423e-3,
    "reversal_impact_speed": 0.0373079, "reversal_impact_energy": 0.0831338,
    "residual_amplitude": 0.0929397250, "torque_mean_cycle": 0.0,
}  # fmt: skip


def digits(value, printed):
    """Whether a value rounds to a printed one in all its digits."""
    text = np.format_float_positional(printed, trim="-").replace(".", "").strip("-").lstrip("0")
    size = len(text)
    return float(f"{value:.{max(size - 1, 0)}e}") == pytest.approx(printed, rel=10.0**-size)


def test_worked_examples():
    drive = table_drive()
    assert all(digits(getattr(drive, name), value) for name, value in FIRST.items())
    for name, degrees in FIRST_ANGLES.items():
        assert digits(math.degrees(getattr(drive, name)), degrees), name
    assert np.degrees(drive.reversals) == pytest.approx([1.21168735], abs=5e-9)
    other = fast_drive()
    assert all(digits(getattr(other, name), value) for name, value in SECOND.items())
    assert math.degrees(other.reversal_impact_angle) == pytest.approx(5.795399, abs=5e-7)
    assert other.settling_time_load == math.inf  # without damping it rings on


@pytest.mark.parametrize("slots", range(3, 17))
def test_two_reversals_that_nearly_meet_are_found(slots):
    # a little less load than the follower needs: its moment dips below zero between two samples
    numbers = {"speed": 6.28, "follower_inertia": 0.4}
    wheel = esc.Geneva(slots, pins=1)
    least = esc.index(wheel, **numbers).least_load_torque
    for share in (1e-3, 1e-5, 1e-7, 1e-9):
        assert len(esc.index(wheel, load_torque=(1.0 - share) * least, **numbers).reversals) == 2
    assert len(esc.index(wheel, load_torque=(1.0 + 1e-9) * least, **numbers).reversals) == 0


@pytest.mark.parametrize(
    "wheel", [{"pin_radius": 0.008}, {"pin_radius": 0.004, "roller_radius": 0.008}], ids=str
)
def test_thick_pins_and_bearings_as_with_a_heavy_driver(wheel):
    more = {
        "follower_bearing_friction": 0.1, "follower_bearing_radius": 0.006,
        "driver_bearing_friction": 0.05, "driver_bearing_radius": 0.01,
        "driver_bearing_torque": 0.1, "follower_drag": 0.05, "driver_viscous": 0.02,
    }  # fmt: skip
    drive = table_drive(wheel | {"clearance": 0.0}, **more)
    heavy = esc.Escapement(
        drive.mechanism, esc.Inertia(4e7, 0.4), torque=1.0, friction=0.08, load_torque=2.0, **more
    )
    motion = esc.simulate(heavy, 1, initial_speed=drive.speed)
    span = motion.at(np.linspace(0.0, drive.index_time, 20_001)).contact_force
    assert np.max(np.abs(span)) == pytest.approx(drive.contact_force_max, rel=1e-6)
    # what the drive gives in a cycle goes into losses and into the load
    ledger = motion.ledger
    spent = ledger.work - ledger.kinetic
    assert 2.0 * math.pi * drive.torque_mean_cycle == pytest.approx(spent, rel=1e-6)


def test_laws_of_a_small_clearance():
    def at(clearance):
        return table_drive({"clearance": clearance})

    small, smaller = at(2e-9), at(2e-10)
    entry = -math.pi / 3.0
    turned = [drive.entry_impact_angle - entry for drive in (small, smaller)]
    assert math.log10(turned[0] / turned[1]) == pytest.approx(1.0 / 2.0, abs=0.01)
    flights = [drive.reversal_flight_time for drive in (small, smaller)]
    assert math.log10(flights[0] / flights[1]) == pytest.approx(1.0 / 3.0, abs=0.01)


def test_the_load_rings_as_an_integrator_says():
    drive = table_drive()
    frequency, damping, speed = 2.0 * math.pi * 15.0, 0.02, drive.speed
    path, entry = drive.mechanism, drive.mechanism.breaks[0]

    def law(time, state):
        theta = entry + speed * time
        bend = path.transmission(theta).dg * speed**2 if time < drive.index_time else 0.0
        return state[1], -2.0 * damping * frequency * state[1] - frequency**2 * state[0] - bend

    times = np.linspace(0.0, drive.index_time, 200)
    found = solve_ivp(
        law, times[[0, -1]], (0.0, 0.0), t_eval=times, rtol=1e-12, atol=1e-14, max_step=1e-3,
        method="DOP853",
    )  # fmt: skip
    deflection = drive.at(entry + speed * times).deflection
    assert deflection == pytest.approx(found.y[0], abs=1e-9 * drive.deflection_max)
    x, rate = found.y[:, -1]
    swing = frequency * math.sqrt(1.0 - damping**2)
    left = math.hypot(x, (rate + damping * frequency * x) / swing)
    assert drive.residual_amplitude == pytest.approx(left, rel=1e-9)
    assert np.abs(deflection).max() <= drive.deflection_max
    assert np.abs(deflection).max() == pytest.approx(drive.deflection_max, rel=1e-3)


def test_stresses_by_hand():
    drive = table_drive(pin_gap=0.002, pressure_limit=300e6, wheel_material="bronze")
    steel, bronze = MATERIALS["steel"], MATERIALS["bronze"]
    yielding = (1 - steel.poisson**2) / steel.modulus + (1 - bronze.poisson**2) / bronze.modulus
    force = drive.contact_force_max
    assert drive.pressure_max == pytest.approx(
        math.sqrt(force / yielding / (math.pi * 0.012 * 0.008)), rel=1e-12
    )
    thick = table_drive(
        wheel_material="bronze", pressure_pin_radius=0.5 * drive.pin_diameter_needed
    )
    assert thick.pressure_max == pytest.approx(300e6, rel=1e-12)
    diameter = 2.0 * 0.008
    assert drive.pin_bending_max == pytest.approx(
        32 * force * 0.008 / (math.pi * diameter**3), rel=1e-12
    )
    assert drive.pin_shear_max == pytest.approx(4 * force / (math.pi * diameter**2), rel=1e-12)


@pytest.mark.parametrize("pin", [0.0, 0.006])
def test_pressure_times_speed_and_load_cycles_by_hand(pin):
    """The speed of the pin's surface less that of the slot's, along the slot."""
    drive = table_drive({"pin_radius": pin, "clearance": 0.0}, running_time=8000 * 3600.0)
    crank, speed = 0.05, drive.speed
    apart = crank / math.sin(math.pi / 6)

    def rubbed(theta):
        state = drive.at(theta)
        centre = apart - crank * np.exp(-1j * theta)
        along = centre / abs(centre)
        touched = centre + 1j * along * pin * np.sign(state.contact_moment)
        of_pin = 1j * speed * (apart - touched)  # the driver turns against the follower
        sliding = (of_pin - 1j * state.phi_dot * touched) * along.conj()
        return abs(sliding.real) * state.contact_force

    grid = np.linspace(*np.array(drive.mechanism.breaks)[[0, -1]], 20_001)
    top = grid[np.argmax(rubbed(grid))]
    ends = (top - 1e-3, top + 1e-3)
    options = {"xatol": 1e-9}
    found = minimize_scalar(
        lambda x: -rubbed(np.array(x)), bounds=ends, method="bounded", options=options
    )
    assert drive.rubbing_max == pytest.approx(-found.fun, rel=1e-12)
    assert drive.pressure_speed_max == pytest.approx(-found.fun / (2 * 0.008 * 0.012), rel=1e-12)
    assert drive.pin_load_frequency == pytest.approx(1.0, rel=1e-12)  # 60 rpm
    assert drive.pin_loads == pytest.approx(8000 * 3600.0, rel=1e-12)
    rolling = table_drive({"pin_radius": 0.004, "roller_radius": 0.006, "clearance": 0.0})
    assert math.isnan(rolling.pressure_speed_max)


def test_the_locking_disc_takes_torque_in_the_dwell():
    locked = {"locking_radius": 0.03, "locking_friction": 0.1, "locking_angle": math.radians(20)}
    drive = table_drive(**locked)
    lever = 0.05 / math.sin(math.pi / 6) * math.sin(math.radians(20))
    assert drive.locking_torque == pytest.approx(0.1 * 2.0 / lever * 0.03, rel=1e-12)
    more = drive.torque_mean_cycle - table_drive().torque_mean_cycle
    assert more == pytest.approx(drive.locking_torque * 2.0 / 3.0, rel=1e-12)


def test_what_cannot_be_given_is_nan():
    bare = esc.index(esc.Geneva(6, pins=1), 1.0, follower_inertia=1.0)
    for name in ("contact_force_max", "pressure_max", "entry_impact_speed", "deflection_max"):
        assert math.isnan(getattr(bare, name))
    assert bare.torque_max > 0.0
    drive = table_drive(pressure_pin_radius=0.0, pressure_limit=300e6)
    assert math.isnan(drive.pressure_max)
    assert drive.pin_diameter_needed > 0.0


@pytest.mark.parametrize(
    ("wheel", "more", "words"),
    [
        ({}, LOAD | {"load_damping": 1.0}, "load_damping must be at least 0 and below 1"),
        ({}, {"pin_material": "stel"}, "pin_material must be"),
        ({}, {"pin_material": (-1.0, 0.3)}, "pin_material must be a name, or a modulus"),
        ({}, {"friction": -0.1}, "friction must be at least 0"),
        ({}, {"load_torque": lambda phi: phi}, "load_torque must be a finite number"),
        ({"pins": 3}, {"load_frequency": 5.0}, "load_frequency must be 0 where the follower never"),
        ({"pins": 3, "clearance": 1e-4}, {}, "clearance must be 0 where the follower never rests"),
        ({"slot_offsets": (1e-5,) * 6}, {}, "slot_offsets"),
        ({}, {"pin_gap": 1e-3}, "pin_gap must come with pin_length, got none"),
        ({}, {"pressure_limit": 1e8}, "pressure_limit must come with pin_length"),
        ({}, {"load_damping": 0.1}, "load_damping must come with load_frequency"),
        ({}, {"locking_radius": 0.1}, "locking_radius must come with locking_angle"),
        ({}, {"pin_length": 0.01}, "pin_length must be given with the radius of the pin"),
        ({"crank_radius": None}, PIN, "pin_length must be 0 for a mechanism without a length"),
    ],
)
def test_refusals(wheel, more, words):
    load = more.pop("load_torque", 2.0)
    mechanism = esc.Geneva(**TABLE | wheel)
    with pytest.raises(InvalidValue, match=words):
        esc.index(mechanism, 1.0, load, follower_inertia=0.4, **more)


TYPED = {
    **{"slots": 6, "pins": 1, "crank-radius": 0.05, "clearance": 1e-4, "load-torque": 2},
    **{"follower-inertia": 0.4, "friction": 0.08, "pressure-pin-radius": 0.008},
    **{"pin-length": 0.012, "load-frequency": 15, "load-damping": 0.02, "load-tolerance": 1e-4},
    "speed": "60 rpm",
}
THIN = ("slots", "pins", "crank-radius", "load-torque", "follower-inertia", "friction", "speed")


def words(names):
    return [word for name in names for word in (f"--{name}", TYPED[name])]


def test_the_command_prints_the_drive_in_the_units_asked_for(report, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    record = report("index", *words(TYPED), "-o", "a.csv", "--plot", "a.png")
    for name, value in FIRST.items():
        assert digits(record[name], value), name
    assert record["reversals_deg"] == pytest.approx([1.21168735], abs=5e-9)
    assert digits(record["torque_max_deg"], FIRST_ANGLES["torque_max_angle"])
    rows = np.genfromtxt("a.csv", delimiter=",", names=True)
    assert rows["torque_N_m"].max() == pytest.approx(record["torque_max"], rel=1e-4)
    assert (tmp_path / "a.png").exists()
    for name, value in report("drive-torque", *words(THIN)).items():
        if name not in ("inputs", "message"):
            assert record[name] == pytest.approx(value, rel=1e-8), name


def test_the_command_speaks_millimetres(command, report):
    typed = {
        **{"slots": 6, "pins": 1, "crank-radius": 50, "clearance": 0.1, "load-torque": 2000},
        **{"follower-inertia": 400_000, "friction": 0.08, "pressure-pin-radius": 8},
        **{"pin-length": 12, "load-frequency": 15, "load-damping": 0.02, "speed": 60},
        "load-tolerance": math.degrees(1e-4),
    }
    words = [word for name, value in typed.items() for word in (f"--{name}", value)]
    record = report("index", *words, "--units", "mm")
    sizes = {
        **{"torque_rms": 1e3, "pressure_max": 1e-6, "entry_impact_speed": 1e3, "power_max": 1.0},
        **{"contact_force_max": 1.0, "entry_impact_energy": 1e3, "settling_time_load": 1.0},
        "residual_amplitude": math.degrees(1.0),
    }
    for name, size in sizes.items():
        assert record[name] == pytest.approx(size * FIRST[name], rel=1e-5), name
    assert record["follower_velocity_max"] == pytest.approx(60.0, rel=1e-12)  # rpm
    out = command("index", *words, "--units", "mm")[1]
    (line,) = [line for line in out.splitlines() if line.startswith("pressure pin radius")]
    assert line.endswith("mm = 0.314961 in, diameter 16 mm")


def test_blows_as_with_a_heavy_driver_and_rigid_contact():
    for drive, inertia in ((table_drive(friction=0.0), 0.4), (fast_drive(), 0.02)):
        heavy = esc.Escapement(
            drive.mechanism, esc.Inertia(1e7 * inertia, inertia), torque=1e-3,
            load_torque=drive.load_torque,
        )  # fmt: skip
        impacts = esc.simulate(heavy, 1, initial_speed=drive.speed).impacts
        first, second = impacts.theta[:2]
        assert drive.entry_impact_angle == pytest.approx(first, rel=1e-5)
        assert drive.reversal_impact_angle == pytest.approx(second, rel=1e-5)
        lost = impacts.energy[:2]
        assert drive.entry_impact_energy == pytest.approx(lost[0], rel=1e-5)
        assert drive.reversal_impact_energy == pytest.approx(lost[1], rel=1e-5)


def test_without_damping_the_amplitude_is_a_fourier_integral():
    drive = fast_drive()
    ratio = 2.0 * math.pi * 20.0 / drive.speed
    wheel = drive.mechanism
    ends = wheel.breaks[0], wheel.breaks[-1]

    def part(function):
        return quad(
            lambda x: wheel.transmission(x).dg * function(ratio * x), *ends,
            epsabs=1e-13, epsrel=1e-13, limit=200,
        )[0]  # fmt: skip

    left = math.hypot(part(math.cos), part(math.sin)) / ratio
    assert drive.residual_amplitude == pytest.approx(left, rel=1e-10)


def test_the_command_speaks_inches(report):
    length = 0.0254
    torque = 4.4482216152605 * length
    size = {"length": length, "torque": torque, "inertia": torque}
    kinds = {
        **dict.fromkeys(("crank-radius", "clearance", "pressure-pin-radius"), "length"),
        **{"pin-length": "length", "load-torque": "torque", "follower-inertia": "inertia"},
    }
    typed = [
        word
        for name in TYPED
        for word in (f"--{name}", TYPED[name] / size[kinds[name]] if name in kinds else TYPED[name])
    ]
    record = report("index", *typed, "--units", "in-lbf-s")
    pressure = 4.4482216152605 / length**2
    assert record["pressure_max"] * pressure == pytest.approx(FIRST["pressure_max"], rel=1e-8)
    assert record["torque_rms"] * torque == pytest.approx(FIRST["torque_rms"], rel=1e-8)
