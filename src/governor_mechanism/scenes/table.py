"""Base of the pydantic models of scene tables. Slow to import: pydantic."""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Final, Self, TypeVar

from pydantic import BaseModel, PlainValidator, ValidationError, ValidationInfo, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.scenes.problems import KEY, Problem, ProblemCode, wrong_value
from governor_mechanism.scenes.quantities import check_label
from governor_mechanism.units.quantities import format_value

TOP_LEVEL_KEYS: Final = ("machine", "title", "dimensions", "effects", "spindle", "start", "run", "events")
"""Keys of a scene file outside its tables, and its tables."""

Title = Annotated[str | None, PlainValidator(lambda value: check_label(value, '; write title = "..."'))]
_Table = TypeVar("_Table", bound="SceneFileTable")


class SceneFileTable(BaseModel, extra="forbid", protected_namespaces=()):
    """A table of a scene file. Every mistake is reported as a sentence, with `KEY` for the path of the table."""

    element: ClassVar[Callable[..., Any]]
    """What the table describes; its keys, except `type`, are the arguments."""
    alternative_keys: ClassVar[tuple[str, ...]] = ()
    """Keys that the same table may have instead, in another scene."""
    alternative_hint: ClassVar[str] = ""
    """What to do if keys of both kinds are given."""
    example: ClassVar[str] = ""
    """A valid table, for messages."""

    @classmethod
    def fields_by_key(cls) -> dict[str, FieldInfo]:
        """Return the fields by their keys in the file."""
        return {field.alias or name: field for name, field in cls.model_fields.items()}

    def given_values(self) -> dict[str, Any]:
        """Return the parsed values of the keys in the file except `type`, in the order of the class."""
        return {name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set and name != "type"}

    def make_element(self, **arguments: Any) -> Any:
        """Return what the table describes; `arguments` are those that are no keys of the table."""
        return type(self).element(**self.given_values(), **arguments)

    @classmethod
    def find_conflicts(cls, values: Mapping[str, Any], context: Any) -> Iterable[str]:
        """Yield the problems of keys that are missing, or exclude each other; `context` is the caller's. A mere sentence is a conflict."""
        return ()

    @classmethod
    def unknown_key(cls, key: str, value: object) -> str:
        """Return the message about an unknown key."""
        known_keys = [*cls.fields_by_key(), *cls.alternative_keys]
        elsewhere = f" {key!r} belongs above the first [table], or is a table of its own." if key in TOP_LEVEL_KEYS else ""
        return f"{KEY}.{key} is unknown; known keys are {', '.join(known_keys)}.{elsewhere or did_you_mean(key, known_keys)}"

    @model_validator(mode="wrap")
    @classmethod
    def _report(cls, values: Any, handler: Callable[[Any], Self], info: ValidationInfo) -> Self:
        if not isinstance(values, Mapping):
            raise wrong_value(values, "must be a table", f"; write {cls.example}" if cls.example else "")
        known_keys = cls.fields_by_key()
        own_keys = [key for key in values if key in known_keys]
        misplaced_keys = [key for key in values if key in cls.alternative_keys] if own_keys else []
        problems = []
        for path in (f"{KEY}.{key}" for key in misplaced_keys[:1]):
            text = f"{path} cannot be combined with {', '.join(own_keys)}; {cls.alternative_hint}"
            problems.append(Problem(text, ProblemCode.CONFLICT, path))
        table = None
        try:
            table = handler({key: value for key, value in values.items() if key not in misplaced_keys})
        except ValidationError as error:
            problems += cls._field_problems(error)
        if not any(problem.code == ProblemCode.UNKNOWN_KEY for problem in problems):
            problems += [Problem(text, ProblemCode.CONFLICT) for text in cls.find_conflicts(values, info.context)]
        if table is None or problems:
            raise MechanismError(*problems)
        return table

    @classmethod
    def _field_problems(cls, error: ValidationError) -> Iterator[Problem]:
        details = error.errors(include_url=False)
        unknown_keys = [str(detail["loc"][-1]) for detail in details if detail["type"] == "extra_forbidden"]
        misspelt_keys = {near for key in unknown_keys for near in difflib.get_close_matches(key, list(cls.fields_by_key()), n=1)}
        for detail in details:
            key = str(detail["loc"][0]) if detail["loc"] else ""
            # A required key that is misspelt is one mistake, reported where the wrong spelling is.
            if not (detail["type"] == "missing" and key in misspelt_keys):
                yield from cls._problems_at(key, detail)

    @classmethod
    def _problems_at(cls, key: str, detail: ErrorDetails) -> Iterator[Problem]:
        path = f"{KEY}.{key}" if key else KEY
        cause = detail.get("ctx", {}).get("error")
        if isinstance(cause, MechanismError):
            yield from (Problem(problem).at(path) for problem in cause.problems)
        elif detail["type"] == "missing":
            yield Problem(f"{path} is missing; it is {cls.fields_by_key()[key].description}", ProblemCode.MISSING_KEY, path)
        elif detail["type"] == "extra_forbidden":
            yield Problem(cls.unknown_key(key, detail["input"]), ProblemCode.UNKNOWN_KEY, path)
        else:
            text = f"{path} cannot be read ({detail['msg'].lower()}); found {format_value(detail['input'])}"
            yield Problem(text, ProblemCode.WRONG_TYPE, path)


SceneFileTables = Mapping[str, type[SceneFileTable]]
"""Models of tables by the type or the key that determines the model."""


def validate(model: type[_Table], values: object, path: str = KEY, context: Any = None) -> _Table:
    """Return the parsed table.

    Parameters
    ----------
    model
        Model of the table.
    values
        The table as read from TOML.
    path
        Key path of the table.
    context
        Passed to the validators.

    Returns
    -------
    SceneFileTable
        An instance of the model.

    Raises
    ------
    MechanismError
        With a `Problem` for each mistake.
    """
    try:
        return model.model_validate(values, context=context)
    except ValidationError as error:
        causes = [detail.get("ctx", {}).get("error") for detail in error.errors(include_url=False)]
        raise MechanismError(*(Problem(problem).at(path) for cause in causes for problem in getattr(cause, "problems", ()))) from error


def nearest_type(values: object, known_types: Iterable[str]) -> str:
    """Return the known type nearest to the `type` of a table; "" if none is near."""
    word = values.get("type") if isinstance(values, Mapping) else None
    return next(iter(difflib.get_close_matches(word, list(known_types), n=1)), "") if isinstance(word, str) else ""
