"""The rule that decides whether a tracer ever leaves a corner, against one bounce after another."""

import numpy as np
import pytest
from marking import slow_but

from particles.events import is_collapsing

BOUNCES = 300
MARGIN = 0.01  # from the boundary of the rule; nearer to it, bounces take too long to decide


def falls_into_the_corner(theta: float, alpha: float, e: float, et: float) -> bool:
    """Bounce between the half-lines at angles 0 and theta from the corner at (0, 0).

    The tracer leaves (1, 0) at the angle alpha with the wall, from the side of the corner. It can
    only strike the other wall, or none: then it has left. Lengths are scaled back to 1 after each
    bounce, and nothing of the rule is used. True if it still bounces after BOUNCES, and the last
    half of them has brought it nearer to the corner; it may also bounce while it runs away.
    """
    walls = np.array([[1.0, 0.0], [np.cos(theta), np.sin(theta)]])
    normals = np.array([[0.0, 1.0], [np.sin(theta), -np.cos(theta)]])
    place, velocity, here = walls[0], np.array([-np.cos(alpha), np.sin(alpha)]), 0
    ln_distance = 0.0
    for bounce in range(BOUNCES):
        here = 1 - here
        wall, normal = walls[here], normals[here]
        approach = velocity @ normal
        if approach >= 0:
            return False
        place = place - (place @ normal) / approach * velocity
        distance = place @ wall
        if distance <= 0:
            return False  # beyond the corner: this half-line is not met
        if bounce >= BOUNCES // 2:
            ln_distance += np.log(distance)
        across = velocity - approach * normal
        velocity = et * across - e * approach * normal
        velocity = velocity / np.hypot(*velocity)
        place = wall
    return ln_distance < 0


def corners(rng: np.random.Generator, n: int) -> np.ndarray:
    """Angles of corners and of directions in them, (n, 2)."""
    # Half of the angles small: there ratios e/et near 1 collapse too.
    theta = rng.uniform(0.01, np.pi - 0.01, n) * rng.choice([1.0, 0.1], n)
    return np.stack((theta, rng.uniform(0.0, np.pi, n)), axis=1)


def rule(rng: np.random.Generator, theta: float, alpha: float, e: float, et: float) -> bool:
    """What the rule says of this corner, turned and mirrored at random."""
    turn, mirror = rng.uniform(0, 2 * np.pi), rng.choice([-1.0, 1.0])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    vectors = [[np.sin(theta), -np.cos(theta)], [0.0, 1.0], [-np.cos(alpha), np.sin(alpha)]]
    before, left, direction = (tuple(rotation @ (v * np.array([1, mirror]))) for v in vectors)
    return is_collapsing(before, left, direction, e, et)


@pytest.mark.parametrize("tangential", slow_but([0.8], [1.0, 0.8, 0.3]))
def test_the_rule_agrees_with_bounces_in_a_wedge(tangential: float) -> None:
    rng = np.random.default_rng(3)
    collapsing = decided = 0
    n = 1500 if tangential == 1.0 else 600
    for theta, alpha in corners(rng, n):
        ratio = rng.uniform(0.01, 0.99)
        bound = (1 + ratio) / (1 - ratio) * np.sin(theta)
        if abs(bound - 1) < MARGIN:
            continue
        if bound < 1 and abs(2 * alpha + theta - np.pi + np.arcsin(bound)) < MARGIN:
            continue
        law = ratio * tangential, tangential
        expected = falls_into_the_corner(theta, alpha, *law)
        assert rule(rng, theta, alpha, *law) == expected, (theta, alpha, ratio)
        decided += 1
        collapsing += expected
    assert decided > 0.86 * n
    assert 0.13 * n < collapsing < decided - 0.13 * n
