"""All hard cases by name."""

from governor_mechanism.studies.hard_cases import governor_cases, linkage_cases, weight_cases
from governor_mechanism.studies.hard_cases.case import HardCase

HARD_CASES: dict[str, HardCase] = {case.name: case for case in (*weight_cases.CASES, *linkage_cases.CASES, *governor_cases.CASES)}
"""The hard cases, in the order of the study."""
