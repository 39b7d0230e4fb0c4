"""Figures and drawings to scale: data in, matplotlib axes out.

Functions for one panel draw into given axes, or into a new figure; nothing is shown on a screen.
`save` writes a figure.

- `style`, `saving`, `films`: the look of every figure, and its file
- `cells`: what a notebook shows for a mechanism or a motion
- `motion_plots`, `motor_panels`, `rundown_curve`, `animation`, `clearance_drawing`: motions, and
  films of them
- `drawing`, `geneva`, `gear_driven`, `planetary`, `touching_bodies`: mechanisms to scale
- `study`, `study_panels`, `study_table`, `sample`, `budget_bars`, `designs`, `comparison_bars`:
  studies, budgets and designs
- `measurement`, `beat_plots`, `timing`: readings and beats
- `index_figure`: drives at constant speed
"""

from escapement.explorer.widget import explore as explore
from escapement.plots.animation import animate as animate
from escapement.plots.beat_plots import plot_beat_spectrum as plot_beat_spectrum
from escapement.plots.beat_plots import plot_beats as plot_beats
from escapement.plots.budget_bars import plot_budget as plot_budget
from escapement.plots.comparison_bars import plot_comparison as plot_comparison
from escapement.plots.designs import plot_designs as plot_designs
from escapement.plots.drawing import plot_mechanism as plot_mechanism
from escapement.plots.drawing import plot_table as plot_table
from escapement.plots.gear_driven import plot_gear_driven as plot_gear_driven
from escapement.plots.geneva import plot_configurations as plot_configurations
from escapement.plots.index_figure import plot_index as plot_index
from escapement.plots.measurement import plot_error_histogram as plot_error_histogram
from escapement.plots.measurement import plot_errors as plot_errors
from escapement.plots.measurement import plot_frequencies as plot_frequencies
from escapement.plots.measurement import plot_measurement as plot_measurement
from escapement.plots.measurement import plot_periodogram as plot_periodogram
from escapement.plots.measurement import plot_positions as plot_positions
from escapement.plots.measurement import plot_speeds as plot_speeds
from escapement.plots.motion_plots import plot_contact_moment as plot_contact_moment
from escapement.plots.motion_plots import plot_phase_portrait as plot_phase_portrait
from escapement.plots.motion_plots import plot_velocities as plot_velocities
from escapement.plots.motor_panels import plot_motor as plot_motor
from escapement.plots.planetary import plot_planetary as plot_planetary
from escapement.plots.rundown_curve import plot_rundown as plot_rundown
from escapement.plots.sample import plot_sample as plot_sample
from escapement.plots.saving import save as save
from escapement.plots.study import plot_lines as plot_lines
from escapement.plots.study import plot_map as plot_map
from escapement.plots.study import plot_rise_and_terminal as plot_rise_and_terminal
from escapement.plots.study import plot_spread as plot_spread
from escapement.plots.study import plot_study as plot_study
from escapement.plots.style import new_axes as new_axes
from escapement.plots.timing import plot_run_up as plot_run_up
from escapement.plots.timing import plot_timing as plot_timing
from escapement.plots.touching_bodies import plot_touching as plot_touching
