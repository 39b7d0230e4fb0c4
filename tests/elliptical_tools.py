"""Planetary drives with elliptical gears: that of the paper, and random ones."""

from hypothesis import strategies as st

import escapement as esc

PAPER = esc.EllipticalPlanetary(sun_radius=0.016, planet_radius=0.009)
drives = st.builds(
    esc.EllipticalPlanetary.from_ellipse, st.floats(1e-3, 1e3), st.floats(1e-3, 0.95)
)
