"""Exudyn: the period of a runaway escapement with pins as spheres on triangles, the teeth's faces.

    pip install -e ".[bench]"
    python benchmarks/peers/runaway_with_exudyn.py

Contact and integrator are Exudyn's own: springs with a dashpot each, and friction proportional to
the speed at low speeds. The dashpot holds pins back that leave a tooth, so that the period differs
from that of rigid bodies by a share proportional to the relaxation time, damping over stiffness.
"""

import cmath
import math

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

import escapement as esc

WHEEL = esc.Runaway(
    12, 1.0, 0.22, math.radians(45.0), math.radians(15.0), 0.01,
    pallets="pins", span=2.5, pallet_radius=1.02, pin_radius=0.05,
)  # fmt: skip
OWN = esc.Escapement(WHEEL, esc.Inertia(1.0, 0.3), 1.0, friction=0.15)
TEETH = range(-4, 3)
"""Those that reach a pin within two pitches."""
STEP, SLIP = 4e-6, 1e-3


def faces(turn):
    """The flat faces of a tooth from the tip to the root, with their normals out of the tooth."""
    tip, root = WHEEL.tip_radius, WHEEL.wheel_radius - WHEEL.tooth_depth
    for angle, sense in ((WHEEL.lead, 1.0), (WHEEL.back, -1.0)):
        normal = 1j * sense * cmath.rect(1.0, -sense * angle)
        start, ahead = WHEEL.wheel_radius - tip + tip * normal, 1j * sense * normal
        along = (start.conjugate() * ahead).real
        length = -along - math.sqrt(along**2 - abs(start) ** 2 + root**2)
        yield start * turn, (start + length * ahead) * turn, normal * turn


def model(start, stiffness, damping):
    """The system, its container, which must not be deleted, and the sensor of the wheel's angle."""
    keeper = exu.SystemContainer()
    system = keeper.AddSystem()
    law = {"dynamicFriction": OWN.friction, "frictionProportionalZone": SLIP}
    law |= {"contactStiffness": stiffness, "contactDamping": damping}
    bodies, nodes = [], []
    inertias = OWN.inertia.driver, OWN.inertia.follower
    for body, place in enumerate((0.0, WHEEL.axes_distance)):
        state = {"initialCoordinates": [start[body]], "initialVelocities": [start[2 + body]]}
        nodes.append(system.AddNode(items.Node1D(referenceCoordinates=[0.0], **state)))
        bodies.append(system.AddObject(items.ObjectRotationalMass1D(
            physicsInertia=inertias[body], nodeNumber=nodes[-1],
            referencePosition=[place, 0.0, 0.0], referenceRotation=np.eye(3),
        )))  # fmt: skip
    turned = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=0))
    system.AddLoad(items.LoadCoordinate(markerNumber=turned, load=OWN.torque))

    def marker(body, z):
        place = [z.real, z.imag, 0.0]
        return system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=place))

    def add(kind, pin, other, **numbers):
        numbers |= {"markerNumbers": [pin, other], **law}
        data = items.NodeGenericData(initialCoordinates=[1, 0, 0, 0], numberOfDataCoordinates=4)
        system.AddObject(kind(nodeNumber=system.AddNode(data), **numbers))

    half, wheel = WHEEL.span * math.pi / WHEEL.teeth, marker(bodies[0], 0j)
    pins = [cmath.rect(WHEEL.pallet_radius, sense * half) for sense in (-1.0, 1.0)]
    for pin in [marker(bodies[1], place - WHEEL.axes_distance) for place in pins]:
        for k in TEETH:
            turn = cmath.rect(1.0, k * WHEEL.pitch)
            tip = marker(bodies[0], (WHEEL.wheel_radius - WHEEL.tip_radius) * turn)
            radii = [WHEEL.pin_radius, WHEEL.tip_radius]
            add(items.ObjectContactSphereSphere, pin, tip, spheresRadii=radii)
            for a, b, n in faces(turn):
                ends = [[a.real, a.imag, 1.0], [a.real, a.imag, -1.0], [b.real, b.imag, 0.0]]
                faced = ((b - a) * n.conjugate()).imag < 0.0
                points = exu.Vector3DList(ends if faced else ends[::-1])
                numbers = {"sphereRadius": WHEEL.pin_radius, "trianglePoints": points}
                add(items.ObjectContactSphereTriangle, pin, wheel, includeEdges=0, **numbers)
    kind = exu.OutputVariableType.Coordinates
    sensor = items.SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=kind)
    found = system.AddSensor(sensor)
    system.Assemble()
    return system, keeper, found


def period(start, stiffness, damping, length):
    """The time of the second pitch from a state of the rigid cycle."""
    system, _keeper, sensor = model(start, stiffness, damping)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(length / STEP)
    settings.timeIntegration.endTime = length
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.discontinuous.ignoreMaxIterations = True
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 5.0 * STEP
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
    time, angle = system.GetSensorStoredData(sensor).T
    goals = start[0] + WHEEL.pitch * np.array([1.0, 2.0])
    return float(np.diff(np.interp(goals, angle, time))[0])


def main():
    """Print the period at some relaxation times, and how much it differs from the rigid one."""
    rigid = float(esc.terminal(OWN).period)
    motion = esc.simulate(OWN, 12)
    state = motion.at(motion.handoff_times[-1:])
    start = 0.0, *(float(x[0]) for x in (state.phi, state.theta_dot, state.phi_dot))
    for stiffness, relaxation in ((1e7, 3e-3), (1e8, 1e-3), (1e8, 3e-4)):
        found = period(start, stiffness, stiffness * relaxation, 2.1 * rigid)
        print(
            f"{stiffness:.0e} {relaxation:.0e} {found:.6f} {found / rigid - 1.0:+.1e}", flush=True
        )


if __name__ == "__main__":
    main()
