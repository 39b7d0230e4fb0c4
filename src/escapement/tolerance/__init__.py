"""Effects of changes of numbers: derivatives, and the budget of a drawing's tolerances.

Read `tolerance_budget` and `sensitivities` first.

- `tolerance_budget`, `scatter`, `spread`, `intervals`, `indices`, `worst_case`: a drawing's
  tolerances, and what they do to a figure of merit
- `permitted`: the inverse, ranges that give a wanted yield
- `scatter_record`: what is told of it, in JSON, tables and reports
- `sensitivities`: derivatives of figures of merit
- `side_by_side`: several designs compared
- `derivatives`: derivatives of several figures by several numbers
- `differences`: derivatives by one number, from differences
"""
