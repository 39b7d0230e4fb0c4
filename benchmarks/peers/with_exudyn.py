"""Exudyn: a sphere on a crank between two triangles on the follower, both rotors of one axis.

Contact and integrators are Exudyn's own: a spring with a dashpot, friction proportional to the
speed at low speeds, and fixed steps. The handoff is interpolated between two steps.
"""

from collections.abc import Callable

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

import escapement as esc


def _model(own: esc.Escapement, speed: float) -> tuple[object, object, list[int]]:
    """The system, its container, which must not be deleted, and sensors of angle and speed."""
    wheel, keeper = own.mechanism, exu.SystemContainer()
    system = keeper.AddSystem()
    crank, axis = wheel.crank_radius, wheel.centre_distance * wheel.crank_radius
    entry = float(own.scene.edges[0])
    phi = float(wheel.follower_angle(np.array([entry]))[0])
    rotors, nodes = [], []
    for inertia, angle, rate, place in (
        (own.inertia.driver, -entry, -speed, axis),
        (own.inertia.follower, phi, 0.0, 0.0),
    ):
        start = {"initialCoordinates": [angle], "initialVelocities": [rate]}
        node = system.AddNode(items.Node1D(referenceCoordinates=[0.0], **start))
        rotor = items.ObjectRotationalMass1D(
            physicsInertia=inertia,
            nodeNumber=node,
            referencePosition=[place, 0.0, 0.0],
            referenceRotation=np.eye(3),
        )
        nodes.append(node)
        rotors.append(system.AddObject(rotor))
    places = ([-crank, 0.0, 0.0], [0.0, 0.0, 0.0])
    pin, slot = (
        system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=place))
        for body, place in zip(rotors, places, strict=True)
    )
    turned = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=0))
    system.AddLoad(items.LoadCoordinate(markerNumber=turned, load=-own.torque))
    far, wall = 4.0 * crank, wheel.pin_radius + 0.5 * wheel.clearance
    for side in (1.0, -1.0):
        corners = [
            [-far, side * wall, -far],
            [3.0 * far, side * wall, -far],
            [far, side * wall, 2.0 * far],
        ]
        # the wall faces the pin
        faced = corners if side > 0.0 else corners[::-1]
        data = system.AddNode(
            items.NodeGenericData(initialCoordinates=[wall, 0, 0, 0], numberOfDataCoordinates=4)
        )
        contact = items.ObjectContactSphereTriangle(
            markerNumbers=[pin, slot],
            nodeNumber=data,
            sphereRadius=wheel.pin_radius,
            trianglePoints=exu.Vector3DList(faced),
            includeEdges=0,
            dynamicFriction=own.friction,
            frictionProportionalZone=own.slip_speed,
            contactStiffness=own.stiffness,
            contactDamping=own.damping,
        )
        system.AddObject(contact)
    kinds = (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
    sensors = [
        system.AddSensor(
            items.SensorNode(nodeNumber=nodes[0], storeInternal=True, outputVariableType=kind)
        )
        for kind in kinds
    ]
    system.Assemble()
    return system, keeper, sensors


def run(
    own: esc.Escapement, speed: float, steps: int, method: str
) -> Callable[[], tuple[float, float]]:
    """A function that returns handoff time and speed; it runs 1 % longer than our engagement."""
    length = 1.01 * float(esc.simulate(own, 1, initial_speed=speed).end_time)

    def solve() -> tuple[float, float]:
        system, _keeper, sensors = _model(own, speed)
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = length
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = length / steps
        system.SolveDynamic(settings, solverType=getattr(exu.DynamicSolverType, method))
        angle, rate = (-system.GetSensorStoredData(sensor)[:, 1] for sensor in sensors)
        time = system.GetSensorStoredData(sensors[0])[:, 0]
        goal = float(own.scene.edges[-1])
        i = int(np.searchsorted(angle, goal))
        share = (goal - angle[i - 1]) / (angle[i] - angle[i - 1])
        at = time[i - 1] + share * (time[i] - time[i - 1])
        return float(at), float(rate[i - 1] + share * (rate[i] - rate[i - 1]))

    return solve
