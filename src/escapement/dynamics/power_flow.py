"""Directions of power through lossy trains, and what a scene of one flow has been divided by.

A flow is a number: 1 is added where the driver drives the barrel, and 2 where the train of the load
drives the follower. `train_losses` explains it.
"""

from escapement.numerics.jit import inner_jit

UNKNOWN = -1.0
"""The flow of a scene that includes both trains as if nothing were lost."""
FLOWS = 4
"""Combinations of directions."""


@inner_jit
def factors(flow, scene):
    """e_b and e_l of a flow."""
    back, given = flow == 1.0 or flow == 3.0, flow >= 2.0
    barrel, train = scene.barrel_efficiency, scene.load_train_efficiency
    return 1.0 / barrel if back else barrel, train if given else 1.0 / train


@inner_jit
def weight(scene):
    """Follower inertia of a scene of one flow, divided by that of its original scene."""
    if scene.flow == UNKNOWN:
        return 1.0
    return 1.0 + (factors(scene.flow, scene)[1] - 1.0) * scene.load_train
