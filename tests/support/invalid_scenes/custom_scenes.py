"""Broken scene files with a custom machine, each with the code and the key of every mistake."""

from invalid_scenes.cases import Case, wrong

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

BROKEN_CUSTOM: list[Case] = [
    wrong(
        "event of an unknown reading",
        custom_scene('[events]\npassed = { reading = "crank_angl", value = "20 deg" }\n'),
        "unknown name: events.passed.reading",
    ),
    wrong("no body", TOP, "missing key: body"),
    wrong("empty list of bodies", TOP + "body = []\n", "missing key: body"),
    wrong("one table for a list", TOP + "[body]\nmass = 1\n", "wrong type: body"),
    wrong("a number for a body", TOP + "body = [3]\n", "wrong type: body 1"),
    wrong("dimensions", custom_scene("[dimensions]\narm = true\n"), "wrong type: dimensions.arm"),
    wrong("misspelt table", custom_scene(top=TOP, joint=JOINT.replace("[[joint]]", "[[jiont]]")), "unknown key: jiont"),
    wrong("unknown plane", custom_scene(top=TOP + 'plane = "turnin"\n'), "unknown name: plane"),
    wrong("size zero", custom_scene(top=TOP + "size = 0\n"), "out of range: size"),
    wrong("ground's point", custom_scene(ground='[ground]\nO = ["5 kg", 0]\n'), "wrong quantity: ground"),
    wrong("ground's point alone", custom_scene(ground="[ground]\nO = 5\n"), "wrong type: ground"),
    wrong(
        "moving points with mistakes",
        custom_scene(ground='[ground]\nO = [0, 0]\nP = [0, { rate = "1 m" }]\nQ = [{ start = 0 }]\n"a.b" = [[[0, 0], [1, 1]], 0]\n'),
        "wrong quantity: ground.P y: rate; wrong type: ground.Q; wrong type: ground.a.b",
    ),
    wrong("mass missing", custom_scene(body=body_with("point = true", mass=None)), 'missing key: body "crank": mass'),
    wrong("negative mass", custom_scene(body=body_with(POINTS_LINE, "inertia = 1", mass="-1")), 'out of range: body "crank": mass'),
    wrong(
        "point masses with mistakes",
        custom_scene(body=body_with("point_masses = [{ mass = 0, at = [0, 0] }, { mass = 1 }]", mass=None)),
        'out of range: body "crank": point_masses, point mass 1: mass; missing key: body "crank": point_masses, point mass 2: at',
    ),
    wrong("no inertia", custom_scene(body=body_with(POINTS_LINE)), 'missing key: body "crank": inertia'),
    wrong("inertia zero", custom_scene(body=body_with(POINTS_LINE, "inertia = 0")), 'out of range: body "crank": inertia'),
    wrong(
        "inertia of the wrong kind", custom_scene(body=body_with(POINTS_LINE, 'inertia = "1 kg"')), 'wrong quantity: body "crank": inertia'
    ),
    wrong("mass not a number", custom_scene(body=body_with("point = true", mass="nan")), 'wrong quantity: body "crank": mass'),
    wrong(
        "a length beyond all that is built",
        custom_scene(body=body_with('rod = { length = "1e10 m" }')),
        'out of range: body "crank": rod.length',
    ),
    wrong("bare millimetres", custom_scene(body=body_with("rod = { length = 300 }")), 'wrong quantity: body "crank": rod.length'),
    wrong("two shapes", custom_scene(body=body_with("rod = { length = 1 }", "disc = { radius = 1 }")), 'conflict: body "crank"'),
    wrong(
        "shape and inertia",
        custom_scene(body=body_with("rod = { length = 1 }", "inertia = 1", "centre = [0, 0]")),
        'conflict: body "crank"',
    ),
    wrong(
        "inertia and moments", custom_scene(body=body_with(POINTS_LINE, "inertia = 1", "moments = { xx = 1 }")), 'conflict: body "crank"'
    ),
    wrong(
        "moments that no body has",
        custom_scene(body=body_with(POINTS_LINE, "moments = { xx = 1, yy = 1, xy = 2 }")),
        'out of range: body "crank": moments',
    ),
    wrong("moments zero", custom_scene(body=body_with(POINTS_LINE, "moments = { zz = 1 }")), 'out of range: body "crank"'),
    wrong("inertia in a turning plane", custom_scene(SPINDLE, body=body_with(POINTS_LINE, "inertia = 1")), 'missing key: body "crank"'),
    wrong("a point mass that turns", custom_scene(body=body_with("point = true", "turns = true")), 'conflict: body "crank"'),
    wrong("an angle without turning", custom_scene(body=body_with("turns = false", 'angle = "30 deg"')), 'conflict: body "crank"'),
    wrong("misspelt key of a body", custom_scene(body=body_with(POINTS_LINE, "inertai = 1")), 'unknown key: body "crank": inertai'),
    wrong("misspelt key of a shape", custom_scene(body=body_with("rod = { lenght = 1 }")), 'unknown key: body "crank": rod.lenght'),
    wrong(
        "body named ground",
        custom_scene(body=body_with("point = true", name="ground")),
        'duplicate: body "ground": name; unknown name: joint "A": second',
    ),
    wrong(
        "a dot in a name",
        custom_scene(body=body_with("point = true", name="a.b")),
        'wrong type: body "a.b": name; unknown name: joint "A": second',
    ),
    wrong(
        "a point's name taken", custom_scene(body=body_with("rod = { length = 1 }", "points = { end = [0, 0] }")), 'duplicate: body "crank"'
    ),
    wrong("two bodies of one name", custom_scene(body=BODY + BODY), "duplicate: body"),
    wrong("two joints of one name", custom_scene(JOINT), "duplicate: joint or link"),
    wrong("unknown type of joint", custom_scene(joint=joint_table("pinn")), 'unknown name: joint "A": type'),
    wrong("type of joint missing", custom_scene(joint=JOINT.replace('type = "pin"\n', "")), 'missing key: joint "A": type'),
    wrong("end missing", custom_scene(joint=JOINT.replace('first = "ground.O"\n', "")), 'missing key: joint "A": first'),
    wrong("unknown body", custom_scene(joint=joint_table("pin", ends=("ground.O", "crnk.start"))), 'unknown name: joint "A": second'),
    wrong("unknown point", custom_scene(joint=joint_table("pin", ends=("ground.O", "crank.strat"))), 'unknown name: joint "A": second'),
    wrong(
        "unknown point of the ground",
        custom_scene(joint=joint_table("pin", ends=("ground.P", "crank.start"))),
        'unknown name: joint "A": first',
    ),
    wrong("a body without a point", custom_scene(joint=joint_table("pin", ends=("ground.O", "crank"))), 'wrong type: joint "A": second'),
    wrong("an end of another kind", custom_scene(joint=JOINT.replace('"ground.O"', "3")), 'wrong type: joint "A": first'),
    wrong("a joint to itself", custom_scene(joint=joint_table("pin", ends=("crank.end", "crank.start"))), 'conflict: joint "A"'),
    wrong("a key of another joint", custom_scene(joint=joint_table("pin", 'angle = "30 deg"')), 'unknown key: joint "A": angle'),
    wrong("slider without angle", custom_scene(joint=joint_table("slider")), 'missing key: joint "A": angle'),
    wrong("arc without radius", custom_scene(joint=joint_table("arc")), 'missing key: joint "A": radius'),
    wrong("gear of ratio 0", custom_scene(joint=joint_table("gear", "ratio = 0")), 'out of range: joint "A": ratio'),
    wrong(
        "a table's points must rise",
        custom_scene(joint=joint_table("curve", "curve = { points = [[1, 0], [0, 0]] }")),
        'inconsistent: joint "A": curve.points',
    ),
    wrong(
        "a curve of two kinds",
        custom_scene(joint=joint_table("curve", "curve = { points = [], coefficients = [] }")),
        'wrong type: joint "A": curve',
    ),
    wrong(
        "no coefficients",
        custom_scene(joint=joint_table("curve", "curve = { coefficients = [] }")),
        'inconsistent: joint "A": curve.coefficients',
    ),
    wrong("a drive without a motion", custom_scene(joint=joint_table("driven_turn")), 'missing key: joint "A"'),
    wrong(
        "a drive of two motions",
        custom_scene(joint=joint_table("driven_turn", "rate = 1", "motion = [[0, 0], [1, 1]]")),
        'conflict: joint "A"',
    ),
    wrong(
        "a drive in a jump", custom_scene(joint=joint_table("driven_turn", "motion = [[0, 0], [0, 1]]")), 'inconsistent: joint "A": motion'
    ),
    wrong(
        "a formula of a motion with mistakes",
        custom_scene(
            joint=joint_table(
                "driven_turn",
                'motion = { rat = 1, harmonics = [{ amplitude = "1 mm", frequency = 1 }, { amplitude = 1, frequency = 0 }, 3, {}] }',
            )
        ),
        'wrong quantity: joint "A": motion.harmonics, harmonic 1: amplitude',
        'out of range: joint "A": motion.harmonics, harmonic 2: frequency; wrong type: joint "A": motion.harmonics, harmonic 3',
        'missing key: joint "A": motion.harmonics, harmonic 4: amplitude',
        'missing key: joint "A": motion.harmonics, harmonic 4: frequency; unknown key: joint "A": motion.rat',
    ),
    wrong("a number for a motion", custom_scene(joint=joint_table("driven_turn", "motion = 3")), 'wrong type: joint "A": motion'),
    wrong(
        "contradictory drives",
        custom_scene(joint_table("driven_turn", "rate = 1", name="B"), joint_table("driven_turn", "rate = 2", name="C")),
        "conflict: joint",
    ),
    wrong("a part nobody holds", custom_scene(body=BODY + body_with("point = true", name="loose")), "missing key: body"),
    wrong(
        "a free spindle beside a fixed plane",
        custom_scene("[spindle]\ninertia = 1\nstart_speed = 2", top=TOP + '\nplane = "fixed"'),
        "conflict: spindle.inertia",
    ),
    wrong(
        "parts nobody holds",
        custom_scene(
            force_table("torque", 'body = "crank"', "moment = 1"),
            body=BODY + body_with("point = true", name="loose"),
            joint=joint_table("pin", ends=("loose.centre", "crank.start")),
        ),
        "missing key: body",
    ),
    wrong(
        "unknown type of force",
        custom_scene(force_table("sprng")),
        'missing key: force "load": first; missing key: force "load": second; unknown name: force "load": type',
        'missing key: force "load": stiffness',
    ),
    wrong(
        "spring of the wrong kind",
        custom_scene(force_table("spring", 'first = "ground.O"', 'second = "crank.end"', 'stiffness = "5 N"')),
        'wrong quantity: force "load": stiffness',
    ),
    wrong(
        "torsion spring of the wrong kind",
        custom_scene(force_table("torsion_spring", 'second = "crank"', 'stiffness = "5 N m"')),
        'wrong quantity: force "load": stiffness',
    ),
    wrong(
        "torque on an unknown body", custom_scene(force_table("torque", 'body = "crnk"', "moment = 1")), 'unknown name: force "load": body'
    ),
    wrong(
        "torque program",
        custom_scene(force_table("torque", 'body = "crank"', 'moment = [[0, "5 N"], 1]')),
        'wrong quantity: force "load": moment; wrong type: force "load": moment',
    ),
    wrong("force without parts", custom_scene(force_table("force", 'point = "crank.end"')), 'missing key: force "load"'),
    wrong("force on the ground", custom_scene(force_table("force", 'point = "ground.O"', "x = 1")), 'conflict: force "load"'),
    wrong(
        "link of no length", custom_scene('[[link]]\nname = "bar"\nfirst = "ground.O"\nsecond = "crank.start"\n'), 'missing key: link "bar"'
    ),
    wrong("unknown reading", custom_scene('[readings]\nlean = { angel = "crank" }\n'), "unknown key: readings.lean.angel"),
    wrong("a reading of two kinds", custom_scene('[readings]\nlean = { x = "crank.end", y = "crank.end" }\n'), "wrong type: readings.lean"),
    wrong("a reading of an unknown point", custom_scene('[readings]\nlean = { x = "crank.eend" }\n'), "unknown name: readings.lean.x"),
    wrong("a reading's name", custom_scene('[readings]\n"a b" = { angle = "crank" }\n'), "wrong type: readings.a b"),
    wrong("unknown start", custom_scene("[start]\ncrank_angel = 1\n"), "unknown key: start.crank_angel"),
    wrong("start of the wrong kind", custom_scene('[start]\ncrank_angle = "1 m"\n'), "wrong quantity: start.crank_angle"),
    wrong(
        "no length at all",
        custom_scene(body=body_with("inertia = 1"), joint=joint_table("pin", ends=("ground.O", "crank.origin"))),
        "missing key: size",
    ),
    wrong(
        "centrifugal in a fixed plane",
        custom_scene(SPINDLE, "[effects]\ncentrifugal = true\n", top=TOP + 'plane = "fixed"\n'),
        "conflict: effects.centrifugal",
    ),
    wrong("a free spindle that nothing slows", custom_scene("[spindle]\ninertia = 1\nstart_speed = 1\n"), "conflict: effects.centrifugal"),
    wrong("speed and inertia", custom_scene('[spindle]\nspeed = "120 rpm"\ninertia = 1\n'), "conflict: spindle.inertia"),
    wrong(
        "no start of a free spindle",
        custom_scene('[spindle]\ninertia = "1 kg"\n'),
        "wrong quantity: spindle.inertia; missing key: spindle.start_speed",
    ),
    wrong("negative inertia of the spindle", custom_scene("[spindle]\ninertia = -1\nstart_speed = 1\n"), "out of range: spindle.inertia"),
    wrong("a misspelt key of the spindle", custom_scene("[spindle]\nsped = 1\n"), "unknown key: spindle.sped"),
    wrong(
        "several mistakes at once",
        custom_scene(
            "[run]\nduration = 0\n",
            force_table("spring", 'first = "grund.O"', 'second = "crank.ned"', "stiffness = 5"),
            body=BODY + body_with("point = true", name="bob", mass="-1"),
            joint=joint_table("pinn") + joint_table("pin", name="B", ends=("bob.nowhere", "crank.end")),
        ),
        'out of range: body "bob": mass; unknown name: joint "A": type; unknown name: force "load": first',
        'unknown name: force "load": second; out of range: run.duration',
    ),
]

WORDING_CUSTOM: list[tuple[str, str]] = [
    ("empty list of bodies", "body is an empty list; a mechanism needs at least one [[body]]"),
    ("one table for a list", "body must be a list of tables; found {'mass': 1}; write [[body]] above each of them"),
    ("a number for a body", "body 1 must be a table; found 3"),
    (
        "misspelt table",
        (
            "[[jiont]] is unknown; a scene file has machine, title, effects, spindle, start, run, events, size, plane, "
            "ground, body, joint, link, force, readings, valve, assembly, dimensions, law. Did you mean 'joint'?"
        ),
    ),
    ("ground's point", 'ground.O x is a length; "5 kg" is a mass; write it in mm, cm or m'),
    ("ground's point alone", 'ground.O must be [x, y]; found 5; write [0, "300 mm"]'),
    ("negative mass", 'body "crank": mass must not be negative; found -1'),
    (
        "mass missing",
        'body "crank": mass is missing; it is the mass, as "0.2 kg", and 0 for a lever without mass; a bar without mass is a [[link]]',
    ),
    (
        "no inertia",
        (
            'body "crank": inertia is missing; give inertia or moments, a shape (rod, disc, plate, point), point_masses '
            "instead of mass, or turns = false for a body that does not rotate"
        ),
    ),
    ("inertia zero", 'body "crank": inertia must be positive; found 0; a body that does not rotate has turns = false'),
    ("mass not a number", 'body "crank": mass must be a finite number; found nan; write "5 kg", or the bare number in kg'),
    ("a length beyond all that is built", 'body "crank": rod.length must lie between 1e-09 and 1e+09 in SI; found "1e10 m"'),
    ("two shapes", 'body "crank": rod and disc are given; a body has one shape, or inertia and centre'),
    ("shape and inertia", 'body "crank": inertia and centre cannot be combined with rod, which determines them'),
    ("inertia and moments", 'body "crank": inertia cannot be combined with moments, from which it follows as xx + yy'),
    ("moments that no body has", 'body "crank": moments.xy must not exceed the square root of xx * yy; found 2.0'),
    ("moments zero", 'body "crank": moments must have xx or yy above 0; a body without extent has point = true'),
    (
        "inertia in a turning plane",
        (
            'body "crank": inertia does not determine the centrifugal forces in a turning plane; give moments = { '
            'xx = "0.5 kg m^2", ... } or a shape (rod, disc, plate) instead'
        ),
    ),
    ("a point mass that turns", 'body "crank": a point mass does not rotate; leave out turns = true, or point = true'),
    ("an angle without turning", 'body "crank": angle must be left out for a body that does not rotate; found 0.5235987755982989 rad'),
    ("body named ground", "body \"ground\": name must not be 'ground', which is the fixed plane; its points are in [ground]"),
    ("body named ground", 'joint "A": second names the unknown body "crank"; bodies are ground.'),
    ("a dot in a name", 'body "a.b": name must be one line of text without a dot, at most 200 characters; found "a.b"'),
    ("a point's name taken", 'body "crank": points.end is the name of a point that the body already has; choose another'),
    ("two bodies of one name", "body 'crank' is defined 2 times; names must differ"),
    (
        "unknown point",
        (
            'joint "A": second names the unknown point "strat" of "crank"; known are origin, centre, start, end; '
            "add others to the points of body \"crank\". Did you mean 'start'?"
        ),
    ),
    ("a body without a point", 'joint "A": second "crank" names no point; write "crank.origin", or ["crank", "10 mm", 0]'),
    ("an end of another kind", 'joint "A": first must be "body.point" or ["body", x, y]; found 3'),
    ("a joint to itself", 'joint "A": both ends are of "crank"; they must be of two different bodies'),
    ("gear of ratio 0", 'joint "A": ratio must not be zero; found 0'),
    ("a table's points must rise", 'joint "A": curve.points: x of a curve\'s points must rise; 0 m follows 1 m'),
    (
        "a curve of two kinds",
        (
            'joint "A": curve must be { coefficients = [c0, c1, ...] } or { points = [[x, y], ...] }, or for a closed curve '
            "{ closed = [[x, y], ...] }, { polar = [[angle, radius], ...] } or { radius = r, harmonics = [...] }; found "
            "{'coefficients': [], 'points': []}"
        ),
    ),
    ("no coefficients", 'joint "A": curve.coefficients: a polynomial curve needs at least one coefficient; [0] is the x axis'),
    (
        "a drive without a motion",
        ('joint "A": rate or motion is missing; write rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'),
    ),
    ("a drive of two motions", 'joint "A": rate cannot be combined with motion, which is complete'),
    ("a drive in a jump", 'joint "A": motion: times of a motion must rise; 0 s follows 0 s; a driver cannot jump'),
    ("contradictory drives", "joints 'B' and 'C' drive the same two bodies, 'ground' and 'crank'; leave one of them out"),
    (
        "a part nobody holds",
        ("nothing connects body 'loose' to the ground: no chain of joints, links, springs or dampers; add a [[joint]] or a [[link]]"),
    ),
    (
        "a free spindle beside a fixed plane",
        (
            "spindle.inertia has no effect, because nothing turns with the spindle in a fixed plane; write plane "
            '= "turning", or leave it out'
        ),
    ),
    (
        "parts nobody holds",
        (
            "nothing connects bodies 'crank', 'loose' to the ground: no chain of joints, links, springs or "
            "dampers; add a [[joint]] or a [[link]]"
        ),
    ),
    ("torque program", 'force "load": moment, point 1: moment is a torque; "5 N" is a force; write it in kgf m or N m'),
    ("torque program", 'force "load": moment, point 2: must be [time, moment]; found 1; write [0, "5 N m"]'),
    ("force without parts", 'force "load": x or y is missing; write x = "40 N" for a force along x'),
    ("force on the ground", 'force "load": point must be of a moving body; a force on the ground has no effect'),
    ("link of no length", 'link "bar": length is missing, and the ends of the link coincide initially'),
    (
        "a reading of two kinds",
        (
            "readings.lean must be a table with one of angle, line, x, y, distance; found {'x': 'crank.end', 'y': "
            "'crank.end'}; write lean = { angle = \"crank\" }"
        ),
    ),
    ("a reading's name", "readings.a b: the name of a reading consists of letters, digits and _, as crank_angle"),
    ("no length at all", ('size is missing: the initial configuration has no length that could be the length scale; write size = "1 m"')),
    ("centrifugal in a fixed plane", 'effects.centrifugal = true needs a turning plane; write plane = "turning", or leave it out'),
    (
        "a free spindle that nothing slows",
        ("effects.centrifugal = true is missing: a free spindle is slowed by the bodies that turn with it; add it, or give spindle.speed"),
    ),
    (
        "speed and inertia",
        ("spindle.inertia cannot be combined with speed; give either speed, or inertia, start_speed and torque of a free spindle"),
    ),
    ("negative inertia of the spindle", "spindle.inertia must not be negative; found -1"),
]
"""A case that has each message, and the message."""
