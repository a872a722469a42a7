"""Rooms of the derivations import only rooms above them in this list, and no module a cycle."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import derivations

ROOT = Path(derivations.__file__).parent
MAY_IMPORT = {
    "symbols": set(),
    "formal": set(),
    "typesetting": {"symbols"},
    "printed": {"symbols", "formal", "typesetting"},
    "premises": {"symbols"},
    "derived": {"symbols", "formal", "typesetting", "premises"},
    "verdicts": {"symbols", "formal", "typesetting", "printed", "derived"},
    "output": {"symbols", "typesetting", "derived", "verdicts"},
}
MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for path in ROOT.rglob("*.py")
    if path != ROOT / "__init__.py"
}


def imported(module: str) -> set[str]:
    """The modules of the package that a module names in any import, type-only ones included."""
    path = MODULES[module]
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        base = package[: len(package) - node.level + 1] + (node.module or "").split(".")
        for alias in node.names:
            names = [part for part in [*base, alias.name] if part]
            found |= {".".join(names)} & set(MODULES) or {".".join(names[:-1])}
    return found - {module, ""}


@pytest.mark.parametrize("module", sorted(MODULES))
def test_a_room_imports_only_the_rooms_it_may(module: str) -> None:
    room = module.split(".")[0]
    assert {name.split(".")[0] for name in imported(module)} <= MAY_IMPORT[room] | {room}


def test_no_module_imports_itself_through_others() -> None:
    # a package's own __init__ is imported with any of its modules: only what it names counts
    graph = {module: imported(module) for module in MODULES}
    TopologicalSorter(graph).prepare()


def test_what_is_imported_is_seen() -> None:
    assert "derived.sonine" in imported("derived.flux")
    assert "printed" in imported("verdicts.checks")
    assert "symbols" in imported("premises")
