"""Names of the parts that a visitor points at, by the roles of their shapes, with a sentence on what they do."""

from typing import Final

from governor_mechanism.render.geometry.primitives import KEY

PART_NAMES: Final[dict[str, tuple[str, str]]] = {
    "axis": ("axis", "The line about which the spindle turns, or along which a part slides."),
    "spindle": ("spindle", "The upright shaft that carries the governor and turns with the engine."),
    "frame": ("frame", "The piece that is keyed to its shaft and carries the pins."),
    "bearing": ("bearing", "Holds the shaft, and lets it turn; seen in section."),
    "arm": ("arm", "A rigid bar; that of a governor hangs on the spindle and carries a ball."),
    "link": ("link", "Joins two pins at a fixed distance."),
    "rod": ("rod", "A bar with mass between two pins."),
    "ball": ("ball", "The mass that swings out when the spindle turns faster."),
    "sleeve": ("sleeve", "Slides on the spindle; its height tells the speed."),
    "pointer": ("pointer", "Shows the lift of the sleeve on the scale."),
    "scale": ("scale", "Measures the lift or the position."),
    "pivot": ("pin", "Joins two parts so that they can turn."),
    "stop": ("stop", "Ends the travel."),
    "bracket": ("bracket", "Carries another part."),
    "seat": ("spring seat", "Takes the end of a spring."),
    "spring": ("spring", "Pushes or pulls more, the further it is deformed."),
    "coil": ("spring", "Pulls or pushes the weights inward."),
    "weight bore": ("bore of the weight", "Houses the spring."),
    "dashpot": ("dashpot", "A cylinder with oil that resists fast motion."),
    "oil": ("oil", "Flows past the piston of the dashpot."),
    "bore": ("bore", "The inside of a cylinder."),
    "weight section": ("weight", "The mass that moves out when the spindle turns faster; seen in section."),
    "angle arc": ("angle", "A reading of the run."),
    "reaction": ("reaction", "The force in a joint."),
    "velocity": ("velocity", "The velocity of this point, as an arrow; all are to one scale."),
    "acceleration": ("acceleration", "The acceleration of this point, as an arrow; all are to one scale."),
    "instantaneous centre": ("instantaneous centre", "A body turns about this point at the moment."),
    "piston": ("piston", "Moves in the cylinder."),
    "piston rod": ("piston rod", "Joins the piston to what it moves."),
    "damper": ("damper", "Resists motion in proportion to its speed."),
    "shoe": ("friction shoe, sliding", "Rubs, and dissipates energy."),
    "held shoe": ("friction shoe, holding", "Holds the sleeve: the forces on it are below the friction."),
    "slot": ("slot", "Guides a pin or a block."),
    "eyelet": ("eye of the link", "Has clearance in the slot."),
    "lens": ("enlarged detail", "Shows the clearance larger than it is."),
    "plate": ("moving body", "A rigid body of the mechanism."),
    "block": ("sliding block", "Slides along a guide."),
    "wheel": ("wheel", "Turns about its shaft."),
    "wheel web": ("flywheel", "Evens out the speed of the shaft."),
    "rim": ("rim", "Carries most of the mass of the wheel."),
    "spoke": ("spoke", "Joins rim and hub."),
    "marked spoke": ("marked spoke", "Painted, so that the turning can be followed."),
    "rack": ("rack", "A straight row of teeth."),
    "tooth": ("tooth", "Drives the next wheel."),
    "drum": ("damper", "Resists turning."),
    "guide": ("guide", "The path of a point or a block."),
    "wall": ("ground", "Does not move."),
    "drive": ("drive", "Prescribes the motion of this pin."),
    "tracer": ("traced point", "Its position is a reading."),
    "force": ("applied load", "A force or a torque from outside."),
    "hub": ("shaft", "Turns in its bearings."),
    "crank web": ("crank", "Turns with the shaft."),
    "eccentric": ("eccentric", "A disc off the centre of the shaft; it moves the valve."),
    "small rod": ("connecting rod", "Joins the crank to the crosshead."),
    "eccentric rod": ("eccentric rod", "Joins the eccentric to the valve."),
    "casting": ("casting", "The fixed iron of cylinder and ports; seen in section."),
    "live steam": ("live steam", "Comes from the supply at full pressure."),
    "expanding steam": ("expanding steam", "Works while its pressure falls."),
    "spent steam": ("spent steam", "Leaves at the pressure behind the piston."),
    "pressed steam": ("steam under compression", "Is shut in before the end of the stroke."),
    "valve": ("slide valve", "Opens and closes the ports."),
    "valve cavity": ("exhaust cavity", "Leads the spent steam away."),
    "crank end curve": ("valve opening, crank end", "Displacement of the valve on the ray of the crank."),
    "head end curve": ("valve opening, head end", "Displacement of the valve on the ray of the crank."),
    "crank end mark": ("crank end, now", "Where the crank end stands on its curve."),
    "head end mark": ("head end, now", "Where the head end stands on its curve."),
    "lap circle": ("lap circle", "The valve opens where the curve passes it."),
    "valve circle": ("valve circle", "Zeuner's circle of the valve."),
    "projection": ("projection", "Joins what happens at the same moment."),
    "division": ("divisions", "Angles of the crank."),
    "belt": ("belt", "Drives the pulleys."),
    "butterfly": ("throttle", "Turns in the pipe and holds back the supply."),
    "weight": ("weight of the brake", "Is the load of the engine."),
    "frame plate": ("stand", "Carries the machine."),
    "burst": ("impact", "Two parts have just met."),
}
"""Name and sentence of each role that has one."""

SAME_AS: Final[dict[str, str]] = {
    "spindle shade": "spindle",
    "bearing hatching": "bearing",
    "engraving": "sleeve",
    "ball shine": "ball",
    "stop hatching": "stop",
    "coil edge": "coil",
    "coil behind": "coil",
    "bore edge": "casting",
    "casting hatching": "casting",
    "hatching": "wall",
    "eye": "pivot",
    "crank end chord": "crank end mark",
    "head end chord": "head end mark",
    "struck": "eyelet",
    "angle ray": "angle arc",
    "letter": "angle arc",
    "weight section hatching": "weight section",
    "plate web": "plate",
    "plate rim": "plate",
    "plate edge": "plate",
}
"""Role whose name a role shares."""

BODY_ROLES: Final = frozenset(
    {"plate", "plate web", "plate rim", "plate edge", "wheel", "block", "ball", "rod", "link", "spoke", "marked spoke", "rim", "wheel web"}
)
"""Roles that a drawing of any mechanism calls by the name of the body."""


ENGINE_ROOM: Final = "engine room"
"""What stands for the machine in the drawing of a governed engine."""

_BELL_CRANK: Final = ("bell crank", "Turns the way of the masses into the lift of the sleeve.")
_PRESSURE: Final = "The indicator diagram: pressure over the travel of the piston."

MACHINE_NAMES: Final[dict[str, dict[str, tuple[str, str]]]] = {
    "hartung": {
        "ball": ("weight", "The mass that moves out when the spindle turns faster."),
        "arm": _BELL_CRANK,
        "link": ("hanger", "Joins the bell crank to the sleeve."),
        "rod": ("cross rod", "Carries the springs."),
    },
    "hartnell": {"arm": _BELL_CRANK, "eyelet": ("roller", "Lifts the sleeve.")},
    "stephenson": {
        "ball": ("handle", "Sets the gear: ahead, back, or between."),
        "arm": ("rod or crank", "Joins two pins."),
        "link": ("eccentric rod", "Joins an eccentric to the link."),
        "plate": ("curved link", "Swings between its two rods; the die takes its motion."),
        "rod": ("hanger", "Lifts the link to reverse the engine."),
        "block": ("die", "Slides in the link and drives the valve."),
    },
    "slide_valve": {"arm": ("crank", "Turns with the shaft."), "block": ("crosshead", "Slides in its guides.")},
    "flywheel_engine": {
        "crank end curve": ("pressure, crank end", _PRESSURE),
        "head end curve": ("pressure, head end", _PRESSURE),
        "crank end mark": ("pressure now, crank end", _PRESSURE),
        "head end mark": ("pressure now, head end", _PRESSURE),
    },
    ENGINE_ROOM: {
        "eccentric": ("throttle lever", "Turns the throttle."),
        "shoe": ("brake", "Is the load of the engine."),
        "arm": ("arm or lever", "Carries a ball, or leads the lift of the sleeve to what the governor moves."),
    },
}
"""Names that the roles have in the drawing of a machine instead."""

GROUP_NAMES: Final[dict[str, tuple[str, str]]] = {
    "throttle": ("throttle gear", "Leads the lift of the sleeve to the throttle."),
    "gearing": ("gearing", "Turns the spindle from a shaft of the engine."),
}
"""Names of all roles with the same first word."""


def name_part(role: str, machine: str, body: str) -> tuple[str, str]:
    """Return the name and the sentence of a shape by its role and machine, or by the name of its body if that is given; or nothing."""
    if body and role in BODY_ROLES:
        return body, ""
    named = SAME_AS.get(role, role).removesuffix(KEY)
    return MACHINE_NAMES.get(machine, {}).get(named) or PART_NAMES.get(named) or GROUP_NAMES.get(role.split()[0], ("", ""))
