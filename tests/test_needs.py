"""Kernels that are compiled for what a scene needs give the same bits as those for everything."""

from dataclasses import replace

import numpy as np
import pytest

import escapement as esc
from escapement.dynamics.needs import FIXED, Kind, kind_of
from escapement.engines.energy.calls import NO_PATTERN, kernel_addresses
from escapement.engines.energy.cells import cells_of
from escapement.engines.energy.handoffs import handoffs
from escapement.model.scene import packed

INERTIA = esc.Inertia(driver=3.39e-7, follower=5.65e-6)
IDEAL = esc.Escapement(esc.Geneva(slots=4, pins=4), INERTIA, torque=0.0113, friction=0.35)
THICK = replace(IDEAL.mechanism, crank_radius=0.01, pin_radius=0.0005)


@pytest.mark.parametrize(
    ("timer", "kind"),
    [
        (replace(IDEAL, load_torque=0.001), Kind.STEADY),
        (replace(IDEAL, mechanism=THICK), Kind.STEADY),
        (replace(IDEAL, driver_drag=1e-8, driver_bearing_torque=1e-4), Kind.STEADY),
        (replace(IDEAL, follower_viscous=1e-6), Kind.WHOLE),
        (replace(IDEAL, spring_rate=1e-5), Kind.WHOLE),
        (replace(IDEAL, barrel=esc.Train(ratio=5.0, efficiency=0.9)), Kind.WHOLE),
    ],
)
def test_each_kind_gives_the_bits_of_the_whole(timer, kind):
    scene = timer.scene
    assert kind_of(scene.torque, scene[FIXED:]) == kind
    cells, found = cells_of(scene.path, scene.edges), []
    for each in Kind:
        if each >= kind:
            times, speeds = np.empty(30), np.empty(30)
            inputs = kernel_addresses(each), packed(scene), cells, NO_PATTERN
            handoffs(*inputs, 0.0, np.inf, 1e-12, 1.0, times, speeds)
            found.append((times.tobytes(), speeds.tobytes()))
    assert len(set(found)) == 1
