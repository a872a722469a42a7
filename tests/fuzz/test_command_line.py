"""The command: status 0 and a result, or status 2, one line and no new file."""

import contextlib
import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import check_line, examples, fuzz, mostly, time_limit
from hypothesis import strategies as st

from kinetics import cli
from kinetics.crosscheck.commands.solve import HEADS

TEXTS = [
    "", " ", "nan", "inf", "-inf", "-1", "0", "1.5", "1e400", "1e-400", "1e308", "5e-324", "x",
    "1,2", "1,,2", ",", "0x10", "1_000", "½", "é", "\udcff", "a\nb", "%s%n", "{}", "--",
    "-", "1" * 400, "1" * 5000, "x" * 1000, "\x1b[31m", "None", "True", "[]", "/", ".", "..",
    "no/such/folder/file", "data.csv", "data.csv/deeper",
]  # fmt: skip
"""Values of options, most of which most options refuse."""

_text = st.sampled_from(TEXTS)
_float = st.floats(0.0, 1.0).map(lambda x: f"{x:.3f}")


def numbers(low: float, high: float) -> Any:
    """A list of up to three rising numbers, as an option takes it."""
    places = st.lists(st.floats(low, high), min_size=1, max_size=3)
    return places.map(lambda found: ",".join(f"{x:.3g}" for x in sorted(found)))


def options(usual: dict[str, Any], always: tuple[str, ...] = ()) -> Any:
    """Lists of arguments: some of these options, those of ``always`` in any case."""
    pairs = {
        name: mostly(values, _text).map(lambda value, name=name: [name, value])
        for name, values in usual.items()
    }
    needed = st.tuples(*(pairs.pop(name) for name in always))
    some = st.lists(st.one_of(*pairs.values()), max_size=4) if pairs else st.just([])
    odd = mostly(st.just([]), st.sampled_from([["--nonsense"], ["--json=1"], ["-"], ["x" * 900]]))
    flags = st.sampled_from([[], ["--json"]])
    parts = st.tuples(needed, some, odd, flags)
    return parts.map(lambda p: [word for group in (*p[0], *p[1], p[2], p[3]) for word in group])


SYSTEM = {
    "-e": _float,
    "--number-density": st.sampled_from(["0.04", "0.1", "1e-3"]),
    "--initial": st.sampled_from(["gaussian", "monoenergetic"]),
}
SOLVE = options(
    {
        **SYSTEM,
        "--times": numbers(0.0, 1e3),
        "--outputs": st.lists(st.sampled_from(sorted(HEADS)), min_size=1, max_size=3).map(",".join),
        "--wave-numbers": numbers(0.0, 3.0),
        "--rtol": st.sampled_from(["1e-2", "1e-4", "1e-8"]),
    }
).map(lambda words: ["solve", *words])
SCALED = options({"-e": _float, "--rtol": st.sampled_from(["1e-10", "1e-3"])}, ("-e",)).map(
    lambda words: ["solve", "--scaled", *words]
)
RADII = options(
    {"-e": st.sampled_from(["0.7", "0.9"]), "--radii": numbers(0.0, 4.0)}, ("--radii",)
).map(
    # early times and the default tolerance take seconds
    lambda words: ["solve", *words, "--times", "3000", "--rtol", "1e-2"]
)
SIMULATE = options(
    {
        **SYSTEM,
        "--count": st.sampled_from(["80", "100"]),
        "--media": st.sampled_from(["1", "2"]),
        "--tracers": st.sampled_from(["1", "2"]),
        "--max-collisions": st.sampled_from(["1", "100"]),
        "--medium": st.sampled_from(["hard-disks", "poisson", "boltzmann-grad"]),
        "--box": st.sampled_from(["periodic", "none"]),
        "--times": numbers(0.1, 9.0),
        "--positions": st.sampled_from(["places.csv", "data.csv", "binary.csv"]),
        "--box-side": st.just("10"),
        "--observables": st.sampled_from(["positions", "msd,positions", "finals"]),
        "-o": st.just("run.h5"),
        "--seed": st.sampled_from(["0", "18446744073709551615"]),
        "--workers": st.just("1"),
    },
    ("--count", "--media", "--tracers", "--max-collisions"),
).map(lambda words: ["simulate", *words])
COMPARE = options(
    {
        **SYSTEM,
        "--positions": st.sampled_from(["auto", "displacement", "absolute"]),
        "--speed-unit": st.sampled_from(["1", "data"]),
        "--diameter": st.just("1"),
        "-o": st.sampled_from(["page.html", "data.html"]),
        "--figures": st.sampled_from(["png", "svg"]),
    },
)
FILES = [
    "data.csv",
    "binary.csv",
    "empty.csv",
    "huge.csv",
    "short.csv",
    "still.csv",
    "list.npz",
    "no.csv",
]
COMPARE = st.tuples(st.lists(st.sampled_from(FILES[1:]), max_size=2), COMPARE).map(
    lambda parts: ["compare", *parts[0], *parts[1]]
)
# what is allowed of these runs for minutes: each has one argument at least that is not
REFUSED = {
    "report": [
        ["-e", "1.5"], ["--count", "0"], ["--media", "1"], ["--rtol", "2"], ["-t", "-1"],
        ["-o", "data.csv"], ["--figures", "gif"], ["--number-density", "9"], ["--seed", "x"],
    ],
    "derive": [["--only", "x" * 500], ["--only", "no"], ["--latex", "data.csv/x"],
               ["--only", "sonine9", "--latex", ""]],
    "bench": [["--case", "x"], ["-o", "data.csv"]],
    "stress": [["--group", "x"], ["-o", "data.csv/x"]],
}  # fmt: skip


@st.composite
def refused(draw: Any) -> list[str]:
    """A command that must be refused, with anything beside what it is refused for."""
    name = draw(st.sampled_from(sorted(REFUSED)))
    words = draw(st.sampled_from([[], ["--json"], ["-o"], ["--seed"], ["-e"]]))
    if words not in ([], ["--json"]):
        words = [*words, draw(_text)]
    return [name, *words, *draw(st.sampled_from(REFUSED[name]))]


@examples(50)
def test_solve(tries: int) -> None:
    fuzz(check_command, SOLVE | SCALED, tries)


@examples(4)
def test_radii(tries: int) -> None:
    fuzz(check_command, RADII, tries)


@examples(84)
def test_simulate(tries: int) -> None:
    fuzz(check_command, SIMULATE, tries)


@examples(40)
def test_data_that_cannot_be_compared(tries: int) -> None:
    fuzz(check_command, COMPARE, tries)


@examples(54)
def test_what_is_refused(tries: int) -> None:
    fuzz(check_is_refused, refused(), tries)


def check_is_refused(words: list[str]) -> None:
    """A command that must be refused."""
    check_refused(*called(words))


def write_data(folder: Path) -> None:
    """Files that commands read, good and bad."""
    Path(folder, "places.csv").write_text("x,y\n3,3\n1,8\n8,2\n")
    Path(folder, "data.csv").write_text("time,x,y,vx,vy\n0,0,0,1,0\n")
    Path(folder, "binary.csv").write_bytes(bytes(range(256)) * 3)
    Path(folder, "empty.csv").write_bytes(b"")
    Path(folder, "short.csv").write_text("time,x,y\n0,0,0\n")
    Path(folder, "huge.csv").write_text("time,x,y,vx,vy\n" + "1,1e308,1e308,1e308,-1e308\n" * 4)
    Path(folder, "still.csv").write_text("time,x,y,vx,vy\n" + "0,0,0,0,0\n1,0,0,0,0\n" * 4)
    np.savez(Path(folder, "list.npz"), time=np.zeros(2), x=np.zeros((2, 2)), y=np.zeros(1))


def called(words: list[str]) -> tuple[int, str, str, list[str]]:
    """Status, standard output, standard error and new files of a command, all in a new folder."""
    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name), time_limit():
        write_data(Path(name))
        before = {path: path.read_bytes() for path in Path(name).iterdir()}
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = cli.main(words)
        after = set(Path(name).iterdir())
        assert all(path.read_bytes() == content for path, content in before.items())
        new = sorted(path.name for path in after - set(before))
    return status, out.getvalue(), err.getvalue(), new


def check_refused(status: int, out: str, err: str, new: list[str]) -> None:
    """Status 2, one line, no new file."""
    assert (status, out, new) == (2, "", []), (status, out[:200], err[:200], new)
    assert err.startswith("lorentz: ")
    assert err.endswith("\n")
    check_line(err)


def check_command(words: list[str]) -> None:
    """A command that may be refused, or give a result."""
    status, out, err, new = called(words)
    if status:
        check_refused(status, out, err, new)
        return
    assert err == ""
    assert all(not name.startswith(".") and "part" not in name for name in new)
    if "--json" in words:
        _check_document(json.loads(out, parse_constant=_no_constant))


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} in a JSON document")


def _check_document(document: dict[str, Any]) -> None:
    if document.get("status") == "converged":
        for name in HEADS:
            assert None not in np.ravel(document.get(name, [])), name
