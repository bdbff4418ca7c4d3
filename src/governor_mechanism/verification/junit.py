"""A check as a JUnit file, which continuous integration shows."""

from pathlib import Path
from xml.etree import ElementTree

from governor_mechanism.files.writing import atomic_write
from governor_mechanism.verification.report import CheckReport, ComparisonRow
from governor_mechanism.verification.user_kernel.report import KernelReport, KernelRow, format_percent


def save_junit(report: CheckReport, path: Path) -> Path:
    """Write a check as a JUnit file, with a test case for each comparison.

    Raises MechanismError if the file cannot be written.
    """
    defects = report.defects if isinstance(report, KernelReport) else ()
    n_failed = sum(not row.passed for row in report.rows) + len(defects)
    counts = {"tests": str(len(report.rows) + len(defects)), "failures": str(n_failed), "errors": "0"}
    suite = ElementTree.Element("testsuite", {"name": f"governor-mechanism crosscheck: {_clean(report.title)}", **counts})
    class_name = f"crosscheck.{report.against.replace(' ', '_')}"
    for row in report.rows:
        case = ElementTree.SubElement(suite, "testcase", {"classname": class_name, "name": _clean(row.quantity)})
        if not row.passed:
            message = _clean(_describe_failure(row))
            ElementTree.SubElement(case, "failure", {"message": message}).text = message
    for number, defect in enumerate(defects, start=1):
        case = ElementTree.SubElement(suite, "testcase", {"classname": class_name, "name": f"defect {number}"})
        ElementTree.SubElement(case, "failure", {"message": _clean(defect)}).text = _clean(defect)
    if report.notes:
        ElementTree.SubElement(suite, "system-out").text = _clean("\n".join(report.notes))
    root = ElementTree.Element("testsuites", counts)
    root.append(suite)
    ElementTree.indent(root)
    with atomic_write(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
    return path


def _describe_failure(row: ComparisonRow) -> str:
    """Return what differs, in a sentence."""
    if isinstance(row, KernelRow) and row.problem:
        return row.problem
    sentence = f"{row.expected:.12g} against the simulated {row.simulated:.12g} {row.unit}, allowed {row.allowed:.1e}"
    return f"{sentence}; {format_percent(row.relative_error)}" if isinstance(row, KernelRow) else sentence


def _clean(text: str) -> str:
    """Return a text without the control characters that XML does not have."""
    return "".join(letter for letter in text if letter >= " " or letter in "\n\t")
