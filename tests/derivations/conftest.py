"""What the tests of the derivations share."""

from collections.abc import Callable, Iterator

import pytest
import sympy as sp

from derivations import Check, verify

Mutants = Callable[[sp.Basic], Iterator[sp.Basic]]


def every_mutant(node: sp.Basic) -> Iterator[sp.Basic]:
    """Every formula with one number changed, or with one term (coefficient 1) doubled."""
    if isinstance(node, sp.Number):
        yield node + 1
        return
    for index, argument in enumerate(node.args):
        changed = list(every_mutant(argument))
        if isinstance(node, sp.Add | sp.Eq | sp.Le) and argument != 0:
            changed.append(2 * argument)
        for mutant in changed:
            arguments = list(node.args)
            arguments[index] = mutant
            options = {"evaluate": False} if isinstance(node, sp.Eq | sp.Le) else {}
            yield node.func(*arguments, **options)


@pytest.fixture(scope="session")
def checks() -> tuple[Check, ...]:
    """All rows, derived once and not while the tests are collected: it takes ten seconds."""
    return verify()


@pytest.fixture(scope="session")
def rows(checks: tuple[Check, ...]) -> dict[str, Check]:
    return {row.label: row for row in checks}


@pytest.fixture(scope="session")
def mutants() -> Mutants:
    return every_mutant
