"""Particle data, from any code, held against the kinetic equation."""
