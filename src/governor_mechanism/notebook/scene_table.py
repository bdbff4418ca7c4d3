"""A scene as a notebook shows it."""

from collections.abc import Iterator

from governor_mechanism.model.scene import Scene
from governor_mechanism.notebook.html import format_html_table, format_paragraph
from governor_mechanism.scenes.described_scene import DescribedPart
from governor_mechanism.scenes.description import describe_scene


def scene_html(scene: Scene) -> str:
    """Return a scene as HTML.

    Result: title; of each part its machine, dimensions and effects; couplings and readings.
    """
    description = describe_scene(scene)
    lines = [format_paragraph(scene.title, is_bold=True)]
    for part in description.parts:
        name = f"{part.name}: " if len(description.parts) > 1 else ""
        lines.append(format_paragraph(f"{name}{part.machine}{f', {part.spindle}' if part.spindle else ''}"))
    rows = [row for part in description.parts for row in _part_rows(part, len(description.parts) > 1)]
    rows += [(one.name, one.text) for one in description.couplings]
    rows.append(("readings", ", ".join(one.name for one in description.readings)))
    return "".join([*lines, format_html_table((), rows, n_text_columns=2)])


def _part_rows(part: DescribedPart, is_one_of_many: bool) -> Iterator[tuple[str, str]]:
    """Yield what a part has, and the list of it in words: its dimensions without those that are left out, or else its bodies and joints."""
    end = f" of {part.name}" if is_one_of_many else ""
    dimensions = [f"{one.name} {one.text}" for one in part.dimensions if one.value is not None]
    effects = [f"{one.name} {one.text}".rstrip() for one in part.effects]
    if dimensions:
        yield f"dimensions{end}", ", ".join(dimensions)
    else:
        yield f"bodies{end}", ", ".join(part.bodies)
        yield f"joints{end}", ", ".join(part.joints)
    if effects:
        yield f"effects{end}", ", ".join(effects)
