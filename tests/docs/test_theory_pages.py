"""The theory pages name what the code has: outcomes, events, engines, effects, hard cases, bounds; and the glossary is in order."""

import re

from documentation_pages import ROOT
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.engines.certificate import JOINTS_OF_FIXED_WORK
from governor_mechanism.engines.multibody.integration import MultibodySettings
from governor_mechanism.engines.reduced.integration import ReducedSettings
from governor_mechanism.engines.selection import ENGINES
from governor_mechanism.mechanics.contact import tolerances
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.studies.hard_cases.study import HARD_CASES

DOCS = ROOT / "docs"


def read(page):
    return (DOCS / "theory" / page).read_text(encoding="utf-8")


def rows(text):
    """Return the cells of all rows of tables, without those of rules."""
    lines = [line for line in text.splitlines() if line.startswith("|") and not re.fullmatch(r"[|\- ]+", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def first_codes(page):
    """Return what stands as code at the start of rows."""
    return {match[1] for row in rows(read(page)) if (match := re.match(r"`([^`]+)`", row[0]))}


def test_outcomes_of_the_limits_are_those_of_the_code_and_have_cause_and_cure():
    assert {name for name in first_codes("limits.md") if name.isupper()} == {outcome.name for outcome in Outcome}
    table = [row for row in rows(read("limits.md")) if row[0].strip("`") in Outcome.__members__]
    assert all(len(row) == 3 and all(row) for row in table)


def test_events_are_those_of_the_code():
    printed = {row[0].strip("`"): row[1] for row in rows(read("events_and_contact.md")) if row[0].strip("`") in EventKind.__members__}
    assert printed == {kind.name: kind.value for kind in EventKind}


def test_every_engine_has_a_section_and_every_effect_a_law():
    headings = re.findall(r"^## `(\w+)`", read("engines.md"), flags=re.MULTILINE)
    assert sorted(headings) == sorted(ENGINES)
    assert {effect.key for effect in EFFECTS} <= first_codes("effects.md")


def test_every_hard_case_is_in_the_tables():
    first_cells = {re.sub(r"\[(.*?)\]\(.*", r"\1", row[0]) for row in rows(read("hard_cases.md"))}
    assert set(HARD_CASES) <= first_cells


def test_bounds_are_those_of_the_code():
    for settings in (MultibodySettings(), ReducedSettings()):
        assert f"{settings.max_step_work:,.0f}" in read("limits.md")
    assert rf"\frac{{N}}{{{JOINTS_OF_FIXED_WORK} + n}}" in read("limits.md")


def test_contact_tolerances_are_those_of_the_code():
    names = ("CONTACT", "REST", "STICTION_RATE", "SIMULTANEITY", "MODE_CONSISTENCY")
    for value in (*(getattr(tolerances, f"{name}_TOLERANCE") for name in names), tolerances.MIN_REBOUND_HEIGHT):
        assert f"{value:g}".replace("e-0", "e-") in read("events_and_contact.md")


def test_every_theory_page_is_in_the_index():
    pages = {path.name for path in (DOCS / "theory").glob("*.md")} - {"index.md"}
    assert pages == set(re.findall(r"^\| \[.*?\]\((\w+\.md)\)", read("index.md"), flags=re.MULTILINE))


def test_glossary_is_sorted_without_double_entries_and_its_references_exist():
    head, *entries = rows((DOCS / "glossary.md").read_text(encoding="utf-8"))
    assert all(len(entry) == len(head) == 4 and entry[1] for entry in entries)
    terms = [entry[0].casefold() for entry in entries]
    assert terms == sorted(set(terms))
    referred = {entry[1].removeprefix("see ") for entry in entries if entry[1].startswith("see ")}
    assert referred <= {entry[0] for entry in entries}
