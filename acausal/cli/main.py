"""The command group: lazy commands, exit codes, and what happens to errors.

Exit codes: 0 done; 1 a mistake in the model or a file; 2 a mistake on the command line; 3 the
simulation failed but what was computed is kept; 70 a defect of acausal; 130 interrupted.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import click

from acausal.cli.report import report, report_error
from acausal.diagnostics import AcausalError, Diagnostic

EXIT_MODEL, EXIT_USAGE, EXIT_PARTIAL, EXIT_DEFECT, EXIT_INTERRUPTED = 1, 2, 3, 70, 130

#: Command -> module in this package and the line that ``--help`` shows. A module is imported when
#: its command runs.
COMMANDS = {
    "simulate": ("simulate", "Simulate a model; write a table, draw a plot."),
    "plot": ("plot", "Draw results that were stored in files."),
    "check": ("check", "Check a model without simulating it."),
    "inspect": ("inspect", "Show what each stage of the compiler made of a model."),
    "schematic": ("schematic", "Draw a model as a schematic diagram."),
    "report": ("model_report", "Write a report about a model and its run as one web page."),
    "animate": ("animate", "Animate a model as a web page, GIF or MP4."),
    "spice": ("spice", "Translate a SPICE netlist to a model."),
    "list": ("listing", "Show what the component library contains."),
    "reference": ("reference", "Write the reference of the component library as web pages."),
    "messages": ("messages", "Tell what message codes mean."),
}

EXAMPLES = """\b
Examples:
  acausal simulate rlc.acm --plot rlc.png
  acausal simulate rlc.acm -p r.R=1[kOhm] --stop 0.2 --output run.csv
  acausal check rlc.acm
  acausal inspect rlc.acm --stage structure
  acausal list electrical.Resistor
"""


class LazyGroup(click.Group):
    """A group that imports a command's module when the command is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order in which a person meets them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command, or return None if there is none of this name."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"acausal.cli.{COMMANDS[cmd_name][0]}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the arguments, or say which may have been meant.

        Raises:
            click.UsageError: If there is no such command.
        """
        name = args[0]
        if name in COMMANDS or name.startswith("-"):
            return super().resolve_command(ctx, args)
        from acausal.diagnostics.suggest import nearest

        close = nearest(name, COMMANDS)
        if close:
            hint = f"Did you mean '{close[0]}'?"
        elif name.endswith((".acm", ".mo", ".cir")):
            hint = f"To simulate the file: acausal simulate {name}"
        else:
            hint = f"The commands are {', '.join(COMMANDS)}."
        raise click.UsageError(f"There is no command '{name}'. {hint}", ctx)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, about) for name, (_, about) in COMMANDS.items()])


def _version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        from acausal.cli.versions import versions

        click.echo(versions())
        ctx.exit()


@click.group(
    cls=LazyGroup,
    epilog=EXAMPLES,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="Show the version, and which SUNDIALS is used.",
)
def group() -> None:
    """Simulate physical systems written as components that are plugged together."""


def run(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and end the process.

    It ends without taking the interpreter and the native libraries apart piece by piece, which
    would take a fifth of the time of a small simulation. Every file is closed by then.

    Args:
        arguments: Words after the program's name; those of the process if None.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    code = execute(words)
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:
        _drop_stdout()
    if sys.gettrace() is not None or sys.getprofile() is not None:
        raise SystemExit(code)  # a debugger, profiler or coverage tool has work left to do
    os._exit(code)


def execute(words: list[str]) -> int:
    """Run the command line and return its exit code; every error has been told."""
    as_json = "--json-errors" in words
    try:
        code = group.main(words, prog_name="acausal", standalone_mode=False, obj=as_json)
    except AcausalError as error:
        report(error, as_json)
        return EXIT_MODEL
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return EXIT_USAGE
    except click.ClickException as error:
        if as_json:
            report([Diagnostic("F401", error.format_message())], as_json)
        else:
            error.show()
        return EXIT_USAGE
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        _drop_stdout()
        return 0
    except MemoryError:
        report(
            [
                Diagnostic(
                    "F402",
                    "the memory of this machine is not large enough",
                    help="make the model smaller, or keep fewer variables with --variables "
                    "and fewer points with --points",
                )
            ],
            as_json,
        )
        return EXIT_MODEL
    except Exception as error:
        if os.environ.get("ACAUSAL_TRACEBACK"):
            raise
        report_error(error, as_json)
        return EXIT_DEFECT
    return code if isinstance(code, int) else 0


def _drop_stdout() -> None:
    """Let the interpreter close a pipe that nobody reads any more without a complaint."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
