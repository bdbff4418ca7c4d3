"""Drawing of an engine with a flywheel: the engine at a small scale, and below it each cylinder with its indicator diagram.

The machine stands with its cylinders below the shaft; the drawing lays it on its side, with the shaft at the left.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from governor_mechanism.machines.flywheel_engine.machine import FLYWHEEL, expansion_gas
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.render.geometry.primitives import DrawnShape
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

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield castings, guides and indicator diagrams."""
        yield from self._engine.background_shapes()
        for cylinder in self._cylinders:
            yield from cylinder.background_shapes()

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield wheel, crank, rods and pistons, the gas, and the points on its diagrams."""
        crank_angle = float(pose[self.part.mechanism.body_index(FLYWHEEL), 2])
        yield from self._engine.moving_shapes(crank_angle)
        is_return = bool(math.floor(crank_angle / math.pi) % 2)
        rods = (self.connecting_rod, 0.5 * self.stroke), (self.pump_connecting_rod, 0.5 * self.pump_stroke)
        cylinders = (*self.expansion_cylinders(time), *self._cylinders[1:])
        for cylinder, (rod, crank) in zip(cylinders, rods, strict=False):
            yield from cylinder.moving_shapes(relative_travel(crank_angle, crank / rod), is_return)


def relative_travel(crank_angle: float, rod_ratio: float) -> float:
    """Return the travel of a piston relative to its stroke; `rod_ratio` is that of crank and connecting rod."""
    across = rod_ratio * math.sin(crank_angle)
    shortening = 0.5 * across * math.sin(crank_angle) / (1 + math.sqrt(1 - across**2))
    return min(max(math.sin(0.5 * crank_angle) ** 2 - shortening, 0.0), 1.0)
