"""The memory of the kernels: rows of sixteen values, one for each Gauss point of a panel.

A flight keeps the coefficients of its Taylor series in rows of the same length.
"""

import numpy as np

from escapement.numerics.gauss import POINTS, N
from escapement.numerics.jit import inner_jit
from escapement.numerics.records import record_dtype

_PANEL = (
    # of the path at the points: g, u, k = g' + c_f g |g|, R and c = p - g; and 1/(rho + g^2)
    *("g", "u", "k", "radius", "c", "inverse_inertia"),
    # of the law: torque of the drive minus that of the bearing, load that changes with the angle,
    # and A and B of dE/dx = A - B E
    *("pull", "load", "gain", "decay"),
    # of the solution: int B, E, theta_dot^2, dt/dx, J theta_ddot, and s X, positive while the
    # wall carries a force
    *("exponent", "energy", "w", "slowness", "net_torque", "force"),
    # torques through lossy trains, positive while the power keeps its direction
    *("barrel_torque", "load_torque"),
)
"""Rows of a panel of contact."""
_SCRATCH = (
    *("alpha", "w_before", "above_rest", "series", "series_slope", "scratch", "at_x", "from_left"),
)
"""Rows for a moment: exp(-int B), theta_dot^2 of the iteration before, the energy above that of
bodies at rest, coefficients of a power series and of its slope, the times at which the motion
reaches the points, and the weights of `gauss.weights_to`."""
_FLIGHT = ("driver_angle", "driver_speed", "follower_angle", "follower_speed", "load_slope")
"""Coefficients of Taylor series in time, from the constant one upwards; `load` has those of the
load, and `load_slope` those of its slope by the follower angle."""
WORKSPACE = record_dtype({
    **dict.fromkeys(("nodes", *_PANEL, *_SCRATCH, *_FLIGHT), (float, N)),
    "points": np.int64,
})  # fmt: skip
"""The rows by name. `nodes` are the Gauss points themselves, and `points` is their number, which
the compiler does not know: see `numerics.gauss`. Fields of a record do not overlap, so that loops
over them become vector code."""


@inner_jit(allocates=True)
def workspace():
    """Memory for one record of rows.

    The compiler frees memory after its last use, and does not count records among the uses: a
    kernel that needs the record in a loop takes it from this memory within the loop.
    """
    memory = np.empty(1, WORKSPACE)
    # assigning to a slice takes longer to compile
    for i in range(N):
        memory[0].nodes[i] = POINTS[i]
    memory[0].points = N
    return memory
