"""Studies: a grid or a sample of cases, solved into memory or into one HDF5 file."""
