"""The named tuples that the steps of a march hand on: its request, its state, its results.

The result of a panel is `halved`, `stalled` or `passed`; where only some fields of a tuple change,
`numerics.altered` makes the new one.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from escapement.engines.energy.locate import AfterReversal
from escapement.engines.energy.panels import FIRST_PANEL, tolerances
from escapement.numerics.altered import altered
from escapement.numerics.jit import inner_jit

NOWHERE = -1
"""The index that stands for no point."""


class Detail(IntEnum):
    """The results that a march computes; each member includes those before it.

    MAP: the map from w at entry to w at exit. It misses a pair of reversals inside one panel.
    TIME: the time as well, and such pairs; reversals are counted and not located. EXTREMA: the
    extrema of the driver speed as well. EVERYTHING: the angles and times of the reversals too.
    """

    MAP = 0
    TIME = 1
    EXTREMA = 2
    EVERYTHING = 3


class Request(NamedTuple):
    """The requested results of a march, and their accuracy.

    detail : a `Detail`.
    loose, strict : tails allowed in a panel for integrals over the whole panel, and for
        values inside it, as `panels.tolerances` gives them.
    """

    detail: Detail
    loose: float
    strict: float


@inner_jit(inlined=True)
def request_of(detail, rtol):
    """The request of a `Detail` with a relative error of `rtol`."""
    loose, strict = tolerances(rtol)
    return Request(detail=detail, loose=loose, strict=strict)


class MarchState(NamedTuple):
    """The motion at the left end of the panel that a march has reached.

    panel : index of the panel in the store.
    w, energy : theta_dot^2, and E = (rho + g^2) w.
    side : s, the side of the slot that carries the force.
    rising : sign of theta_ddot just before, 0 at the start of the motion; it is kept only from
        Detail.EXTREMA on.
    time : since the entry.
    exponent, source : of the affine map E = exp(-exponent) E_entry + source to here.
    used : number of events noted.
    left_noted : whether the events of this left end are among them, as they are when the
        panel is halved and entered again.
    """

    panel: int
    w: float
    energy: float
    side: float
    rising: float
    time: float
    exponent: float
    source: float
    used: int
    left_noted: bool


@inner_jit(inlined=True)
def at_entry(w, energy, side, rising, used):
    """The state at the left end of the first panel."""
    return MarchState(
        panel=FIRST_PANEL, w=w, energy=energy, side=side, rising=rising, time=0.0, exponent=0.0,
        source=0.0, used=used, left_noted=False,
    )  # fmt: skip


@inner_jit(inlined=True)
def with_rho(state, g, before, after):
    """The state where rho changes in E = (rho + g^2) w, since power turns back through a train."""
    ratio = (after + g * g) / (before + g * g)
    return altered(
        state, "energy", state.w * (after + g * g), "exponent", state.exponent - np.log(ratio),
        "source", ratio * state.source,
    )  # fmt: skip


class Passage(NamedTuple):
    """The motion over one panel.

    split : whether the panel must be halved first, so that nothing else here counts but `angle`.
    has_stalled : whether the motion ends inside it; of the rest only angle and time count then.
    angle : driver angle of a stall, or at which to split, 0 for the middle of the panel [rad].
    energy, w, contact : E, w and s X at the right end; where there is a reversal, as if s had
        not changed.
    time : from the entry to the right end, or to the stall; with Detail.MAP to the left end.
    reversal : first point after a pin reversal, `NOWHERE` without one.
    slowing : number of points at which theta_ddot <= 0.
    left_contact : s X at the left end.
    """

    split: bool
    has_stalled: bool
    angle: float
    energy: float
    w: float
    contact: float
    time: float
    reversal: int
    slowing: int
    left_contact: float


class PanelEnds(NamedTuple):
    """The motion at the ends of a panel.

    left_w, left_contact : w and s X at the left end.
    energy, w, contact : E, w and s X at the right end.
    """

    left_w: float
    left_contact: float
    energy: float
    w: float
    contact: float


@inner_jit(inlined=True)
def with_contact(ends, contact):
    """The ends with another s X at the right one."""
    return altered(ends, "contact", contact)


@inner_jit(inlined=True)
def passed(ends, time, reversal, slowing):
    """The passage to the right end of a panel."""
    return Passage(
        split=False, has_stalled=False, angle=0.0, energy=ends.energy, w=ends.w,
        contact=ends.contact, time=time, reversal=reversal, slowing=slowing,
        left_contact=ends.left_contact,
    )  # fmt: skip


@inner_jit(inlined=True)
def halved(ends, time):
    """The passage over a panel that must be halved first."""
    return split_at(ends, time, 0.0)


@inner_jit(inlined=True)
def split_at(ends, time, angle):
    """The passage over a panel that must be split first, at a driver angle.

    The rest of it is not read; with these numbers the march is faster than with zeros.
    """
    return altered(passed(ends, time, NOWHERE, 0), "split", True, "angle", angle)


@inner_jit(inlined=True)
def stalled(angle, time):
    """The passage to a stop inside a panel, at a driver angle."""
    return Passage(
        split=False, has_stalled=True, angle=angle, energy=0.0, w=0.0, contact=0.0, time=time,
        reversal=NOWHERE, slowing=0, left_contact=0.0,
    )  # fmt: skip


class SpeedExtremum(NamedTuple):
    """The extremum of the driver speed in a panel, if there is one.

    split : whether the panel must be halved first.
    point : the first point after the extremum, `NOWHERE` without one.
    first, final : J theta_ddot at the left end, and at the right end or reversal.
    time, energy, side : time since the entry and E at the left end, and s.
    coarse : whether the panel is too coarse for interpolation inside it.
    """

    split: bool
    point: int
    first: float
    final: float
    time: float
    energy: float
    side: float
    coarse: bool


class MarchResult(NamedTuple):
    """The result of a march over one engagement and the dwell after it.

    status : a value of `Status`.
    w : theta_dot^2 at the end of the cell.
    angle : driver angle of a stall [rad].
    time : from the entry to the end of the cell, or to the stall.
    exponent, source : of the affine map
        w_out (rho + g_out^2) = exp(-exponent) w_in (rho + g_in^2) + source,
        which holds as long as the reversals stay at their angles.
    side, rising : s at the exit, and the sign of theta_ddot at the end.
    panels, used : number of panels in use, and of events noted.
    """

    status: int
    w: float
    angle: float
    time: float
    exponent: float
    source: float
    side: float
    rising: float
    panels: int
    used: int


@inner_jit(inlined=True)
def ended(status, state, angle, time, count):
    """The result of a march that ends with `state`, and has `count` panels in use."""
    return MarchResult(
        status=status, w=state.w, angle=angle, time=time, exponent=state.exponent,
        source=state.source, side=state.side, rising=state.rising, panels=count, used=state.used,
    )  # fmt: skip


class Inside(NamedTuple):
    """The result of noting a reversal and an extremum inside a panel.

    split : whether the panel must be halved first.
    used : number of events noted.
    after_reversal : the motion after the reversal, where there is one.
    """

    split: bool
    used: int
    after_reversal: AfterReversal


@inner_jit(inlined=True)
def behind_panel(following, state, passage, solution, rising, used):
    """The state at the left end of the panel at `following`, behind one without a reversal.

    The affine map of the panel is composed with that up to its left end.
    """
    return MarchState(
        panel=following, w=passage.w, energy=passage.energy, side=state.side, rising=rising,
        time=passage.time, exponent=state.exponent + solution.b_end,
        source=solution.alpha_end * state.source + solution.beta_end, used=used, left_noted=False,
    )  # fmt: skip


@inner_jit(inlined=True)
def behind_reversal(following, state, after, w, rising, used):
    """The state at the left end of the panel at `following`, behind one with a reversal.

    `after` is its `AfterReversal`, and `w` belongs to the energy there.
    """
    return MarchState(
        panel=following, w=w, energy=after.energy, side=-state.side, rising=rising,
        time=state.time + after.length, exponent=state.exponent + after.exponent,
        source=after.source, used=used, left_noted=False,
    )  # fmt: skip
