"""Drawing of an engine with a flywheel: the engine at a small scale, and below it each cylinder with its indicator diagram.

The machine stands with its cylinders below the shaft; the drawing lays it on its side, with the shaft at the left.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from governor_mechanism.machines.flywheel_engine.machine import FLYWHEEL, expansion_gas
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_shifted, fixed
from governor_mechanism.render.geometry.primitives import DrawnShape, Vec2
from governor_mechanism.render.machines.flywheel_engine.cylinder import BORE_HEIGHT, DIAGRAM_HEIGHT, WALL, CylinderView, highest_pressure
from governor_mechanism.render.machines.flywheel_engine.engine_view import EngineView
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.types import FloatArray

# In strokes of the picture.
_GAP, _LEFT, _RIGHT = 0.07, -0.12, 1.26
_CASTING_HEIGHT = BORE_HEIGHT + 2 * WALL


class FlywheelEngineDrawing(MachineDrawing):
    """Drawing of an engine with a flywheel. Lengths in m."""

    panel_readings = ("shaft_speed", "gas_torque", "stored_work")
    stroke = Dimension("stroke")
    pump_stroke = Dimension("pump_stroke")
    connecting_rod = Dimension("connecting_rod")
    pump_connecting_rod = Dimension("pump_connecting_rod")
    clearance = Dimension("clearance")
    pump_clearance = Dimension("pump_clearance")
    back_pressure = Dimension("back_pressure")

    @cached_property
    def _gases(self) -> dict[str, CylinderGas]:
        """Gas on the faces of the pistons by name."""
        elements = self.part.mechanism.force_elements
        return {element.name: element for element in elements if isinstance(element, CylinderGas)}

    @cached_property
    def _controls(self) -> FloatArray:
        """Opening of the throttle, 1 without one, and cut-off at the reported times; shape (n, 2). Only for gas in cylinders."""
        readings = self.select_entries(self.run.readings)
        cut_offs = readings["cut_off"]
        return np.column_stack([readings.get("throttle_opening", np.ones_like(cut_offs)), cut_offs])

    def _expansion_gas(self, k: int) -> CylinderGas:
        """Return the gas behind the expansion piston at the reported time k."""
        opening, cut_off = self._controls[k].tolist()
        return expansion_gas(self.part.mechanism, opening, cut_off)

    @cached_property
    def _cylinders(self) -> tuple[CylinderView, ...]:
        """The expansion cylinder, and below it the pump if there is one; none where the torque of the gas is averaged."""
        if not self._gases:
            return ()
        widest_opening = int(np.argmax(self._controls[:, 0]))
        gases = self._gases | {"expansion": self._expansion_gas(widest_opening)}
        u, top = self.stroke, highest_pressure(gases.values())
        has_pump = "suction" in gases
        base = (DIAGRAM_HEIGHT + _GAP + _CASTING_HEIGHT + _GAP) * u if has_pump else 0.0
        expansion = CylinderView(
            name="engine",
            driving=gases["expansion"],
            resisting=None,
            back_pressure=self.back_pressure,
            clearance=self.clearance,
            stroke=u,
            base=base,
            diagram_base=base + (_CASTING_HEIGHT + _GAP) * u,
            highest_pressure=top,
            has_moving_diagram=bool(np.any(np.ptp(self._controls, axis=0) > 0.0)),
        )
        if not has_pump:
            return (expansion,)
        pump = CylinderView(
            name="pump",
            driving=gases["suction"],
            resisting=gases["delivery"],
            back_pressure=0.0,
            clearance=self.pump_clearance,
            stroke=u,
            base=(DIAGRAM_HEIGHT + _GAP) * u,
            diagram_base=0.0,
            highest_pressure=top,
        )
        return expansion, pump

    def expansion_cylinders(self, time: float) -> tuple[CylinderView, ...]:
        """Return the expansion cylinder with its gas at a time (s); none where the torque of the gas is averaged."""
        cylinders = self._cylinders[:1]
        if not any(one.has_moving_diagram for one in cylinders):
            return cylinders
        last_sample = int(np.searchsorted(self.run.times, time, side="right")) - 1
        return tuple(replace(one, driving=self._expansion_gas(last_sample)) for one in cylinders)

    @cached_property
    def _engine(self) -> EngineView:
        u, base = self.stroke, 0.0
        if self._cylinders:
            base = self._cylinders[0].diagram_base + (DIAGRAM_HEIGHT + _GAP) * u
        return EngineView(crank=0.5 * u, rod=self.connecting_rod, left=_LEFT * u, right=_RIGHT * u, base=base)

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield castings, guides and indicator diagrams."""
        yield fixed(self._engine.background_shapes())
        yield from (fixed(cylinder.background_shapes()) for cylinder in self._cylinders)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield wheel, crank, rods and pistons, the gas, and the points on its diagrams."""
        yield from self._engine.moving_parts(self._angle_at)
        rods = (self.connecting_rod, 0.5 * self.stroke), (self.pump_connecting_rod, 0.5 * self.pump_stroke)
        for number, (cylinder, (rod, crank)) in enumerate(zip(self._cylinders, rods, strict=False)):
            travel_at = partial(self._travel_at, crank / rod)
            yield Flexible(shapes_at=partial(self._cylinder_shapes, CylinderView.gas_shapes, number, travel_at))
            piston_axes = axes_shifted(partial(_piston_place, travel_at, cylinder.stroke))
            yield Attached(frame=piston_axes, shapes=(cylinder.piston(),))
            yield Flexible(shapes_at=partial(self._cylinder_shapes, CylinderView.mark_shapes, number, travel_at))

    def _angle_at(self, moment: Moment) -> float:
        """Return the crank angle at a moment (rad)."""
        return float(moment.pose[self.part.mechanism.body_index(FLYWHEEL), 2])

    def _travel_at(self, rod_ratio: float, moment: Moment) -> float:
        """Return the travel of a piston relative to its stroke at a moment."""
        return relative_travel(self._angle_at(moment), rod_ratio)

    def _cylinder_shapes(
        self,
        shapes_of_view: Callable[[CylinderView, float, bool], Iterator[DrawnShape]],
        number: int,
        travel_at: Callable[[Moment], float],
        moment: Moment,
    ) -> Iterator[DrawnShape]:
        """Return some shapes of a cylinder with its gas at a moment; the first one is the expansion cylinder."""
        cylinder = self.expansion_cylinders(moment.time)[0] if number == 0 else self._cylinders[number]
        is_return = bool(math.floor(self._angle_at(moment) / math.pi) % 2)
        return shapes_of_view(cylinder, travel_at(moment), is_return)


def _piston_place(travel_at: Callable[[Moment], float], stroke: float, moment: Moment) -> Vec2:
    """Return how far a piston is from the start of its stroke (m)."""
    return travel_at(moment) * stroke, 0.0


def relative_travel(crank_angle: float, rod_ratio: float) -> float:
    """Return the travel of a piston relative to its stroke; `rod_ratio` is that of crank and connecting rod."""
    across = rod_ratio * math.sin(crank_angle)
    shortening = 0.5 * across * math.sin(crank_angle) / (1 + math.sqrt(1 - across**2))
    return min(max(math.sin(0.5 * crank_angle) ** 2 - shortening, 0.0), 1.0)
