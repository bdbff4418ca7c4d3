"""The table of compiled kernels."""

from __future__ import annotations

from governor_mechanism.studies import kernel_compilation


def test_the_table_counts_what_each_use_adds_to_the_cache(tmp_path, monkeypatch):
    def compile_two():
        for name in ("first.nbc", "second.nbc", "second.nbi"):
            (tmp_path / name).touch()

    monkeypatch.setattr(kernel_compilation, "kernel_cache_folder", lambda: tmp_path)
    monkeypatch.setattr(kernel_compilation, "_KERNEL_USES", {"engine": compile_two, "statics": lambda: None})
    compilation = kernel_compilation.compile_all_kernels()
    assert [(use.name, use.n_compiled) for use in compilation.uses] == [("engine", 2), ("statics", 0)]
    heading, row = str(compilation).splitlines()
    assert heading.split() == ["compiled", "for", "kernels", "seconds", "folder"]
    assert row.split()[:2] == ["engine", "2"]
    assert row.endswith(str(tmp_path))
    assert compilation.as_json()["folder"] == str(tmp_path)
    assert str(kernel_compilation.compile_all_kernels()) == f"all kernels are compiled already, in {tmp_path}"
