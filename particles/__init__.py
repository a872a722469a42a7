"""Event-driven particles: the collisions, followed one after another."""
