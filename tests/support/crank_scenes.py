"""Scenes of driven crank machines for the tests, read as files are."""

from data_files import read_data
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from reference import flywheel

NUMBERS = read_data(__file__)
SLIDE_VALVE_DIMENSIONS, LINK_GEAR_DIMENSIONS = NUMBERS["SLIDE_VALVE_DIMENSIONS"], NUMBERS["LINK_GEAR_DIMENSIONS"]
SLIDER_CRANK_DIMENSIONS, SLIDER_CRANK_MASSES = NUMBERS["SLIDER_CRANK_DIMENSIONS"], NUMBERS["SLIDER_CRANK_MASSES"]


def document(machine: str, dimensions: dict, effects: dict | None = None, **run) -> dict:
    """A scene file as a document; a dimension of None is left out."""
    settings = {"duration": 1.0, "output_interval": 0.01, "accuracy": 1e-6} | run
    given = {name: value for name, value in dimensions.items() if value is not None}
    return {"machine": machine, "dimensions": given, "effects": effects or {}, "run": settings}


def valve_scene(changes: dict | None = None, **run) -> Scene:
    """Marks' slide valve, l : r = 4, with some dimensions changed."""
    return parse_scene_document(document("slide_valve", SLIDE_VALVE_DIMENSIONS | (changes or {}), **run))


def crank_scene(changes: dict | None = None, effects: dict | None = None, **run) -> Scene:
    """A slider crank of the reference's sizes, with some dimensions changed."""
    return parse_scene_document(document("slider_crank", SLIDER_CRANK_DIMENSIONS | (changes or {}), effects, **run))


def link_gear_scene(changes: dict | None = None, effects: dict | None = None, **run) -> Scene:
    """Stephenson's link motion of the reference's sizes, with some dimensions changed."""
    return parse_scene_document(document("stephenson", LINK_GEAR_DIMENSIONS | (changes or {}), effects, **run))


def air_engine_document(changes: dict | None = None, effects: dict | None = None, **run) -> dict:
    """The closed cycle of the reference's example as a document, from the dead centre, with some dimensions changed."""
    dimensions = flywheel.ENGINE | {"load_pressure": None, "inertia": flywheel.EXAMPLE_INERTIA} | (changes or {})
    start = {"crank_angle": 0.0, "crank_rate": run.pop("crank_rate", flywheel.EXAMPLE_START_SPEED)}
    return document("flywheel_engine", dimensions, effects, **({"duration": 2.0, "accuracy": 1e-10} | run)) | {"start": start}


def air_engine_scene(changes: dict | None = None, effects: dict | None = None, **run) -> Scene:
    """The closed cycle of the reference's example as a scene, see `air_engine_document`."""
    return parse_scene_document(air_engine_document(changes, effects, **run))
