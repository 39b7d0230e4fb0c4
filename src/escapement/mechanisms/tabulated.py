"""A mechanism known by its position function alone: designed elsewhere, or measured."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any

from escapement import validate
from escapement.errors import InputFileError, InvalidValue
from escapement.lazy import Lazy
from escapement.mechanisms.kind import Kind
from escapement.model import FloatArray
from escapement.quantity import InputFile, Numbers, Setting, Truth, declared, quantity, setting
from escapement.scene import Path

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from escapement.mechanisms import _periodic_spline as splines
    from escapement.mechanisms import _rows as rows
    from escapement.mechanisms import slotted
else:
    np, slotted = Lazy("numpy"), Lazy("escapement.mechanisms.slotted")
    rows = Lazy("escapement.mechanisms._rows")
    splines = Lazy("escapement.mechanisms._periodic_spline")

_BACKWARDS = 1e-3  # of the greatest g: what rounding and noise may leave of a stop
_SAMPLES = 2001
_REPORTED = 721


@dataclass(frozen=True)
class Tabulated(Kind):
    """Any mechanism whose follower keeps to its driver, from a table.

    A periodic quintic spline goes through the table, or, where the table is
    measured, smoothly between its rows. The mechanism has no slot: its losses are
    those of a mesh.

    Parameters
    ----------
    theta : sequence of float
        Driver angles [rad]: one cell, both ends included, ascending. With
        `cell_angle` and `follower_step`: any angles in any order, at least 12.
    phi : sequence of float
        Follower angles there [rad].
    measured : bool
        Whether the rows scatter. Else they are exact, at most 601.
    cell_angle : float, optional
        Driver angle after which the motion repeats itself [rad], > 0. Default: that
        of the table.
    follower_step : float, optional
        What the follower turns in it [rad], > 0 in either sense. Default: likewise; of
        measured rows fitted, for two of them would scatter too much.

    Raises
    ------
    InvalidValue
        When the table breaks a rule.

    Warns
    -----
    UserWarning
        Where more than a tenth of the cell has no rows: five times their usual
        distance or more, fifteen times where they are measured.

    Notes
    -----
    The spline has four continuous derivatives. Where the follower's acceleration
    jumps, as at the ends of a Geneva wheel's engagement, it is rounded off over a
    few rows.
    """

    kind = "tabulated"
    summary = "any drive that is always in mesh, from a table of its angles"
    meshed = True

    theta: Sequence[float] = field(metadata=setting(
        Numbers(long_name="driver angles [rad]", remedy="give a list of angles in rad")
    ))  # fmt: skip
    phi: Sequence[float] = field(metadata=setting(
        Numbers(long_name="follower angles [rad]", remedy="give a list of angles in rad")
    ))  # fmt: skip
    measured: bool = field(default=False, metadata=setting(
        Truth(long_name="the rows scatter: a smooth curve goes between them")
    ))  # fmt: skip
    cell_angle: float = field(default=0.0, metadata=quantity(
        "driver angle after which the motion repeats itself", "angle", exclusive=True, axis=False,
        metavar="DEG", remedy="give the angle, after it the motion repeats itself"
    ))  # fmt: skip
    follower_step: float = field(default=0.0, metadata=quantity(
        "what the follower turns in a cell", "angle", exclusive=True, axis=False, metavar="DEG",
        remedy="give the angle, the follower must have turned on from cell to cell"
    ))  # fmt: skip

    def __post_init__(self) -> None:
        theta, phi = (rows.column(name, getattr(self, name)) for name in ("theta", "phi"))
        measured = validate.truth("measured", self.measured)
        rows.check_rows(theta, phi, measured)
        cell, step = self.cell_angle, self.follower_step
        if cell == 0.0:
            cell = rows.one_cell(theta)
            turned = float(phi[-1] - phi[0])
            step = step or abs(splines.rise_over(theta, phi, cell) if measured else turned)
        elif step == 0.0:
            raise InvalidValue(
                "cell_angle must come with follower_step, got it alone; give both, or neither "
                "for a table of one whole cell"
            )
        angles = {"theta": tuple(theta.tolist()), "phi": tuple(phi.tolist())}
        vars(self).update(angles, measured=measured, cell_angle=cell, follower_step=step)
        self.check_fields()
        if self._rows.is_one_cell:
            self._rows.check_step()
        self._rows.warn_of_gap()

    def __repr__(self) -> str:
        # a study file knows a mechanism of one's own by its repr, so tables that differ
        # must not look alike
        checksum = zlib.crc32(np.array([self.theta, self.phi]).tobytes())
        return (
            f"{type(self).__name__}(<{len(self.theta)} rows, checksum {checksum:08x}>, "
            f"measured={self.measured}, cell_angle={self.cell_angle}, "
            f"follower_step={self.follower_step})"
        )

    @classmethod
    def from_csv(cls, path: str | PathLike[str], **options: Any) -> Tabulated:
        """Read a table of driver and follower angles.

        Parameters
        ----------
        path : path
            Two columns, apart by commas, semicolons, tabs or blanks: driver and follower
            in degrees. A line of headings may come first, without any number, and tell
            otherwise: phi_rad,theta_rad say. Lines that start with # are passed over.
        **options
            `measured`; `cell_angle` and `follower_step` in radians.

        Raises
        ------
        MissingInput, InputFileError
            When the file is not there, or is no such table.
        InvalidValue
            When an option breaks a rule.
        """
        theta, phi = rows.read_angles(path)
        try:
            table = cls(theta, phi, **options)  # type: ignore[arg-type]
            _ = table.spline
        except InvalidValue as error:
            if str(error).startswith(("theta ", "phi ")):
                raise InputFileError(f"table {path}: {error}") from None
            raise
        return table

    @classmethod
    def options(cls) -> dict[str, Setting]:
        """What the command line asks for: a file in place of the angles, and degrees."""
        known: dict[str, Any] = declared(cls)
        table = InputFile(
            name="table", key="table", metavar="FILE.csv", required=True,
            long_name="driver and follower angles, two columns, in degrees unless their headings "
            "say radians: one whole cell, or any rows with --cell-angle and --follower-step",
        )  # fmt: skip
        angles = {
            name: replace(known[name], unit="degrees", default=None)
            for name in ("cell_angle", "follower_step")
        }
        return {"table": table, "measured": known["measured"], **angles}

    @classmethod
    def from_options(cls, **given: Any) -> Tabulated:
        """The mechanism of a file, and of the angles that were typed beside it."""
        return cls.from_csv(given.pop("table"), **given)

    @cached_property
    def _rows(self) -> rows.FoldedRows:
        theta, phi = np.array(self.theta), np.array(self.phi)
        return rows.FoldedRows(theta, phi, self.measured, self.cell_angle, self.follower_step)

    @property
    def sense(self) -> float:
        """+1 or -1: how the table's follower turns; here it counts so that it grows."""
        return self._rows.sense

    @property
    def spline(self) -> splines.PeriodicSpline:
        """The position function less its mean rise, over the cell."""
        return self._rows.spline

    @cached_property
    def breaks(self) -> tuple[float, float]:
        """Both ends of the cell [rad].

        Those of the table; where its rows are of any cells, the cell about zero that
        begins where the follower is slowest. Between them the fourth derivative of g
        has a step at each knot; both engines go from knot to knot.
        """
        first = float(self.spline.knots[0])
        if self._rows.is_one_cell:
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

        Rounding off of sharp corners is not among them.
        """
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        g, dg = (self.spline.deviation(angles, order) for order in (1, 2))
        return slotted.Transmission(g, np.zeros_like(g), dg)

    def transmission(self, theta: ArrayLike) -> slotted.Transmission:
        """Transmission at driver angles of any size [rad]; u is 0, nothing slides."""
        g = self._rows.mean_ratio + self.spline(theta, 1)
        return slotted.Transmission(g, np.zeros_like(g), self.spline(theta, 2))

    def follower_angle(self, theta: ArrayLike) -> FloatArray:
        """Follower angle at driver angles of any size [rad], in the sense that grows."""
        angles = np.asarray(theta, dtype=float)
        return self.spline(angles) + self._rows.mean_ratio * (angles - self.theta[0])

    @cached_property
    def path(self) -> Path:
        """The spline, piece by piece, as kernels evaluate it.

        Raises
        ------
        InvalidValue
            Where the follower turns back: by more than a thousandth of its greatest
            speed and three standard deviations. No motion can be computed then.
        """
        from escapement.mechanisms.table import chebyshev_table

        theta = np.linspace(*self.breaks, _SAMPLES)
        g = self.transmission(theta).g
        worst = int(np.argmin(g))
        doubt = 3.0 * float(self.deviation(theta[worst]).g[0])
        if g[worst] < -max(_BACKWARDS * g.max(), doubt):
            raise InvalidValue(
                f"phi must rise (or fall) throughout for a motion, got a slope of {g[worst]:.3g} "
                f"against its sense at theta = {theta[worst]:.6g} rad; correct the table, or "
                "measure more of it"
            )
        start, end = self.breaks
        # the last knot is the first again
        knots = np.sort(start + np.mod(self.spline.knots[:-1] - start, self.cell_angle))
        inside = knots[(knots > start + self._rows.near) & (knots < end - self._rows.near)].tolist()
        return chebyshev_table(
            lambda x: self.transmission(x).g, [start, *inside, end], splines.DEGREE
        )

    def report(self) -> dict[str, Any]:
        """What the table says, and how well it knows, by JSON key."""
        theta = np.linspace(*self.breaks, _REPORTED)
        found, doubt = self.transmission(theta), self.deviation(theta)
        return {
            "rows": len(self.theta),
            **super().report(),
            "noise_deg": math.degrees(self.noise),
            "transmission_max": float(found.g.max()),
            "transmission_min": float(found.g.min()),
            "transmission_deviation": float(doubt.g.max()),
            "acceleration_function_max": float(found.dg.max()),
            "acceleration_function_min": float(found.dg.min()),
            "acceleration_function_deviation": float(doubt.dg.max()),
        }
