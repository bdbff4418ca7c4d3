"""The package layout: imports point one way between folders, no cycles, and the two independent routes never meet."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import Counter
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

PACKAGE = "governor_mechanism"
SOURCE = Path(__file__).parents[1] / "src" / PACKAGE

FOLDERS = [
    {"errors"},
    {"types", "later_module"},
    {"numerics"},
    {"units"},
    {"model"},
    {"effects"},
    {"machines", "closed_form", "mechanics"},
    {"integrators"},
    {"statics"},
    {"observables"},
    {"engines"},
    {"scenes"},
    {"building"},
    {"files"},
    {"verification"},
    {"studies"},
    {"render"},
    {"papers"},
    {"__init__"},
    {"live"},
    {"notebook"},
    {"api"},
    {"cli", "pytest_plugin"},
]
"""A folder imports only folders of an earlier set. The package itself imports none before a public name is asked for."""

INNER_FOLDERS = {
    "model": [{"*"}, {"results"}],
    "mechanics": [{"curves"}, {"kinematics"}, {"dynamics"}, {"reduction"}, {"contact"}],
    "mechanics/dynamics": [
        {"contacts", "force_laws"},
        {"inputs"},
        {"output_forces"},
        {"contact_modes"},
        {"arrays", "characteristic_scales"},
        {"event_functions"},
        {"lowering"},
        {"body_forces"},
        {"constrained_solution"},
        {"equations_of_motion"},
    ],
    "engines": [
        {"continuation", "exit_location"},
        {"base"},
        {"certificate", "initial_state"},
        {"impulse", "multibody", "reduced"},
        {"selection"},
        {"__init__"},
    ],
    "engines/impulse": [{"applied_forces"}, {"pymunk_contact"}, {"pymunk_model"}, {"*"}],
    "papers": [
        {"erratum"},
        {"dubois", "redtenbacher", "zehnder"},
        {"errata_results"},
        {"errata_drawings"},
        {"rule"},
        {"droop"},
        {"damping", "dead_band", "shaking"},
        {"rules_study"},
    ],
    "render": [
        {"*"},
        {"machines"},
        {"range_bands"},
        {"frame_data"},
        {"motion_layers", "plot_panels"},
        {"figures"},
        {"page"},
        {"film"},
        {"dxf", "results_folder"},
    ],
    "scenes": [
        {"described_scene"},
        {"quantities"},
        {"loads"},
        {"effect_tables", "schema"},
        {"custom"},
        {"description", "document", "json_schema"},
        {"parser"},
        {"changed_document"},
        {"library"},
        {"template"},
    ],
    "studies": [
        {"compared_quantities", "effect_ablation", "equilibrium_report", "kinematics", "plain_runs"},
        {"sweep"},
        {"assemblies", "comparison", "hard_cases", "regulation", "unknowns", "valve_gears", "work_precision_results"},
        {"design", "fitting", "optimisation", "sensitivities", "synthesis", "work_precision"},
    ],
    "verification": [
        {"report"},
        {"laws", "user_kernel_simulation"},
        {"machines", "user_kernel", "user_kernel_quantities"},
        {"user_kernel_comparison"},
    ],
}
"""The same order inside folders; "*" stands for every other module."""

MAX_FILES = 14
"""Largest number of files in a folder that is read as a whole."""
ROOMS_OF_MANY = {"closed_form", "effects", "machines", "render/machines", "verification/machines"}
"""Folders with one file for each closed form, effect, machine or joint, whose files are read one at a time."""

ONLY = {
    "pymunk": {f"engines/impulse/{one}.py" for one in ("applied_forces", "pymunk_contact", "pymunk_model")},
    "matplotlib": {"render", "papers"},
    "PIL": {"render"},
    "imageio": {"render"},
    "ezdxf": {"render"},
    "pint": {"units"},
    "typer": {"cli"},
    "joblib": {"studies"},
    "xarray": {"files", "types.py"},
    "pandas": {"files", "types.py"},
    "anywidget": {"notebook"},
    "tomlkit": {"live"},
    "starlette": {"live"},
    "uvicorn": {"live"},
}
"""The only folders and files that import a package."""


DELEGATIONS = {
    "model.results.trajectory": {
        f"Trajectory.{name}"
        for name in (
            "paths",
            "to_xarray",
            "to_dataframe",
            "as_json",
            "plot_diagnostics",
            "plot_paths",
            "plot_reactions",
            "film",
            "save",
            "save_dxf",
            "_repr_html_",
        )
    },
    "model.results.records": {"Energy._repr_html_", "Reaction._repr_html_"},
    "model.results.result": {
        "Recorded.as_json",
        *(f"Result.{name}" for name in ("__str__", "to_dataframe", "save_json", "save_csv", "figures", "_draw", "_repr_html_")),
    },
    "model.scene": {f"Scene.{name}" for name in ("from_dict", "replace", "to_toml", "save", "describe", "_repr_html_")},
    "model.mechanism": {"Mechanism.build", "Mechanism._repr_html_"},
    "mechanics.kinematics.kinematic_analysis": {"Kinematics.plot_paths"},
    "statics.speed_curve": {"SpeedCurve._repr_html_"},
    "studies.comparison": {"Comparison.film"},
    "building.mechanism_builder": {"MechanismBuilder.assemblies"},
}
"""Methods that hand on to a function of a later folder, by module. They alone import upwards, and do nothing else."""

DELEGATED_TYPES = {
    "model.scene": {"described_scene"},
    "model.mechanism": {"mechanism_builder"},
    "building.mechanism_builder": {"assemblies"},
}
"""Modules with what such methods return: a type checker alone imports them upwards, and otherwise who reads an annotation."""


@cache
def modules() -> dict[str, Path]:
    """Dotted names inside the package, with their files."""
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts) or "__init__"] = path
    return found


def delegations_of(path: Path, tree: ast.Module) -> dict[str, ast.FunctionDef]:
    """The methods of a file that DELEGATIONS lists, by name."""
    listed = DELEGATIONS.get(".".join(path.relative_to(SOURCE).with_suffix("").parts), set())
    methods = (
        (f"{owner.name}.{node.name}", node)
        for owner in tree.body
        if isinstance(owner, ast.ClassDef)
        for node in owner.body
        if isinstance(node, ast.FunctionDef)
    )
    return {name: node for name, node in methods if name in listed}


def type_imports_of(path: Path, tree: ast.Module) -> list[ast.ImportFrom]:
    """The imports for type checkers alone of the names that DELEGATED_TYPES lists."""
    listed = DELEGATED_TYPES.get(".".join(path.relative_to(SOURCE).with_suffix("").parts), set())
    blocks = [node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
    return [node for node in imports if {alias.name for alias in node.names} <= listed]


@cache
def imported(path: Path) -> frozenset[str]:
    """Every module named in any form of import, wherever it stands, also for type checkers alone; without those of delegations."""
    names: set[str] = set()
    package = [PACKAGE, *path.relative_to(SOURCE).with_suffix("").parts[:-1]]
    tree = ast.parse(path.read_text(encoding="utf-8"))
    handed_on = {id(inner) for method in delegations_of(path, tree).values() for inner in ast.walk(method)}
    handed_on |= {id(node) for node in type_imports_of(path, tree)}
    for node in (node for node in ast.walk(tree) if id(node) not in handed_on):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, [base, node.module]))
            names |= {f"{module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            names |= {str(argument.value) for argument in node.args if isinstance(argument, ast.Constant)}
    return frozenset(names)


@cache
def dependencies(path: Path) -> frozenset[str]:
    """The modules of the package that a file imports."""
    found = set()
    for name in imported(path):
        if name.split(".")[0] != PACKAGE:
            continue
        inside = name.split(".")[1:]
        while inside and ".".join(inside) not in modules():
            inside = inside[:-1]
        found.add(".".join(inside) or "__init__")
    return frozenset(found)


def folder_of(module: str, depth: int = 0) -> str:
    return module.split(".")[depth]


def rank(order: list[set[str]], name: str) -> int:
    for position, names in enumerate(order):
        if name in names:
            return position
    return next((position for position, names in enumerate(order) if "*" in names), -1)


def test_every_folder_has_a_place_in_the_order():
    unplaced = {folder_of(module) for module in modules() if rank(FOLDERS, folder_of(module)) < 0}
    assert not unplaced


@pytest.mark.parametrize("folder", sorted({folder_of(module) for module in modules()}))
def test_a_folder_imports_only_folders_before_it(folder):
    wrong = [
        f"{module} imports {other}"
        for module, path in modules().items()
        if folder_of(module) == folder
        for other in dependencies(path)
        if folder_of(other) != folder and rank(FOLDERS, folder_of(other)) >= rank(FOLDERS, folder)
    ]
    assert not wrong


@pytest.mark.parametrize("folder", INNER_FOLDERS)
def test_inside_a_folder_imports_point_one_way_too(folder):
    prefix, order = folder.replace("/", "."), INNER_FOLDERS[folder]
    depth = prefix.count(".") + 1

    def inner(module: str) -> str:
        return "__init__" if module == prefix else folder_of(module, depth)

    inside = {module: path for module, path in modules().items() if f"{module}.".startswith(f"{prefix}.")}
    wrong = [
        f"{module} imports {other}"
        for module, path in inside.items()
        for other in dependencies(path) & inside.keys()
        if inner(other) != inner(module)
        and rank(order, inner(other)) >= rank(order, inner(module))
        and not ("*" in order[rank(order, inner(module))] and rank(order, inner(other)) == rank(order, inner(module)))
    ]
    assert not wrong


@pytest.mark.parametrize("folder", INNER_FOLDERS)
def test_the_order_inside_a_folder_names_what_is_there(folder):
    named = set[str]().union(*INNER_FOLDERS[folder]) - {"*", "__init__"}
    there = {path.stem for path in (SOURCE / folder).iterdir() if path.suffix == ".py" or any(path.glob("*.py"))} - {"__init__"}
    assert named <= there
    assert named == there or {"*"} in INNER_FOLDERS[folder]


def test_no_folder_has_many_files():
    folders = [path.parent.relative_to(SOURCE) for path in SOURCE.rglob("*") if path.is_file()]
    written = Counter(folder.as_posix() for folder in folders if not {"__pycache__", "_kernels"} & set(folder.parts))
    assert {place for place, count in written.items() if count > MAX_FILES} <= ROOMS_OF_MANY


def test_only_the_public_functions_know_the_papers():
    """Nothing else imports them, the command line neither: its results draw themselves. They do so inside a function, when asked."""
    users = {module: path for module, path in modules().items() if folder_of(module) != "papers"}
    users = {module: path for module, path in users.items() if any(folder_of(other) == "papers" for other in dependencies(path))}
    assert {folder_of(module) for module in users} == {"api"}
    for path in users.values():
        assert "papers" not in "".join(map(ast.unparse, (node for node in ast.parse(path.read_text()).body if is_import(node))))


def is_import(node: ast.AST) -> bool:
    return isinstance(node, ast.Import | ast.ImportFrom)


def test_no_import_cycles():
    """Also none that only a type checker sees."""
    graph = {module: set(dependencies(path)) - {module} for module, path in modules().items()}
    removable = True
    while removable:
        removable = {module for module, others in graph.items() if not others & graph.keys()}
        graph = {module: others for module, others in graph.items() if module not in removable}
    assert not sorted(graph)


@pytest.mark.parametrize("module", DELEGATIONS)
def test_a_delegation_only_hands_on(module):
    """After its docstring it imports one function and returns what this function returns."""
    path = modules()[module]
    methods = delegations_of(path, ast.parse(path.read_text(encoding="utf-8")))
    assert methods.keys() == DELEGATIONS[module]
    for method in methods.values():
        *_, imports, last = method.body
        assert len(method.body) == 2 + (ast.get_docstring(method) is not None)
        assert isinstance(imports, ast.ImportFrom)
        assert len(imports.names) == 1
        assert isinstance(last, ast.Return)
        assert isinstance(last.value, ast.Call)


@pytest.mark.parametrize("folder", sorted({folder_of(module) for module in modules()}))
def test_closed_forms_and_simulation_never_meet(folder):
    others = {folder_of(other) for module, path in modules().items() if folder_of(module) == folder for other in dependencies(path)}
    if folder == "closed_form":
        assert others <= {"errors", "types", "numerics", "closed_form"}
    elif folder not in {"verification", "studies", "render", "papers", "cli", "api", "__init__"}:
        assert "closed_form" not in others


@pytest.mark.parametrize("package", ONLY)
def test_heavy_packages_stay_where_they_belong(package):
    wrong = [
        where
        for path in modules().values()
        if any(name.split(".")[0] == package for name in imported(path))
        and not any(f"{(where := path.relative_to(SOURCE).as_posix())}/".startswith(f"{home}/") for home in ONLY[package])
    ]
    assert not wrong


def modules_loaded_by(code: str, folder: Path) -> set[str]:
    """Names of the packages and modules that a new process has imported after some code."""
    answer = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\nprint(*sys.modules, file=sys.stderr)"],
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
    )
    return set(answer.stderr.split())


@pytest.mark.parametrize("words", ["--help", "run --help", "models"])
def test_light_commands_start_without_the_heavy_packages(words, tmp_path):
    code = (
        "from governor_mechanism.cli.main import main\n"
        f"sys.argv = ['governor-mechanism', *{words.split()}]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code"
    )
    unwanted = {"numpy", "scipy", "numba", "pymunk", "matplotlib", "pint"} | ({"rich"} if "--help" in words else set())
    assert not modules_loaded_by(code, tmp_path) & unwanted


def test_the_package_is_imported_without_the_heavy_packages(tmp_path):
    heavy = {"numpy", "scipy", "numba", "pymunk", "matplotlib", "pint", "typer", "rich"}
    assert not modules_loaded_by("import governor_mechanism", tmp_path) & heavy


NOT_FOR_RUNS = {"scipy", "numba", "llvmlite", "matplotlib", "pint", "PIL", "rich", "typer", "joblib", "numpy.ma", "numpy.random"}
"""Packages and modules that take about as long to import as a governor takes to run, or longer."""


@pytest.mark.parametrize(("engine", "allowed"), [("reduced", set()), ("multibody", set()), ("impulse", {"pymunk"})])
def test_a_run_needs_only_the_packages_of_its_own_engine(engine, allowed, tmp_path):
    code = f"import governor_mechanism as gm\nassert gm.run('porter', {engine!r}, times=[0.0, 0.01]).times.size"
    assert not modules_loaded_by(code, tmp_path) & ({*NOT_FOR_RUNS, "pymunk"} - allowed)


@pytest.mark.parametrize(
    ("words", "drawing"), [("--no-film", {"matplotlib"}), ("--no-figure", {"matplotlib"}), ("--no-film --no-figure", set())]
)
def test_the_command_run_imports_what_draws_only_for_a_picture(words, drawing, tmp_path):
    code = (
        "from governor_mechanism.cli.main import main\n"
        f"sys.argv = ['governor-mechanism', 'run', 'porter', '--seconds', '0.1', *{words.split()}]\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code"
    )
    loaded = modules_loaded_by(code, tmp_path)
    unwanted = {"scipy", "numba", "pymunk", "pint", "rich", "joblib", "matplotlib.pyplot", "matplotlib.animation", "imageio", "pandas"}
    assert not loaded & (unwanted | {"governor_mechanism.render.page.writer", "governor_mechanism.studies"})
    assert loaded & {"matplotlib"} == drawing


def test_what_the_tests_add_to_the_path_bears_the_name_of_no_other_module(pytestconfig):
    """A test that means a module of the package, or of a library, never gets one of the tests."""
    places = [pytestconfig.rootpath / place for place in pytestconfig.getini("pythonpath")]
    entries = [path for place in places for path in place.iterdir() if path.name != "__pycache__"]
    added = [path.stem for path in entries if path.suffix == ".py" or path.is_dir()]
    taken = {part for module in modules() for part in module.split(".")} | set(sys.stdlib_module_names) | set(packages_distributions())
    assert len(added) > len(places)
    assert not taken & set(added)
    assert len(set(added)) == len(added)


def test_the_project_does_not_read_what_lies_beside_it():
    root = SOURCE.parents[1]
    for path in [*root.glob("src/**/*.py"), *root.glob("tests/**/*.py"), *root.glob("models/*.toml")]:
        if path != Path(__file__):
            assert "../shared" not in path.read_text(encoding="utf-8")
