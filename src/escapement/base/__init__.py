"""What everything else uses and what knows nothing of mechanisms.

- `errors`, `status`, `validate`: the errors that users meet, outcomes of a computation, checks of
  single values
- `units`, `spoken`, `quantity`: unit factors, the system that the user chose, and declarations of
  numbers
- `columns`, `headings`, `lines`, `clock`: the reader of files with columns, with headings, lines
  and times as loggers write them
- `text`, `files`, `toml_file`: tables and JSON, files that appear only when they are complete, TOML
- `progress`, `notice`: progress of long work, and the notice that kernels are compiled
- `lazy`: modules that are loaded when they are first used
"""
