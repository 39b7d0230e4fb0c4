"""Figures that the reports of several kinds of mechanism have in common."""

from typing import TYPE_CHECKING, Any

from escapement.units import degrees

if TYPE_CHECKING:
    from escapement.mechanisms import EllipticalPlanetary, GearDriven, Geneva, Tabulated


def cell(mechanism: "Geneva | GearDriven | EllipticalPlanetary | Tabulated") -> dict[str, Any]:
    """How far driver and follower turn in a cell, by JSON key."""
    return {
        "motion_ratio": mechanism.motion_ratio,
        "cell_angle_deg": degrees(mechanism.cell_angle),
        "follower_step_deg": degrees(mechanism.follower_step),
    }


def wheel(mechanism: "Geneva | GearDriven") -> dict[str, Any]:
    """The same of a wheel with slots, with its slots, pins and dwell."""
    turned = cell(mechanism)
    return {
        **turned,
        "slots": mechanism.slots,
        "pins": mechanism.pins,
        "continuous": mechanism.continuous,
        "dwell_deg": turned["cell_angle_deg"] * (1.0 - mechanism.motion_ratio),
        "transmission_max": float(mechanism.transmission(0.0).g),
    }
