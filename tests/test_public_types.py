"""The types of the public functions can be imported and read, results are shown in a few lines, and misspelt names are refused."""

import ast
import dataclasses
import inspect
import pickle
import typing
from importlib import resources

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.errors import UnknownName
from governor_mechanism.units.text_table import MAX_REPR_LENGTH

FUNCTIONS = [name for name in gm.__all__ if inspect.isfunction(getattr(gm, name))]
CLASSES = [name for name in gm.__all__ if inspect.isclass(getattr(gm, name))]


@pytest.fixture(scope="module")
def run():
    return gm.run("porter", times=np.linspace(0.0, 1.0, 1001), certify=False)


def test_the_types_are_marked_as_typed():
    assert resources.files("governor_mechanism").joinpath("py.typed").is_file()


def test_the_stub_has_every_public_name_and_nothing_else():
    """The package reads it as text; a type checker reads it as Python does."""
    *imports, version = ast.parse(resources.files("governor_mechanism").joinpath("__init__.pyi").read_text(encoding="utf-8")).body
    names = [alias for one in imports for alias in typing.cast(ast.ImportFrom, one).names]
    assert [alias.name for alias in names] == [alias.asname for alias in names]  # so a type checker takes it for public
    assert sorted(alias.name for alias in names) == sorted([*gm.__all__, "open"])  # which would hide that of Python
    assert ast.unparse(version) == "__version__: str"


def test_what_is_public_has_a_name_of_its_own():
    """Also where an editor reads the names from the source, which has those of its imports too."""
    assert all(name in (*gm.__all__, "open") or name.startswith("_") or inspect.ismodule(one) for name, one in vars(gm).items())
    assert {"Scene", "Trajectory", "Outcome", "Equilibrium", "SpeedCurve", "Sweep", "CheckReport", "Mechanism"} <= set(CLASSES)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_annotations_of_every_function_can_be_read(name):
    function = getattr(gm, name)
    hints = typing.get_type_hints(function)
    assert set(inspect.signature(function).parameters) <= set(hints)
    assert "return" in hints
    options = [one for one in inspect.signature(function).parameters.values() if one.kind is inspect.Parameter.VAR_KEYWORD]
    assert all(hints[one.name] is not typing.Any for one in options)


@pytest.mark.parametrize("name", CLASSES)
def test_the_annotations_of_every_class_can_be_read(name):
    owner = getattr(gm, name)
    typing.get_type_hints(owner)
    for _, method in public_methods(owner):
        assert "return" in typing.get_type_hints(method)


def public_methods(owner: type) -> list[tuple[str, typing.Any]]:
    """Methods, class methods and properties of a class that users call, by name."""
    members = [(name, member) for name, member in inspect.getmembers_static(owner) if not name.startswith("_")]
    functions = [(name, getattr(member, "fget", None) or getattr(member, "func", None) or member) for name, member in members]
    functions = [(name, getattr(one, "__func__", one)) for name, one in functions]
    return [(name, one) for name, one in functions if inspect.isfunction(one) and one.__module__.startswith("governor_mechanism")]


UNTYPED = {
    # What a scene file may hold has no narrower type than that of its schema.
    "a document of a scene, or a value of one": {
        *(
            f"MechanismBuilder.{name}"
            for name in ("actuator", "document", "effect", "force", "given_document", "ground", "joint", "motor", "spindle", "torque")
        ),
        *(f"Scene.{name}" for name in ("document", "from_dict", "replace", "with_changes")),
        *(f"{design}.scene_document" for design in ("FlywheelDesign", "GovernedEngineDesign", "HartnellDesign", "PendulumDesign")),
        "sweep",
    },
    "values of JSON": {f"{name}.as_json" for name in CLASSES},
    "an optional package, which a type checker reads and a run may lack": {
        "Trajectory.to_xarray",
        "fit",
        *(f"{name}.to_dataframe" for name in CLASSES),
    },
    "numbers, or words of a varied key": {"Sweep.column", "Sweep.grid"},
    "a kernel of the caller": {"crosscheck"},
}
"""What has `Any` in its annotations, by the reason."""


def holds_any(hint: object) -> bool:
    """Whether a hint has `Any` in it, but for the shape of an array, which numpy leaves open."""
    if typing.get_origin(hint) is np.ndarray:
        return holds_any(typing.get_args(hint)[1])
    return hint is typing.Any or any(holds_any(one) for one in (hint if isinstance(hint, list) else typing.get_args(hint)))


def test_only_what_cannot_have_a_type_has_none():
    """So a type checker knows every result; `Any` would switch it off."""
    found = {name for name in FUNCTIONS if any(map(holds_any, typing.get_type_hints(getattr(gm, name)).values()))}
    for name in CLASSES:
        owner = getattr(gm, name)
        fields = {field: hint for field, hint in typing.get_type_hints(owner).items() if not field.startswith("_")}
        found |= {f"{name}.{field}" for field, hint in fields.items() if holds_any(hint)}
        hints = {f"{name}.{method}": typing.get_type_hints(function) for method, function in public_methods(owner)}
        found |= {method for method, types in hints.items() if any(map(holds_any, types.values()))}
    assert not found - set().union(*UNTYPED.values())


def test_methods_that_hand_on_name_what_they_return():
    assert typing.get_type_hints(gm.Scene.describe)["return"] is gm.SceneDescription
    assert typing.get_type_hints(gm.Mechanism.build)["return"] is gm.MechanismBuilder
    assert gm.ClusterClient in typing.get_args(typing.get_type_hints(gm.sweep)["cluster"])


def test_a_run_takes_and_returns_the_exported_types():
    hints = typing.get_type_hints(gm.run)
    assert hints["return"] is gm.Trajectory
    assert gm.Scene in typing.get_args(hints["scene"])
    assert typing.get_type_hints(gm.equilibria)["return"] == tuple[gm.Equilibrium, ...]


def test_a_misspelt_type_is_answered_with_the_nearest():
    with pytest.raises(AttributeError, match="Did you mean 'Trajectory'"):
        gm.Trajectry  # noqa: B018


def holds_array(hint: object) -> bool:
    arguments = [one for one in typing.get_args(hint) if not isinstance(one, str | list)]
    return hint is np.ndarray or typing.get_origin(hint) is np.ndarray or any(map(holds_array, arguments))


@pytest.mark.parametrize("name", [name for name in CLASSES if dataclasses.is_dataclass(getattr(gm, name))])
def test_results_with_arrays_are_equal_only_to_themselves(name):
    """Field by field, `==` of arrays would raise "the truth value of an array is ambiguous"."""
    owner = getattr(gm, name)
    if any(map(holds_array, typing.get_type_hints(owner).values())):
        assert owner.__eq__ is object.__eq__


def test_a_misspelt_name_is_a_key_error_with_the_nearest_name(run):
    for table, misspelt, sentence in (
        (run.readings, "arm_angel", "no reading 'arm_angel'; known are arm_angle, ball_radius"),
        (run.rates, "sleeve_lfit", "Did you mean 'sleeve_lift'?"),
        (run.reactions, "right arn", "Did you mean 'right arm'?"),
        (run.speed_fluctuations, "crank_angle", "no shaft angle 'crank_angle'; known are none."),
        (gm.equilibria("porter")[0].readings, "arm_angel", "Did you mean 'arm_angle'?"),
    ):
        with pytest.raises(KeyError) as caught:
            table[misspelt]
        assert sentence in str(caught.value)
        assert isinstance(caught.value, UnknownName)
    assert run.readings.get("arm_angel") is None
    assert "arm_angel" not in run.readings


def test_results_by_name_survive_another_process(run):
    copied = pickle.loads(pickle.dumps(run.readings))
    assert copied.keys() == run.readings.keys()
    with pytest.raises(KeyError, match="no reading"):
        copied["arm_angel"]


def test_results_are_shown_in_a_few_lines(run):
    shown = {
        "Porter governor": run,
        "arm_angle": run.readings,
        "kinetic": run.energy,
        "engine": run.cost,
        "force": next(iter(run.reactions.values())),
        "pendulum_governor": run.scene,
        "governor": run.scene.parts[0],
        "sleeve": run.scene.mechanism,
        "speed": gm.speed_curve("porter", 50, resistance="40 N"),
        "stiffness": gm.equilibria("porter")[0],
        "readings": gm.linearise("porter"),
        "radius": gm.controlling_force("porter", points=50),
        "crank_angle": gm.kinematics("slider_crank_torque", "crank_angle", [0.1, 0.2]),
        "closed form": gm.crosscheck("porter"),
    }
    for word, result in shown.items():
        assert word in repr(result)
        assert len(repr(result)) <= MAX_REPR_LENGTH
        assert "\n" not in repr(result)
        assert "array(" not in repr(result)


def test_a_shell_completes_what_is_public():
    assert set(dir(gm)) == {*gm.__all__, "open", "__version__"}
