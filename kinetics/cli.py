"""The command `lorentz`: one group; a command is loaded from `kinetics.crosscheck.cli` when named.

Exit status: 0; 1 where a comparison or a stability sweep says so; 2 for bad input, and for output
that cannot be written (one line on standard error); 130 after Ctrl-C and 143 after SIGTERM.
"""

import contextlib
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from importlib import import_module
from threading import Timer
from typing import Any

import click

from kinetics.crosscheck.cli.options import UNITS

BAD_INPUT = click.UsageError.exit_code
ENDED = {int(signal.SIGINT): 130, int(signal.SIGTERM): 143}
"""Signals that end a command -> its exit status."""
GRACE = 1.0  # seconds that it then has to remove what is half written and say what is saved
COMMANDS = (
    "report", "solve", "simulate", "merge", "compare", "fit", "explore", "derive", "bench",
    "stress",
)  # fmt: skip


class _Commands(click.Group):
    """Commands that are imported when they are asked for, from the rooms of the cross-check."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(dict.fromkeys((*COMMANDS, *self.commands)))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name in COMMANDS and cmd_name not in self.commands:
            homes = {"stress": "bench", "fit": "compare", "merge": "simulate"}
            home = homes.get(cmd_name, cmd_name)
            module = import_module(f"kinetics.crosscheck.cli.{home}")
            self.add_command(getattr(module, cmd_name))
        return self.commands.get(cmd_name)


def _print_version(context: click.Context, option: click.Parameter, asked: bool) -> None:
    if asked:
        from kinetics import __version__

        click.echo(f"lorentz, version {__version__}")
        if line := other_owners():
            _say(line)
        context.exit()


def other_owners() -> str:
    """One line if other distributions have packages of our names, which pip does not notice."""
    from importlib.metadata import packages_distributions

    owners = packages_distributions()
    names = ("kinetics", "particles", "derivations")
    for name, others in ((name, {*owners.get(name, ())} - {"inelastic-lorentz"}) for name in names):
        if others:
            whose = ", ".join(sorted(others))
            return f"the package {name!r} is also of {whose}; use a fresh environment"
    return ""


@click.group(
    cls=_Commands,
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True,
                      "max_content_width": 100},
    invoke_without_command=True,
    epilog=UNITS,
)  # fmt: skip
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_print_version,
    help="Show the version and exit.",
)  # fmt: skip
@click.pass_context
def cli(context: click.Context) -> None:
    """The inelastic Lorentz gas: a kinetic solver, an event-driven simulator, sympy derivations,
    and a report that compares the three.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit status, see above.

    Without arguments it is the command line of this process, which ends at once after a signal.
    """
    own_process = arguments is None
    if sys.stdout is None:  # closed by the shell: the next file would take its place
        return _complain("standard output is closed; send it to a file, or to /dev/null")
    if hasattr(sys.stdout, "reconfigure"):  # a terminal that lacks a sign shows ? for it
        sys.stdout.reconfigure(errors="replace")
    with _ends_at_a_signal(), warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: _say(f"warning: {message}")
        if own_process and not sys.warnoptions:
            warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of single operations
        status = _run(sys.argv[1:] if arguments is None else arguments)
    if own_process and status in ENDED.values():
        os._exit(status)
    for stream in filter(None, (sys.stdout, sys.stderr)) if own_process else ():
        try:
            stream.flush()
        except OSError:  # what it does not take would fail again as Python ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    return status


def _run(arguments: list[str]) -> int:
    """Run the command and turn whatever may stop it into an exit status."""
    try:
        with cli.make_context("lorentz", list(arguments)) as context:
            status = cli.invoke(context)
        sys.stdout.flush()
        return status if isinstance(status, int) else 0
    except click.exceptions.Exit as done:
        return done.exit_code
    except click.ClickException as error:
        return _complain(error.format_message())
    except MemoryError as error:
        return _complain(f"not enough memory: {error}")
    except (KeyboardInterrupt, click.Abort):
        return ENDED[signal.SIGINT]
    except SystemExit as error:
        if error.code not in ENDED.values():
            raise
        return int(error.code or 0)
    except BrokenPipeError:
        return 0  # whoever read our output has gone
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _complain(f"{where}{error.strerror or error}")
    except ValueError as error:
        return _complain(str(error))
    except (ImportError, AttributeError):
        if line := other_owners():
            return _complain(line)
        raise


def _complain(message: str) -> int:
    line = " ".join(message.split())
    # what is wrong stands first, and what is allowed last
    _say(line if len(line) <= 390 else f"{line[:240]} ... {line[-135:]}")
    return BAD_INPUT


def _say(message: str) -> None:
    """One line on standard error, if that takes it: what a command ends with is its status."""
    with contextlib.suppress(OSError, ValueError, AttributeError):  # click 8.1.0: none is there
        click.echo(f"lorentz: {' '.join(message.split())}", err=True)


@contextlib.contextmanager
def _ends_at_a_signal() -> Iterator[None]:
    """Meanwhile the first signal raises an exception here, and ends the process in time."""
    before = {number: signal.getsignal(number) for number in ENDED}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, _raise)
    try:
        yield
    finally:
        while _LATE:
            _LATE.pop().cancel()
        for number, handler in before.items():
            signal.signal(number, handler)


_LATE: list[Timer] = []  # what ends the process if the exception does not


def _raise(number: int, frame: Any) -> None:
    """Raise, but not in an import, half of which may crash, nor in a finaliser, which loses it."""
    while frame is not None and hasattr(signal, "setitimer"):
        file, name = frame.f_code.co_filename, frame.f_code.co_name
        if file.startswith("<frozen importlib") or name in ("__del__", "remove", "_remove"):
            signal.signal(signal.SIGALRM, lambda _, later: _raise(number, later))
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            return
        frame = frame.f_back
    _LATE.append(Timer(GRACE, os._exit, [ENDED[number]]))
    _LATE[-1].daemon = True
    _LATE[-1].start()
    for one in ENDED:  # no second signal interrupts what the first has begun to clean up
        signal.signal(one, signal.SIG_IGN)
    raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(ENDED[number])


if __name__ == "__main__":
    sys.exit(main())
