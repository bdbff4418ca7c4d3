"""What a page says of a run in words: its source, its effects and loads, its accuracy and its cost."""

from collections.abc import Iterator
from pathlib import Path

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.number_format import format_closing_lines, format_name
from governor_mechanism.render.page.picture import PICTURE_SIZE
from governor_mechanism.scenes.description import describe_scene
from governor_mechanism.types import FloatArray

_SCHEMA_MARK = "#:"
"""Start of a comment for editors, which is no text."""
_CLOSING_LINE_LENGTH = 400
MAX_NAMED_EVENTS = 6
"""Largest number of events that are listed one by one."""


def read_caption(scene: Scene) -> str:
    """Return the comment at the head of the scene file: what the mechanism is, and where it is from. Empty without a file or a comment."""
    path = Path(scene.source)
    if not scene.source or not path.is_file():
        return ""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith(_SCHEMA_MARK):
            lines.append(line.lstrip("# ").rstrip())
    return " ".join(filter(None, lines))


def list_effects(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield name and parameters of each effect, force element, coupling and load of a scene."""
    description = describe_scene(scene)
    for part in description.parts:
        prefix = f"{format_name(part.name)}: " if len(description.parts) > 1 else ""
        if part.spindle:
            yield f"{prefix}spindle", part.spindle.removeprefix("spindle ")
        for effect in part.effects:
            yield f"{prefix}{format_name(effect.name)}", effect.text or "acts on all bodies"
    names = {coupling.name for coupling in description.couplings}
    elements = [element for element in description.force_elements if element.name not in names]
    for element in (*elements, *description.couplings):
        yield format_name(element.name), f"{element.kind}, {element.text}" if element.text else element.kind


def list_dimensions(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield name and value of each dimension that is given."""
    description = describe_scene(scene)
    for part in description.parts:
        prefix = f"{format_name(part.name)}: " if len(description.parts) > 1 else ""
        for dimension in part.dimensions:
            if dimension.value is not None:
                yield f"{prefix}{format_name(dimension.name)}", dimension.text


def describe_accuracy(run: Trajectory, times: FloatArray) -> list[tuple[str, str]]:
    """Return what is known of the accuracy of a run and of its drawing at sample times (n,) s, and what it cost."""
    cost = run.cost
    lines, _ = format_closing_lines(run, _CLOSING_LINE_LENGTH)
    runs = f"{cost.runs} runs, " if cost.runs > 1 else ""
    rows = [
        ("engine", f"{cost.engine}{f': {cost.reason}' if cost.reason else ''}"),
        ("accuracy", "; ".join(lines) + ", relative to the scale of each reading" * (run.error_estimate is not None)),
        ("cost", f"{runs}{cost.steps} steps, {1e3 * cost.wall_time:.3g} ms"),
        ("outcome", run.message),
        ("drawing", _describe_drawing(times)),
    ]
    if run.events:
        rows.append(("events", "; ".join(map(str, run.events[:MAX_NAMED_EVENTS])) + _rest(len(run.events) - MAX_NAMED_EVENTS)))
    return rows


def _describe_drawing(times: FloatArray) -> str:
    """Return how the drawing follows the run."""
    rounding = f"positions rounded to 1/{PICTURE_SIZE} of the picture"
    if len(times) < 2:
        return f"one moment; {rounding}"
    step = 1e3 * float(times[1] - times[0])
    return f"{len(times)} moments, {step:.3g} ms apart, with a cubic between them; {rounding}"


def _rest(count: int) -> str:
    """Return how many more there are."""
    return f"; and {count} more" if count > 0 else ""
