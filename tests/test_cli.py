"""The command `lorentz`: what it prints where, what it refuses and how, and what it loads."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest

from kinetics import cli

TINY = ["--media", "3", "--tracers", "4", "--count", "400", "--free-tracers", "100", "-t", "30"]

BAD_INPUT = [
    # arguments; what the line must name: the argument, the value
    (["report", "-e", "1.5"], ["restitution", "1.5"]),
    (["report", "-e", "abc"], ["restitution", "abc"]),
    (["report", "-e", "0.5", "-e", "0.5"], ["restitution", "0.5"]),
    (["report", "--dimension", "4"], ["dimension", "4"]),
    (["report", "--tangential-restitution", "2"], ["tangential_restitution", "2.0"]),
    (["report", "--number-density", "-1"], ["number_density", "-1"]),
    (["report", "--number-density", "0.9"], ["number_density", "0.9"]),
    (["report", "-t", "-5"], ["until", "-5"]),
    (["report", "-t", "5", "-t", "6"], ["until", "2", "4"]),
    (["report", "--media", "1"], ["media", "1"]),
    (["report", "--count", "0"], ["count", "0"]),
    (["report", "--tracers", "0"], ["tracers", "0"]),
    (["report", "--free-tracers", "0"], ["free_tracers", "0"]),
    (["report", "--seed", "-1"], ["seed", "-1"]),
    (["report", "--workers", "0"], ["workers", "0"]),
    (["report", "--rtol", "0"], ["rtol", "0"]),
    (["report", "--nonsense"], ["--nonsense"]),
    (["nonsense"], ["nonsense"]),
    (["solve", "-e", "1.01"], ["restitution", "1.01"]),
    (["solve", "--number-density", "-0.04"], ["number_density", "-0.04"]),
    (["solve", "--times", ""], ["times"]),
    (["solve", "--times", "-1,1"], ["times", "-1"]),
    (["solve", "--times", "1,two"], ["times", "two"]),
    (["solve", "--outputs", "msd,speed_density"], ["outputs", "speed_density"]),
    (["solve", "--outputs", ""], ["outputs"]),
    (["solve", "--radii", "1,-2"], ["radii", "-2"]),
    (["solve", "--wave-numbers", "-1"], ["wave_numbers", "-1"]),
    (["solve", "--wave-numbers", "1e9"], ["wave_numbers", "1e+09"]),
    (["solve", "--initial", "cold"], ["initial", "cold"]),
    (["solve", "--rtol", "nan"], ["rtol", "nan"]),
    (["solve", "--scaled", "-e", "1"], ["restitution", "1"]),
    (["solve", "--scaled", "-e", "1e-250"], ["restitution", "1e-250"]),
    (["solve", "--times", "1,2" + "x" * 5000], ["times", "1,2x", "numbers separated by commas"]),
    (["simulate", "-e", "2"], ["restitution", "2"]),
    (["simulate", "--number-density", "-1"], ["number_density", "-1"]),
    (["simulate", "--number-density", "5"], ["number_density", "5"]),
    (["simulate", "--times", ""], ["times"]),
    (["simulate", "--times", "3,2"], ["times"]),
    (["simulate", "--count", "-3"], ["count", "-3"]),
    (["simulate", "--medium", "glass"], ["medium", "glass"]),
    (["derive", "--only", "nonsense"], ["nonsense"]),
]


@pytest.mark.parametrize(("arguments", "named"), BAD_INPUT, ids=lambda v: " ".join(v)[:80])
def test_bad_input_gets_one_line_that_names_it(
    lorentz: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    named: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    line = lorentz.refused(*arguments).replace("-", "_")
    assert all(name.replace("-", "_") in line for name in named), line
    assert list(tmp_path.iterdir()) == []


def test_a_density_that_is_too_high_to_fill_the_box_is_refused(lorentz: Any) -> None:
    # Below the limit that the medium refuses at once, random placing may still come to an end.
    line = lorentz.refused("simulate", "--number-density", "0.9", "--count", "100", "--media", "2")
    assert "number_density" in line


def test_an_output_that_is_a_file_is_refused_before_any_work(
    lorentz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from kinetics.crosscheck.report import report

    def never(*arguments: object) -> None:
        raise AssertionError("the report was begun")

    monkeypatch.setattr(report, "make_report", never)
    file = tmp_path / "file"
    file.write_text("mine")
    for folder in (file, file / "deeper", Path("/proc/no/such")):
        assert str(folder) in lorentz.refused("report", "-o", str(folder))
    assert str(file) in lorentz.refused("derive", "--latex", str(file / "x.tex"))
    assert file.read_text() == "mine"


def run(*arguments: str, cwd: Path, **keywords: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "kinetics.cli", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        **keywords,
    )


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from kinetics import cli\n"
        "for arguments in ['--help'], ['report', '--help'], ['solve', '--help'],"
        " ['simulate', '--help'], ['derive', '--help'], ['--version'], []:\n"
        "    assert cli.main(arguments) == 0, arguments\n"
        "print(*sorted({m.split('.')[0] for m in sys.modules}), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    loaded = set(done.stderr.split())
    assert done.returncode == 0, done.stderr
    heavy = {"numpy", "scipy", "numba", "sympy", "mpmath", "matplotlib", "jinja2", "tqdm", "h5py"}
    assert "click" in loaded
    assert not heavy & loaded
    assert "report" in done.stdout
    assert "Traceback" not in done.stderr


def test_every_command_that_is_there_has_help(lorentz: Any) -> None:
    assert set(cli.cli.commands) == {
        "report",
        "solve",
        "simulate",
        "derive",
        "bench",
        "stress",
        "compare",
    }
    for name in cli.cli.commands:
        out = lorentz(name, "--help")
        assert f"lorentz {name}" in out
        for parameter in cli.cli.commands[name].params:
            # What an argument is, the command's own text says: click has no help for arguments.
            if isinstance(parameter, click.Option):
                assert parameter.help, f"{name} {parameter.name} has no help"


def test_solve_prints_one_json_document(lorentz: Any) -> None:
    document = lorentz.json("solve", "-e", "0.5", "--times", "1,10,100")
    assert document["times"] == [1, 10, 100]
    speeds = document["thermal_speed"]
    assert 2**0.5 > speeds[0] > speeds[1] > speeds[2] > 0


def test_solve_prints_a_table_with_units(lorentz: Any) -> None:
    lines = lorentz("solve", "-e", "0.5", "--times", "1,10").splitlines()
    assert lines[0].split("  ")[-1] == "<r^2> [d^2]"
    assert [line.split()[0] for line in lines[1:3]] == ["1", "10"]


def test_solve_prints_what_is_asked_for(lorentz: Any) -> None:
    more = ["--outputs", "kurtosis", "--radii", "0,1", "--wave-numbers", "0.0,0.1"]
    arguments = ["solve", "-e", "0.5", "--times", "0,100", "--rtol", "1e-3", *more]
    found = lorentz.json(*arguments)
    assert "msd" not in found
    assert found["kurtosis"][1] > 2.0
    assert found["scaled_position_density"][1][0] == 0.0
    assert 0.5 < found["scaled_position_density"][1][1] < 0.7
    assert found["intermediate_scattering"][0] == [1.0, 1.0]
    text = lorentz(*arguments)
    assert "G(1)" in text
    assert "F(0.1/d)" in text


def test_solve_at_the_end_of_double_precision(lorentz: Any) -> None:
    """t v/l overflows; G(R) is late, and does not depend on it."""
    found = lorentz("solve", "--number-density", "1e12", "--times", "1e308", "--radii", "1,2")
    assert "status: the error estimate meets rtol" in found


def test_solve_scaled_prints_the_cooling_rate(lorentz: Any) -> None:
    document = lorentz.json("solve", "--scaled", "-e", "0.5")
    b = math.sqrt(0.75)  # h = 2 sqrt(kappa lambda(1)) at e = 1/2
    kappa, rate = 1 - 0.5 * math.acos(0.5) / b, (1 - 0.25 * math.atanh(b) / b) / 2
    assert document["cooling_rate"] == pytest.approx(2 * math.sqrt(kappa * rate), rel=1e-9)
    assert document["moments"]["2"] == pytest.approx(1)
    assert "cooling_rate" in lorentz("solve", "--scaled", "-e", "0.5")


@pytest.mark.parametrize("medium", ["hard-disks", "poisson", "boltzmann-grad"])
def test_simulate_prints_estimates_with_errors(lorentz: Any, medium: str) -> None:
    arguments = ["simulate", "--medium", medium, "--count", "400", "--media", "4", "--times", "1,9"]
    document = lorentz.json(*arguments)
    assert document["times"] == [1, 9]
    for name in ("thermal_speed", "a2", "msd", "collisions"):
        assert len(document[name]["value"]) == len(document[name]["error"]) == 2
    assert document["statuses"]["finished"] == 400
    lines = lorentz(*arguments).splitlines()
    assert lines[0].split()[:2] == ["t", "[d/U]"]
    assert f"{document['msd']['value'][1]:.6g}" in lines[2]


def test_derive_prints_one_equation_with_its_steps(lorentz: Any, tmp_path: Path) -> None:
    file = tmp_path / "sonine9.tex"
    document = lorentz.json("derive", "--only", "sonine9", "--latex", str(file))
    assert document["checks"][0]["label"] == "sonine9"
    assert "\\end{document}" in file.read_text(encoding="utf-8")
    assert [p.name for p in file.parent.iterdir()] == ["sonine9.tex"]
    assert "sonine9" in lorentz("derive", "--only", "sonine9")


@pytest.mark.slow
def test_a_report_of_two_restitutions(lorentz: Any, tmp_path: Path) -> None:
    output = tmp_path / "out"
    arguments = ["report", "-o", str(output), "-e", "0.5", "-e", "1", *TINY]
    document = lorentz.json(*arguments)
    assert sorted(p.name for p in output.iterdir()) == ["report.html", "report.json"]
    assert document == json.loads((output / "report.json").read_text(encoding="utf-8"))
    strict = [r for r in document["rows"] if r["kind"] == "numerical"]
    assert len(strict) == 3
    assert {r["verdict"] for r in strict} == {"agrees"}
    assert {c["status"] for c in document["algebra"]} >= {"verified"}
    page = (output / "report.html").read_text(encoding="utf-8")
    assert page.count("<svg") == len(document["figures"]) + 1  # and the picture of the system
    # The same seed gives the same report, to the byte, whatever the number of threads.
    before = {p.name: p.read_bytes() for p in output.iterdir()}
    table = lorentz(*arguments, "--workers", "1")
    assert "h(e)" in table
    assert str(output / "report.html") in table
    same = [
        (b.replace(b'"workers": null', b'"workers": 1'), (output / name).read_bytes())
        for name, b in before.items()
    ]
    assert all(a == b for a, b in same)


@pytest.mark.slow
def test_a_report_without_a_cooling_restitution(lorentz: Any, tmp_path: Path) -> None:
    output = tmp_path / "out"
    lorentz("report", "-o", str(output), "-e", "1", *TINY)
    document = json.loads((output / "report.json").read_text(encoding="utf-8"))
    assert "cooling-rate" not in document["figures"]
    assert document["cases"][0]["scaled"] is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminal")
def test_progress_is_shown_on_a_terminal_only(tmp_path: Path) -> None:
    import fcntl
    import pty
    import struct
    import termios

    arguments = ["simulate", "--media", "20", "--count", "400", "--times", "1", "--json"]
    master, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 100, 0, 0))
    command = [sys.executable, "-m", "kinetics.cli", *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=terminal, cwd=tmp_path)
    os.close(terminal)
    shown = os.read(master, 100_000).decode()
    os.close(master)
    assert "/20" in shown
    assert json.loads(done.stdout)["tracers"] == 100
    assert run(*arguments, cwd=tmp_path).stderr == ""


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    done = subprocess.run(
        f"{sys.executable} -m kinetics.cli derive --only sonine9 --json | head -c 1",
        shell=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.stderr == ""


def test_a_status_that_a_command_sets_is_the_one_of_the_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """`lorentz stress` ends with 1 if a case ended as it must not."""

    @click.command()
    @click.pass_context
    def bad(context: click.Context) -> None:
        context.exit(1)

    monkeypatch.setitem(cli.cli.commands, "bad", bad)
    assert cli.main(["bad"]) == 1
