"""A third integrator, written without the package, to judge its engines in bulk.

Taylor series in the driver angle, in double precision, from the Lagrangian: with
rho = I_d/I_f, W = theta_dot^2 I_f/torque, m = load/torque, c = s mu |u|, p = g + c,
D = rho + g^2 and J = rho + g p,

    J W' + 2 p g' W = 2 (1 - p m),        s = sign K,   K = rho (g' W + m) + g.

Every step expands the transmission, W, K and W^(-1/2) about its start and goes as far
as their last coefficients are negligible. W ~ x at a start from rest and W ~ -x before
a stop: there the half-integer powers are integrated term by term. Beside W it carries
the logarithm l of the homogeneous solution of E = D W and the particular one S,

    l' = -2 c rho g'/(J D),     S' = 2 D (1 - p m)/J + l' S,

whose end values give the terminal cycle as W = (S/rho + dwell)/(1 - e^l) without
cancellation. Speeds and times are in natural units; angles in rad from dead centre.
"""

from .compiling import compiled
from .engagement import HEAD, LOST, OK, PAINLEVE, ROW, STALL, VARIATION, engage
from .equation import Case, case_of, critical_friction
from .motions import motion, terminal
from .series import SIZE

__all__ = [
    "HEAD",
    "LOST",
    "OK",
    "PAINLEVE",
    "ROW",
    "SIZE",
    "STALL",
    "VARIATION",
    "Case",
    "case_of",
    "compiled",
    "critical_friction",
    "engage",
    "motion",
    "terminal",
]
