"""The command: status 0 and a result, or status 2, one line and no new file."""

import contextlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import pytest
from fuzzing import check_line, fuzz, mostly
from hypothesis import strategies as st

from kinetics import cli
from kinetics.crosscheck.cli.solve import HEADS

TEXTS = st.sampled_from([
    "", " ", "nan", "inf", "-inf", "-1", "0", "1.5", "1e400", "1e-400", "1e308", "5e-324", "x",
    "1,2", "1,,2", ",", "0x10", "½", "é", "\udcff", "a\nb", "%s%n", "{}", "--", "-", "1" * 400,
    "1" * 5000, "x" * 1000, "\x1b[31m", "None", "[]", "/", ".", "..", "no/such/file", "data.csv",
])  # fmt: skip
FILES = {
    "data.csv": b"time,x,y,vx,vy\n0,0,0,1,0\n",
    "binary.csv": bytes(range(256)) * 3,
    "empty.csv": b"",
    "huge.csv": b"time,x,y,vx,vy\n" + b"1,1e308,1e308,1e308,-1e308\n" * 4,
}
number = st.floats(0.0, 1.0).map(lambda x: f"{x:.3f}")


def several(low: float, high: float) -> Any:
    places = st.lists(st.floats(low, high), min_size=1, max_size=3)
    return places.map(lambda found: ",".join(f"{x:.3g}" for x in sorted(found)))


def words(*first: str, always: tuple[str, ...] = (), **usual: Any) -> Any:
    """Arguments: some of these options, each mostly with a usual value, and those of `always`."""
    pairs = {}
    for name, values in usual.items():
        option = f"--{name.replace('_', '-')}" if len(name) > 1 else f"-{name}"
        pairs[name] = st.tuples(st.just(option), mostly(values, TEXTS))
    needed = st.tuples(*(pairs.pop(name) for name in always))
    odd = mostly([()], st.sampled_from([("--nonsense",), ("--json=1",), ("-",), ("x" * 900,)]))
    flags = st.sampled_from([(), ("--json",)])
    some = st.lists(st.one_of(*pairs.values()), max_size=4)
    return st.tuples(needed, some, odd, flags).map(
        lambda p: [*first, *(w for group in (*p[0], *p[1], p[2], p[3]) for w in group)]
    )


system = {"e": number, "number_density": ["0.04", "1e-3"], "initial": ["gaussian", "rest"]}
solve = words(
    "solve", **system, times=several(0.0, 1e3), wave_numbers=several(0.0, 3.0),
    outputs=st.lists(st.sampled_from(sorted(HEADS)), min_size=1, max_size=3).map(",".join),
    rtol=["1e-2", "1e-4", "1e-8"], o=["a.csv", "a.nc", "a.h5"],
)  # fmt: skip
scaled = words("solve", "--scaled", always=("e",), e=number, rtol=["1e-10", "1e-3"])
simulate = words(
    "simulate", always=("count", "media", "tracers", "max_collisions"), **system,
    count=["80", "100"], media=["1", "2"], tracers=["1", "2"], max_collisions=["1", "100"],
    scatterers=["hard-disks", "overlapping", "dilute"], times=several(0.1, 9.0),
    o=["run.h5", "a.h5md"], observables=["positions", "msd,positions", "finals"], workers=["1"],
)  # fmt: skip
compare = st.sampled_from(["empty.csv", "binary.csv", "huge.csv", "no.csv"]).flatmap(
    lambda name: words("compare", name, **system, speed_unit=["1", "data"], o=["page.html"])
)


def called(arguments: list[str]) -> tuple[int, str, str, set[str]]:
    """Status, standard output, standard error and new files, all in a new folder."""
    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for name, content in FILES.items():
            Path(name).write_bytes(content)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = cli.main(arguments)
        # a file that is named as the output may be written
        kept = {name: content for name, content in FILES.items() if name not in arguments}
        assert all(Path(name).read_bytes() == content for name, content in kept.items())
        new = set(os.listdir()) - set(FILES)
    return status, out.getvalue(), err.getvalue(), new


def check_refused(status: int, out: str, err: str, new: set[str]) -> None:
    assert (status, out, new) == (2, "", set()), (status, out[:200], err[:200], new)
    assert err.startswith("lorentz: ")
    check_line(err)


@fuzz(60, arguments=solve | solve | scaled | simulate | compare)
def test_commands(arguments: list[str]) -> None:
    status, out, err, new = called(arguments)
    if status:
        check_refused(status, out, err, new)
        return
    assert err == ""
    assert all(not name.startswith(".") and "part" not in name for name in new)
    if "--json" in arguments:
        json.loads(out, parse_constant=pytest.fail)
