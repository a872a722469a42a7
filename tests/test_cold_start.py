"""Threads that all use a package first at the same time."""

import subprocess
import sys

import pytest
from marking import slow_but

#: Each line is the work of a thread: other names of other modules, in another order.
WORK = """
kinetics.Scene; kinetics.solve
kinetics.solve_steady
kinetics.ScalingSolution; kinetics.sonine
kinetics.CollisionLaw
kinetics.solve_scaled
from kinetics.crosscheck import compare_data, Comparison
kinetics.compare; kinetics.fit
particles.simulate; particles.HardDisks
"""
CODE = f"""
import threading, time, traceback
import kinetics, particles
errors = []
work = {WORK!r}.strip().splitlines()
barrier = threading.Barrier(len(work))
def run(line):
    barrier.wait()
    try:
        exec(line)
    except BaseException:
        errors.append(traceback.format_exc())
threads = [threading.Thread(target=run, args=[line]) for line in work]
for thread in threads: thread.start()
for thread in threads: thread.join()
print(*errors, sep="\\n", end="")
"""


@pytest.mark.parametrize("switch_interval", slow_but([1e-5], [1e-5, 5e-3]))
def test_eight_threads_import_public_names_at_once(switch_interval: float) -> None:
    code = f"import sys; sys.setswitchinterval({switch_interval})\n{CODE}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300)
    assert (done.stdout, done.returncode) == ("", 0)


def test_the_name_of_a_function_is_never_its_module() -> None:
    """The import of a module sets its name in the package before the function can take it."""
    code = """
import importlib, pkgutil, particles, kinetics, derivations
for package in (particles, kinetics, derivations):
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    assert not modules & set(package.__all__), modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)
