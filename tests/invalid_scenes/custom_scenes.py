"""Broken scene files of a user's own mechanism, each with the sentences it must produce."""

from __future__ import annotations

TOP = 'title = "A crank"\nmachine = "custom"\n'
GROUND = "[ground]\nO = [0, 0]\n"
BODY = '[[body]]\nname = "crank"\nmass = "2 kg"\nrod = { length = "100 mm" }\n'
JOINT = '[[joint]]\ntype = "pin"\nname = "A"\nfirst = "ground.O"\nsecond = "crank.start"\n'


def custom_scene(*more: str, top: str = TOP, ground: str = GROUND, body: str = BODY, joint: str = JOINT) -> str:
    """A rod pinned at one end, with some tables written otherwise, and more of them."""
    return "\n".join([top, ground, body, joint, *more])


def body_with(*lines: str, name: str = "crank", mass: str | None = '"2 kg"') -> str:
    """A body of that mass, with these lines."""
    told = [] if mass is None else [f"mass = {mass}"]
    return "\n".join(["[[body]]", f'name = "{name}"', *told, *lines, ""])


def joint_table(kind: str, *lines: str, name: str = "A", ends: tuple[str, str] = ("ground.O", "crank.start")) -> str:
    """A joint between two points."""
    first, second = ends
    return "\n".join(["[[joint]]", f'type = "{kind}"', f'name = "{name}"', f'first = "{first}"', f'second = "{second}"', *lines, ""])


def force_table(kind: str, *lines: str) -> str:
    """A force."""
    return "\n".join(["[[force]]", f'type = "{kind}"', 'name = "load"', *lines, ""])


POINTS_LINE = 'points = { start = ["-50 mm", 0] }'
SPINDLE = '[spindle]\nspeed = "120 rpm"\n'

BROKEN_CUSTOM: list[tuple[str, str, list[str]]] = [
    ("no body", TOP, ["body is missing; it is the moving parts, one table [[body]] for each"]),
    ("empty list of bodies", TOP + "body = []\n", ["body is an empty list; a mechanism needs at least one [[body]]"]),
    ("one table for a list", TOP + "[body]\nmass = 1\n", ["body must be a list of", "write [[body]] above each"]),
    ("a number for a body", TOP + "body = [3]\n", ["body 1 must be a table; found 3"]),
    ("dimensions", custom_scene("[dimensions]\narm = 1\n"), ["[dimensions] is unknown", "lengths stand with its bodies"]),
    ("misspelt table", custom_scene(top=TOP, joint=JOINT.replace("[[joint]]", "[[jiont]]")), ["Did you mean 'joint'?"]),
    (
        "unknown plane",
        custom_scene(top=TOP + 'plane = "turnin"\n'),
        ["plane \"turnin\" is unknown; known are fixed, turning. Did you mean 'turning'?"],
    ),
    ("size zero", custom_scene(top=TOP + "size = 0\n"), ["size must be positive; found 0"]),
    ("ground's point", custom_scene(ground='[ground]\nO = ["5 kg", 0]\n'), ['ground.O x is a length; "5 kg" is a mass']),
    ("ground's point alone", custom_scene(ground="[ground]\nO = 5\n"), ["ground.O must be [x, y]; found 5; write [0,"]),
    ("mass missing", custom_scene(body=body_with("point = true", mass=None)), ['body "crank": mass is missing; it is']),
    (
        "massless",
        custom_scene(body=body_with(POINTS_LINE, "inertia = 1", mass="0")),
        ['body "crank": mass must be positive; found 0; a bar without mass is a [[link]]'],
    ),
    (
        "no inertia",
        custom_scene(body=body_with(POINTS_LINE)),
        ['body "crank": inertia is missing; give inertia or moments, a shape', "or turns = false"],
    ),
    (
        "inertia zero",
        custom_scene(body=body_with(POINTS_LINE, "inertia = 0")),
        ['body "crank": inertia must be positive; found 0; a body that never turns has turns = false'],
    ),
    (
        "inertia of the wrong kind",
        custom_scene(body=body_with(POINTS_LINE, 'inertia = "1 kg"')),
        ['body "crank": inertia is a moment of inertia; "1 kg" is a mass; write it in kg m^2'],
    ),
    ("mass not a number", custom_scene(body=body_with("point = true", mass="nan")), ["mass must be a finite number"]),
    (
        "a length beyond all that is built",
        custom_scene(body=body_with('rod = { length = "1e10 m" }')),
        ['body "crank": rod.length must lie between 1e-09 and 1e+09 in SI; found "1e10 m"'],
    ),
    ("bare millimetres", custom_scene(body=body_with("rod = { length = 300 }")), ['write "300 mm" if that is meant']),
    (
        "two shapes",
        custom_scene(body=body_with("rod = { length = 1 }", "disc = { radius = 1 }")),
        ['body "crank": rod and disc stand together; a body has one shape'],
    ),
    (
        "shape and inertia",
        custom_scene(body=body_with("rod = { length = 1 }", "inertia = 1", "centre = [0, 0]")),
        ['body "crank": inertia and centre cannot stand beside rod, which tells how the mass lies'],
    ),
    (
        "inertia and moments",
        custom_scene(body=body_with(POINTS_LINE, "inertia = 1", "moments = { xx = 1 }")),
        ['body "crank": inertia and moments stand together'],
    ),
    (
        "moments that no body has",
        custom_scene(body=body_with(POINTS_LINE, "moments = { xx = 1, yy = 1, xy = 2 }")),
        ['body "crank": moments.xy must not exceed the square root of xx * yy; found 2'],
    ),
    ("moments zero", custom_scene(body=body_with(POINTS_LINE, "moments = { zz = 1 }")), ["moments must have xx or yy above 0"]),
    (
        "inertia in a turning plane",
        custom_scene(SPINDLE, body=body_with(POINTS_LINE, "inertia = 1")),
        ['body "crank": inertia does not tell how a turning plane pulls at the body; give moments'],
    ),
    ("a point mass that turns", custom_scene(body=body_with("point = true", "turns = true")), ['body "crank": a point mass does not turn']),
    (
        "an angle without turning",
        custom_scene(body=body_with("turns = false", 'angle = "30 deg"')),
        ['body "crank": angle must be left out for a body that never turns; found "30 deg"'],
    ),
    (
        "misspelt key of a body",
        custom_scene(body=body_with(POINTS_LINE, "inertai = 1")),
        ['body "crank": inertai is unknown; known keys of [[body]] are name, mass,', "Did you mean 'inertia'?"],
    ),
    (
        "misspelt key of a shape",
        custom_scene(body=body_with("rod = { lenght = 1 }")),
        ['body "crank": rod.lenght is unknown', "Did you mean 'length'?"],
    ),
    (
        "body named ground",
        custom_scene(body=body_with("point = true", name="ground")),
        ["name must not be 'ground'", "names the unknown body"],
    ),
    (
        "a dot in a name",
        custom_scene(body=body_with("point = true", name="a.b")),
        ["name must be text without a dot", "names the unknown body"],
    ),
    (
        "a point's name taken",
        custom_scene(body=body_with("rod = { length = 1 }", "points = { end = [0, 0] }")),
        ['body "crank": points.end is a name that this body has already'],
    ),
    ("two bodies of one name", custom_scene(body=BODY + BODY), ["body 'crank' stands 2 times; names must differ"]),
    ("two joints of one name", custom_scene(JOINT), ["joint or link 'A' stands 2 times; names must differ"]),
    (
        "unknown type of joint",
        custom_scene(joint=joint_table("pinn")),
        ['joint "A": type "pinn" is unknown; known are pin, weld, prismatic,', "Did you mean 'pin'?"],
    ),
    (
        "type of joint missing",
        custom_scene(joint=JOINT.replace('type = "pin"\n', "")),
        ['joint "A": type is missing; it is one of pin, weld, prismatic, slider, arc, curve, gear, rack, driven_turn'],
    ),
    ("end missing", custom_scene(joint=JOINT.replace('first = "ground.O"\n', "")), ['joint "A": first is missing; it is']),
    (
        "unknown body",
        custom_scene(joint=joint_table("pin", ends=("ground.O", "crnk.start"))),
        ['joint "A": second names the unknown body "crnk"; bodies are ground, crank. Did you mean \'crank\'?'],
    ),
    (
        "unknown point",
        custom_scene(joint=joint_table("pin", ends=("ground.O", "crank.strat"))),
        ['joint "A": second names the unknown point "strat" of "crank"; known are origin, centre, start, end', "Did you mean 'start'?"],
    ),
    (
        "unknown point of the ground",
        custom_scene(joint=joint_table("pin", ends=("ground.P", "crank.start"))),
        ['joint "A": first names the unknown point "P" of "ground"; known are origin, O, and more may'],
    ),
    (
        "a body without a point",
        custom_scene(joint=joint_table("pin", ends=("ground.O", "crank"))),
        ['joint "A": second "crank" names no point; write "crank.origin"'],
    ),
    ("an end of another kind", custom_scene(joint=JOINT.replace('"ground.O"', "3")), ['first must be "body.point" or']),
    (
        "a joint to itself",
        custom_scene(joint=joint_table("pin", ends=("crank.end", "crank.start"))),
        ['joint "A": first and second must be of two different bodies; both are of "crank"'],
    ),
    (
        "a key of another joint",
        custom_scene(joint=joint_table("pin", 'angle = "30 deg"')),
        ['joint "A": angle is unknown; known keys of [[joint]] are name, first, second, type.'],
    ),
    ("slider without angle", custom_scene(joint=joint_table("slider")), ['joint "A": angle is missing; it is the direction']),
    ("arc without radius", custom_scene(joint=joint_table("arc")), ['joint "A": radius is missing; it is the radius of']),
    ("gear of ratio 0", custom_scene(joint=joint_table("gear", "ratio = 0")), ["ratio must not be zero; found 0"]),
    (
        "a table's points must rise",
        custom_scene(joint=joint_table("curve", "curve = { points = [[1, 0], [0, 0]] }")),
        ['joint "A": curve.points: x of a curve\'s points must rise; 0 m follows 1 m'],
    ),
    (
        "a curve of two kinds",
        custom_scene(joint=joint_table("curve", "curve = { points = [], coefficients = [] }")),
        ['joint "A": curve must be { coefficients = [c0, c1, ...] } or { points = [[x, y], ...] }'],
    ),
    (
        "too many coefficients",
        custom_scene(joint=joint_table("curve", "curve = { coefficients = [1, 2, 3, 4, 5] }")),
        ["curve.coefficients: a polynomial curve has one to four coefficients; got 5"],
    ),
    (
        "a drive without a motion",
        custom_scene(joint=joint_table("driven_turn")),
        ['joint "A": rate or motion is missing; write rate = "120 rpm"'],
    ),
    (
        "a drive of two motions",
        custom_scene(joint=joint_table("driven_turn", "rate = 1", "motion = [[0, 0], [1, 1]]")),
        ['joint "A": rate cannot stand beside motion'],
    ),
    (
        "a drive in a jump",
        custom_scene(joint=joint_table("driven_turn", "motion = [[0, 0], [0, 1]]")),
        ['joint "A": motion: times of a motion must rise'],
    ),
    (
        "contradictory drives",
        custom_scene(joint_table("driven_turn", "rate = 1", name="B"), joint_table("driven_turn", "rate = 2", name="C")),
        ["joints 'B' and 'C' drive the same two bodies, 'ground' and 'crank'; leave one of them out"],
    ),
    (
        "a part nobody holds",
        custom_scene(body=BODY + body_with("point = true", name="loose")),
        ["nothing holds body 'loose' to the ground, and it keeps a mobility of 2: no chain of joints, links"],
    ),
    (
        "a free spindle beside a fixed plane",
        custom_scene("[spindle]\ninertia = 1\nstart_speed = 2", top=TOP + '\nplane = "fixed"'),
        ["spindle.inertia: nothing turns with it in a fixed plane", 'write plane = "turning", or leave it out'],
    ),
    (
        "parts nobody holds",
        custom_scene(
            force_table("torque", 'body = "crank"', "moment = 1"),
            body=BODY + body_with("point = true", name="loose"),
            joint=joint_table("pin", ends=("loose.centre", "crank.start")),
        ),
        ["nothing holds bodies 'crank', 'loose' to the ground"],
    ),
    (
        "unknown type of force",
        custom_scene(force_table("sprng")),
        ['force "load": type "sprng" is unknown; known are spring, damper,', "Did you mean 'spring'?"],
    ),
    (
        "spring of the wrong kind",
        custom_scene(force_table("spring", 'first = "ground.O"', 'second = "crank.end"', 'stiffness = "5 N"')),
        ['force "load": stiffness is a stiffness; "5 N" is a force; write it in N/mm, kgf/cm or N/m'],
    ),
    (
        "torsion spring of the wrong kind",
        custom_scene(force_table("torsion_spring", 'second = "crank"', 'stiffness = "5 N m"')),
        ['force "load": stiffness is a stiffness in torsion; "5 N m" is a torque; write it in N m/deg or N m/rad'],
    ),
    (
        "torque on an unknown body",
        custom_scene(force_table("torque", 'body = "crnk"', "moment = 1")),
        ['force "load": body names the unknown body "crnk"', "Did you mean 'crank'?"],
    ),
    (
        "torque program",
        custom_scene(force_table("torque", 'body = "crank"', 'moment = [[0, "5 N"], 1]')),
        [
            'force "load": moment, point 1: moment is a torque; "5 N" is a force',
            'force "load": moment, point 2: must be [time, moment]; found 1; write [0, "5 N m"]',
        ],
    ),
    (
        "force without parts",
        custom_scene(force_table("force", 'point = "crank.end"')),
        ['force "load": x or y is missing; write x = "40 N"'],
    ),
    (
        "force on the ground",
        custom_scene(force_table("force", 'point = "ground.O"', "x = 1")),
        ['force "load": point must be of a moving body'],
    ),
    (
        "link of no length",
        custom_scene('[[link]]\nname = "bar"\nfirst = "ground.O"\nsecond = "crank.start"\n'),
        ['link "bar": length is missing, and the ends of the link stand in one place'],
    ),
    (
        "unknown reading",
        custom_scene('[readings]\nlean = { angel = "crank" }\n'),
        ["readings.lean.angel is unknown; known keys of [readings.lean] are angle, against. Did you mean 'angle'?"],
    ),
    (
        "a reading of two kinds",
        custom_scene('[readings]\nlean = { x = "crank.end", y = "crank.end" }\n'),
        ["readings.lean must be a table with one of angle, line, x, y, distance; found"],
    ),
    (
        "a reading of an unknown point",
        custom_scene('[readings]\nlean = { x = "crank.eend" }\n'),
        ['readings.lean: x names the unknown point "eend" of "crank"', "Did you mean 'end'?"],
    ),
    ("a reading's name", custom_scene('[readings]\n"a b" = { angle = "crank" }\n'), ["readings.a b: the name of a"]),
    (
        "unknown start",
        custom_scene("[start]\ncrank_angel = 1\n"),
        ["start.crank_angel is unknown; known keys of [start] are crank_angle, crank_rate.", "Did you mean 'crank_angle'?"],
    ),
    ("start of the wrong kind", custom_scene('[start]\ncrank_angle = "1 m"\n'), ['start.crank_angle is an angle; "1 m" is a length']),
    (
        "no length at all",
        custom_scene(body=body_with("inertia = 1"), joint=joint_table("pin", ends=("ground.O", "crank.origin"))),
        ['size is missing: the sketch has no length to refer accuracies to; write size = "1 m"'],
    ),
    (
        "centrifugal in a fixed plane",
        custom_scene(SPINDLE, "[effects]\ncentrifugal = true\n", top=TOP + 'plane = "fixed"\n'),
        ['effects.centrifugal = true needs a plane that turns; write plane = "turning"'],
    ),
    (
        "a free spindle that nothing slows",
        custom_scene("[spindle]\ninertia = 1\nstart_speed = 1\n"),
        ["effects.centrifugal = true is missing: a free spindle is slowed by what turns with it"],
    ),
    (
        "speed and inertia",
        custom_scene('[spindle]\nspeed = "120 rpm"\ninertia = 1\n'),
        ["spindle.speed cannot stand beside inertia: either the speed is given, or inertia"],
    ),
    (
        "no start of a free spindle",
        custom_scene('[spindle]\ninertia = "1 kg"\n'),
        ['spindle.inertia is a moment of inertia; "1 kg" is a mass', "spindle.start_speed is missing; it is the speed"],
    ),
    (
        "negative inertia of the spindle",
        custom_scene("[spindle]\ninertia = -1\nstart_speed = 1\n"),
        ["spindle.inertia must not be negative; found -1"],
    ),
    (
        "a misspelt key of the spindle",
        custom_scene("[spindle]\nsped = 1\n"),
        [
            "spindle.sped is unknown; known keys of [spindle] are speed, speed_fluctuation, cycles_per_turn, inertia, start_speed,",
            "Did you mean 'speed'?",
        ],
    ),
    (
        "several mistakes at once",
        custom_scene(
            "[run]\nduration = 0\n",
            force_table("spring", 'first = "grund.O"', 'second = "crank.ned"', "stiffness = 5"),
            body=BODY + body_with("point = true", name="bob", mass="0"),
            joint=joint_table("pinn") + joint_table("pin", name="B", ends=("bob.nowhere", "crank.end")),
        ),
        [
            'body "bob": mass must be positive',
            'joint "A": type "pinn" is unknown',
            'force "load": first names the unknown body "grund"; bodies are ground, crank, bob.',
            'force "load": second names the unknown point "ned"',
            "run.duration must be positive",
        ],
    ),
]
