"""Fronts of speed densities: speeds at which the density from sharp speeds is not smooth.

f is the density of the speed; it steps, or is infinite, at speeds to which sharp speeds are brought
by head-on or grazing collisions, where the loss -ln s is an extremum. Begin with
:func:`speed_fronts`.
"""

from __future__ import annotations

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.numerics import FloatArray
from kinetics.states.state import LogMeasure


def speed_fronts(law: CollisionLaw, start: LogMeasure) -> FloatArray:
    """Return the speeds at which f may step or be infinite, from a start of sharp speeds.

    They are those of the start, and the ends of the ranges to which one and two collisions bring
    them; later collisions leave weaker kinks.

    Parameters
    ----------
    law : collision law of the tracer
    start : the sharp speeds

    Returns
    -------
    Speeds in U, rising, shape (n,); none for elastic tracers, which keep their speeds.
    """
    if law.is_elastic:
        return np.zeros(0)
    after_one = [-loss for loss in law.loss_ends]
    after_two = np.add.outer(after_one, after_one).ravel()
    log_ratios = np.unique([0.0, *after_one, *after_two])
    speeds = np.exp(np.add.outer(np.unique(start.x), log_ratios).ravel())
    return np.unique(speeds[speeds > 0.0])
