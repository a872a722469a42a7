"""Files of particle data, read in pieces and reduced to one sample."""
