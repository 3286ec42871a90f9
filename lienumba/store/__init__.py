"""One labelled netCDF file: its layout, its provenance, and how it reaches the disk whole or not at all."""
