"""Options that several commands have, and what all of them show on the terminal alike."""

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import click
from click import Choice, option
from click.core import ParameterSource

from kinetics.errors import InputError, suggestion
from kinetics.scatterers import usual_word

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

#: A function that click makes a command of, or that it already has.
Command = TypeVar("Command", bound=Callable[..., Any])
#: Columns of a line of words.
WIDTH = 100
#: Numbers of a range at most: a longer one is a slip of the keyboard.
MAX_NUMBERS = 100_000
#: Times up to --until, ten in a decade, and the decades that they span.
N_TIMES_UNTIL = 31
#: The last of these times over the first: three decades.
RATIO_OF_TIMES_UNTIL = 1e3
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

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Return the numbers; click's complaint names the option and the text."""
        if isinstance(value, tuple):
            return value
        if not value.strip():
            return ()
        numbers: list[float] = []
        try:
            for text in value.split(","):
                numbers += numbers_of(text)
        except ValueError:
            allowed = "it must be numbers separated by commas, or a range such as 1:1e6:50"
            self.fail(f"{value!r}: {allowed}, from 1 to 1e6 in 50", param, ctx)
        return tuple(numbers)


def numbers_of(text: str) -> tuple[float, ...]:
    """Return one number, or those of a range; ValueError for another text."""
    if ":" not in text:
        return (float(text),)
    first, last, count = text.split(":")
    return geometric_range(float(first), float(last), int(count))


def geometric_range(first: float, last: float, count: int) -> tuple[float, ...]:
    """Return numbers at equal ratios, of 14 digits; ValueError for no such range."""
    is_range = 0.0 < first < math.inf and 0.0 < last < math.inf
    if not is_range or not 2 <= count <= MAX_NUMBERS:
        raise ValueError(f"no range: {first}:{last}:{count}")
    ratio = last / first
    inner = [first * ratio ** (k / (count - 1)) for k in range(1, count - 1)]
    return (first, *(float(f"{number:.14g}") for number in inner), last)


def part_of(
    context: click.Context, parameter: click.Parameter, text: str | None
) -> tuple[int, int] | None:
    """Return two whole numbers from "3/20"; click's complaint names the option and the text."""
    if not text:
        return None
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if match is None:
        message = f"{text!r}: it must be K/N, the K-th of N parts, such as 3/20"
        raise click.BadParameter(message, context, parameter)
    return int(match[1]), int(match[2])


class OneNumber(click.types.FloatParamType):
    """A number; of several the message says how they are solved."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; click's complaint names the option and the text."""
        if isinstance(value, str) and "," in value:
            self.fail(f"{value!r}: it must be one number; kinetics.sweep takes several", param, ctx)
        return super().convert(value, param, ctx)


class Word(Choice[str]):
    """One of some words; for another one the message says which was probably meant."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the word; click's complaint names the option and the text."""
        if value not in self.choices:
            words = ", ".join(self.choices)
            near = suggestion(value, self.choices)
            self.fail(f"{value!r}; it must be one of {words}{near}", param, ctx)
        return super().convert(value, param, ctx)


class Scatterers(Word):
    """A word for the scatterers, as a Scene has it; a space may be a hyphen or an underscore."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the word; click's complaint names the option and the text."""
        return super().convert(usual_word(value), param, ctx)


class Output(click.Path):
    """A folder, or a file with one of these endings ("": any), checked to be writable."""

    def __init__(self, *endings: str) -> None:
        super().__init__(path_type=Path)
        self.endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path; click's complaint names the option."""
        from kinetics.crosscheck.files import require_file, require_writable_folder

        if value == "":
            self.fail("'' is no path; it must name a file or a folder", param, ctx)
        path = Path(str(super().convert(value, param, ctx)))
        if not self.endings:
            require_writable_folder(path)
            return path
        name = "output"
        if param is not None and param.name is not None:
            name = param.name
        require_file(name, path, [ending for ending in self.endings if ending])
        return path


# fmt: off
restitution_option = option("-e", "--restitution", type=OneNumber(), default=0.7,
                            help="Coefficient of restitution, 0 to 1.")
tangential_option = option("--tangential-restitution", type=float, default=1.0,
                           help="Share of the tangential velocity that a collision leaves, 0 to 1.")
mass_option = option(
    "--mass-ratio", type=float, default=math.inf,
    help="Mass of a scatterer over that of the tracer; inf: scatterers are fixed. Only for dilute, "
    "smooth scatterers.")
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
           help="Standard deviation of each velocity component of the scatterers, in U; 0: they "
           "are fixed. Only for dilute scatterers."),
    option("--heating", type=float, default=0.0, help="Strength D of white noise, in U^3/d: each "
           "velocity component gains the variance 2 D dt. Only for dilute scatterers."),
    option("--drag", type=float, default=0.0, help="Rate gamma of a drag dv/dt = -gamma v, "
           "in U/d. Only for dilute scatterers."),
    option("--capture-speed", type=float, default=0.0,
           help="Impacts whose normal speed is below this stick, in U; 0: none does."),
    option("--viscoelastic", type=float, metavar="B",
           help="In place of -e: viscoelastic spheres with the material constant B, in U^(-1/10); "
           "faster impacts lose a larger share."),
)
# fmt: on
DRIVES = ("bath_speed", "heating", "drag", "capture_speed")


def drive_options(command: Command) -> Command:
    """Add the options of driven tracers, and --viscoelastic."""
    for add_option in reversed(_DRIVES):
        command = add_option(command)
    return command


def impact_law(viscoelastic: float | None, package: str, restitution: Any) -> Any:
    """Return the restitution: of --viscoelastic, as a package has it, or else what -e says."""
    if viscoelastic is None:
        return restitution
    refuse_given(["restitution"], "--viscoelastic")
    return import_module(package).Viscoelastic(viscoelastic)


def law_keys(restitution: object) -> dict[str, object]:
    """Return the keys of a JSON document that hold a restitution."""
    if isinstance(restitution, float | int):
        return {"restitution": restitution}
    return {"restitution": None, "viscoelastic": getattr(restitution, "b", None)}


def names_in(text: str) -> tuple[str, ...]:
    """Return the names in a text that separates them by commas."""
    names = [name.strip() for name in text.split(",")]
    return tuple(name for name in names if name)


def given(names: Iterable[str]) -> list[str]:
    """Return which parameters stand on the command line, as their options are written."""
    context = click.get_current_context()
    options = {parameter.name: parameter.opts[-1] for parameter in context.command.params}
    specified = []
    for name in names:
        is_default = context.get_parameter_source(name) is ParameterSource.DEFAULT
        if name in options and not is_default:
            specified.append(options[name])
    return specified


def is_given(name: str) -> bool:
    """Return whether a parameter stands on the command line."""
    return bool(given([name]))


def refuse_given(names: Iterable[str], beside: str) -> None:
    """Raise click.UsageError if one of the parameters was given, which mean nothing `beside`."""
    for name in given(names):
        raise click.UsageError(f"{name}: not with {beside}")


def times_until(times: tuple[float, ...], until: float | None) -> tuple[float, ...]:
    """Return the times of --times, or of --until in its place.

    Raises InputError for one that is not above 0.
    """
    if until is None:
        return times
    refuse_given(["times"], "--until, which stands in its place")
    if not 0.0 < until < math.inf:
        raise InputError(f"until: got {until:g}; it must be a finite time above 0")
    return geometric_range(until / RATIO_OF_TIMES_UNTIL, until, N_TIMES_UNTIL)


# -- what is shown ---------------------------------------------------------------------------------
def print_json(document: object) -> None:
    """Print one strict JSON document on standard output."""
    from kinetics.crosscheck.files import dumps

    click.echo(dumps(document), nl=False)


def written(value: object, digits: int = 6) -> str:
    """Return a number as a physicist writes it: 0.0123, 1e6, 4.5e-7; other values as text."""
    if not isinstance(value, float):
        return str(value)
    text = f"{value:.{digits}g}"
    return re.sub(r"e([+-])0*", lambda match: "e" + match[1].strip("+"), text)


def columns(table: Mapping[str, Iterable[Any]]) -> str:
    """Return a table of columns of numbers or texts by their heads, a line for each row."""
    aligned: list[list[str]] = []
    for head, column in table.items():
        cells = [head]
        for cell in column:
            cells.append(cell if isinstance(cell, str) else written(float(cell)))
        width = max(len(cell) for cell in cells)
        aligned.append([cell.rjust(width) for cell in cells])
    heads, *lines = ("  ".join(line) for line in zip(*aligned, strict=True))
    return "\n".join([click.style(heads, bold=True), *lines])


class Tell(Protocol):
    """Called with the name of what is worked on, and perhaps with how much of it is done."""

    def __call__(self, name: str, total: int | None = None, done: int | None = None) -> None:
        """Show it."""


def _tell_nothing(name: str, total: int | None = None, done: int | None = None) -> None:
    """Take what is worked on, and show nothing."""


class _BarTell:
    """Moves a bar: by one step at each call that does not say how much is done."""

    def __init__(self, bar: "Bar", task: "TaskID") -> None:
        self.bar = bar
        self.task = task

    def __call__(self, name: str, total: int | None = None, done: int | None = None) -> None:
        state = self.bar.tasks[0]
        if done is None:
            done = int(state.completed) + 1
        self.bar.update(self.task, description=name, total=total or state.total, completed=done)


@contextmanager
def progress(total: int | None = None, name: str = "") -> Iterator[Tell]:
    """Yield a function tell(name, total, done) for each step of long work: a bar, on a terminal.

    Parameters
    ----------
    total : steps of the work
    name : shown meanwhile, for work whose steps are not told
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield _tell_nothing
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    with Progress(
        "{task.description}",
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    ) as bar:
        yield _BarTell(bar, bar.add_task(name, total=total))
