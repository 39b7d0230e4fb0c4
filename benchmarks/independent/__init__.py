"""A third integrator, written independently of the package, to check its engines on many cases.

It uses Taylor series in the driver angle, in double precision. The equation of motion is derived
from the Lagrangian: with rho = I_d/I_f, W = theta_dot^2 I_f/torque, m = load/torque, c = s mu |u|,
p = g + c, D = rho + g^2 and J = rho + g p,

    J W' + 2 p g' W = 2 (1 - p m),        s = sign K,   K = rho (g' W + m) + g.

Every step expands the transmission, W, K and W^(-1/2) about its start, and is so long that their
last coefficients are negligible. Near a start from rest W is proportional to the distance x, and
near a stop to -x; there the half-integer powers are integrated term by term. Two more functions of
the angle are integrated for E = D W: the logarithm l of its homogeneous solution, and a particular
solution S,

    l' = -2 c rho g'/(J D),     S' = 2 D (1 - p m)/J + l' S.

Their values at the end give the terminal cycle as W = (S/rho + dwell)/(1 - e^l) without loss of
digits. Speeds and times are in natural units; angles in rad from dead centre.
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
