"""The three witnesses share no code path: who may import whom (README, "Independence")."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
WITNESSES = {"kinetics", "particles", "derivations"}
COURT = {"kinetics/cli.py"}


def project_imports(source: str, package: str) -> set[str]:
    """Top-level project packages that a module names in any import, wherever it stands in it."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(package if node.level else (node.module or "").split(".")[0])
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "import_module":
            found |= {a.value.split(".")[0] for a in node.args if isinstance(a, ast.Constant)}
    return found & WITNESSES


def is_court(path: str) -> bool:
    return path in COURT or path.startswith("kinetics/crosscheck/")


MODULES = sorted(
    p.relative_to(ROOT).as_posix() for w in WITNESSES for p in (ROOT / w).rglob("*.py")
)


@pytest.mark.parametrize("path", MODULES)
def test_a_witness_imports_no_other_witness(path: str) -> None:
    package = path.split("/")[0]
    imported = project_imports((ROOT / path).read_text(encoding="utf-8"), package)
    allowed = WITNESSES if is_court(path) else {package}
    assert imported <= allowed, f"{path} imports {sorted(imported - allowed)}"


def test_the_core_of_kinetics_does_not_import_its_court() -> None:
    for path in MODULES:
        if not path.startswith("kinetics/") or is_court(path):
            continue
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            names = []
            if isinstance(node, ast.Import):
                names = [a.name for a in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [f"{'.' * node.level}{node.module or ''}.{a.name}" for a in node.names]
            assert not any("crosscheck" in n or n.endswith("cli") for n in names), path


def test_the_check_sees_a_forbidden_import() -> None:
    assert project_imports("def f():\n    from particles.media import Poisson\n", "kinetics") == {
        "particles"
    }
    assert project_imports("import derivations.verify as v\n", "particles") == {"derivations"}


@pytest.mark.parametrize("package", ["kinetics", "particles", "derivations"])
def test_importing_a_witness_loads_no_other(package: str) -> None:
    code = f"import sys, {package}; print(*sorted(m.split('.')[0] for m in sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout.split()
    assert not (WITNESSES - {package}) & set(loaded)


def test_importing_kinetics_is_light() -> None:
    code = "import sys, kinetics; print(*sorted(m.split('.')[0] for m in sys.modules))"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    ).stdout.split()
    assert not {"sympy", "numba", "matplotlib", "mpmath", "jinja2", "h5py"} & set(loaded)
