"""Results of a function that are kept with the immutable object they belong to."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

Owner = TypeVar("Owner")
Result = TypeVar("Result")


def once_per_object(function: Callable[[Owner], Result]) -> Callable[[Owner], Result]:
    """Return a function of one object, evaluated once, that keeps its result with the object, which never changes."""
    key = f"_{function.__module__}.{function.__qualname__}"

    @wraps(function)
    def evaluate_once(owner: Owner) -> Result:
        kept_results = vars(owner)
        if key not in kept_results:
            kept_results[key] = function(owner)
        result: Result = kept_results[key]
        return result

    return evaluate_once
