"""Everything a motion shows on one sheet."""

from matplotlib.figure import Figure

from escapement.motion import Motion
from escapement.plots import style
from escapement.plots.motion import plot_contact_moment, plot_phase_portrait, plot_velocities


def plot_motion(motion: Motion) -> Figure:
    """Velocities and contact moment against time, and the phase portrait.

    Parameters
    ----------
    motion : Motion
        What `escapement.simulate` returns.

    Raises
    ------
    InvalidValue
        For a motion without length.
    """
    figure = style.new_figure(style.TWO_COLUMN, 8.2)
    velocities, moment, phase = (style.dress(ax) for ax in figure.subplots(3, 1))
    plot_velocities(motion, velocities)
    plot_contact_moment(motion, moment)
    plot_phase_portrait(motion, phase)
    return figure
