"""Small faults of the program, as changes of its syntax tree."""

from __future__ import annotations

import ast
import importlib.util
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

SOURCE = Path(__file__).resolve().parents[1] / "src"
PACKAGE = "governor_mechanism"

TEXT_KEYWORDS = {"meaning", "examples", "hint", "noun", "reason"}
"""Arguments of `quantity` and `entry` that only messages and schemas show."""

OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.MatMult: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}

FUNCTIONS = {
    "min": "max",
    "max": "min",
    "any": "all",
    "all": "any",
    "minimum": "maximum",
    "maximum": "minimum",
    "sin": "cos",
    "cos": "sin",
    "zeros": "ones",
    "ceil": "floor",
    "floor": "ceil",
    "inf": "nan",
}
"""Functions and their replacements."""


@dataclass(frozen=True)
class Mutant:
    """One change in a module: the node is that of this number in the order of `ast.walk`."""

    path: Path
    node: int
    change: int
    line: int
    text: str

    @property
    def module(self) -> str:
        """Return the name of the module."""
        return ".".join(self.path.relative_to(SOURCE).with_suffix("").parts)

    @cached_property
    def is_in_kernels(self) -> bool:
        """Whether the change is in one of the definitions that kernels come from."""
        tree, definitions = ast.parse(self.path.read_text(encoding="utf-8")), _kernel_sources().definitions
        node = next(one for number, one in enumerate(ast.walk(tree)) if number == self.node)
        (statement,) = (one for one in tree.body if node in ast.walk(one))
        if isinstance(statement, ast.FunctionDef):
            return (self.module, statement.name) in definitions
        if isinstance(statement, ast.ClassDef) and (self.module, statement.name) not in definitions:
            return False
        changed = ast.unparse(mutated_tree(self))  # of a class, kernels have some members alone
        return _search_module().KernelSources(_package_texts() | {self.module: changed}).digest() != _kernel_digest()

    @property
    def place(self) -> str:
        """Return file and line."""
        return f"{self.path.relative_to(SOURCE / PACKAGE)}:{self.line}"


Change = tuple[str, Callable[[ast.AST], None]]
"""A description, and what changes the node in place."""


def changes(node: ast.AST) -> list[Change]:
    """Return the changes of a node."""
    found: list[Change] = []
    if isinstance(node, ast.BinOp | ast.AugAssign | ast.BoolOp) and type(node.op) in OPERATORS:
        found.append(_operator_change(node, "op"))
    elif isinstance(node, ast.Compare) and len(node.ops) >= 1:
        found += [_comparison_change(node, k) for k in range(len(node.ops))]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        found.append(("operator removed", _remove_operator))
    elif isinstance(node, ast.Constant):
        found += _constant_changes(node)
    elif isinstance(node, ast.If | ast.IfExp | ast.While):
        found.append(("condition negated", _negate_condition))
    elif isinstance(node, ast.Attribute | ast.Name) and isinstance(node.ctx, ast.Load):
        name = node.attr if isinstance(node, ast.Attribute) else node.id
        if name in FUNCTIONS:
            found.append((f"{name} becomes {FUNCTIONS[name]}", _rename))
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        found.append(("statement removed", lambda one: _replace(one, ast.Pass())))
    elif isinstance(node, ast.Break):
        found.append(("break becomes continue", lambda one: _replace(one, ast.Continue())))
    elif isinstance(node, ast.Continue):
        found.append(("continue becomes break", lambda one: _replace(one, ast.Break())))
    return found


def _replace(node: ast.AST, other: ast.AST) -> None:
    """Turn a node into another one in place, so that its parent need not be known."""
    place = {name: getattr(node, name) for name in ("lineno", "col_offset", "end_lineno", "end_col_offset")}
    node.__class__ = other.__class__
    node.__dict__ = {**place, **vars(other)}


def _operator_change(node: ast.AST, field: str) -> Change:
    new = OPERATORS[type(getattr(node, field))]
    return f"{type(getattr(node, field)).__name__} becomes {new.__name__}", lambda one: setattr(one, field, new())


def _comparison_change(node: ast.Compare, k: int) -> Change:
    new = OPERATORS[type(node.ops[k])]
    return f"{type(node.ops[k]).__name__} becomes {new.__name__}", lambda one: one.ops.__setitem__(k, new())


def _constant_changes(node: ast.Constant) -> list[Change]:
    value = node.value
    if isinstance(value, bool):
        new: object = not value
    elif isinstance(value, int):
        new = value + 1
    elif isinstance(value, float):
        new = 1.0 if value == 0.0 else 2.0 * value
    else:
        return []
    return [(f"{value!r} becomes {new!r}", lambda one: setattr(one, "value", new))]


def _remove_operator(node: Any) -> None:
    _replace(node, node.operand)


def _negate_condition(node: Any) -> None:
    node.test = ast.UnaryOp(op=ast.Not(), operand=node.test)


def _rename(node: Any) -> None:
    if isinstance(node, ast.Attribute):
        node.attr = FUNCTIONS[node.attr]
    else:
        node.id = FUNCTIONS[node.id]


def executed_nodes(tree: ast.AST) -> Iterator[tuple[int, ast.AST]]:
    """Yield the number in the order of `ast.walk` and the node of all that is neither a text, an annotation nor a message of an error."""
    hidden: set[ast.AST] = set()
    for number, node in enumerate(ast.walk(tree)):
        if node in hidden:
            hidden.update(ast.iter_child_nodes(node))
            continue
        hidden.update(_hidden_children(node))
        yield number, node


def _hidden_children(node: ast.AST) -> Iterator[ast.AST]:
    for name in ("annotation", "returns"):
        if (child := getattr(node, name, None)) is not None:
            yield child
    if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom):
        yield from ast.iter_child_nodes(node)
    elif isinstance(node, ast.keyword) and node.arg in TEXT_KEYWORDS:
        yield node.value
    elif isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield from node.decorator_list


def all_mutants(folder: str) -> list[Mutant]:
    """Return every mutant of a folder of the package."""
    found = []
    for path in sorted((SOURCE / PACKAGE / folder).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for number, node in executed_nodes(tree):
            for k, (text, _) in enumerate(changes(node)):
                found.append(Mutant(path, number, k, getattr(node, "lineno", 0), f"{text}: {' '.join(ast.unparse(node).split())[:90]}"))
    return found


def mutated_tree(mutant: Mutant) -> ast.Module:
    """Return the syntax tree of the module with its fault."""
    tree = ast.parse(mutant.path.read_text(encoding="utf-8"))
    node = next(one for number, one in enumerate(ast.walk(tree)) if number == mutant.node)
    changes(node)[mutant.change][1](node)
    return tree


@cache
def _search_module() -> ModuleType:
    """Return the module that finds the sources of kernels, without importing the package: that is left to the process of a mutant."""
    name = f"{PACKAGE}.numerics.kernel_sources"
    spec = importlib.util.spec_from_file_location(name, SOURCE.joinpath(*name.split(".")).with_suffix(".py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def _package_texts() -> dict[str, str]:
    return _search_module().read_texts(SOURCE / PACKAGE)


@cache
def _kernel_sources() -> Any:
    """Return the definitions that kernels come from."""
    return _search_module().KernelSources(_package_texts())


@cache
def _kernel_digest() -> str:
    return _kernel_sources().digest()
