"""Effects of changes of numbers: derivatives, and the budget of a drawing's tolerances."""
