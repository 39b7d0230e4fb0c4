"""Exudyn, a general multibody program: an engagement with walls that yield, and a runaway's period.

    pip install -e ".[bench]"
    python benchmarks/peers/with_exudyn.py

Contact and integrator are Exudyn's own: springs with a dashpot each, and friction proportional to
the speed at low speeds. Pins are spheres, and walls and flanks are triangles, of rotors about
parallel axes. The wheel has four slots, friction 0.3, pins of radius 0.05 r, a play of 5e-4 r on
either side, and walls with a stiffness of 1e6 torque/r^2 and more than critical damping. The
dashpot holds the pins of a runaway back that leave a tooth, so that its period differs from that of
rigid bodies by a share proportional to the relaxation time, damping over stiffness.
"""

import cmath
import math

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

import escapement as esc

RADIUS, TORQUE, SPEED = 0.01, 0.1, 86.0
CLOCK, UNIT = math.sqrt(50e-6 / TORQUE), TORQUE / RADIUS**2
WHEEL = esc.Escapement(
    esc.Geneva(4, crank_radius=RADIUS, pin_radius=0.05 * RADIUS, clearance=1e-3 * RADIUS),
    esc.Inertia(3e-6, 50e-6), TORQUE, 0.3, stiffness=1e6 * UNIT, damping=1e3 * UNIT * CLOCK,
    slip_speed=1e-4 * RADIUS / CLOCK,
)  # fmt: skip
RUNAWAY = esc.Escapement(
    esc.Runaway(
        12, 1.0, 0.22, math.radians(45.0), math.radians(15.0), 0.01,
        pallets="pins", span=2.5, pallet_radius=1.02, pin_radius=0.05,
    ),
    esc.Inertia(1.0, 0.3), 1.0, friction=0.15,
)  # fmt: skip
TEETH = range(-4, 3)
"""Those that reach a pin within two pitches."""


class Model:
    """Two rotors, of which the first is driven, with their axes at `places`.

    start : angles and speeds of both.
    law : friction, stiffness and damping of each contact, in Exudyn's words.
    """

    def __init__(self, own, places, start, torque, law):
        self.keeper, self.law, self.bodies, nodes = exu.SystemContainer(), law, [], []
        self.system = self.keeper.AddSystem()
        inertias = own.inertia.driver, own.inertia.follower
        for inertia, place, angle, speed in zip(inertias, places, *start, strict=True):
            state = {"initialCoordinates": [angle], "initialVelocities": [speed]}
            nodes.append(self.system.AddNode(items.Node1D(referenceCoordinates=[0.0], **state)))
            self.bodies.append(self.system.AddObject(items.ObjectRotationalMass1D(
                physicsInertia=inertia, nodeNumber=nodes[-1],
                referencePosition=[place, 0.0, 0.0], referenceRotation=np.eye(3),
            )))  # fmt: skip
        turned = items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=0)
        load = items.LoadCoordinate(markerNumber=self.system.AddMarker(turned), load=torque)
        self.system.AddLoad(load)
        kinds = exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t
        self.sensors = [
            self.system.AddSensor(items.SensorNode(
                nodeNumber=nodes[0], storeInternal=True, outputVariableType=kind
            ))
            for kind in kinds
        ]  # fmt: skip

    def marker(self, body, z):
        """A point of a rotor, from its axis."""
        place = [z.real, z.imag, 0.0]
        marker = items.MarkerBodyRigid(bodyNumber=self.bodies[body], localPosition=place)
        return self.system.AddMarker(marker)

    def touch(self, kind, pin, other, **numbers):
        """Add a contact of a pin."""
        numbers |= {"markerNumbers": [pin, other], **self.law}
        data = items.NodeGenericData(initialCoordinates=[1, 0, 0, 0], numberOfDataCoordinates=4)
        self.system.AddObject(kind(nodeNumber=self.system.AddNode(data), **numbers))

    def touch_wall(self, pin, other, radius, corners):
        """Add the contact of a pin with a triangle, whose corners turn to the left as it sees."""
        numbers = {"sphereRadius": radius, "trianglePoints": exu.Vector3DList(corners)}
        self.touch(items.ObjectContactSphereTriangle, pin, other, includeEdges=0, **numbers)

    def solved(self, length, steps):
        """Times, and angles and speeds of the driver."""
        self.system.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = length
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.discontinuous.ignoreMaxIterations = True
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = 5.0 * length / steps
        self.system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
        (time, angle), (_, speed) = (self.system.GetSensorStoredData(x).T for x in self.sensors)
        return time, angle, speed


def law_of(friction, slip, stiffness, damping):
    """The law of contact in Exudyn's words."""
    law = {"dynamicFriction": friction, "frictionProportionalZone": slip}
    return law | {"contactStiffness": stiffness, "contactDamping": damping}


def handoff(steps):
    """Handoff time and speed of the wheel."""
    own, wheel = WHEEL, WHEEL.mechanism
    entry, crank = float(own.scene.edges[0]), wheel.crank_radius
    phi = float(wheel.follower_angle(np.array([entry]))[0])
    law = law_of(own.friction, own.slip_speed, own.stiffness, own.damping)
    places = wheel.centre_distance * crank, 0.0
    model = Model(own, places, ((-entry, phi), (-SPEED, 0.0)), -own.torque, law)
    pin, slot = model.marker(0, complex(-crank)), model.marker(1, 0j)
    far, wall = 4.0 * crank, wheel.pin_radius + 0.5 * wheel.clearance
    for side in (1.0, -1.0):
        y = side * wall
        corners = [[-far, y, -far], [3.0 * far, y, -far], [far, y, 2.0 * far]]
        model.touch_wall(pin, slot, wheel.pin_radius, corners[:: int(side)])
    length = 1.01 * float(esc.simulate(own, 1, initial_speed=SPEED).end_time)
    time, angle, speed = model.solved(length, steps)
    found = np.interp(float(own.scene.edges[-1]), -angle, time)
    return found, -np.interp(found, time, speed)


def flanks(wheel, turn):
    """The flat flanks of a tooth from the tip to the root, with their normals out of the tooth."""
    tip, root = wheel.tip_radius, wheel.wheel_radius - wheel.tooth_depth
    for angle, sense in ((wheel.lead, 1.0), (wheel.back, -1.0)):
        normal = 1j * sense * cmath.rect(1.0, -sense * angle)
        start, ahead = wheel.wheel_radius - tip + tip * normal, 1j * sense * normal
        along = (start.conjugate() * ahead).real
        length = -along - math.sqrt(along**2 - abs(start) ** 2 + root**2)
        yield start * turn, (start + length * ahead) * turn, normal * turn


def period(stiffness, damping, step=4e-6):
    """The time of the second pitch of the runaway from a state of its rigid cycle."""
    own, wheel = RUNAWAY, RUNAWAY.mechanism
    motion = esc.simulate(own, 12)
    state = motion.at(float(motion.handoff_times[-1]))
    start = (0.0, float(state.phi)), (float(state.theta_dot), float(state.phi_dot))
    law = law_of(own.friction, 1e-3, stiffness, damping)
    model = Model(own, (0.0, wheel.axes_distance), start, own.torque, law)
    half, centre = wheel.span * math.pi / wheel.teeth, model.marker(0, 0j)
    pins = [cmath.rect(wheel.pallet_radius, sense * half) for sense in (-1.0, 1.0)]
    for pin in [model.marker(1, place - wheel.axes_distance) for place in pins]:
        for k in TEETH:
            turn = cmath.rect(1.0, k * wheel.pitch)
            tip = model.marker(0, (wheel.wheel_radius - wheel.tip_radius) * turn)
            radii = [wheel.pin_radius, wheel.tip_radius]
            model.touch(items.ObjectContactSphereSphere, pin, tip, spheresRadii=radii)
            for a, b, n in flanks(wheel, turn):
                ends = [[a.real, a.imag, 1.0], [a.real, a.imag, -1.0], [b.real, b.imag, 0.0]]
                faced = 1 if ((b - a) * n.conjugate()).imag < 0.0 else -1
                model.touch_wall(pin, centre, wheel.pin_radius, ends[::faced])
    length = 2.1 * float(esc.terminal(own).period)
    time, angle, _speed = model.solved(length, round(length / step))
    return float(np.diff(np.interp(wheel.pitch * np.array([1.0, 2.0]), angle, time))[0])


def main():
    """Print how much both results of Exudyn differ from ours."""
    motion = esc.simulate(WHEEL, 1, initial_speed=SPEED, rtol=1e-12)
    ours = motion.handoff_times[0], motion.handoff_velocities[0]
    for steps in (20_000, 200_000):
        apart = (a / b - 1.0 for a, b in zip(handoff(steps), ours, strict=True))
        print("handoff", steps, *(f"{x:+.1e}" for x in apart), flush=True)
    rigid = float(esc.terminal(RUNAWAY).period)
    for stiffness, relaxation in ((1e7, 3e-3), (1e8, 1e-3), (1e8, 3e-4)):
        found = period(stiffness, stiffness * relaxation)
        print("period", f"{stiffness:.0e} {relaxation:.0e} {found / rigid - 1.0:+.1e}", flush=True)


if __name__ == "__main__":
    main()
