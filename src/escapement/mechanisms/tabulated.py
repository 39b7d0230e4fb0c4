"""A mechanism of which only the position function is known: designed elsewhere, or measured."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from typing import Any

from escapement.base.errors import InputFileError, InvalidValue
from escapement.base.quantity import InputFile, Setting, declared
from escapement.mechanisms._rows import Rows
from escapement.mechanisms.kind import ArrayLike, np, slotted, table
from escapement.mechanisms.path import Path
from escapement.mechanisms.protocol import FloatArray

_BACKWARDS = 1e-3  # share of the greatest g that rounding and noise may leave at a stop
_SAMPLES = 2001
_REPORTED = 721


@dataclass(frozen=True, repr=False)
class Tabulated(Rows):
    """Any mechanism in which driver and follower are always connected, from a table.

    A periodic quintic spline interpolates the table, or smooths its rows if they are measured.
    The mechanism has no slots: its losses are given by an efficiency.

    Parameters
    ----------
    theta : sequence of float
        Driver angles [rad]: one cell, both ends included, ascending. With
        `cell_angle` and `follower_step`: any angles in any order, at least 12.
    phi : sequence of float
        Follower angles there [rad].
    measured : bool
        Whether the rows scatter. Otherwise they are exact, and at most 601.
    cell_angle : float, optional
        Driver angle after which the motion repeats itself [rad], > 0. Default: that
        of the table.
    follower_step : float, optional
        Angle that the follower turns in a cell [rad], > 0 in either direction. Default: that of
        the table; with measured rows it is fitted, because two single rows would scatter too
        much.

    Raises
    ------
    InvalidValue
        When the table breaks a rule.

    Warns
    -----
    UserWarning
        If more than a tenth of the cell has no rows and this gap is at least five times their
        usual distance, or fifteen times if they are measured.

    Notes
    -----
    The spline has four continuous derivatives. Where the follower's acceleration
    jumps, as at the ends of a Geneva wheel's engagement, it is smoothed over a few rows.
    """

    kind = "tabulated"
    summary = "any drive that is always in mesh, from a table of its angles"
    meshed = True
    without_parts = True

    def _shown(self) -> list[tuple[str, Any, str]]:
        # a study file identifies such a mechanism by its repr, so different tables must have
        # different ones
        checksum = zlib.crc32(np.array([self.theta, self.phi]).tobytes())
        return [
            ("rows", len(self.theta), ""),
            ("checksum", f"{checksum:08x}", ""),
            ("measured", self.measured, ""),
            ("cell_angle", self.cell_angle, "rad"),
            ("follower_step", self.follower_step, "rad"),
        ]

    @classmethod
    def from_csv(cls, path: str | PathLike[str], **options: Any) -> Tabulated:
        """Read a table of driver and follower angles.

        Parameters
        ----------
        path : path
            Two columns, separated by commas, semicolons, tabs or blanks: driver and follower in
            degrees. A first line of headings, without any number, may set another order or unit,
            for example phi_rad,theta_rad. Lines that start with # are skipped.
        **options
            `measured`; `cell_angle` and `follower_step` in radians.

        Raises
        ------
        MissingInput, InputFileError
            When the file does not exist, or is not such a table.
        InvalidValue
            When an option breaks a rule.
        """
        from escapement.base.columns import read_columns

        found = read_columns(path, "table", by_order=True)
        if set(found.units) == {"rad", None}:
            raise InputFileError(
                f"table {path} must name the units of both columns or of neither, got radians for "
                "one; write for example theta_deg,phi_deg"
            )
        bad = np.flatnonzero(~np.isfinite(np.sum(found.angles, axis=0)))
        if bad.size:
            where = f"{path}, line {found.line[bad[0]]}"
            raise InputFileError(f"{where} must have two finite numbers; leave out the row")
        try:
            drive = cls(*found.angles, **options)  # type: ignore[arg-type]
            _ = drive.spline
        except InvalidValue as error:
            if str(error).startswith(("theta ", "phi ")):
                raise InputFileError(f"table {path}: {error}") from None
            raise
        return drive

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """The options of the command line: a file instead of the angles, and degrees."""
        known: dict[str, Any] = declared(cls)
        file = InputFile(
            name="table", key="table", metavar="FILE.csv", required=True,
            long_name="driver and follower angles, two columns, in degrees unless their headings "
            "say radians: one whole cell, or any rows with --cell-angle and --follower-step",
        )  # fmt: skip
        angles = {
            name: replace(known[name], unit="degrees", default=None)
            for name in ("cell_angle", "follower_step")
        }
        return {"table": file, "measured": known["measured"], **angles}

    @classmethod
    def from_options(cls, **given: Any) -> Tabulated:
        """The mechanism of a file, and of the angles that were typed with it."""
        return cls.from_csv(given.pop("table"), **given)

    @cached_property
    def breaks(self) -> tuple[float, float]:
        """Both ends of the cell [rad].

        Those of the table; if its rows lie in any cells, the ends of the cell around zero that
        begins where the follower is slowest. Between them the fourth derivative of g has a step
        at each knot; both engines go from knot to knot.
        """
        first = float(self.spline.knots[0])
        if self._is_one_cell:
            return first, float(self.spline.knots[-1])
        theta = np.linspace(first, first + self.cell_angle, _SAMPLES)
        slowest = float(theta[np.argmin(self.transmission(theta).g)])
        start = slowest - self.cell_angle * math.ceil(slowest / self.cell_angle)
        return start, start + self.cell_angle

    @property
    def noise(self) -> float:
        """Standard deviation of the measured follower angles [rad]; 0 for an exact table."""
        return self.spline.noise

    def deviation(self, theta: ArrayLike) -> slotted.Transmission:
        """Standard deviations of g and g' at 1-D driver angles [rad], from the noise.

        They do not include the smoothing of sharp corners.
        """
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        g, dg = (self.spline.deviation(angles, order) for order in (1, 2))
        return slotted.Transmission(g, np.zeros_like(g), dg)

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles of any size [rad]; u is 0, nothing slides."""
        g = self._mean_ratio + self.spline(theta, 1)
        return slotted.Transmission(g, np.zeros_like(g), self.spline(theta, 2))

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles of any size [rad], in the sense that grows."""
        angles = np.asarray(theta, dtype=float)
        return self.spline(angles) + self._mean_ratio * (angles - self.theta[0])

    @cached_property
    def path(self) -> Path:
        """The spline, piece by piece, as kernels evaluate it.

        Raises
        ------
        InvalidValue
            Where the follower turns back: by more than a thousandth of its greatest
            speed and three standard deviations. No motion can be computed then.
        """
        theta = np.linspace(*self.breaks, _SAMPLES)
        g = self.transmission(theta).g
        worst = int(np.argmin(g))
        doubt = 3.0 * float(self.deviation(theta[worst]).g[0])
        if g[worst] < -max(_BACKWARDS * g.max(), doubt):
            raise InvalidValue(
                f"phi must rise (or fall) throughout for a motion, got a slope of {g[worst]:.3g} "
                f"in the other sense at theta = {theta[worst]:.6g} rad; correct the table, or "
                "give more rows"
            )
        start, end = self.breaks
        # the last knot is the first again
        knots = np.sort(start + np.mod(self.spline.knots[:-1] - start, self.cell_angle))
        inside = knots[(knots > start + self._near) & (knots < end - self._near)].tolist()
        edges = [start, *inside, end]
        return table.chebyshev_table(lambda x: self.transmission(x).g, edges, table.DEGREE)

    def report(self) -> dict[str, Any]:
        """The numbers of the table and their uncertainty, by JSON key."""
        theta = np.linspace(*self.breaks, _REPORTED)
        found, doubt = self.transmission(theta), self.deviation(theta)
        noise = math.degrees(self.noise)
        record = {"rows": len(self.theta), **super().report(), "noise_deg": noise}
        for name, key in (("transmission", "g"), ("acceleration_function", "dg")):
            values, deviations = getattr(found, key), getattr(doubt, key)
            record[f"{name}_max"], record[f"{name}_min"] = float(values.max()), float(values.min())
            record[f"{name}_deviation"] = float(deviations.max())
        return record
