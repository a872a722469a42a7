"""The command `lorentz`: one group, whose commands are in `kinetics.crosscheck`, with their work.

What a command needs is imported when it runs, so that `lorentz --help` stays quick.
"""

import os
import signal
import sys
from typing import Any

import click

from kinetics.crosscheck.bench.command import bench
from kinetics.crosscheck.commands.derive import derive
from kinetics.crosscheck.commands.options import STOP, UNITS
from kinetics.crosscheck.commands.simulate import simulate
from kinetics.crosscheck.commands.solve import solve
from kinetics.crosscheck.comparison.command import compare
from kinetics.crosscheck.report.command import report
from kinetics.crosscheck.stress.command import stress

CONTEXT = {"help_option_names": ["-h", "--help"], "show_default": True, "max_content_width": 100}
BAD_INPUT, INTERRUPTED, TERMINATED = 2, 130, 143


def _print_version(context: click.Context, option: click.Parameter, asked: bool) -> None:
    if asked:
        from kinetics import __version__

        click.echo(f"lorentz, version {__version__}")
        context.exit()


@click.group(
    context_settings=CONTEXT,
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


for command in (report, solve, simulate, compare, derive, bench, stress):
    cli.add_command(command)


def main(arguments: list[str] | None = None) -> int:
    """Run the command: 0, or 2 for bad input (one line on standard error), 130 after Ctrl-C."""
    STOP.clear()
    signal.signal(signal.SIGTERM, _terminate)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)
    if hasattr(sys.stdout, "reconfigure"):  # a terminal that lacks a sign shows ? for it
        sys.stdout.reconfigure(errors="replace")
    try:
        cli.main(arguments, prog_name="lorentz", standalone_mode=False)
    except click.ClickException as error:
        return _complain(error.format_message())
    except ValueError as error:
        return _complain(str(error))
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read our output has gone; nothing is left to flush to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return 0


def _complain(message: str) -> int:
    line = " ".join(message.split())
    if len(line) > 390:  # what is wrong stands first, and what is allowed last
        line = f"{line[:240]} ... {line[-135:]}"
    click.echo(f"lorentz: {line}", err=True)
    return BAD_INPUT


def _interrupt(number: int, frame: Any) -> None:
    """As Python does, and leave word for loops that would not notice: see STOP."""
    STOP.append(KeyboardInterrupt)
    raise KeyboardInterrupt


def _terminate(number: int, frame: Any) -> None:
    """End as after Ctrl-C: unwinding removes what is half written and ends the child process."""
    sys.exit(TERMINATED)


if __name__ == "__main__":
    sys.exit(main())
