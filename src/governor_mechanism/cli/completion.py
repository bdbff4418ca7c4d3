"""Words that a shell completes: names of scenes and of machines. Nothing heavy is imported."""

from pathlib import Path

TEMPLATES = (
    "custom",
    "flywheel_engine",
    "governed-engine",
    "hartnell",
    "hartung",
    "parabolic_governor",
    "pendulum_governor",
    "proell",
    "slide_valve",
    "slider_crank",
    "stephenson",
)
"""What `init` writes; a test compares it with the registry of machines, which is slow to import."""


def complete_scene(incomplete: str) -> list[str]:
    """Return the shipped scenes, and the scene files and folders of the file system, that begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes, shipped_scenes

    names = [name for name in (*shipped_scenes(), *catalogue_scenes()) if name.startswith(incomplete)]
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") else typed.parent
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return names
    paths = [f"{entry}/" if entry.is_dir() else str(entry) for entry in entries if entry.is_dir() or entry.suffix == ".toml"]
    return names + [path for path in paths if path.startswith(incomplete)]


def complete_machine(incomplete: str) -> list[str]:
    """Return machines and classic mechanisms for which there is a scene file to begin with, and whose names begin with what is typed."""
    from governor_mechanism.scenes.library import catalogue_scenes

    return [name for name in (*TEMPLATES, *catalogue_scenes()) if name.startswith(incomplete)]
