"""Every command of the README and the documentation runs as it stands there: `make test-docs`."""

import subprocess
import sys
from pathlib import Path

import pytest

from documentation_pages import PAGES, ROOT, named_scenes, snippets_of

COMMAND = Path(sys.executable).with_name("governor-mechanism")


def lines(page: Path) -> list[str]:
    """Return the commands of a page, short and long, in its order."""
    found = [
        (int(snippet.place.rpartition(":")[2]), snippet.code) for language in ("sh", "sh long") for snippet in snippets_of(page, language)
    ]
    return "".join(code for _, code in sorted(found)).splitlines()


@pytest.mark.parametrize("page", [pytest.param(page, id=str(page.relative_to(ROOT))) for page in PAGES if lines(page)])
def test_commands_run(page, tmp_path):
    scenes = named_scenes(page)
    for line in lines(page):
        words = line.replace("governor-mechanism", str(COMMAND), 1)
        answer = subprocess.run(["bash", "-c", words], cwd=tmp_path, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        assert answer.returncode == 0, f"{line}\n{answer.stdout[-2000:]}\n{answer.stderr[-2000:]}"
        written = line.rpartition(" > ")[2]
        if written in scenes:
            (tmp_path / written).write_text(scenes[written], encoding="utf-8")
