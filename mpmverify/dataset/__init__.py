"""Results as netCDF: one file per finished run, one DataTree per study."""
