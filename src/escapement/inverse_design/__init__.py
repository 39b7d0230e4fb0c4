"""From a requirement to designs: a task, and the timers or the indexing drives that do it best.

- `requirement`, `timer_search`: the task of a timer, and the search; `similarity`: the figures of a
  wheel; `design_record`: what is told of designs
- `drive_requirement`, `drive_search`: the same for indexing drives, by studies of them
- `front`: the designs of which none is better than another in everything
"""
