"""What the commands share: how they are declared, parsed strictly and end; options, messages, JSON, progress, interrupts."""

import functools
import inspect
import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, NoReturn, Protocol

import typer
from typer import BadParameter
from typer.core import TyperCommand

from governor_mechanism.cli.options import (
    FIGURE_PARAMETERS,
    FILM_PARAMETERS,
    gather_figure_files,
    gather_film_options,
    in_typed_words,
    remember_options,
)
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.files.writing import format_json
from governor_mechanism.model.results.pictures import FilmOptions
from governor_mechanism.render.figure_files import FigureFiles

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object to standard output, and nothing else.")]
Accuracy = Annotated[float | None, typer.Option(help="Accuracy relative to the scale of each reading; by default the one of the scene.")]
EngineOfScene = Annotated[str, typer.Option(help="Name of an engine; auto uses the engine of the scene.")]
EngineOfRuns = Annotated[str, typer.Option(help="The engine of all runs.")]
Workers = Annotated[int, typer.Option(help="Largest number of processes. The result does not depend on it.")]
EXIT_OK = 0
EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130

INTERRUPT_REPEAT_INTERVAL = 1.0
"""Time after which a swallowed interrupt is raised again, s; long enough to delete a half-written file."""


class CommandExit(SystemExit):
    """End of a command that has already printed everything."""


class PlainResult(Protocol):
    """A result that can be given as JSON."""

    def as_json(self) -> Mapping[str, Any]:
        """Return all numbers in the types of JSON."""


@dataclass(frozen=True)
class CommandResult:
    """What a command reports."""

    # the result, which prints as text and is given as JSON; None for a command without one
    result: PlainResult | None = None
    _: KW_ONLY
    text: Sequence[object] | None = None  # what is printed, line by line; by default the result
    # what is printed with the option --json, after the values of the result
    values: Mapping[str, object] = field(default_factory=dict)
    files: Sequence[Path] | None = None  # the files that were written; None for a command that writes none
    ok: bool = True  # whether the command reached its goal

    def print(self, *, as_json: bool) -> None:
        """Print the result as one JSON object, or as text with the files that were written."""
        if as_json:
            values = {} if self.result is None else self.result.as_json()
            print_json({**values, **self.values, **({} if self.files is None else {"files": self.files})})
        else:
            lines = [self.result] if self.text is None else self.text
            print_to_stdout("\n".join([*map(str, lines), *(f"wrote {path}" for path in self.files or ())]))


def guarded_command(
    # function that returns its result. An option `as_json` selects how it is printed. A parameter of the type
    # FigureFiles stands for the options of folder, formats and theme, and one of the type FilmOptions for
    # those of films
    command: Callable[..., CommandResult],
) -> Callable[..., None]:
    """Print the result of a command; turn its failures into one message each and an exit status."""

    @functools.wraps(command)
    def guarded(*args: Any, **options: Any) -> None:
        """Run the command, print its result and end with its exit status."""
        as_json = bool(options.get("as_json"))
        interrupt_handler = InterruptHandler()
        try:
            with interrupt_handler:
                arguments = _gather_records(options, records)
                with _prepare_folder(arguments):
                    result = command(*args, **arguments)
                result.print(as_json=as_json)
                status = EXIT_OK if result.ok else EXIT_FAILED
        except (Exception, KeyboardInterrupt) as error:
            status = interrupt_handler.report() if interrupt_handler.was_interrupted else _report_failure(error, as_json=as_json)
        raise CommandExit(status)

    parameters = inspect.signature(command, eval_str=True).parameters
    records = {name: one.annotation for name, one in parameters.items() if one.annotation in _RECORDS}
    if records:
        _declare_options(guarded, parameters)
    return guarded


def _declare_options(command: Any, parameters: Mapping[str, inspect.Parameter]) -> None:
    """Give a command the options of its records in the places of their parameters."""
    declared = list[inspect.Parameter]()
    for parameter in parameters.values():
        options, _ = _RECORDS.get(parameter.annotation, ([parameter], None))
        declared += [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in options]
    command.__signature__ = inspect.Signature(declared)
    command.__annotations__ = {parameter.name: parameter.annotation for parameter in declared}


def _gather_records(options: Mapping[str, Any], records: Mapping[str, type]) -> dict[str, Any]:
    """Return the arguments of a command: its options, with records in the places of theirs."""
    taken = {option.name for record in records.values() for option in _RECORDS[record][0]}
    gathered = {name: _RECORDS[record][1](options) for name, record in records.items()}
    return {**{name: value for name, value in options.items() if name not in taken}, **gathered}


@contextmanager
def _prepare_folder(arguments: Mapping[str, Any]) -> Iterator[None]:
    """Make the folder of the figures before the work, if a command has any; take it away again if it is new and nothing is in it."""
    folder = next((one.folder for one in arguments.values() if isinstance(one, FigureFiles)), None)
    if folder is not None and folder.is_dir() and not os.access(folder, os.W_OK):
        raise MechanismError(f"--out {folder} is a folder in which you may not write; choose another one")
    if folder is None or folder.is_dir():
        yield
        return
    if folder.exists():
        raise MechanismError(f"--out {folder} is a file; give the name of a folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MechanismError(f"--out {folder} cannot be made: {error.strerror or error}; choose another folder") from None
    try:
        yield
    finally:
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


_RECORDS: Mapping[Any, tuple[Sequence[inspect.Parameter], Callable[[Mapping[str, Any]], object]]] = {
    FigureFiles: (FIGURE_PARAMETERS, gather_figure_files),
    FilmOptions: (FILM_PARAMETERS, gather_film_options),
}
"""Parameters that stand for a record, and the function that makes it of their values, by its type."""


def _report_failure(error: BaseException, *, as_json: bool) -> int:
    """Print what the user can correct and return the exit status; raise any other error again."""
    if isinstance(error, GovernorMechanismError):
        problems = error.problems if isinstance(error, MechanismError) else [str(error)]
        return report_problems([*map(in_typed_words, problems)], as_json=as_json)
    if isinstance(error, OSError):
        sentence = f"cannot read or write {error.filename}: {error.strerror or error}; change this, or choose another place"
        return report_problems([sentence], as_json=as_json)
    raise error


class StrictCommand(TyperCommand):
    """A command that refuses what the parser of the command line would drop, or take for the current folder, without a word."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words of the command line; end the command if an option is given twice or a value is empty."""
        if ctx.resilient_parsing:  # a shell completes words
            return super().parse_args(ctx, args)
        values, _, given = self.make_parser(ctx).parse_args(args=list(args))
        options = [one for one in given if one.param_type_name == "option"]
        problems = [*_find_repetitions(options), *_find_empty_values(given, values)]
        is_answered = any(one.is_eager for one in options)  # --help, whatever else is given
        if problems and not is_answered:
            raise CommandExit(report_problems(problems, as_json="--json" in args))
        remember_options({one.name: one.opts[0] for one in options})
        try:
            return super().parse_args(ctx, args)
        except BadParameter as error:
            error.message = error.message.removeprefix("Value error, ")  # which pydantic writes before the words of typer
            raise


def _find_repetitions(options: Sequence[Any]) -> Iterator[str]:
    """Yield one sentence for each option that is given twice and counts once."""
    for name, count in Counter(one.opts[0] for one in options if not one.multiple).items():
        if count > 1:
            yield f"{name} is given {'twice' if count == 2 else f'{count} times'}, and counts once; give it once"


def _find_empty_values(given: Sequence[Any], values: dict[str, Any]) -> Iterator[str]:
    """Yield one sentence for each argument or option with a value without a letter."""
    for parameter in dict.fromkeys(given):
        value = values.get(parameter.name)
        texts = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(text, str) and not text.strip() for text in texts):
            name = parameter.opts[0] if parameter.param_type_name == "option" else (parameter.metavar or parameter.name.upper())
            yield f"{name} is empty; give a value, or leave it out"


def add_command(
    app: typer.Typer,
    command: Callable[..., CommandResult],
    name: str | None = None,
    *,
    command_class: type[StrictCommand] = StrictCommand,
    **settings: Any,
) -> None:
    """Add a command to an application, by default under the name of its function."""
    app.command(name, cls=command_class, short_help=_first_sentence(command), **settings)(guarded_command(command))


def _first_sentence(command: Callable[..., object]) -> str:
    """Return the first paragraph of the docstring of a command, for the list of commands."""
    return (command.__doc__ or "").split("\n\n")[0].replace("\n", " ")


@contextmanager
def first_interrupt_is_answered() -> Iterator[None]:
    """Let what runs in the context answer the first Ctrl-C, by keeping what it has; the next one ends the command."""
    ending = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def answer(signal_number: int, frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, ending)
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, answer)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, ending)


class InterruptHandler:
    """Context in which Ctrl-C, or a request to terminate, is certain to end the command.

    Within a finaliser or an import, Python or a library may swallow KeyboardInterrupt or replace it by another exception.
    The interrupt is therefore repeated every second, and `was_interrupted` is True at the end. What is swallowed is not reported.
    """

    def __init__(self) -> None:
        self.was_interrupted = False
        self._signal_number: int = signal.SIGINT
        self._can_repeat = hasattr(signal, "setitimer")
        self._signals = [signal.SIGINT, signal.SIGTERM, *([signal.SIGALRM] if self._can_repeat else [])]
        self._previous_handlers: list[Any] = []
        self._previous_hook = sys.unraisablehook

    def __enter__(self) -> None:
        """Install the signal handlers, in the main thread only."""
        if threading.current_thread() is threading.main_thread():
            self._previous_handlers = [signal.signal(kind, self._handle_signal) for kind in self._signals]
            sys.unraisablehook = self._report_unraisable

    def __exit__(self, *_: object) -> None:
        """Restore the handlers; raise KeyboardInterrupt if an interrupt was swallowed."""
        if self._previous_handlers:
            if self._can_repeat:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            for signal_number, handler in zip(self._signals, self._previous_handlers, strict=True):
                signal.signal(signal_number, handler)
            sys.unraisablehook = self._previous_hook
        if self.was_interrupted:
            raise KeyboardInterrupt

    def report(self) -> int:
        """Print that the command was interrupted and return the exit status."""
        print_to_stderr("interrupted; complete files are kept, and no half-written file is left")
        return 128 + self._signal_number

    def _handle_signal(self, signal_number: int, frame: FrameType | None) -> None:
        self.was_interrupted = True
        self._signal_number = signal_number if signal_number == signal.SIGTERM else self._signal_number
        if self._can_repeat:
            signal.setitimer(signal.ITIMER_REAL, INTERRUPT_REPEAT_INTERVAL)
        raise KeyboardInterrupt

    def _report_unraisable(self, unraisable: "sys.UnraisableHookArgs") -> None:
        """Report an exception that Python has to ignore, as in a finaliser, unless it is the interrupt, which is repeated."""
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            self._previous_hook(unraisable)


def show_status(message: str) -> AbstractContextManager[object]:
    """Show a spinner with a message on a terminal; do nothing in a pipe."""
    if not sys.stderr.isatty():
        return nullcontext()
    from rich.console import Console

    return Console(stderr=True).status(message)


@contextmanager
def show_progress_bar(label: str) -> Iterator[Callable[[int, int], None] | None]:
    """Show a progress bar on a terminal and yield its update function; yield None in a pipe."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def report_problems(problems: Sequence[str], *, as_json: bool) -> int:
    """Print the user's mistakes, one sentence each, and return the exit status."""
    for problem in problems:
        print_to_stderr(problem)
    if as_json:
        print_json({"outcome": "bad_input", "problems": problems})
    return EXIT_BAD_INPUT


def print_to_stderr(message: str) -> None:
    """Print a message to standard error."""
    try:
        print(message, file=sys.stderr, flush=True)
    except OSError:  # there is no reader; what is buffered must not fail again when Python exits, so that the exit status is right
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


def print_json(value: Mapping[str, object]) -> None:
    """Print a JSON object to standard output."""
    print_to_stdout(format_json(value))


def print_to_stdout(text: str) -> None:
    """Print a text to standard output, at once: a closed pipe shows here, not when Python exits."""
    try:
        print(text, flush=True)
    except OSError as error:
        exit_without_output(error)


def exit_without_output(error: OSError) -> NoReturn:
    """End a command whose output cannot be written; what is still buffered goes nowhere. A reader who has seen enough is no failure."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if isinstance(error, BrokenPipeError):
        raise CommandExit(EXIT_OK)
    print_to_stderr(f"cannot write to standard output: {error.strerror or error}")
    raise CommandExit(EXIT_BAD_INPUT)
