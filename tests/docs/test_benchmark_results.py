"""The tables of benchmarks/RESULTS.md are found by the script that writes them, and belong to scripts that exist."""

import importlib.util

from documentation_pages import ROOT

FOLDER = ROOT / "benchmarks"


def load_script():
    spec = importlib.util.spec_from_file_location("write_results", FOLDER / "write_results.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script


def test_each_table_belongs_to_a_script():
    script, text = load_script(), (FOLDER / "RESULTS.md").read_text(encoding="utf-8")
    names = script.TABLES.findall(text)
    assert len(names) == len(set(names)) == text.count("<!-- table: ") == text.count("<!-- end -->")
    assert [name for name in names if not (FOLDER / f"{name}.py").is_file()] == []


def test_the_tables_of_one_script_are_replaced_and_nothing_else():
    text = "a\n<!-- table: one -->\n\n| 1 |\n\n<!-- end -->\nb\n<!-- table: two -->\n\n| 2 |\n\n<!-- end -->\nc\n"
    assert load_script().replace_tables(text, "two", "| 3\\1 |\n") == text.replace("| 2 |", "| 3\\1 |")
