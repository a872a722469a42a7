"""Anybody's particle data: read (`formats`), as one dense form (`tracks`), as averages (`sample`)."""
