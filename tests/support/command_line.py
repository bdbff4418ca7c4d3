"""Calls of the command line in this process."""

from typing import Any

from typer.testing import CliRunner, Result

from governor_mechanism.cli.main import app


def invoke(*words: object, **options: Any) -> Result:
    """Call the command line with these words."""
    return CliRunner().invoke(app, [str(word) for word in words], **options)
