"""Who may import whom: the independence of the methods, the rooms of kinetics, no cycle anywhere.

Imports that are only for type checkers, and those inside functions, count like all others.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
METHODS = ("kinetics", "particles", "derivations")

# The rooms of the core, from the ground up, and what each may import beside itself.
CHECKS = {"errors", "validation"}
BASE = {"numerics", "collision", "results"} | CHECKS
VELOCITY = {"states", "scaling", "moments", "densities"}
QUESTION = {"outputs", "scene", "undriven", "answer"}
ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "version": set(),
    "interruption": set(),
    "names": set(),
    "loading": {"names", "results"},
    "numerics": set(),
    "validation": {"errors"},
    "results": {"errors", "version"},
    "scatterers": set(),
    "collision": {"numerics", "results", "scatterers"} | CHECKS,
    "states": {"numerics", "results"} | CHECKS,
    "scaling": BASE,
    "paper": {"numerics"},
    "moments": BASE | {"states"},
    "densities": BASE | {"states", "scaling", "moments"},
    "position": BASE | {"states", "moments"},
    "drive": BASE,
    "driven": BASE | {"states", "drive", "outputs", "scene"},
    "outputs": {"moments"},
    "scene": BASE | {"states", "outputs", "drive"},
    "model_error": BASE | {"scene"},
    "undriven": BASE | {"moments", "densities", "position", "outputs", "scene", "model_error"},
    "answer": BASE | {"scene", "undriven", "driven"},
    "between_frames": BASE | {"states", "moments", "densities"},
    "solution_dataset": BASE | {"outputs", "scene", "model_error"},
    "solution": BASE
    | VELOCITY
    | QUESTION
    | {"position", "solution_dataset", "between_frames", "model_error"},
    "solving": BASE | {"scene", "solution", "model_error"},
}
# Those of the derivations: what is printed and what is derived know nothing of each other.
DERIVED = {
    "printed": {"symbols", "formal", "printers"},
    "derived": {"symbols", "formal", "premises"},
}
MODULES = {
    path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__")
    for method in METHODS
    for path in (ROOT / method).rglob("*.py")
}


def file_of(module: str) -> Path:
    path = ROOT / module.replace(".", "/")
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def named(source: str, module: str, is_package: bool) -> Iterator[tuple[str, str | None]]:
    """(module, name) of every import in the source; name is None for `import module`."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".")
                up = node.level - is_package
                base = ".".join([*parts[: len(parts) - up], *([base] if base else [])])
            yield from ((base, alias.name) for alias in node.names)
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "import_module":
            yield from ((a.value, None) for a in node.args if isinstance(a, ast.Constant))


@cache
def imports_of(module: str) -> frozenset[str]:
    """The project's modules that this one imports, each name followed to where it is defined."""
    path = file_of(module)
    found = set()
    for base, name in named(path.read_text(encoding="utf-8"), module, path.stem == "__init__"):
        target = follow(base, name)
        if target is not None and target != module:
            found.add(target)
    return frozenset(found)


def follow(base: str, name: str | None) -> str | None:
    """Through the `__init__.py` of packages, which hand names on."""
    if name is not None and f"{base}.{name}" in MODULES:
        return f"{base}.{name}"
    if base not in MODULES:
        return None
    path = file_of(base)
    if name is not None and path.stem == "__init__":
        for inner, given in named(path.read_text(encoding="utf-8"), base, True):
            if given == name:
                return follow(inner, name)
    return base


def room_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def is_crosscheck(module: str) -> bool:
    return module == "kinetics.cli" or module.startswith("kinetics.crosscheck")


@pytest.mark.parametrize("module", sorted(MODULES))
def test_a_method_imports_no_other_method(module: str) -> None:
    if is_crosscheck(module):
        return
    own = module.split(".")[0]
    others = {m for m in imports_of(module) if m.split(".")[0] != own or is_crosscheck(m)}
    if module == "kinetics":
        # the face of the package hands on names of the cross-check, loaded at first use
        others = {m for m in others if not is_crosscheck(m)}
    assert not others, f"{module} imports {sorted(others)}"


CORE = sorted(m for m in MODULES if m.startswith("kinetics.") and not is_crosscheck(m))


def test_every_room_of_the_core_is_known() -> None:
    assert {room_of(module) for module in CORE} <= set(ROOMS)
    TopologicalSorter(ROOMS).prepare()  # and none stands on another that stands on it


@pytest.mark.parametrize("module", sorted(m for m in MODULES if m in CORE or room_of(m) in DERIVED))
def test_a_room_imports_only_what_it_may(module: str) -> None:
    room = room_of(module)
    rooms = {room_of(other) for other in imports_of(module)}
    allowed = (ROOMS | DERIVED)[room]
    assert rooms <= allowed | {room}, f"{module} imports {sorted(rooms - allowed)}"


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = {m: imports_of(m) for m in MODULES if file_of(m).stem != "__init__"}
    TopologicalSorter(graph).prepare()  # CycleError names the circle


def test_the_check_sees_imports_of_every_kind() -> None:
    source = "def f():\n    from particles.media import Poisson\n"
    assert list(named(source, "kinetics.solution", False)) == [("particles.media", "Poisson")]
    source = "from ..collision import CollisionLaw\n"
    found = [("kinetics.collision", "CollisionLaw")]
    assert list(named(source, "kinetics.states.kinds", False)) == found
    assert follow("kinetics", "CollisionLaw") == "kinetics.collision.law"


HEAVY = {"numpy", "scipy", "sympy", "mpmath", "numba", "matplotlib", "jinja2", "h5py"}
HEAVY |= {"pyarrow", "pandas"}
STATED = "derivations; derivations.printed_equation('vchange')"


@pytest.mark.parametrize(("package", "others"), [
    ("kinetics", {"particles", "derivations"} | HEAVY),
    ("particles", {"kinetics", "derivations"}),
    ("derivations", {"kinetics", "particles", "sympy", "mpmath"}),
    (STATED, {"derivations.derived"}),  # it derives nothing
])  # fmt: skip
def test_what_importing_a_method_loads(package: str, others: set[str]) -> None:
    code = f"import sys, {package}; print(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert not others & set(ran.stdout.split())
