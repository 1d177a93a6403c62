"""Wind pump: turbine, transmissions with a driven shaft, pumps, pipe."""
