"""What a map is: arrays, the camera model, and the HDF5 map file."""
