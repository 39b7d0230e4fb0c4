"""Prikhodko (2020): printed numbers and equations beside what they should be.

The raw measurements are not published, so three statistics of them are taken as
printed; everything else is recomputed, from the two radii and from these three.
"""

import csv
import math
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np

from escapement.measurement import sturges
from escapement.mechanisms import EllipticalPlanetary
from escapement.sources.printed import Erratum, digits

if TYPE_CHECKING:
    from escapement.measurement import Measurement

ENCODER_STEPS = 4096
CONFIDENCE = 0.99
_NODES = 60


@dataclass(frozen=True)
class PrintedValue:
    """One printed number beside the right value.

    name, place, unit : what it is, where it stands.
    printed, right : text with the same number of digits; `right` is None for what
        follows from nothing that is printed.
    value : the right value, unrounded, or NaN.
    reason : why they differ, in a sentence; "" where they agree or nothing is known.
    """

    name: str
    place: str
    unit: str
    printed: str
    right: str | None
    value: float
    reason: str

    @property
    def agrees(self) -> bool:
        """Whether the printed number is right to its last digit, or cannot be judged."""
        return self.right is None or digits(self.right).value == digits(self.printed).value


ERRATA = (
    Erratum("section 2", "b is the minor axis", "the semi-minor axis, sqrt(R1 R2) = 12 mm"),
    Erratum(
        "after (6)",
        "phi_7 = (R1/R2) phi_1 is the rotation of wheel 7",
        "its rotation on the carrier; in space it turns by (1 + R1/R2) phi_1",
    ),
    Erratum("(12)", "sqrt((x_i - M)^2 p_i)", "sqrt(sum over i of (x_i - M)^2 p_i)"),
    Erratum(
        "(16)",
        "upper limit chi^2_(1-alpha)(r), the quantile for the level that is sought",
        "the chi^2 = 7.595 that was found in (15)",
    ),
    Erratum(
        "after (16)",
        "the distribution is normal with significance level 26.93 %",
        "of normal samples 26.93 % deviate this much or more: no reason to reject",
    ),
    Erratum(
        "(19)",
        "the interval is one of M(X)",
        "of a single error; the mean is known to 2.58 * 1.298/sqrt(148) = 0.275 degrees",
    ),
)
"""What the paper's equations and sentences must say instead."""


@cache
def printed() -> dict[str, str]:
    """Printed numbers by name, as text."""
    return {row["quantity"]: row["printed"] for row in _rows()}


def drive() -> EllipticalPlanetary:
    """The drive that was measured: R1 = 16, R2 = 9 mm."""
    radii = printed()
    return EllipticalPlanetary(
        float(radii["sun_radius"]) / 1e3, float(radii["planet_radius"]) / 1e3
    )


def table() -> list[PrintedValue]:
    """Every printed number that can be judged, and those it is judged by."""
    values = _recomputed()
    return [
        _judged(row["quantity"], row["place"], row["unit"], row["printed"], values)
        for row in _rows()
    ]


def synthetic_measurement() -> "Measurement":
    """A measurement such as the paper's, made up: its drive, encoders, spread and classes.

    148 readings over two cells, whose errors are normal with the printed deviation.
    """
    from escapement.measurement import Encoder, measure, synthetic_readings

    given, mechanism = printed(), drive()
    readings = synthetic_readings(
        mechanism,
        seed=2020,
        samples=int(given["sample_size"]),
        turns=2.0 * mechanism.cell_angle / (2.0 * math.pi),
        encoder=Encoder(ENCODER_STEPS),
        noise=math.radians(float(given["error_deviation"])),
    )
    return measure(readings, mechanism, bins=int(given["intervals"]))


def position_function_error(nodes: int = _NODES) -> float:
    """Greatest deviation of the closed position function from quadrature of (9) [rad].

    Gauss-Legendre over each of three quarters of a cell, of the printed equation in
    R1, R2 and rho: nothing of the closed form enters.
    """
    mechanism = drive()
    places, weights = np.polynomial.legendre.leggauss(nodes)
    sun, planet = mechanism.sun_radius, mechanism.planet_radius
    a, e = mechanism.semi_major_axis, mechanism.eccentricity
    edges = np.linspace(0.0, 0.75 * mechanism.cell_angle, 13)
    half = 0.5 * np.diff(edges)
    angle = edges[:-1, None] + half[:, None] * (1.0 + places)
    rho = a * (1.0 - e * e) / (1.0 - e * np.cos(sun / planet * angle))
    analogue = 1.0 - sun * rho / (planet * (sun + planet - rho))
    integral = np.cumsum(half * (analogue @ weights))
    return float(np.abs(integral + mechanism.follower_angle(edges[1:])).max())


def pitch_curve_slip() -> float:
    """Greatest mismatch of radii or arcs of the pitch curves over a cell, in centre distances."""
    mechanism = drive()
    theta = np.linspace(*mechanism.breaks, 361)
    driving, driven = mechanism.pitch_ellipses
    alpha, beta = mechanism.ratio * theta, theta + mechanism.follower_angle(theta)
    apart = driving.radius(alpha) + driven.radius(beta) - mechanism.centre_distance
    slip = driving.arc(alpha) - driven.arc(beta)
    return float(max(np.abs(apart).max(), np.abs(slip).max()) / mechanism.centre_distance)


@cache
def _rows() -> tuple[dict[str, str], ...]:
    place = files("escapement.sources.prikhodko") / "table_1.csv"
    return tuple(csv.DictReader(place.read_text(encoding="utf-8").splitlines()))


def _recomputed() -> dict[str, float]:
    """What follows from the radii, and from size, deviation and chi^2 of the sample."""
    from scipy.stats import chi2, norm

    mechanism, given = drive(), {name: float(text) for name, text in printed().items()}
    quantile = float(norm.ppf(0.5 * (1.0 + CONFIDENCE)))
    lengths = ("semi_major_axis", "semi_minor_axis", "focal_distance")
    # two degrees are lost, because mean and deviation were estimated from the sample
    return {
        **{name: 1e3 * getattr(mechanism, name) for name in lengths},
        "eccentricity": mechanism.eccentricity,
        "encoder_resolution": 360.0 / ENCODER_STEPS,
        "stop_interval": math.degrees(mechanism.cell_angle),
        "intervals": sturges(int(given["sample_size"])),
        "degrees_of_freedom": given["intervals"] - 1.0 - 2.0,
        "significance": 100.0 * float(chi2.sf(given["chi_squared"], given["degrees_of_freedom"])),
        "quantile": quantile,
        "half_width": given["quantile"] * given["error_deviation"],
    }


def _judged(name: str, place: str, unit: str, text: str, values: dict[str, float]) -> PrintedValue:
    if name not in values:
        return PrintedValue(name, place, unit, text, None, math.nan, "")
    shown, value = digits(text), values[name]
    right, reason = shown.like(value), ""
    if right.value != shown.value:
        reason = f"{value:.4g} is not {text}"
        if shown.like(value, cut=True).value == shown.value:
            reason = f"cut off, not rounded: {value:.4g}"
        elif shown.value == math.ceil(value):
            reason = f"the next greater whole number: {value:.4g}"
    return PrintedValue(name, place, unit, text, right.text, value, reason)
