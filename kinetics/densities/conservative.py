r"""Solves for a harmonic of the velocity density conservatively: for steps, peaks and noisy tables.

The state is a set of masses at equidistant x = ln v (`node_masses`). A bounce takes a mass at v to
s v, which is shared between the two nodes around it so that mass and energy are exactly those of
the bounce. l is the mean free path, lambda(p) = 1 - E[s^p]. Nodes lose mass at the rate v/l. The
exponential of this linear system is a sum of non-negative terms (`uniformisation`): no mass is ever
below 0, their sum is kept to rounding, and the energy obeys d<v^2>/dt = -lambda(2) <v^3>/l with the
exact lambda(2). Second order in the spacing.

Near steps and infinities of f no nodes give f itself. What is kept to rtol is the share of the
tracers that are slower than v, for every v. Its error is the difference of two spacings, times a
stated factor. Begin with :func:`solve_conservative`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinetics.collision import CollisionLaw
from kinetics.densities.harmonic import HarmonicArray, HarmonicProblem, Profile
from kinetics.densities.node_masses import NodeMasses, deposit
from kinetics.densities.uniformisation import CollidingMasses
from kinetics.errors import InputError
from kinetics.numerics import FOLDS, LARGEST_LOG, FloatArray
from kinetics.numerics.gauss import panels_between
from kinetics.states.state import LogMeasure, State

#: First spacing in ln v that is tried; each next one is half of the one before. Chosen: with half
#: or twice of it the same last spacing is found.
COARSEST_SPACING = 0.128
#: Finest spacing that the solver chooses by itself: after eight halvings. Chosen: the limit of the
#: work often ends the halvings before.
FINEST_SPACING = COARSEST_SPACING / 2**8
#: Margin, for rounding, by which a spacing is taken to be the finest one. Chosen: spacings differ
#: by factors of two.
SPACING_MARGIN = 1.01
#: The error over the difference of two spacings from sharp speeds. The first bounces make inverse
#: square roots, whose distribution function converges as sqrt(h). Derived: 1/(sqrt(2) - 1) = 2.4,
#: and more where the front lies badly between the nodes.
SAFETY_OF_SHARP_START = 4.0
#: The same from densities. Derived: steps and kinks converge as h at least: 1, with a margin of 2.
SAFETY_OF_DENSITY = 2.0
#: Errors are relative to the share of tracers that have left a single speed, or to this share,
#: whichever is larger. Chosen: at t = 0 none have.
LEAST_SHARE_OF_ERROR = 1e-9
#: Least error of the points that represent a start: they need not be better known. Chosen:
#: at half and at twice shares of flights and of slow tracers move by 2e-6 (e = 0.7, rtol
#: 1e-3).
MAX_RTOL_OF_START = 1e-6
#: The axis ends so many e-folds below the slowest speed that matters, l/t, or the slowest one of
#: the start. Chosen: at half the shares of tracers slower than v move by 3e-15 (e = 0 and 0.7, one
#: speed and a table with edges, t up to 1e3, rtol 1e-2), with 0.7 of the nodes.
DEPTH_OF_AXIS = 12.0
#: Nodes on top of those that span the axis: an empty one above the fastest tracers, and both ends.
#: Derived.
MORE_NODES = 3
#: Radians of s^z on one cell, z a wave number, so that the losses of the collision quadrature lie a
#: tenth of a cell apart. Chosen. At half and at twice these shares move by 2e-6.
RADIANS_PER_CELL = 16.0
#: Equal pieces into which a cell is cut, for the steps of a density. Chosen: at half and at twice
#: these shares move by 3e-4 and 2e-4, the estimates being 7e-3 to 2e-2.
PIECES_OF_CELL = 8
#: Gauss points of such a piece. Chosen: with 2 and with 8 these shares move by 3e-6 and 4e-4.
PIECE_POINTS = 4
#: If the cells catch less than this fraction of the mass of the start, its density lies between
#: their Gauss points, and its own points are shared between the nodes instead. The origin is not
#: recorded: any start that the cells resolve is caught nearly as a whole.
LEAST_MASS_OF_CELLS = 0.5
#: Path in mean free paths that stands for 0 in a logarithm: close to the smallest number.
TINY_PATH = 1e-300


@dataclass(frozen=True)
class _ConservativeProblem:
    """A harmonic problem, and what all spacings of its solution have in common.

    Parameters
    ----------
    law, state, m : of the harmonic problem
    start : harmonic m of the state as weighted points
    paths : times in l/U, shape (n_times,)
    span : length of the axis in ln v
    """

    law: CollisionLaw
    state: State
    m: int
    start: LogMeasure
    paths: FloatArray
    span: float

    @classmethod
    def of(cls, problem: HarmonicProblem) -> _ConservativeProblem:
        """Represent the start by points, and choose the length of the axis."""
        start = problem.state.harmonic(problem.m, min(problem.rtol, MAX_RTOL_OF_START))
        assert start is not None  # harmonics that are zero are not asked for
        paths = problem.times / problem.mean_free_path
        log_fastest = float(start.x.max())
        log_slowest = min(float(start.x.min()), log_fastest)
        log_slowest_that_collide = -math.log(max(float(paths[-1]), TINY_PATH))
        lowest = min(log_slowest, log_slowest_that_collide) - DEPTH_OF_AXIS
        span = min(log_fastest - lowest, LARGEST_LOG)
        return cls(problem.law, problem.state, problem.m, start, paths, span)

    @property
    def has_density(self) -> bool:
        """Whether the start is a density, not sharp speeds."""
        return self.state.profile(0) is not None

    @property
    def has_one_speed(self) -> bool:
        """Whether the start is one point, whose uncollided tracers are kept apart."""
        return self.start.x.size == 1

    @property
    def log_fastest(self) -> float:
        """Largest ln v of the points of the start."""
        return float(self.start.x.max())

    def uncollided_peak(self) -> HarmonicArray:
        """Return the weight of a single speed that has not collided, shape (n_times,)."""
        rate = math.exp(self.log_fastest)
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(self.start.weight[0] * np.exp(-rate * self.paths))


def solve_conservative(problem: HarmonicProblem) -> Profile:
    """Solve for the harmonic at the times, for a start of any kind, e < 1.

    Returns
    -------
    The profile, with the masses at the nodes as its density. Its error estimate is relative to the
    share of tracers that have left the single speed of the start, if that is what the start is.

    Raises
    ------
    InputError
        Where following the state would take too long; at a finite density; and for sharp speeds
        under laws of single ratios, which make delta peaks only.
    """
    _refuse_what_has_no_density(problem)
    conservative = _ConservativeProblem.of(problem)
    masses, error = _halve_until_converged(conservative, problem)
    peak_speed = None
    peak_weight = None
    if conservative.has_one_speed:
        peak_speed = math.exp(conservative.log_fastest)
        peak_weight = conservative.uncollided_peak()
    return Profile(
        density=masses,
        count=problem.times.size,
        method="conservative",
        nodes=masses.x.size,
        error_estimate=error,
        peak_speed=peak_speed,
        peak_weight=peak_weight,
    )


def _refuse_what_has_no_density(problem: HarmonicProblem) -> None:
    """Raise InputError for starts that this method cannot follow."""
    if problem.law.returns(0)[0]:
        raise InputError("initial: at a finite density, speed densities need a smooth start")
    if problem.state.profile(0) is None and problem.law.has_atoms:
        raise InputError(
            "initial: from sharp speeds, bounces that take single shares of the speed (samples, "
            "et = e) make delta peaks and no density; give a SpeedTable, or ask for averages"
        )


def _halve_until_converged(
    conservative: _ConservativeProblem, problem: HarmonicProblem
) -> tuple[NodeMasses, float]:
    """Halve the spacing until two solutions agree; return the last one and its error estimate.

    With a requested number of nodes there are two: that number, and half of it.
    """
    spacing = COARSEST_SPACING
    finest = FINEST_SPACING
    if problem.nodes:
        spacing = 2.0 * conservative.span / problem.nodes
        finest = conservative.span / problem.nodes
    safety = SAFETY_OF_DENSITY if conservative.has_density else SAFETY_OF_SHARP_START
    reference_share = np.ones(conservative.paths.size)
    if conservative.has_one_speed:
        rate = math.exp(conservative.log_fastest)
        reference_share = -np.expm1(-rate * conservative.paths)
    reference_share = np.maximum(reference_share, LEAST_SHARE_OF_ERROR)
    masses = _solve_with_spacing(conservative, spacing)
    error = math.inf
    while masses is not None and error > problem.rtol and spacing > SPACING_MARGIN * finest:
        spacing = 0.5 * spacing
        finer_masses = _solve_with_spacing(conservative, spacing)
        if finer_masses is None:
            break
        difference = _distribution_difference(masses, finer_masses)
        error = safety * float(np.max(difference / reference_share))
        masses = finer_masses
    if masses is None or error == math.inf:
        raise InputError(
            f"times: got up to {problem.times[-1]:g} at {problem.law.described}; the conservative "
            "method would take too long, ask for earlier times, fewer nodes, or averages only"
        )
    return masses, error


def _solve_with_spacing(conservative: _ConservativeProblem, spacing: float) -> NodeMasses | None:
    """Return the masses at the times with this spacing; None where it would take too long."""
    start = conservative.start
    x = _nodes(conservative, spacing)
    start_mass = _start_masses(conservative, x, spacing)
    arrival_shares = _arrival_shares(conservative.law, conservative.m, spacing)
    # these begin with the fastest node
    colliding = CollidingMasses(np.exp(x)[::-1], arrival_shares, start_mass[::-1].copy())
    mass = np.empty((conservative.paths.size, x.size), dtype=start_mass.dtype)
    durations = np.diff(conservative.paths, prepend=0.0)
    for i, duration in enumerate(map(float, durations)):
        colliding.advance(duration)
        if colliding.takes_too_long:
            return None
        mass[i] = colliding.mass[::-1]
    uncollided = None
    if conservative.has_one_speed:
        # those that have not collided are known, and left out; they are at the last node but one
        with np.errstate(under="ignore"):
            mass[:, -2] -= conservative.uncollided_peak()
        if colliding.is_positive:
            mass[:, -2] = np.maximum(mass[:, -2], 0.0)  # what is below is rounding
    elif start.x.size > 1 and not conservative.has_density:
        with np.errstate(under="ignore"):
            uncollided = start_mass * np.exp(-np.outer(conservative.paths, np.exp(x)))
    mass.flags.writeable = False  # so that NodeMasses needs no copy
    return NodeMasses(x, spacing, mass, uncollided)


def _nodes(conservative: _ConservativeProblem, spacing: float) -> FloatArray:
    """Return the nodes of ln v: one empty node above the fastest tracers, the others below."""
    count = math.ceil(conservative.span / spacing) + MORE_NODES
    log_fastest = conservative.log_fastest
    if conservative.has_density:
        # a density may go on beyond its last Gauss point, by less than that is from the one before
        last_two_points = np.sort(conservative.start.x)[-2:]
        log_fastest += spacing + float(np.diff(last_two_points).sum())
    return log_fastest + spacing * np.arange(2 - count, 2, dtype=float)


def _start_masses(
    conservative: _ConservativeProblem, nodes: FloatArray, spacing: float
) -> HarmonicArray:
    """Return the start at the nodes: from its density cell by cell, or point by point."""
    start = conservative.start
    density = conservative.state.profile(conservative.m)
    if density is None:
        return deposit(start, nodes, spacing)
    n_pieces = PIECES_OF_CELL * (nodes.size - 1)
    edges = np.linspace(nodes[0], nodes[-1], n_pieces + 1)
    x, weight = panels_between(edges, PIECE_POINTS)
    v = np.exp(x)
    mass = deposit(LogMeasure(x, weight * v * density(v)), nodes, spacing)
    if conservative.m:
        return mass
    total = float(mass.sum())
    expected_total = float(start.weight.sum())
    if total < LEAST_MASS_OF_CELLS * expected_total:
        return deposit(start, nodes, spacing)
    # scaled to the mass of the start: some lies beyond the axis, or between the Gauss points
    return mass * (expected_total / total)


def _arrival_shares(law: CollisionLaw, m: int, spacing: float) -> FloatArray:
    """Return the share of a node's bounces that arrive k nodes below, times cos(m chi), (n_k,)."""
    bounces = law.quadrature_for(RADIANS_PER_CELL / spacing)
    log_loss = np.minimum(bounces.log_loss, FOLDS)
    cosines = 1.0 - bounces.harmonic_loss(m)
    last = math.ceil(float(log_loss.max()) / spacing) + 1
    nodes = spacing * np.arange(-last, 1.0)
    shares = deposit(LogMeasure(-log_loss, bounces.weight * cosines), nodes, spacing)
    return np.asarray(shares[::-1])


def _distribution_difference(coarse: NodeMasses, fine: NodeMasses) -> FloatArray:
    """Return the largest difference of two distribution functions over all speeds, (n_times,)."""
    differences = []
    for i, fine_mass in enumerate(fine.mass):
        coarse_mass = coarse.per_log_speed(i, fine.x) * fine.spacing
        differences.append(coarse_mass - fine_mass)
    difference = np.array(differences)
    # the trapezoid rule, from the slowest node on
    distribution = np.cumsum(0.5 * (difference[:, 1:] + difference[:, :-1]), axis=1)
    return np.asarray(np.abs(distribution).max(axis=1))
