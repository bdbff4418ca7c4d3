"""Calls of the command line in this process."""

import json
from typing import Any

from typer.testing import CliRunner, Result

from governor_mechanism.cli.main import app


def invoke(*words: object, **options: Any) -> Result:
    """Call the command line with these words."""
    return CliRunner().invoke(app, [str(word) for word in words], **options)


def succeed(*words: object) -> Result:
    """Call a command, which must end well."""
    result = invoke(*words)
    assert result.exit_code == 0, result.output
    return result


def json_of(*words: object) -> Any:
    """Return what a command prints as JSON; it must end well."""
    return json.loads(succeed(*words, "--json").stdout)
