"""One table of symbols: what stands for what, with its assumptions and its meaning.

Every derivation and every printed formula takes its symbols from here, so that two formulas
which name the same thing hold the same sympy object. Vectors are commuting symbols that only ever
stand inside :func:`derivations.formal.dot`, as arguments, or as one factor of a vector equation;
the gradient is the symbol ``nabla``: it commutes with all that does not depend on position, which
is all that the paper's expansions ask of it.
"""

from __future__ import annotations

import sympy as sp
from sympy.core.function import UndefinedFunction

_MEANINGS: dict[str, str] = {}


def _real(name: str, meaning: str) -> sp.Symbol:
    _MEANINGS[name] = meaning
    return sp.Symbol(name, real=True)


def _positive(name: str, meaning: str) -> sp.Symbol:
    _MEANINGS[name] = meaning
    return sp.Symbol(name, positive=True)


def _vector(name: str, meaning: str) -> sp.Symbol:
    _MEANINGS[name] = meaning
    return sp.Symbol(name)


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
t = _positive("t", "time")
t1 = _positive("t'", "time, as integration variable")
dt = _positive("delta_t", "a short time")

# --- vectors
br = _vector(r"\mathbf{r}", "position")
bv = _vector(r"\mathbf{v}", "velocity, after the collision where there is one")
bvs = _vector(r"\mathbf{v}^{*}", "precollision velocity")
bvp = _vector(r"\mathbf{v}'", "postcollision velocity")
bvh = _vector(r"\hat{\mathbf{v}}", "direction of the velocity")
bc = _vector(r"\mathbf{c}", "velocity over the thermal velocity")
bcs = _vector(r"\mathbf{c}^{*}", "scaled precollision velocity")
bl = _vector(r"\mathbf{l}", "hopping vector")
sigma = _vector(r"\hat{\sigma}", "unit vector from the scatterer to the tracer")
nabla = _vector(r"\nabla", "gradient in position")
nabla0 = _vector(r"\nabla^{(0)}", "gradient in position, first order in epsilon")
nabla1 = _vector(r"\nabla^{(1)}", "gradient in position, second order in epsilon")
hemi = _vector(r"\mathbf{v}\cdot\hat{\sigma}>0", "the half circle of possible sigma")
hemi_c = _vector(r"\mathbf{c}\cdot\hat{\sigma}>0", "the half circle of possible sigma")

# --- one collision
y = _real("y", "impact parameter in units of d, uniform on [-1, 1]")
theta = _real("theta", "angle between velocity and the line of centres")
b = _real("b", "impact parameter")
psi = _real("psi", "angle between the precollision velocity and sigma")
s = _positive("s", "speed ratio |v'|/|v| of one collision")
p = _positive("p", "order of a moment")
j = _positive("j", "order of an expansion")
Brate = _function("B", "rate of collisions per unit angle of sigma, over rho_0")

# --- velocities and distributions
v = _positive("v", "speed")
vs = _positive("v^{*}", "precollision speed")
vh = _positive("|vhat|", "length of the direction vector, one")
c = _positive("c", "scaled speed v/v0(t)")
cp = _positive("c'", "scaled postcollision speed")
x = _positive("x", "argument of a Sonine polynomial")
v0 = _function("v_0", "thermal velocity, the square root of <v^2>", positive=True)
T = _function("T", "temperature m v0^2/2", positive=True)
f = _function("f", "velocity distribution")
fa2 = _function("f_{a_2}", "velocity distribution in the first Sonine approximation")
F = _function("F", "scaled velocity distribution")
phi = _function("phi", "Gaussian exp(-c^2)/pi")
S = _function("S", "Sonine polynomial S(p, x)")
I_ = _function("I", "dimensionless collision integral")
pd = _function("p", "distribution of position and velocity; p(V, R): exponent of the integrand")
p0 = _function("p^{(0)}", "its zeroth order")
p1 = _function("p^{(1)}", "its first order")
p2 = _function("p^{(2)}", "its second order")
pj = _function("p^{(j)}", "its order j")
X = _function("X", "any function of the velocity")
Y = _function("Y", "any function of the velocity")

# --- cooling and Sonine coefficients
h = _positive("h", "dimensionless cooling rate h(e)")
M2 = _positive("M_2", "second moment of the scaled collision integral")
M4 = _positive("M_4", "fourth moment of the scaled collision integral")
Mp = _positive("M_p", "p-th moment of the scaled collision integral")
a1 = _real("a_1", "first Sonine coefficient")
a2 = _real("a_2", "second Sonine coefficient")
a = _function("a", "Sonine coefficient a(p)", real=True)
a2bar = _real(r"\bar{a}_2", "stationary second Sonine coefficient")
a2t = _function("a_2", "second Sonine coefficient over time", real=True)
da2 = _function(r"\delta a_2", "departure of a_2 from its stationary value", real=True)
H = _real("H", "growth rate of a perturbation of a_2, up to a positive factor")
pm = _real("pm", "plus or minus one: the branch of a square root")
pprime = _positive("p'", "order of a second polynomial")
alpha = _positive("alpha", "1/v0(0)")
beta = _positive("beta", "d rho_0 h(e)")

# --- random walk and Chapman-Enskog
N = _positive("N", "number of collisions")
tau = _function("tau", "time between collision N-1 and collision N", positive=True)
tc = _function("t", "time of collision N")
k = _positive("k", "summation index")
eps = _positive("epsilon", "formal expansion parameter")
nd = _function("n", "density of the tracer")
J = _function(r"\mathbf{J}", "flux of the tracer")
J0 = _function(r"\mathbf{J}^{(0)}", "its zeroth order")
J1 = _function(r"\mathbf{J}^{(1)}", "its first order")
Jj = _function(r"\mathbf{J}^{(j)}", "its order j")
Bv = _function(r"\mathbf{B}", "p^(1) per density gradient")
De = _function("D_e", "diffusion coefficient", positive=True)
nuD = _positive("nu_D", "relaxation rate of the flux")
xi = _function("xi", "cooling rate of the temperature, 2 d rho_0 h v0(t)", positive=True)
msd = _function(r"\langle r^{2}\rangle_{e}", "mean square displacement", positive=True)
msd1 = _function(r"\langle r^{2}\rangle", "mean square displacement, elastic", positive=True)
mn = _function("m", "f summed over directions at one speed")
delta = _function("delta", "Dirac's delta")
Gamma_minus, Gamma_plus, Gamma_flow = (
    _vector(rf"\Gamma_{{{name}}}", f"change of p dr dv in a short time: {meaning}")
    for name, meaning in (("-", "loss"), ("+", "gain"), (r"\mathrm{flow}", "streaming"))
)

# --- distribution of position
R = _positive("R", "distance over the root of the mean square displacement")
r = _positive("r", "distance from the start")
V = _positive("V", "scaled hopping velocity")
Vbar = _positive(r"\bar{V}", "a constant in place of V")
Vs = _positive("V^{*}", "the V at which the integrand has its saddle")
tau1 = _positive("tau", "time between two collisions")
eta = _positive("eta", "the paper's parameter of G(R)")
gamma = _positive("gamma", "the paper's fitted prefactor")
kappa_d = _positive("kappa", "the paper's undetermined prefactor of D_e(V, t)")
g = _function("g", "radial density of position, elastic")
ge = _function("g_e", "radial density of position")
gt = _function(r"\tilde{g}_e", "radial density of position at one hopping velocity")
G = _function("G", "scaled radial density of position")
Gt = _function(r"\tilde{G}", "scaled radial density of position at one hopping velocity")

# --- exact theory
cos_chi = _real(r"\langle\cos\chi\rangle", "mean cosine of the deflection angle")
klog = _positive(r"\kappa_{\ln}", "mean log loss E[-ln s]")
lam = _function("lambda", "loss of |v|^p per collision, E[1 - s^p]", positive=True)


def meaning(name: str) -> str:
    """What the symbol or function of this name stands for; KeyError if it is not in the table."""
    return _MEANINGS[name]


def table() -> tuple[tuple[str, str], ...]:
    """All symbols as (name, meaning), sorted by name."""
    return tuple(sorted(_MEANINGS.items()))
