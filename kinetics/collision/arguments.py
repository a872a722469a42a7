"""The law that the arguments of a scene mean: as the solvers take them, checked."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from kinetics.collision.law import CollisionLaw
from kinetics.collision.medium import HIGHEST_DENSITY, ORDERS, SCATTERERS, Medium, MediumLaw
from kinetics.errors import InputError
from kinetics.validation import check_positive, one_of, refuse

_TINY = 1e-300  # densities below it are beyond the range of doubles


def law_of(restitution: Any, tangential_restitution: Any = 1.0, dimension: Any = 2) -> CollisionLaw:
    """The law of these arguments, as the solvers take them.

    ``restitution`` may be a CollisionLaw itself; the other two are its own then, and need not be
    given. Raises InputError for arguments out of range, and for a law that gains energy.
    """
    if not isinstance(restitution, CollisionLaw):
        arguments = restitution, tangential_restitution, dimension
        plain = tuple(map(type, arguments)) == (float, float, int)
        return _kept_law(*arguments) if plain else CollisionLaw(*arguments)
    law = restitution
    for name, value, default in (
        ("tangential_restitution", tangential_restitution, 1.0),
        ("dimension", dimension, 2),
    ):
        if value is not None and value not in (default, getattr(law, name)):
            refuse(name, value, f"restitution is a law, in which it is {getattr(law, name)}")
    if law.least_loss < 0.0:
        largest = math.exp(-law.least_loss)
        raise InputError(
            f"restitution: got a law with speed ratios up to {largest:.6g}; the solvers need "
            "a tracer that never gains energy (ratios up to 1)"
        )
    return law


@lru_cache(maxsize=16)
def _kept_law(e: float, et: float, dimension: int) -> CollisionLaw:
    """The same law again: its quadratures are not made twice."""
    return CollisionLaw(e, et, dimension)


def law_in_medium(
    law: CollisionLaw, scatterers: Any, number_density: Any, diameter: Any, order: Any = "second"
) -> CollisionLaw:
    """The law among these scatterers; the law itself where they are dilute.

    Raises InputError for unknown names, for a density above 0.3 d^-2, and for laws for which the
    theory is not derived: rough scatterers, spheres, samples.
    """
    scatterers = one_of("scatterers", scatterers, SCATTERERS)
    order = one_of("density_order", order, ORDERS)
    if scatterers == "dilute":
        return law
    if law.dimension != 2 or law.restitution is None or law.tangential_restitution != 1.0:
        allowed = "a finite density is derived for smooth disks in the plane only"
        refuse("scatterers", scatterers, allowed)
    if number_density is None:
        refuse("number_density", number_density, f"scatterers={scatterers!r} needs it")
    rho, d = check_positive("number_density", number_density), check_positive("diameter", diameter)
    n = rho * d * d
    if not _TINY < n <= HIGHEST_DENSITY:
        allowed = f"with scatterers={scatterers!r} it must be at most {HIGHEST_DENSITY:g} d^-2"
        refuse("number_density", number_density, allowed)
    return _kept_in_medium(Medium(scatterers, n, law.restitution, order))


@lru_cache(maxsize=16)
def _kept_in_medium(medium: Medium) -> MediumLaw:
    """The same law again: its quadratures are not made twice."""
    return MediumLaw(medium.restitution, 1.0, 2, None, medium)
