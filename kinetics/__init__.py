"""The inelastic Lorentz equation on a discretised velocity space."""
