"""What everything else uses and what knows nothing of mechanisms.

- `errors`, `status`, `validate`: the errors that users meet, outcomes of a computation, checks of
  single values
- `units`, `spoken`, `quantity`: unit factors, numbers in the user's units, and declarations of
  numbers
- `results`, `records`: declarations of what is computed, and records that print themselves
- `text_table`, `columns`, `headings`, `lines`, `clock`: the readers of files with columns, of those
  with angles, and of headings, lines and times as loggers write them
- `text`, `files`, `toml_file`: tables and JSON, files that appear only when they are complete, TOML
- `progress`, `notice`: progress of long work, and the notice that kernels are compiled
- `lazy`: modules that are loaded when they are first used
"""
