"""Files on disk: atomic output, a file object for HDF5, and checks of names."""
