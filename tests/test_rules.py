"""Rules between numbers: whatever breaks one is refused in a line that names it.

What a single number may be follows from its declaration; `test_bad_input` tries those.
"""

import math

import numpy as np
import pytest

import escapement as esc
from bad_calls import TIMER, built, study, wheel
from escapement import explorer, plots
from escapement.base.errors import InvalidValue
from escapement.mechanisms.elliptical_teeth import fewest_teeth, tooth_module
from escapement.outlines.parts import parts_of
from escapement.synthesis import GearPair, find_mechanisms
from tabulated_drive import exact

LINE = np.linspace(0.0, 1.0, 20)
SIZED = {"crank_radius": 0.01}
LOOSE = esc.Geneva(6, 1, crank_radius=0.02, pin_radius=1e-3, clearance=1e-5)
LATE = esc.Geneva(4, pin_angle_errors=(1e-3, 0, 0, 0))
OVALS = esc.EllipticalPlanetary(0.016, 0.009)
GEARS = esc.GearDriven(12, 3)
ROUND = esc.GearDriven(6, "1/2", fixed_radius=0.01)
CAM = esc.TorqueCurve([0.0, 0.5, 2.0], [0.8, 1.0, 0.8], periodic=True)
WOUND = built(spring_rate=1e-5)
CUT = esc.Geneva(6, 1, crank_radius=0.02, pin_radius=0.0015, clearance=3e-5)
DRIVEN = esc.GearDriven(12, 3, fixed_radius=0.03, pin_radius=0.0005)
WIDE = wheel(**SIZED, pin_radius=1e-4)


def walls(**numbers):
    return built(mechanism=wheel(**SIZED, clearance=1e-5), **{"stiffness": 1e8} | numbers)


def stiff(**numbers):
    return esc.simulate(walls(**numbers), 1)


def curve(*angles, torque=(1.0, 0.9), periodic=False):
    return esc.TorqueCurve(angles, torque, periodic)


def gears(*given):
    return esc.GearDriven(*given, "epicycloid")


def meshed(**numbers):
    return built(mechanism=OVALS, friction=0.0, **numbers)


def driven(mechanism=None, **numbers):
    given = {"speed": 10.0, "load_torque": 1.0, "follower_inertia": 0.019} | numbers
    return esc.index(esc.Geneva(8) if mechanism is None else mechanism, **given)


def parts(mechanism, **fits):
    return parts_of(mechanism, esc.Fits(**fits))


def film(**choice):
    return plots.animate(esc.simulate(TIMER, 1), **choice)


def found(**wishes):
    return find_mechanisms(6, **wishes)


OF_WHEELS = [
    (lambda: esc.Geneva(5, 4), "pins must be at most 3 for 5 slots, got 4"),
    (lambda: esc.Geneva(5, 2, internal=True), "at most 1 for an internal wheel"),
    (lambda: esc.Geneva(4, pin_radius=1e-3), "pin_radius must be left out for .* without a length"),
    (lambda: wheel(**SIZED, pin_radius=0.004), "where neighbouring slots meet"),
    (lambda: wheel(**SIZED, roller_radius=0.001), "greater than pin_radius"),
    (lambda: esc.Geneva(4, clearance=1e-5), "clearance must be left out for a mechanism without"),
    (lambda: esc.Geneva(4, slot_angle_errors=(0, 1e-3)), "as long as there are slots, 4"),
    (lambda: esc.Geneva(4, slot_offsets=(0, 0, 0, 1e-5)), "slot_offsets .*without a length"),
    (lambda: esc.Geneva(4, pin_angle_errors=1e-3), "a list of numbers"),
    (lambda: esc.Geneva(4, centre_distance_error=1e-5), "error .*without a length"),
    (lambda: esc.GearDriven(7, 1, **{"fixed_radius": 0.05, "slot_offsets": (1e-5,)}), "slots, 7"),
    (lambda: esc.GearDriven(7, 1, centre_distance_error=1e-5), "without a length"),
    (lambda: gears(4, "1/0"), "lobes must be a rational"),
    (lambda: esc.GearDriven(6, 2), "lobes must be below stations/2 - 1 = 2 for a hypocycloid.*'2'"),
    (lambda: esc.GearDriven(5, 1), "no mechanism corresponds to stations 5, lobes 1.*alpha <= pi"),
    (lambda: esc.GearDriven(4, 1, "epicycloid", 9), "pins must be at most 8, .*0.119282"),
    (lambda: esc.GearDriven(6, "1/2", "epicycloid", 1, 1), "unused_lobes .*where lobe 1 passes"),
    (lambda: esc.GearDriven(12, 4, "hypocycloid", 1, 2), "unused_lobes must be 0 .*jump"),
    (lambda: esc.GearDriven(4, 1, "epicycloid", 1, 0, 2), "solution must be at most 1 here, got 2"),
    (lambda: esc.EllipticalPlanetary(9e-3, 16e-3), "sun_radius .*greater than the planet"),
    (lambda: esc.EllipticalPlanetary(1e6, 1.0), "sun_radius / planet_radius .*10000"),
    (lambda: esc.EllipticalPlanetary.from_ellipse(1.0, 1.0), "eccentricity .*below 1"),
    (lambda: esc.EllipticalPlanetary.from_ellipse(1.0, 0.0), "eccentricity .*circle"),
    (lambda: esc.EllipticalPlanetary.from_ellipse(-1.0, 0.5), "semi_major_axis .*-1.0"),
    (lambda: esc.EllipticalPlanetary.from_stop_interval(7.0, 1.0), "below 6.28319.*2 pi"),
    (lambda: esc.EllipticalPlanetary.from_teeth(18, 32, 1e-3), "sun_radius .*greater"),
    (lambda: OVALS.dwell_below(-1.0), "ratio must be at least 0, got -1.0"),
    (lambda: OVALS.dwell_within(0.0), "angle must be greater than 0, got 0.0"),
    (lambda: OVALS.planet_inertia(1.0, 1e-9, 1e-3), r"moment .*offset\^2.*shaft"),
    (lambda: tooth_module(OVALS, 2), "teeth .*at least 3, got 2"),
    (lambda: fewest_teeth(OVALS, 1.0), "pressure_angle .*below 0.785398"),
    (lambda: fewest_teeth(OVALS, addendum=0.0), "addendum must be greater than 0"),
    (lambda: esc.Tabulated([0, 1, 2], [0, 1, 2]), "theta .*at least 12 rows.*3"),
    (lambda: esc.Tabulated(LINE, LINE[:-1]), "phi .*as long as theta, 20.*19"),
    (lambda: esc.Tabulated(LINE, np.where(LINE > 0.9, np.nan, LINE)), "phi .*finite"),
    (lambda: esc.Tabulated(LINE[::-1], LINE), "must ascend.*got 0.9.*sort the table"),
    (lambda: esc.Tabulated(LINE, 0.0 * LINE), "follower_step .*greater than 0.*turned on"),
    (lambda: esc.Tabulated(LINE, LINE, cell_angle=1.0), "must come with.*both"),
    (lambda: esc.Tabulated(np.arange(7e2), np.arange(7e2)), "at most 601 rows.*700"),
    (lambda: esc.Tabulated(LINE % 0.5, LINE, cell_angle=0.5, follower_step=1.0).spline,
     "theta must differ.*measured"),
    (lambda: esc.Tabulated(LINE, 0.8 * LINE, follower_step=1.0),
     "follower_step .*the cell, 0.8 rad or 45.83662 degrees, got 1.0.*step out"),
    (lambda: esc.Tabulated(LINE, 0.4 * LINE, measured=True, follower_step=1.0),
     "follower_step .*0.4 rad.*got 1.0"),
]  # fmt: skip
OF_MODELS = [
    (lambda: built(efficiency=0.9), "efficiency must be 1 for a slotted mechanism"),
    (lambda: meshed(efficiency=2), "efficiency must be at least 0.001 and at most 1, got"),
    (lambda: built(mechanism=OVALS), "friction must be 0 for a mechanism without a slot"),
    (lambda: built(mechanism=ROUND, driver_bearing_radius=1e-3), "0 for a gear-driven wheel"),
    (lambda: meshed(follower_bearing_radius=1e-3), "0 for a mechanism without a slot"),
    (lambda: stiff(stiffness=100.0), "stiffness must be at least 113000"),
    (lambda: stiff(restitution=0.3), "restitution must be 0 with linear walls"),
    (lambda: stiff(contact_law="hunt-crossley", damping=0.0), "restitution must be greater than 0"),
    (lambda: built(mechanism=wheel(**SIZED, clearance=1e-3, pin_angle_errors=(1e-4, 0, 0, 0))),
     "clearance must be 0 with errors of the parts"),
    (lambda: built(spring_rate=1e-3, driver_viscous=1e-9, barrel=esc.Train(5.0, 0.8)),
     "^barrel_efficiency must be 1 with viscous drag and a"),
    (lambda: built(mechanism=wheel(**SIZED, slot_offsets=(1e-6, 0, 0, 0)),
                   barrel=esc.Train(5.0, 0.8)), "^barrel_efficiency must be 1 with errors of the"),
    (lambda: built(barrel=5), "^barrel must be a Train, got 5; give for"),
    (lambda: built(pin_material="steal"), "did you mean 'steel'"),
    (lambda: built(pin_length=2e-3), "pin_length must be 0 for a mechanism without a length"),
    (lambda: built(mechanism=wheel(**SIZED), pin_length=2e-3), "given with the radius of the pin"),
    (lambda: esc.sweep(TIMER, barrel_inertia=[1e-6]), "^barrel_ratio must be given with barrel_in"),
    (lambda: curve(0.0), "2 to 1000 angles"),
    (lambda: curve(0.0, 1.0, torque=[1.0]), "2 angles and 1 torques"),
    (lambda: curve(1.0, 2.0), "ascending from 0"),
    (lambda: curve(0.0, 1.0, 1.0, torque=[1.0] * 3), "ascending from 0"),
    (lambda: curve(0.0, 1.0, torque=[1.0, -1.0]), "at least 0"),
    (lambda: curve(0.0, 1.0, torque=[0.0, 0.0]), "not all 0"),
    (lambda: curve(0.0, 1.0, periodic=True), "the same at both ends"),
    (lambda: curve(0.0, math.nan), "finite"),
    (lambda: curve(0.0, 1.0, periodic="yes"), "true or false"),
    (lambda: built(torque=CAM, spring_rate=1.0), "spring_rate must be 0 with a torque curve"),
    (lambda: built(torque=curve(*np.linspace(0.0, 1.0, 900), torque=np.ones(900))),
     "at most 256 points in a cell, got 900"),
]  # fmt: skip
OF_RUNS = [
    (lambda: esc.simulate(TIMER, 3, duration=1.0), "must not both be given, got 3 and 1.0"),
    (lambda: esc.simulate(TIMER, method="RK45"), "left out with engine 'energy'"),
    (lambda: esc.simulate(TIMER, 10_001, engine="ivp"), "whole number of at most 10000"),
    (lambda: esc.simulate(TIMER, duration=1e9), "in which 10000000 engagements pass"),
    (lambda: esc.simulate(walls(), engine="ivp"), "engine must be 'contact' with clearance"),
    (lambda: esc.sweep(walls(), friction=[0.2], engine="energy"), "'contact' with clearance"),
    (lambda: esc.terminal(TIMER, engine="contact"), "leave it out, or give one of the two"),
    (lambda: esc.simulate(TIMER, 1).at(-1.0), "t must be between 0 and the end of the"),
    (lambda: esc.simulate(TIMER, 1).at("now"), "t must be a time in s or an array"),
    (lambda: esc.rundown(WOUND, turns=0.0), "turns must be greater than 0"),
    (lambda: esc.rundown(WOUND, turns=1.0, duration=1.0), "duration must be left out with turns"),
    (lambda: esc.rundown(WOUND, turns=1e9), "turns must be at most 2.5e"),
    (lambda: esc.rundown(TIMER), "turns must be given"),
    (lambda: esc.rundown(WOUND, turns=1.0).time_of(1.5), "turns must be at most 1"),
    (lambda: esc.rundown(esc.Geneva(4), turns=1.0), "escapement must be an Escapement"),
    (lambda: esc.sweep(TIMER, friction=[0.1, -0.1]), r"friction\[1\] must be at least 0"),
    (lambda: esc.sweep(TIMER, friction=[0.1], workers=0), "number of at least 1, got 0"),
    (lambda: esc.sweep(TIMER), "sweep at least one parameter"),
    (lambda: esc.sweep(built(torque=CAM), torque=[1.0]), r"a curve or in \[sweep\], got both"),
    (lambda: esc.sweep(TIMER, slot_angle_errors_factor=[1, 2]), "that are not all 0"),
    (lambda: esc.sweep(TIMER, pin_angle_errors=[0.0]), "its factor is 'pin_angle_errors_f"),
    (lambda: study(frictions=1.0), "unknown key 'frictions'.*did you mean 'friction'"),
    (lambda: study(solver=4), "solver must be a table, got 4"),
    (lambda: study(units="imperial"), "units must be one of SI, in-lbf-s"),
    (lambda: esc.synthetic_readings(LATE, seed=1), "without errors of its parts"),
]  # fmt: skip
AT_CONSTANT_SPEED = [
    (lambda: driven(LATE), "without errors of its parts"),
    (lambda: driven(efficiency=1.01), "efficiency must be greater than 0 and at most 1"),
    (lambda: driven(6), "mechanism must be a mechanism, got 6; give for"),
    (lambda: driven(follower_inertia=-0.019), "follower_inertia must be greater than 0"),
    (lambda: driven(load_torque=-1.0), "load_torque must be at least 0"),
    (lambda: driven().at(-1.3), "theta must be between pin entry and the end of the cell"),
    (lambda: driven().at(math.nan), "theta must be finite, got nan"),
    (lambda: esc.reversal_study(4, -0.5), "inertia_ratio must be at least 0, got -0.5"),
    (lambda: esc.reversal_study(4, [1.0, math.inf]), "inertia_ratio must be finite"),
    (lambda: esc.reversal_study([3, 2], 1.0), "slots must be whole .* at least 3, got 2"),
    (lambda: esc.fewest_slots(-1.0), r"inertia_ratio must be at least 0, got -1\.0"),
]  # fmt: skip
OF_SHAPES = [
    (lambda: found(motion_ratio=1.3), "motion_ratio must be at most 1"),
    (lambda: found(motion_ratio=-0.3), "motion_ratio must be at least 0"),
    (lambda: found(motion_ratio=0.3, curves="circle"), "curves must be one of .*got 'circle'"),
    (lambda: found(motion_ratio=0.3, finest=10**4), "most_lobes and finest must"),
    (lambda: found(motion_ratio=0.3, most_unused=10**6), "most_unused must be .* at most 100000"),
    (lambda: found(motion_ratio=0.3, largest_radius=0.0), "largest_radius must be greater than 0"),
    (lambda: GearPair(GEARS, 60, 21, 1e-3), r"teeth must be in the ratio \|k\| = 3 .*60/21"),
    (lambda: GearPair(GEARS, 48, 16, 1e-3), "planet_teeth must be .* at least 17, got 16"),
    (lambda: GearPair(esc.GearDriven(12, 0, "pericycloid"), 84, 91, 1e-3),
     "must differ by at least 10 .*use the epicycloid"),
    (lambda: GearPair(GEARS, 60, 20, 0.0), "module must be greater than 0"),
    (lambda: parts(OVALS, teeth=18), "teeth must be at least 19"),
    (lambda: parts(OVALS, clearance=0.003), "leave tips"),
    (lambda: parts(wheel(**SIZED, pin_radius=0.001), teeth=20), "teeth must be 0"),
    (lambda: parts(esc.Geneva(4)), "crank_radius must be given for drawings"),
    (lambda: parts(esc.Geneva(4, **SIZED)), "pin_radius must be given for drawings"),
    (lambda: parts(CUT, follower_shaft_radius=0.019), "hole of the follower .* less than 0.018"),
    (lambda: parts(CUT, driver_shaft_radius=0.012), "hole of the locking-disc must have"),
    (lambda: parts(CUT, pin_fit=-0.003), "pin_fit must be greater than -0.003"),
    (lambda: parts(CUT, kerf=-1e-4), "kerf must be at least 0"),
    (lambda: parts(DRIVEN, clearance=0.02), "clearance must be less than 0.00"),
    (lambda: parts(exact(24)), "tabulated has no parts"),
    (lambda: parts(esc.GearDriven(11, "1/2", unused_lobes=2)), "unused_lobes must be 0"),
    (lambda: plots.plot_mechanism(wheel(slots=201)), "slots must be at most 200 in a drawing"),
    (lambda: plots.plot_mechanism("geneva"), "mechanism must be a mechanism, got 'geneva'"),
    (lambda: plots.plot_mechanism(wheel(), np.nan), "theta must be a finite number, got nan"),
    (lambda: plots.plot_mechanism(wheel(), "x"), "theta must be a finite number, got 'x'"),
    (lambda: plots.plot_mechanism(LATE, exaggerate=-1.0), "at least 0"),
    (lambda: plots.plot_mechanism(LATE, exaggerate=1e3), "pins to meet slots"),
    (lambda: film(start=-1.0), "film must be a part of the motion's"),
    (lambda: film(start=1e-3, stop=1e-3), "film must be a part of the motion's"),
    (lambda: film(frames=1), "frames must be a whole number of at least 2"),
    (lambda: film(frames=5000), "frames must be a whole number of at most 2000"),
    (lambda: film(rate=0.0), "rate must be"),
    (lambda: plots.animate(esc.simulate(built(mechanism=exact(40), friction=0.0), 1)),
     "plot_velocities"),
    (lambda: plots.plot_mechanism(esc.GearDriven(203, 0)), "at most 200 in a drawing, got 203"),
    (lambda: plots.plot_mechanism(gears(4, 1001)), "lobes of the whole path must be at most 200"),
]  # fmt: skip
OF_THE_PAGE = [
    (lambda made=made: explorer.page(made), f"^{said}.*must be.*explorer")
    for said, made in (
        ("mechanism", built(mechanism=esc.GearDriven(4, 1, "epicycloid"))),
        ("driver_viscous", built(driver_viscous=1e-9)),
        ("roller_radius", built(mechanism=wheel(**SIZED, pin_radius=1e-3, roller_radius=2e-3))),
        ("pin_angle_errors", built(mechanism=LATE)),
        ("torque", built(torque=CAM)),
        ("slots", built(mechanism=esc.Geneva(41))),
        ("friction", built(friction=2e3)),
    )
]
RULES = [*OF_WHEELS, *OF_MODELS, *OF_RUNS, *AT_CONSTANT_SPEED, *OF_SHAPES, *OF_THE_PAGE]


@pytest.mark.parametrize(("call", "said"), RULES, ids=[said for _, said in RULES])
def test_what_breaks_a_rule_is_refused_in_a_line_that_names_it(call, said):
    with pytest.raises(InvalidValue, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)
