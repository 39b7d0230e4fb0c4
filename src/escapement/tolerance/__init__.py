"""Effects of changes of numbers: derivatives, and the budget of a drawing's tolerances.

Read `budget` and `sensitivities` first.

- `budget`, `scatter`, `spread`, `intervals`, `indices`, `worst_case`: a drawing's tolerances, and
  what they do to a figure of merit
- `sensitivities`: derivatives of figures of merit
- `dual`, `law`, `parts`, `panels`, `variation`, `extremes`, `contraction`, `figures`: derivatives
  by
  differentiating the equation of motion
- `differences`: derivatives where it cannot be differentiated
"""
