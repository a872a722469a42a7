"""The command `lorentz`: one group, whose commands are in `kinetics.crosscheck`, with their work.

What a command needs is imported when it runs, so that `lorentz --help` stays quick.
"""

import os
import signal
import socket
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread
from typing import Any

import click

from kinetics.crosscheck.bench.command import bench
from kinetics.crosscheck.cli.compare import compare
from kinetics.crosscheck.commands.derive import derive
from kinetics.crosscheck.commands.options import UNITS
from kinetics.crosscheck.commands.simulate import simulate
from kinetics.crosscheck.commands.solve import solve
from kinetics.crosscheck.report.command import report
from kinetics.crosscheck.stress.command import stress

CONTEXT = {"help_option_names": ["-h", "--help"], "show_default": True, "max_content_width": 100}
BAD_INPUT, INTERRUPTED, TERMINATED = 2, 130, 143
_ENDED = {int(signal.SIGINT): INTERRUPTED, int(signal.SIGTERM): TERMINATED}
GRACE = 1.0
"""Seconds that the command has after Ctrl-C or SIGTERM to save what is complete."""


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
    """Run the command: 0, or 2 for bad input (one line on standard error), 130 after Ctrl-C.

    Without arguments it is the command line of this process, which then ends at once after Ctrl-C
    or SIGTERM: Python would wait for what still runs in other threads.
    """
    own_process = arguments is None
    if hasattr(sys.stdout, "reconfigure"):  # a terminal that lacks a sign shows ? for it
        sys.stdout.reconfigure(errors="replace")
    with _ends_in_time(), warnings.catch_warnings():
        warnings.showwarning = _show_warning
        if own_process and not sys.warnoptions:
            warnings.simplefilter("ignore", RuntimeWarning)  # numpy's, of single operations
        status = _run(arguments)
    if own_process and status in _ENDED.values():
        os._exit(status)
    return status


def _run(arguments: list[str] | None) -> int:
    """Run the command and turn whatever may stop it into an exit status."""
    try:
        status = cli.main(arguments, prog_name="lorentz", standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        return _complain(error.format_message())
    except ValueError as error:
        return _complain(str(error))
    except MemoryError as error:
        return _complain(f"not enough memory: {error}")
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except SystemExit as error:
        if error.code != TERMINATED:
            raise
        return TERMINATED
    except BrokenPipeError:
        _forget_output()
        return 0  # whoever read our output has gone
    except OSError as error:
        _forget_output()
        where = f"{error.filename}: " if error.filename else ""
        return _complain(f"{where}{error.strerror or error}")
    return status if isinstance(status, int) else 0


def _complain(message: str) -> int:
    line = " ".join(message.split())
    if len(line) > 390:  # what is wrong stands first, and what is allowed last
        line = f"{line[:240]} ... {line[-135:]}"
    click.echo(f"lorentz: {line}", err=True)
    return BAD_INPUT


def _show_warning(
    message: Warning | str,
    category: Any,
    filename: str,
    lineno: int,
    file: Any = None,
    line: Any = None,
) -> None:
    """Show a warning on one line, without the place in the source that it comes from."""
    click.echo(f"lorentz: warning: {' '.join(str(message).split())}", err=True)


def _forget_output() -> None:
    """Let what standard output could not take go nowhere: Python would try again at the end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


# -- Ctrl-C and SIGTERM ---------------------------------------------------------------------------


@contextmanager
def _ends_in_time() -> Iterator[None]:
    """Meanwhile the first Ctrl-C or SIGTERM raises an exception here, and the process ends in time.

    Unwinding removes what is half written and ends the child process. But Python raises nothing
    while compiled code runs, so the system also tells a thread of the signal, which ends the
    process `GRACE` seconds later if it is still there.
    """
    before = {number: signal.getsignal(number) for number in _ENDED}
    report_dropped = sys.unraisablehook
    sys.unraisablehook = _report_dropped
    listening, telling = socket.socketpair()
    telling.setblocking(False)
    other = signal.set_wakeup_fd(telling.fileno(), warn_on_full_buffer=False)
    Thread(target=_end_in_time, args=(listening,), daemon=True).start()
    signal.signal(signal.SIGTERM, _terminate)
    if before[signal.SIGINT] is signal.default_int_handler:  # else it is to be ignored
        signal.signal(signal.SIGINT, _interrupt)
    try:
        yield
    finally:
        signal.set_wakeup_fd(other)
        telling.close()
        sys.unraisablehook = report_dropped
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in before.items():
            signal.signal(number, handler)


def _end_in_time(listening: socket.socket) -> None:
    """Wait for a signal, then for the other end to be closed; end the process if it is not."""
    status, end = 0, 0.0
    with listening:
        try:
            while told := listening.recv(1):
                if not status and told[0] in _ENDED:
                    status, end = _ENDED[told[0]], time.monotonic() + GRACE
                if status:
                    listening.settimeout(max(end - time.monotonic(), 1e-3))
        except TimeoutError:
            os._exit(status)


def _interrupt(number: int, frame: Any) -> None:
    _ignore_the_next()
    _raise(KeyboardInterrupt(), frame)


def _terminate(number: int, frame: Any) -> None:
    _ignore_the_next()
    _raise(SystemExit(TERMINATED), frame)


def _raise(exception: BaseException, frame: Any) -> None:
    """Raise, but not in the middle of an import: half a compiled module may crash. Try again."""
    while frame is not None and hasattr(signal, "setitimer"):
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            _raise_later(exception)
            return
        frame = frame.f_back
    raise exception


def _raise_later(exception: BaseException) -> None:
    signal.signal(signal.SIGALRM, lambda number, frame: _raise(exception, frame))
    signal.setitimer(signal.ITIMER_REAL, 0.02)


def _report_dropped(dropped: Any) -> None:
    """Report what is raised in a destructor; a Ctrl-C that was dropped there is raised again."""
    if not issubclass(dropped.exc_type, KeyboardInterrupt | SystemExit):
        sys.__unraisablehook__(dropped)
    elif hasattr(signal, "setitimer"):
        ended = issubclass(dropped.exc_type, SystemExit)
        _raise_later(SystemExit(TERMINATED) if ended else KeyboardInterrupt())


def _ignore_the_next() -> None:
    """Let no second signal interrupt what the first one has begun to clean up."""
    for number in _ENDED:
        signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    sys.exit(main())
