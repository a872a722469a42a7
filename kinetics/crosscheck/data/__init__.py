"""Anybody's particle data: files (`formats`), one dense form (`tracks`), averages (`sample`)."""
