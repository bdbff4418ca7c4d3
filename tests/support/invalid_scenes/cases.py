"""The form of a case of a wrong scene file."""

Case = tuple[str, str, list[tuple[str, str]]]
"""Name of a case, text of the file, and the code and the key of every mistake."""


def wrong(name: str, text: str, *mistakes: str) -> Case:
    """Return a case of mistakes "code: key", of which a string may have several, separated by semicolons."""
    pairs = (mistake.split(": ", 1) for several in mistakes for mistake in several.split("; "))
    return name, text, [(code, key) for code, key in pairs]
