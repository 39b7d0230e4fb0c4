"""What a change of a number does: derivatives, and the budget of a drawing's tolerances."""
