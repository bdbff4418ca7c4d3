"""The tables of benchmarks/RESULTS.md are found by the script that writes them, and belong to scripts that exist."""

from documentation_pages import ROOT, load_script

FOLDER = ROOT / "benchmarks"
SCRIPT = load_script(FOLDER / "write_results.py")


def test_each_table_belongs_to_a_script():
    text = (FOLDER / "RESULTS.md").read_text(encoding="utf-8")
    names = SCRIPT.TABLES.findall(text)
    assert len(names) == len(set(names)) == text.count("<!-- table: ") == text.count("<!-- end -->")
    assert [name for name in names if not (FOLDER / f"{name}.py").is_file()] == []


def test_the_tables_of_one_script_are_replaced_and_nothing_else():
    text = "a\n<!-- table: one -->\n\n| 1 |\n\n<!-- end -->\nb\n<!-- table: two -->\n\n| 2 |\n\n<!-- end -->\nc\n"
    assert SCRIPT.replace_tables(text, "two", "| 3\\1 |\n") == text.replace("| 2 |", "| 3\\1 |")
