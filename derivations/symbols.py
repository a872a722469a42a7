"""One table of symbols: what stands for what, with its assumptions and its meaning.

Every derivation and every printed formula takes its symbols from here, so that two formulas
which name the same thing hold the same sympy object. Vectors are commuting symbols that only ever
stand inside :func:`dot` or as arguments; the gradient is the symbol ``nabla`` (it commutes with
whatever does not depend on position, which is all that the paper's expansions ask of it).
"""

from __future__ import annotations

import sympy as sp
from sympy.core.function import UndefinedFunction

_MEANINGS: dict[str, str] = {}


def _symbol(name: str, meaning: str, **assumptions: bool) -> sp.Symbol:
    symbol = sp.Symbol(name, **assumptions)
    _MEANINGS[name] = meaning
    return symbol


def _positive(name: str, meaning: str) -> sp.Symbol:
    return _symbol(name, meaning, positive=True)


def _function(name: str, meaning: str, **assumptions: bool) -> UndefinedFunction:
    _MEANINGS[name] = meaning
    return sp.Function(name, **assumptions)


# --- the system
e = _positive("e", "coefficient of restitution")
d = _positive("d", "diameter of a disk (tracer and scatterer)")
rho0 = _positive("rho_0", "number density of the scatterers")
l = _positive("l", "mean free path; 1/(2 d rho_0) in the Boltzmann-Grad limit")  # noqa: E741
m = _positive("m", "mass of the tracer")
n = _positive("n", "mean density of the tracer")
U = _positive("U", "standard deviation of one component of the initial velocity")
t = _positive("t", "time")
t1 = _positive("t'", "time, integration variable")
dt = _positive("delta_t", "a short time")

# --- one collision
y = _symbol("y", "impact parameter in units of d, uniform on [-1, 1]", real=True)
theta = _symbol("theta", "angle between velocity and the line of centres", real=True)
b = _symbol("b", "impact parameter", real=True)
psi = _symbol("psi", "angle between the precollision velocity and sigma", real=True)
s = _positive("s", "speed ratio |v'|/|v| of one collision")
p = _positive("p", "order of a moment")
sigma = _symbol(r"\hat{\sigma}", "unit vector from the scatterer to the tracer")
cos_chi = _symbol("cos_chi", "mean cosine of the deflection angle", real=True)

# --- velocities and distributions
v = _positive("v", "speed")
c = _positive("c", "scaled speed v/v0(t)")
a2 = _symbol("a_2", "second Sonine coefficient", real=True)
a1 = _symbol("a_1", "first Sonine coefficient", real=True)
a2bar = _symbol(r"\bar{a}_2", "stationary second Sonine coefficient", real=True)
a2t = _function("a_2", "second Sonine coefficient over time", real=True)
da2 = _function(r"\delta a_2", "departure of a_2 from its stationary value", real=True)
M2 = _positive("M_2", "second moment of the scaled collision integral")
M4 = _positive("M_4", "fourth moment of the scaled collision integral")
Mp = _positive("M_p", "p-th moment of the scaled collision integral")
h = _positive("h", "dimensionless cooling rate h(e)")
H = _symbol("H", "linear growth rate of a perturbation of a_2, up to a positive factor", real=True)
pm = _symbol("pm", "plus or minus one: the branch of a square root", real=True)
v0 = _function("v_0", "thermal velocity, the square root of <v^2>", positive=True)
T = _function("T", "temperature m v0^2/2", positive=True)

# --- transport
De = _function("D_e", "diffusion coefficient", positive=True)
nuD = _positive("nu_D", "relaxation rate of the flux")
xi = _function("xi", "cooling rate of the temperature, 2 d rho_0 h v0(t)", positive=True)
msd = _function(r"\langle r^2\rangle_e", "mean square displacement", positive=True)

# --- formal pieces of equations
Partial = _function("Partial", "formal derivative Partial(X, T) = dX/dT, not evaluated")
Dot = _function("Dot", "scalar product of two vectors")


def dot(one: sp.Expr, other: sp.Expr) -> sp.Expr:
    """The scalar product, with its two vectors in a fixed order (it is symmetric)."""
    return Dot(*sorted((one, other), key=sp.default_sort_key))


def meaning(name: str) -> str:
    """What the symbol or function of this name stands for; KeyError if it is not in the table."""
    return _MEANINGS[name]


def table() -> tuple[tuple[str, str], ...]:
    """All symbols as (name, meaning), sorted by name."""
    return tuple(sorted(_MEANINGS.items()))
