"""Options that several commands have, and what all of them show on the terminal alike."""

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import click
from click import Choice, option
from click.core import ParameterSource

from kinetics.errors import InputError

WIDTH = 100  # columns of a line of words
UNITS = (
    "Lengths are in d (diameter of a scatterer and of the tracer), speeds in U (standard deviation "
    "of one component of the initial velocity), times in d/U, densities in d^-2 (in space d^-3)."
)


def example(line: str, before: str = UNITS) -> str:
    """The end of a command's help: `before`, then a line to copy, which click does not wrap."""
    return f"{before}\n\n\b\nExample:\n  {line}"


class Numbers(click.ParamType):
    """A tuple of numbers and ranges, "0,1,10:1000:5": A:B:N is N from A to B at equal ratios."""

    name = "numbers"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """The numbers, or click's complaint that names the option and the text."""
        if isinstance(value, tuple) or not value.strip():
            return value or ()
        try:
            return tuple(x for part in value.split(",") for x in _numbers(part))
        except ValueError:
            what = "it must be numbers separated by commas, or a range such as 1:1e6:50"
            self.fail(f"{value!r}: {what}, from 1 to 1e6 in 50", param, ctx)


def part_of(context: Any, option: Any, text: str | None) -> tuple[int, int] | None:
    """Two whole numbers from "3/20", or click's complaint that names the option and the text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text or "")
    if text and not found:
        what = f"{text!r}: it must be K/N, the K-th of N parts, such as 3/20"
        raise click.BadParameter(what, context, option)
    return found and (int(found[1]), int(found[2]))


class Scatterers(Choice):
    """A word for the scatterers, as a Scene has it; a space may be a hyphen."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """The word, or click's complaint that names the option and the text."""
        return super().convert(value.replace("-", " "), param, ctx)


class Output(click.Path):
    """A folder, or a file with one of these endings ("": any), that can be written: asked first."""

    def __init__(self, *endings: str) -> None:
        super().__init__(path_type=Path)
        self.endings = endings

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """The path, or click's complaint that names the option."""
        from kinetics.crosscheck.files import require_file, require_writable_folder

        if value == "":
            self.fail("'' is no path; it must name a file or a folder", param, ctx)
        path: Any = super().convert(value, param, ctx)
        if self.endings:
            require_file(param.name, path, [end for end in self.endings if end])
        else:
            require_writable_folder(path)
        return path


def _numbers(part: str, most: int = 100_000) -> tuple[float, ...]:
    """One number, or those of a range."""
    if ":" not in part:
        return (float(part),)
    first, last, count = part.split(":")
    low, high, n = float(first), float(last), int(count)
    if not (0.0 < low < math.inf and 0.0 < high < math.inf and 2 <= n <= most):
        raise ValueError(part)
    inner = (low * (high / low) ** (k / (n - 1)) for k in range(1, n - 1))
    return (low, *(float(f"{x:.14g}") for x in inner), high)


# fmt: off
restitution_option = option("-e", "--restitution", type=float, default=0.7,
                            help="Coefficient of restitution, 0 to 1.")
tangential_option = option("--tangential-restitution", type=float, default=1.0,
                           help="What a collision leaves of the tangential velocity, 0 to 1.")
mass_option = option(
    "--mass-ratio", type=float, default=math.inf,
    help="Mass of a scatterer over that of the tracer; by default scatterers are fixed. For dilute "
    "smooth ones: with others, and among scatterers that have places, it is refused.")
dimension_option = option("--dimension", type=int, default=2,
                          help="3: spheres; number densities are then in d^-3.")
density_option = option("--number-density", type=float, default=0.04,
                        help="Scatterers per d^2; in space per d^3.")
times_option = option(
    "--times", type=Numbers(), default="1,3,10,30,100,300,1000",
    help="Output times in d/U, increasing, separated by commas; 1:1e6:50 is 50 of them from 1 to "
    "1e6, at equal ratios.")
until_option = option(
    "-t", "--until", type=float,
    help="Last time in d/U: in place of --times, 31 times up to it, 10 in a decade.")
seed_option = option("--seed", type=int, default=1, help="Seed of every random number.")
workers_option = option("--workers", type=int, help="Threads. [default: one per processor]")
json_option = option("--json", "as_json", is_flag=True,
                     help="Print one JSON document and nothing else.")
_DRIVES = (
    option("--bath-speed", type=float, default=0.0,
           help="Scatterers move: standard deviation of a component of their velocity in U. This, "
           "heating and drag are for dilute ones (with simulate --scatterers dilute)."),
    option("--heating", type=float, default=0.0, help="White noise 2 D dt, D in U^3/d."),
    option("--drag", type=float, default=0.0, help="Rate of the drag -DRAG v, in U/d."),
    option("--capture-speed", type=float, default=0.0, help="Slower impacts stick [U]."),
    option("--viscoelastic", type=float, metavar="B",
           help="In place of -e: viscoelastic spheres, B in U^(-1/10), of lower restitution when "
           "faster."),
)
# fmt: on
DRIVES = ("bath_speed", "heating", "drag", "capture_speed")


def drive_options(command: Any) -> Any:
    """The options of driven tracers, and --viscoelastic."""
    for one in reversed(_DRIVES):
        command = one(command)
    return command


def impact_law(viscoelastic: float | None, package: str, otherwise: Any) -> Any:
    """The restitution: of --viscoelastic, as a package has it, in place of what -e says."""
    if viscoelastic is None:
        return otherwise
    refuse_given(["restitution"], "--viscoelastic")
    return import_module(package).Viscoelastic(viscoelastic)


def law_keys(restitution: Any) -> dict[str, Any]:
    """The keys of a JSON document that hold a restitution."""
    if isinstance(restitution, float | int):
        return {"restitution": restitution}
    return {"restitution": None, "viscoelastic": getattr(restitution, "b", None)}


def names_in(text: str) -> tuple[str, ...]:
    """The names in a text that separates them by commas."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def given(names: Iterable[str]) -> list[str]:
    """Those of the parameters that stand on the command line, as their options are written."""
    context = click.get_current_context()
    options = {one.name: one.opts[-1] for one in context.command.params}
    found = (n for n in names if context.get_parameter_source(n) is not ParameterSource.DEFAULT)
    return [options[name] for name in found if name in options]


def is_given(name: str) -> bool:
    """Return whether a parameter stands on the command line."""
    return bool(given([name]))


def refuse_given(names: Iterable[str], beside: str) -> None:
    """Raise click.UsageError if one of the parameters was given, which mean nothing `beside`."""
    for name in given(names):
        raise click.UsageError(f"{name}: not with {beside}")


def times_until(times: tuple[float, ...], until: float | None) -> tuple[float, ...]:
    """The times of --times, or of --until in its place. Raises InputError for one not above 0."""
    if until is None:
        return times
    refuse_given(["times"], "--until, which stands in its place")
    if not 0.0 < until < math.inf:
        raise InputError(f"until: got {until:g}; it must be a finite time above 0")
    return _numbers(f"{until / 1e3!r}:{until!r}:31")


def print_json(document: Any) -> None:
    """Print one strict JSON document on standard output."""
    from kinetics.crosscheck.files import dumps

    click.echo(dumps(document), nl=False)


def written(value: Any, digits: int = 6) -> str:
    """A number as a physicist writes it: 0.0123, 1e6, 4.5e-7; other values as text."""
    if not isinstance(value, float):
        return str(value)
    return re.sub(r"e([+-])0*", lambda e: "e" + e[1].strip("+"), f"{value:.{digits}g}")


def columns(table: Mapping[str, Iterable[Any]]) -> str:
    """A table of columns of numbers or texts by their heads, a line for each row."""
    texts = []
    for head, column in table.items():
        cells = [head, *(x if isinstance(x, str) else written(float(x)) for x in column)]
        width = max(map(len, cells))
        texts.append([cell.rjust(width) for cell in cells])
    top, *rows = ("  ".join(row) for row in zip(*texts, strict=True))
    return "\n".join([click.style(top, bold=True), *rows])


@contextmanager
def progress(total: int | None = None, name: str = "") -> Iterator[Callable[..., None]]:
    """A function tell(name, total, done) for each part of long work: a bar, on a terminal.

    name : shown meanwhile, for work whose parts are not told
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda *_, **__: None
        return
    from rich import console, progress

    parts = (progress.BarColumn(), progress.MofNCompleteColumn(), progress.TimeElapsedColumn())
    where = console.Console(stderr=True)
    with progress.Progress("{task.description}", *parts, console=where, transient=True) as bar:
        task = bar.add_task(name, total=total)

        def tell(name: str, total: int | None = None, done: int | None = None) -> None:
            now = bar.tasks[0].completed + 1 if done is None else done
            bar.update(task, description=name, total=total or bar.tasks[0].total, completed=now)

        yield tell
