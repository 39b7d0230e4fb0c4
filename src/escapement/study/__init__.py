"""Studies: a grid or a sample of cases, solved into memory or into one HDF5 file.

A study is planned, solved case by case, kept, and written. Read `plan` and `running` first.

- `subject`: what a study can be about, an escapement or an indexing drive
- `parse`: from a file or a design to a plan; `plan`, `configuration`: the plan, and its JSON
- `scenes`, `checked`, `cases`: equal scenes once, some of them checked, then each case with its own
  unit of time; `index_cases`: those of indexing drives
- `running`, `solving`, `pool`, `block`: blocks of cases on threads or on a cluster
- `journal`, `writer`, `hdf5`, `table_files`: finished blocks, and the files that are made of them
- `reader`, `stored`, `result`: the results, from a file or in memory
- `selection`: a case that is selected by its values, and a few cases to be shown
"""
