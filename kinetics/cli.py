"""The command `lorentz`: one group; a command is loaded from `kinetics.crosscheck.cli` when named.

Exit status: 0; 1 where a comparison or a stability sweep says so; 2 for bad input, and for output
that cannot be written (one line on standard error); 130 after Ctrl-C and 143 after SIGTERM.
"""

import contextlib
import os
import signal
import sys
import warnings
from importlib import import_module

import click
from click.shell_completion import shell_complete

from kinetics.crosscheck.cli.options import UNITS
from kinetics.errors import printable, suggestion
from kinetics.interruption import EXIT_STATUS, ends_at_a_signal

BAD_INPUT = click.UsageError.exit_code
#: The commands, in the order of the help, and the module of each in `kinetics.crosscheck.cli`.
COMMANDS = {
    "report": "report",
    "solve": "solve",
    "simulate": "simulate",
    "merge": "simulate",
    "compare": "compare",
    "fit": "fit",
    "explore": "explore",
    "derive": "derive",
    "bench": "bench",
    "stress": "bench",
}
#: Packages of this distribution.
PACKAGES = ("kinetics", "particles", "derivations")
DISTRIBUTION = "inelastic-lorentz"
#: Characters of a message that are shown: what is wrong stands first, what is allowed last.
MESSAGE_BEGIN = 240
#: Characters of the end of such a message.
MESSAGE_END = 135
#: The environment variable with which a shell asks for completions, as click names it.
COMPLETION_VARIABLE = "_LORENTZ_COMPLETE"


class _Commands(click.Group):
    """Commands that are imported when they are named."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(dict.fromkeys([*COMMANDS, *self.commands]))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the first word, or say which one was probably meant."""
        name = args[0]
        if not name.startswith("-") and self.get_command(ctx, name) is None:
            near = suggestion(name, self.list_commands(ctx))
            ctx.fail(f"no such command {name!r}{near}")
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name in COMMANDS and cmd_name not in self.commands:
            module = import_module(f"kinetics.crosscheck.cli.{COMMANDS[cmd_name]}")
            self.add_command(getattr(module, cmd_name))
        return self.commands.get(cmd_name)


def _print_version(context: click.Context, option: click.Parameter, is_requested: bool) -> None:
    if not is_requested:
        return
    from kinetics import __version__

    click.echo(f"lorentz, version {__version__}")
    conflict = other_owners()
    if conflict:
        _say(conflict)
    context.exit()


def other_owners() -> str:
    """Return one line if another distribution has a package of our names; else an empty one.

    pip does not notice it, and imports would mix both.
    """
    from importlib.metadata import packages_distributions

    distributions = packages_distributions()
    for package in PACKAGES:
        others = set(distributions.get(package, ())) - {DISTRIBUTION}
        if others:
            owners = ", ".join(sorted(others))
            return f"the package {package!r} is also of {owners}; use a fresh environment"
    return ""


@click.group(
    cls=_Commands,
    context_settings={
        "help_option_names": ["-h", "--help"],
        "show_default": True,
        "max_content_width": 100,
    },
    invoke_without_command=True,
    epilog=UNITS,
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show the version and exit.",
)
@click.pass_context
def cli(context: click.Context) -> None:
    """The inelastic Lorentz gas: a kinetic solver, an event-driven simulator, sympy derivations,
    and a report that compares the three.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit status (see the module).

    Without arguments it is the command line of this process, which ends at once after a signal.
    """
    is_own_process = arguments is None
    if is_own_process and COMPLETION_VARIABLE in os.environ:
        instruction = os.environ[COMPLETION_VARIABLE]
        return shell_complete(cli, {}, "lorentz", COMPLETION_VARIABLE, instruction)
    if sys.stdout is None:  # closed by the shell: the next file would take its place
        return _complain("standard output is closed; send it to a file, or to /dev/null")
    if hasattr(sys.stdout, "reconfigure"):  # a terminal that lacks a sign shows ? for it
        sys.stdout.reconfigure(errors="replace")
    with ends_at_a_signal(), warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: _say(f"warning: {message}")
        if is_own_process and not sys.warnoptions:
            warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of single operations
        status = _run(sys.argv[1:] if arguments is None else arguments)
    if is_own_process:
        if status in EXIT_STATUS.values():
            os._exit(status)
        _flush_outputs()
    return status


def _flush_outputs() -> None:
    """Flush the standard streams; one that takes nothing would fail again as Python ends."""
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _run(arguments: list[str]) -> int:
    """Run the command, and return an exit status for whatever may stop it."""
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
        return EXIT_STATUS[signal.SIGINT]
    except SystemExit as error:
        if error.code not in EXIT_STATUS.values():
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
        conflict = other_owners()
        if conflict:
            return _complain(conflict)
        raise


def _complain(message: str) -> int:
    """Say what is wrong in one line, and return the status of bad input."""
    line = " ".join(message.split())
    if len(line) > MESSAGE_BEGIN + MESSAGE_END:
        line = f"{line[:MESSAGE_BEGIN]} ... {line[-MESSAGE_END:]}"
    _say(line)
    return BAD_INPUT


def _say(message: str) -> None:
    """Write one line to standard error, if that takes it: the status tells how a command ended."""
    line = printable(" ".join(message.split()))
    with contextlib.suppress(OSError, ValueError, AttributeError):  # click 8.1.0: none is there
        click.echo(f"lorentz: {line}", err=True)


if __name__ == "__main__":
    sys.exit(main())
