"""One table of symbols: what stands for what, with its assumptions and its meaning.

Every derivation and every printed formula takes its symbols from here, so that two formulas
which name the same thing hold the same sympy object. Vectors are commuting symbols that only ever
stand inside :func:`derivations.formal.dot`, as arguments, or as one factor of a vector equation;
the gradient is the symbol ``nabla``: it commutes with all that does not depend on position, which
is all that the paper's expansions ask of it.
"""

from __future__ import annotations

from functools import partial

import sympy as sp
from sympy.core.function import UndefinedFunction

_MEANINGS: dict[str, str] = {}
LATEX: dict[str, str] = {}
"""LaTeX of the names that sympy would not typeset as the paper does."""


def _symbol(name: str, meaning: str, latex: str = "", **assumptions: bool) -> sp.Symbol:
    _enter(name, meaning, latex)
    return sp.Symbol(name, **assumptions)


def _function(name: str, meaning: str, latex: str = "", **assumptions: bool) -> UndefinedFunction:
    _enter(name, meaning, latex)
    return sp.Function(name, **assumptions)


def _enter(name: str, meaning: str, latex: str) -> None:
    """Write a name into the table of symbols."""
    _MEANINGS[name] = meaning
    if latex:
        LATEX[name] = latex


_vector = _symbol
_real = partial(_symbol, real=True)
_positive = partial(_symbol, positive=True)
_positive_function = partial(_function, positive=True)


# --- the system
e = _positive("e", "coefficient of restitution")
et = _positive("e_t", "coefficient of tangential restitution, one in the paper")
d = _positive("d", "diameter of a disk or a sphere (tracer and scatterer)")
dim = _positive("D", "number of dimensions: 2 in the plane, 3 in space")
rho0 = _positive("rho_0", "number density of the scatterers")
l = _positive("l", "mean free path 1/(2 d rho_0), in space 1/(pi d^2 rho_0)")  # noqa: E741
m = _positive("m", "mass of the tracer")
n = _positive("n", "mean density of the tracer")
t = _positive("t", "time")
t1 = _positive("t'", "time, as integration variable")
dt = _positive("dt", "a short time", latex=r"\delta t")

# --- vectors
br = _vector("r_vec", "position", latex=r"\mathbf{r}")
bv = _vector("v_vec", "velocity, after the collision where there is one", latex=r"\mathbf{v}")
bvs = _vector("v_vec_pre", "precollision velocity", latex=r"\mathbf{v}^{*}")
bvp = _vector("v_vec_post", "postcollision velocity", latex=r"\mathbf{v}'")
bvh = _vector("v_hat", "direction of the velocity", latex=r"\hat{\mathbf{v}}")
bc = _vector("c_vec", "velocity over the thermal velocity", latex=r"\mathbf{c}")
bcs = _vector("c_vec_pre", "scaled precollision velocity", latex=r"\mathbf{c}^{*}")
bl = _vector("l_vec", "hopping vector", latex=r"\mathbf{l}")
sigma = _vector("sigma_hat", "unit vector from the scatterer to the tracer", latex=r"\hat{\sigma}")
nabla = _vector("nabla", "gradient in position", latex=r"\nabla")
nabla0 = _vector("nabla_0", "gradient in position, first order in epsilon", latex=r"\nabla^{(0)}")
nabla1 = _vector("nabla_1", "gradient in position, second order in epsilon", latex=r"\nabla^{(1)}")
hemi = _vector("v.sigma > 0", "half circle of sigma", latex=r"\mathbf{v}\cdot\hat{\sigma}>0")
hemi_c = _vector("c.sigma > 0", "half circle of sigma", latex=r"\mathbf{c}\cdot\hat{\sigma}>0")

# --- one collision
y = _real("y", "impact parameter in units of d: uniform on [-1, 1]; in space y^2 on [0, 1]")
theta = _real("theta", "angle between velocity and the line of centres")
chi = _real("chi", "deflection angle, between the velocities before and after a collision")
chance = _function("P", "probability density of its argument over one collision")
b = _real("b", "impact parameter")
psi = _real("psi", "angle between the precollision velocity and sigma")
s = _positive("s", "speed ratio |v'|/|v| of one collision")
p = _positive("p", "order of a moment")
j = _positive("j", "order of an expansion")
Brate = _function("B", "rate of collisions per unit angle of sigma, over rho_0")

# --- velocities and distributions
v = _positive("v", "speed")
vs = _positive("v_pre", "precollision speed", latex=r"v^{*}")
vh = _positive("|v_hat|", "length of the direction vector, one", latex=r"|\hat{\mathbf{v}}|")
c = _positive("c", "scaled speed v/v0(t)")
cp = _positive("c'", "scaled postcollision speed")
x = _positive("x", "argument of a Sonine polynomial")
v0 = _positive_function("v_0", "thermal velocity, the square root of <v^2>")
T = _positive_function("T", "temperature m v0^2/2")
f = _function("f", "velocity distribution")
fa2 = _function("f_a2", "velocity distribution in the first Sonine approximation", latex=r"f_{a_2}")
F = _function("F", "scaled velocity distribution")
phi = _function("phi", "Gaussian exp(-c^2)/pi")
S = _function("S", "Sonine polynomial S(p, x)")
I_ = _function("I", "dimensionless collision integral")
pd = _function("p", "distribution of position and velocity; p(V, R): exponent of the integrand")
p0 = _function("p_0", "distribution of position and velocity: zeroth order", latex=r"p^{(0)}")
p1 = _function("p_1", "distribution of position and velocity: first order", latex=r"p^{(1)}")
p2 = _function("p_2", "distribution of position and velocity: second order", latex=r"p^{(2)}")
pj = _function("p_j", "distribution of position and velocity: order j", latex=r"p^{(j)}")
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
a2bar = _real("a2_bar", "stationary a_2", latex=r"\bar{a}_2")
a2t = _function("a_2", "second Sonine coefficient over time", real=True)
da2 = _function("delta_a2", "departure of a_2 from that", latex=r"\delta a_2", real=True)
H = _real("H", "growth rate of a perturbation of a_2, up to a positive factor")
pm = _real("pm", "plus or minus one: the branch of a square root", latex=r"\pm")
pprime = _positive("p'", "order of a second polynomial")
alpha = _positive("alpha", "1/v0(0)")
beta = _positive("beta", "d rho_0 h(e)")

# --- random walk and Chapman-Enskog
N = _positive("N", "number of collisions")
tau = _positive_function("tau", "time between collision N-1 and collision N")
tc = _function("t", "time of collision N")
k = _positive("k", "summation index")
eps = _positive("epsilon", "formal expansion parameter")
nd = _function("n", "density of the tracer")
J = _function("J_vec", "flux of the tracer", latex=r"\mathbf{J}")
J0 = _function("J_vec_0", "flux of the tracer: zeroth order", latex=r"\mathbf{J}^{(0)}")
J1 = _function("J_vec_1", "flux of the tracer: first order", latex=r"\mathbf{J}^{(1)}")
Jj = _function("J_vec_j", "flux of the tracer: order j", latex=r"\mathbf{J}^{(j)}")
Bv = _function("B_vec", "p^(1) per density gradient", latex=r"\mathbf{B}")
De = _positive_function("D_e", "diffusion coefficient")
nuD = _positive("nu_D", "relaxation rate of the flux")
xi = _positive_function("xi", "cooling rate of the temperature, 2 d rho_0 h v0(t)")
msd = _positive_function("msd_e", "mean square displacement", latex=r"\langle r^{2}\rangle_{e}")
msd1 = _positive_function("msd", "mean square displacement, elastic", latex=r"\langle r^{2}\rangle")
mn = _function("m", "f summed over directions at one speed")
delta = _function("delta", "Dirac's delta")
Gamma_minus = _vector("Gamma_loss", "change of p dr dv in a short time: loss", r"\Gamma_{-}")
Gamma_plus = _vector("Gamma_gain", "change of p dr dv in a short time: gain", r"\Gamma_{+}")
Gamma_flow = _vector("Gamma_flow", "the same by free flight", r"\Gamma_{\mathrm{flow}}")

# --- distribution of position
R = _positive("R", "distance over the root of the mean square displacement")
r = _positive("r", "distance from the start")
V = _positive("V", "scaled hopping velocity")
Vbar = _positive("V_bar", "a constant in place of V", latex=r"\bar{V}")
Vs = _positive("V_saddle", "the V at which the integrand has its saddle", latex=r"V^{*}")
tau1 = _positive("tau", "time between two collisions")
eta = _positive("eta", "the paper's parameter of G(R)")
gamma = _positive("gamma", "the paper's fitted prefactor")
kappa_d = _positive("kappa", "the paper's undetermined prefactor of D_e(V, t)")
g = _function("g", "radial density of position, elastic")
ge = _function("g_e", "radial density of position")
gt = _function("g_e_tilde", "the same at one hopping velocity", latex=r"\tilde{g}_e")
G = _function("G", "scaled radial density of position")
Gt = _function("G_tilde", "the same at one hopping velocity", latex=r"\tilde{G}")

# --- displacement in any dimension
msdN = _function("msd_N", "<r^2> after N collisions", latex=r"\langle r^{2}\rangle_{N}")
zeta = _positive("zeta", "v t/l with v the speed at the start")
chi1 = _function("chi_1", "displacement along the initial direction, over l")
rho2 = _function("rho_2", "<r^2>/l^2 of tracers that start with one speed")
rho4 = _function("rho_4", "<r^4>/l^4 of tracers that start with one speed")
laplace = _positive("z", "variable of the Laplace transform in zeta")
rho4z = _function("rho_4_tilde", "Laplace transform of rho_4 in zeta", latex=r"\tilde{\rho}_4")
wave = _positive("K", "wave number times l")
Fhat = _function("F_hat", "Fourier and Laplace transform of g", latex=r"\hat{F}")
nu1 = _positive("nu_1", "decay rate of the first harmonic, 1 - E[cos(chi)]")
nu2 = _positive("nu_2", "decay rate of the second harmonic")
S2 = _function("S_2", "second harmonic of <exp(i k.r)>, of order k^2, in units of l^2")
W1 = _function("W_1", "first harmonic of <exp(i k.r)>, of order k^3, in units of l^3")

# --- scatterers that are met again, at a finite density
harm = _vector("m_phi", "order of an angular harmonic", latex="m", integer=True, nonnegative=True)
lamm = _positive("lambda_m", "loss of v^p exp(i m phi) per collision, 1 - E[s^p cos(m chi)]")
lamd = _positive("lambda_m_rho", "the same among scatterers of a finite density")
back = _positive("P_pi", "probability density of the deflection at pi, per radian")
ret = _positive("epsilon_B", "chance per collision to be thrown back to the scatterer before")
retR = _function("epsilon_R", "the same from the distance R, per unit of R")
dist = _positive("R_12", "distance of two scatterers", latex="R")
offset = _positive("delta_y", "distance of the way back from the way out, over d")
damp = _positive("a_l", "scatterers met on the way out and back, over R/l")
loop = _positive("y_l", "path of a loop, there and back, over l", latex="y")
loop0 = _positive("a_y", "the shortest loop, over l, which is not flown", latex="a")
lost = _positive("c_y", "mean of a_l/2: how fast loops become fewer with their path", latex="c")
pathz = _positive("z_x", "variable of the Laplace transform in the path over l", latex="z")
retz = _function("epsilon_z", "Laplace transform of the chance of a loop", latex=r"\epsilon_z")
Lnest = _real("L", "logarithm by which a nested ring differs from a single return")
ln = _positive("l_rho", "mean free path at a finite density")
coefA = _function("A", "coefficient of n ln(1/n) in the slope of the displacement, n = rho_0 d^2")
free = _function("G_0", "harmonic m of one free flight in Fourier space")
tail = _function("F_j", "what the harmonics from j on do to the one before")
prop = _positive("R_mm", "harmonic m of the propagator in Fourier space")
lamj = _function("lambda_j", "loss of harmonic j per collision")

# --- exact theory
q = _positive("q", "half of an even order")
cos_chi = _real("cos_chi", "mean cosine of the deflection angle", latex=r"\langle\cos\chi\rangle")
klog = _positive("kappa_ln", "mean log loss E[-ln s]", latex=r"\kappa_{\ln}")
lam = _positive_function("lambda", "loss of |v|^p per collision, E[1 - s^p]")
MY = _positive_function("M_Y", "moment E[Y^p] of Y = lim v t/l")
VarN = _positive("Var_N", "growth of Var N(t) per ln t", latex=r"d\,\mathrm{Var}\,N/d\ln t")
VarX = _positive("Var_X", "growth of Var X(t) per ln t", latex=r"d\,\mathrm{Var}\,X/d\ln t")
gap = _positive("delta", "1 - e")
width2 = _positive("w2", "relative variance of the speed", latex=r"w^2")
power = _real("power", "power of c in the tail of F")
rate = _positive("rate", "rate of the exponential in the tail of F")
slope = _positive("slope", "d<r^2>/d ln t over l^2")
norm = _positive("norm", "integral of G(R) over R")
flatness = _positive("flatness", "<R^4>/<R^2>^2")

# --- a uniform field along z, beyond the paper; lengths in l, accelerations in that of the field
f0 = _function("f_0", "harmonic 0 of the velocity distribution about the field")
f1 = _function("f_1", "harmonic 1 of the velocity distribution about the field")
f2 = _function("f_2", "harmonic 2 of the velocity distribution about the field")
f3 = _function("f_3", "harmonic 3 of the velocity distribution about the field")
row0 = _function("row_0", "harmonic 0 of the derivative of f by v_z")
row1 = _function("row_1", "harmonic 1 of the derivative of f by v_z")
row2 = _function("row_2", "harmonic 2 of the derivative of f by v_z")
lam1 = _positive_function("lambda_1", "1 - E[s^p cos(chi)], by the order p")
theta_z = _real("theta_z", "angle between the velocity and the field", latex=r"\theta_z")
drift = _positive("u", "drift along the field")
Dperp = _positive("D_perp", "diffusion coefficient across the field", latex=r"D_\perp")
deficit = _positive("epsilon_e", "1 - e^2", latex=r"\epsilon")

# --- scatterers at rest that have a mass, beyond the paper
masses = _positive("A_m", "mass of a scatterer over that of the tracer", latex="A")
relative = _positive("alpha_r", "coefficient of restitution of two masses", latex=r"\alpha")
effective = _real("e_eff", "that of a fixed scatterer with the same effect", latex=r"e^{*}")
least_share = _positive("a_E", "least share of its energy that is left to the tracer", latex="a")
lethargy = _positive("xi_E", "mean loss of ln E in a collision, 2 kappa", latex=r"\xi")

# --- a tracer that spins, beyond the paper
spin = _real("u_s", "speed of the tracer's rim by its spin, radius times angular velocity")
speed_after = _real("v_a", "speed after one collision more", latex="v'")
spin_after = _real("u_a", "speed of the rim by the spin, after it", latex="u'")
rolling = _real(
    "beta_t", "restitution of the tangential velocity of the rim, from -1 to 1", latex=r"\beta"
)
inertia = _positive("k_I", "moment of inertia over mass and radius squared", latex="k")

# --- what drives a tracer, beyond the paper
bath = _positive("w_V", "standard deviation of a component of a scatterer's velocity")
hot = _positive("tau_v", "standard deviation of a component of the tracer's velocity, in a bath")
bath_rate = _function("nu_w", "rate of collisions of a tracer of this speed in a bath, in 1/l")
bath_pull = _function("B_w", "mean of |v - V| (v - V).v over the velocities V of the bath")
collided = _function("L_c", "change of the average of a function of v by collisions, per unit time")
heat = _positive("D_v", "strength of white noise: <dv_i dv_j> = 2 D_v delta_ij dt")
drag = _positive("gamma_v", "rate of a drag, dv/dt = -gamma_v v")
diffusivity = _positive("D_r", "diffusion coefficient of the tracer")
mobility = _positive("mu", "drift over a weak field")
capture = _positive("v_c", "normal impact speed below which a tracer sticks")
depth = _positive("Z_c", "distance along the field in which the share that moves falls by e")


def table() -> tuple[tuple[str, str], ...]:
    """All symbols as (name, meaning), sorted by name."""
    return tuple(sorted(_MEANINGS.items()))
