"""Definitions that compiled kernels come from, found in the text of the package, and their digest.

Kernels and types of records are where the search begins. From there it follows names, through files, to functions, constants and classes;
of a class it takes the members whose names occur. It takes too much rather than too little, but no comment, no docstring, no annotation,
and no plain function that only calls kernels. Plain functions decide with which types a kernel is called: its caller compares those at
every call.
"""

import ast
import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

PACKAGE = __name__.partition(".")[0]

COMPILING_MODULE = f"{PACKAGE}.numerics.jit"
COMPILING_NAMES = {(COMPILING_MODULE, name) for name in ("jit", "jit_in_place", "jit_inlined", "record_dtype")}
"""What makes kernels and types of records."""

ENUMS = {"Enum", "IntEnum", "IntFlag", "StrEnum"}
CONSTRUCTORS = {"__init__", "__new__", "__post_init__"}
"""Members of a class that are called where the class is."""

UNREAD_FIELDS = {"annotation", "returns", "ctx", "kind", "type_comment", "type_params", "type_ignores"}
"""Parts of a syntax tree that do not change a kernel."""

INNER_IMPORT = re.compile(r"^\s+(from|import) ", re.MULTILINE)

NAMES = {"id", "attr", "name", "arg"}
"""Parts of a syntax tree that are names of Python."""

Definition = tuple[str, str]
"""A module, and a name in it."""


@dataclass(frozen=True)
class _Module:
    """Text of a module."""

    name: str  # its name, as in an import
    tree: ast.Module  # its syntax tree
    has_inner_imports: bool  # whether functions may import

    @cached_property
    def definitions(self) -> dict[str, list[ast.stmt]]:
        """Statements of the module by the names that they bind or change."""
        found: dict[str, list[ast.stmt]] = {}
        for statement in self.tree.body:
            for name in _bound_names(statement):
                found.setdefault(name, []).append(statement)
        return found

    @cached_property
    def imports(self) -> dict[str, Definition]:
        """What imported names stand for: a definition of another module, or a module and no name."""
        found: dict[str, Definition] = {}
        for node in ast.walk(self.tree) if self.has_inner_imports else self.tree.body:
            if isinstance(node, ast.ImportFrom):
                found |= {one.asname or one.name: (node.module or "", one.name) for one in node.names}
            elif isinstance(node, ast.Import):
                found |= {one.asname or one.name.partition(".")[0]: (one.name, "") for one in node.names}
        return found


def _bound_names(statement: ast.stmt) -> set[str]:
    """Return the names that a statement of a module binds or changes; an import binds none here."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, ast.Import | ast.ImportFrom) or _is_text(statement):
        return set()
    if isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        return {node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)}
    return {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}  # a call may change what it names


def _is_text(statement: ast.AST) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


@dataclass
class KernelSources:
    """Search for the definitions that kernels come from."""

    texts: Mapping[str, str]  # text of every module by its name
    _modules: dict[str, _Module] = field(default_factory=dict, repr=False)
    _members: set[str] = field(default_factory=set, repr=False)

    @cached_property
    def definitions(self) -> frozenset[Definition]:
        """Definitions that kernels come from."""
        found: set[Definition] = set()
        waiting, n_members = set(self._roots()), -1
        while waiting or len(self._members) > n_members:
            n_members = len(self._members)
            while waiting:
                definition = waiting.pop()
                found.add(definition)
                waiting |= set(self._references(definition)) - found
            # Names of members may be members of any class, and what those name may be too.
            waiting = {one for definition in found if self._is_class(definition) for one in self._references(definition)} - found
        return frozenset(found)

    def digest(self) -> str:
        """Return the digest of the definitions and of what the names in them stand for."""
        digest = hashlib.sha256()
        for module_name, name in sorted(self.definitions):
            module = self._module(module_name)
            digest.update(f"\n{module_name} {name}\n".encode())
            for part in self._parts(module, name):
                names = {node.id for node in _nodes(part) if isinstance(node, ast.Name)} & module.imports.keys()
                meanings = sorted((one, module.imports[one]) for one in names)
                digest.update(f"{' '.join(_words(part))} {meanings}".encode())
        return digest.hexdigest()

    def _module(self, name: str) -> _Module:
        if name not in self._modules:
            text = self.texts[name]
            self._modules[name] = _Module(name, ast.parse(text), bool(INNER_IMPORT.search(text)))
        return self._modules[name]

    def _roots(self) -> Iterator[Definition]:
        """Yield the definitions that call or are decorated by what makes kernels and types of records."""
        for module_name, text in self.texts.items():
            if COMPILING_MODULE in text:
                module = self._module(module_name)
                for name, statements in module.definitions.items():
                    nodes = (node for statement in statements for node in _nodes(statement))
                    if any(isinstance(node, ast.Name) and module.imports.get(node.id) in COMPILING_NAMES for node in nodes):
                        yield module_name, name

    def _references(self, definition: Definition) -> Iterator[Definition]:
        """Yield the definitions of the package that the parts of a definition name, and note the names of members."""
        module = self._module(definition[0])
        for part in self._parts(module, definition[1]):
            for node in _nodes(part):
                if isinstance(node, ast.Name):
                    yield from self._resolve(module, node.id)
                elif isinstance(node, ast.Attribute):
                    self._members.add(node.attr)
                    yield from self._resolve_member(module, node)
                elif isinstance(node, ast.Call):
                    self._members.add(f"{getattr(node.func, 'id', getattr(node.func, 'attr', ''))}()")
                elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
                    self._members.add(node.value)
                elif isinstance(node, ast.arg | ast.AnnAssign) and node.annotation:
                    yield from self._named_tuples(module, node.annotation)

    def _is_class(self, definition: Definition) -> bool:
        statements = self._module(definition[0]).definitions[definition[1]]
        return any(isinstance(statement, ast.ClassDef) for statement in statements)

    def _resolve(self, module: _Module, name: str) -> Iterator[Definition]:
        """Yield the definition of a name of a module, if it is in the package."""
        if name in module.definitions:
            yield module.name, name
        elif name in module.imports:
            source, imported = module.imports[name]
            if imported and source in self.texts:
                yield from self._resolve(self._module(source), imported)

    def _resolve_member(self, module: _Module, node: ast.Attribute) -> Iterator[Definition]:
        """Yield the definition of `module.name`."""
        if isinstance(node.value, ast.Name) and node.value.id in module.imports:
            source = ".".join(filter(None, module.imports[node.value.id]))
            if source in self.texts:
                yield from self._resolve(self._module(source), node.attr)

    def _named_tuples(self, module: _Module, annotation: ast.expr) -> Iterator[Definition]:
        """Yield the named tuples of an annotation: their fields are what a kernel gets."""
        for node in ast.walk(annotation):
            for module_name, name in self._resolve(module, node.id) if isinstance(node, ast.Name) else ():
                statements = self._module(module_name).definitions[name]
                if any(isinstance(one, ast.ClassDef) and "NamedTuple" in _base_names(one) for one in statements):
                    yield module_name, name

    def _parts(self, module: _Module, name: str) -> Iterator[ast.AST]:
        """Yield the syntax trees of a definition: statements, but of a class its head, its fields and the members that are named."""
        for statement in module.definitions[name]:
            if not isinstance(statement, ast.ClassDef):
                yield statement
                continue
            yield from [*statement.decorator_list, *statement.bases, *statement.keywords]
            bases = _base_names(statement)
            called = CONSTRUCTORS if f"{name}()" in self._members else set()
            for member in statement.body:
                names = _bound_names(member)
                if names & self._members or names & called or (bases & ENUMS and not isinstance(member, ast.FunctionDef)):
                    yield member
                elif isinstance(member, ast.AnnAssign):
                    yield ast.AnnAssign(member.target, member.annotation if "NamedTuple" in bases else ast.Constant(None), None, 1)


def _base_names(statement: ast.ClassDef) -> set[str]:
    return {base.id for base in statement.bases if isinstance(base, ast.Name)}


def _nodes(part: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a syntax tree without what does not change a kernel: docstrings and annotations."""
    waiting = [part]
    while waiting:
        node = waiting.pop()
        yield node
        waiting += [entry for _, entry in _entries(node) if isinstance(entry, ast.AST)]


def _entries(node: ast.AST) -> Iterator[tuple[str, object]]:
    """Yield the entries of a node of a syntax tree, with their names, without docstrings and annotations."""
    for name in node._fields:
        value = getattr(node, name, None)
        if value is not None and name not in UNREAD_FIELDS:
            for entry in value if isinstance(value, list) else (value,):
                if not (isinstance(entry, ast.Expr) and _is_text(entry)):
                    yield name, entry


def _words(node: ast.AST) -> Iterator[str]:
    """Yield a syntax tree as words, the same for every version of Python, without docstrings and annotations."""
    yield f"({type(node).__name__}"
    for name, entry in _entries(node):
        if isinstance(entry, ast.AST):
            yield name
            yield from _words(entry)
        else:
            yield f"{name} {entry}" if name in NAMES else f"{name} {entry!r}"
    yield ")"


def read_texts(root: Path) -> dict[str, str]:
    """Return the text of every module of the package in a folder by its name."""
    texts = {}
    for path in root.rglob("*.py"):
        name = ".".join((PACKAGE, *path.relative_to(root).with_suffix("").parts)).removesuffix(".__init__")
        texts[name] = path.read_text(encoding="utf-8")
    return texts
