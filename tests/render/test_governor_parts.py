"""What governors drive and what drives them, the key of friction shoes, and the enlarged lift."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from drawing_checks import Drawn, assert_within, of_role
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.geometry.attached import shapes_of
from governor_mechanism.render.geometry.primitives import Lines, Polygon, TextShape, bounding_box
from governor_mechanism.render.machines.engine_room.drawing import GovernorElevation
from governor_mechanism.render.machines.governor_parts import ThrottleGear
from governor_mechanism.render.machines.pendulum import lift_magnification
from governor_mechanism.render.machines.registry import drawing_of
from stub_effects import fake_run_with_effects
from stub_run import GOVERNOR_DIMENSIONS, fake_run


def make_gear(side, half_lift):
    return ThrottleGear(
        unit=0.3, side=side, pin_range=(-0.5 - half_lift, -0.5 + half_lift), strap_half_width=0.05, pivot_distance=0.15, valve_height=-0.7
    )


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("half_lift", [0.0, 0.02, 0.1])
def test_rod_and_arms_of_a_throttle_keep_their_lengths(side, half_lift):
    gear = make_gear(side, half_lift)
    arm = math.dist(gear.valve, gear.valve_arm_end(-0.5))
    for height in np.linspace(*gear.pin_range, 21).tolist():
        end, arm_end = gear.lever_end(height), gear.valve_arm_end(height)
        assert math.dist(end, arm_end) == pytest.approx(gear.rod_length, rel=1e-12)
        assert math.dist(gear.valve, arm_end) == pytest.approx(arm, rel=1e-12)
        assert math.dist(gear.pivot, end) == pytest.approx(gear.outer_arm, rel=1e-12)
        # Pin, pivot and outer end of the lever lie in one line.
        (x, y), (end_x, end_y) = gear.pivot, end
        assert (end_x - x) * (height - y) == pytest.approx((end_y - y) * (0.0 - x), abs=1e-15)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_rising_sleeve_closes_the_throttle(side):
    gear = make_gear(side, 0.1)
    slopes, moving = [], list(gear.moving_parts(lambda height: height))
    for height in np.linspace(*gear.pin_range, 21).tolist():
        (plate,) = of_role(shapes_of(moving, height), "throttle plate")
        ((x0, y0), (x1, y1)) = plate.lines[0]
        slopes.append(math.atan2(abs(y1 - y0), abs(x1 - x0)))
    # From nearly along the pipe to nearly across it.
    assert slopes[0] < math.radians(15)
    assert slopes[-1] > math.radians(75)
    assert (np.diff(slopes) > 0).all()


@pytest.mark.parametrize("name", GOVERNOR_DIMENSIONS)
def test_the_lever_holds_the_sleeve_at_its_pin(name):
    drawn = Drawn(fake_run(GOVERNOR_DIMENSIONS[name], duration=1.0, mean_angle=30.0))
    heights = []
    for shapes in drawn.moving:
        pin, (slot,) = of_role(shapes, "throttle pin")[0], of_role(shapes, "throttle slot")
        left, right, bottom, top = bounding_box([slot])
        assert left < pin.x == 0.0 < right
        assert bottom < pin.y < top
        heights.append(pin.y)
    np.testing.assert_allclose(np.diff(heights), np.diff(drawn.run.readings["sleeve_lift"]), atol=1e-12)


def test_an_engine_room_shows_neither_throttle_gear_nor_drive_of_the_governor():
    drawn = Drawn(fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0))
    drawing = drawn.drawing
    assert {"throttle lever", "gearing wheel"} <= drawn.roles() | {shape.role for shape in drawing.static_shapes}
    elevation = GovernorElevation(drawing, "sleeve_lift")
    parts = (*elevation.fixed_parts(), *elevation.moving_parts(lambda moment: moment))
    shown = {shape.role for shape in shapes_of(parts, drawing.first_moment)}
    assert {"spindle", "sleeve"} <= shown
    assert not [role for role in shown if role.startswith(("throttle", "gearing"))]


def test_only_a_governor_with_dry_friction_has_the_key_of_its_shoes():
    friction = DryFriction(reading="sleeve_lift", force=InputFunction(values=(40.0,)))
    for effects in ([], [friction]):
        still = Drawn(fake_run_with_effects(GOVERNOR_DIMENSIONS["porter"], effects, duration=1.0)).still
        texts = {shape.text for shape in still if isinstance(shape, TextShape)}
        assert ({"holds", "slides"} <= texts) == bool(effects)
        samples = {shape.role for shape in still if shape.role.endswith("shoe key")}
        assert samples == ({"shoe key", "held shoe key"} if effects else set())


@pytest.mark.parametrize("name", ["porter", "hartung_dubois", "hartnell", "parabolic"])
def test_the_key_of_friction_shoes_is_clear_of_all_that_is_drawn(name):
    drawn = Drawn(gm.run(gm.load(name).replace({"effects.dry_friction.sleeve": "40 N", "run.duration": "0.1 s"}), certify=False))
    still = drawn.still
    keys = [
        one
        for one in still
        if one.role in ("shoe key", "held shoe key") or (isinstance(one, TextShape) and one.text in ("holds", "slides"))
    ]
    assert len(keys) == 4
    left, right, low, high = bounding_box(keys)
    others = [one for one in (*still, *drawn.at(0)) if one not in keys]
    for shape in others:
        x0, x1, y0, y1 = bounding_box([shape]) if not isinstance(shape, Lines) or shape.lines else (right, right, 0.0, 0.0)
        assert x1 <= left or x0 >= right or y1 <= low or y0 >= high, shape.role


def test_a_lift_too_small_to_be_seen_is_enlarged_as_stated():
    # A swing of 0.1 degrees lifts the sleeve of a governor with arms of 300 mm by less than 1 mm.
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, mean_angle=30.0, amplitude=0.1)
    drawn = Drawn(run)
    still, magnification = drawn.still, lift_magnification(drawn.drawing)
    assert magnification > 10.0
    (frame,) = of_role(still, "lens")
    assert any(isinstance(shape, TextShape) and shape.text == f"lift, {magnification:g} : 1" for shape in still)
    tips = []
    for shapes in drawn.moving:
        *_, pointer = of_role(shapes, "pointer", Polygon)
        tips.append(pointer.points[0][1])
        assert_within([pointer], bounding_box([frame]))
    np.testing.assert_allclose(np.diff(tips), magnification * np.diff(run.readings["sleeve_lift"]), atol=1e-12)
    # The ruler in the detail gives the same lift as the pointer.
    *_, ruler = of_role(still, "scale", Lines)
    numbers = of_role(still, "scale", TextShape)[-2:]
    (low_y, low), (high_y, high) = ((shape.y, float(shape.text.removesuffix(" mm")) / 1e3) for shape in numbers)
    assert bounding_box([ruler])[2:] == pytest.approx((low_y, high_y))
    assert low + (tips[0] - low_y) / (high_y - low_y) * (high - low) == pytest.approx(run.readings["sleeve_lift"][0], abs=1e-9)


def test_a_lift_that_can_be_seen_is_not_enlarged():
    run = fake_run(GOVERNOR_DIMENSIONS["porter"], duration=1.0, mean_angle=30.0)
    assert lift_magnification(drawing_of(run, run.scene.part)) == 0.0
