"""What a release needs: one version, honest metadata, and nothing that one system alone has."""

import json
import os
import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]

# What os and signal have on Unix only, and modules that Windows has not. (os.link is there, but
# not on every file system. os.uname stays: numpy asks for it where sys.platform is linux.)
WITHOUT_UNIX = """
    import os, signal, sys

    keep_os = {"RDONLY", "WRONLY", "RDWR", "APPEND", "CREAT", "EXCL", "TRUNC"}
    names = [n for n in dir(os) if n.startswith("O_") and n[2:] not in keep_os]
    names += "fork forkpty link symlink mkfifo kill killpg getuid geteuid sysconf".split()
    names += "sched_getaffinity sched_setaffinity getloadavg chown lchown fchown nice wait3".split()
    for name in names:
        if hasattr(os, name):
            delattr(os, name)
    keep = "SIGABRT SIGFPE SIGILL SIGINT SIGSEGV SIGTERM SIG_DFL SIG_IGN".split()
    names = [n for n in dir(signal) if n.startswith("SIG") and n not in keep]
    names += "setitimer getitimer ITIMER_REAL alarm pause pthread_kill pthread_sigmask".split()
    names += "sigwait sigpending siginterrupt".split()
    for name in names:
        if hasattr(signal, name):
            delattr(signal, name)
    for name in "fcntl resource pwd grp termios tty pty syslog".split():
        sys.modules[name] = None
"""


def test_one_version() -> None:
    version = PROJECT["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
    assert json.loads((ROOT / ".zenodo.json").read_text("utf-8"))["version"] == version
    headings = re.findall(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert headings[0] == version


@pytest.mark.parametrize("name", ["CHANGELOG.md", "examples/paper/paper.md"])
def test_the_number_of_equations_is_that_of_the_algebra(name: str) -> None:
    from derivations.printed import ROWS

    count = sum(bool(row.number) for row in ROWS.values())
    stated = re.findall(r"paper's (\d+) numbered equations", (ROOT / name).read_text("utf-8"))
    assert stated == [str(count)]


def test_another_package_of_the_same_name_is_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "particles").mkdir()
    (tmp_path / "particles" / "__init__.py").write_text("")
    (tmp_path / "quarks-1.0.dist-info").mkdir()
    for name, text in {
        "METADATA": "Metadata-Version: 2.1\nName: quarks\nVersion: 1.0\n",
        "RECORD": "particles/__init__.py,,\n",
        "top_level.txt": "particles\n",
    }.items():
        (tmp_path / "quarks-1.0.dist-info" / name).write_text(text)
    run = "import sys; from kinetics.cli import main; sys.exit(main())"
    environment = {**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    for arguments, status, out in (
        (["simulate", "--media", "2", "--times", "1"], 2, ""),
        (["--version"], 0, "lorentz, version"),
        (["solve", "--times", "1"], 0, "t [d/U]"),  # needs no particles, and says nothing
    ):
        done = subprocess.run(
            [sys.executable, "-c", run, *arguments], env=environment, cwd=tmp_path,
            capture_output=True, text=True,
        )  # fmt: skip
        assert (done.returncode, out in done.stdout) == (status, True), done.stderr
        if arguments[0] == "solve":
            assert done.stderr == ""
        else:
            assert done.stderr.startswith("lorentz: the package 'particles' is also of quarks")
            assert done.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has these names not to begin with")
def test_without_what_only_unix_has(tmp_path: Path) -> None:
    work = """
        from kinetics import ScalingSolution, Scene, cli, load, solve
        from particles import Ensemble, HardDisks, simulate

        run = "simulate --media 2 --tracers 2 --count 400 --times 1,9".split()
        solution = solve(Scene(0.7, times=[1.0, 100.0], outputs=("thermal_speed", "msd")))
        solution.save("a.h5")
        assert load("a.h5") == solution
        for arguments in (
            ["solve", "--times", "1,10", "-o", "a.csv"],
            [*run, "-o", "whole.h5"],
            [*run, "--part", "1/2", "-o", "1.h5"],
            [*run, "--part", "2/2", "-o", "2.h5", "--resume"],
            ["merge", "1.h5", "2.h5", "-o", "all.h5"],
        ):
            assert cli.main(arguments) == 0, arguments
        again = simulate(HardDisks(0.04, 400), 0.7, times=[1.0, 9.0], media=2, tracers=2)
        assert Ensemble.load("all.h5") == again
        assert not hasattr(os, "fork") and not hasattr(signal, "SIGALRM")
        print("done")
    """
    code = textwrap.dedent(WITHOUT_UNIX) + textwrap.dedent(work)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.stdout.endswith("done\n"), done.stderr
    assert done.stderr == ""
