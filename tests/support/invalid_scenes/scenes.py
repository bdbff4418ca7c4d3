"""Broken scene files, each with the code and the key of every mistake."""

from governor_mechanism.scenes.parser import MAX_SCENE_FILE_SIZE
from invalid_scenes.cases import Case, wrong

SCENE_HEADER = 'title = "A Porter governor"\nmachine = "pendulum_governor"\n'
DIMENSIONS = {"arm": '"300 mm"', "offset": '"40 mm"', "ball_mass": '"5 kg"', "sleeve_mass": '"20 kg"'}
DEFAULT_TABLES = {
    "effects": "gravity = true\ncentrifugal = true",
    "spindle": 'speed = "120 rpm"',
    "start": 'arm_angle = "40 deg"',
    "run": 'duration = "10 s"\noutput_interval = "10 ms"\naccuracy = 1e-6\nengine = "auto"',
}


def scene_text(top: str = SCENE_HEADER, dimensions: str | None = None, /, **tables: str | None) -> str:
    """The Porter scene, with some tables written otherwise; None leaves a table out."""
    lines = "\n".join(f"{key} = {value}" for key, value in DIMENSIONS.items()) if dimensions is None else dimensions
    contents = {"dimensions": lines, **DEFAULT_TABLES, **tables}
    return top + "".join(f"\n[{name}]\n{text}\n" for name, text in contents.items() if text is not None)


def format_dimensions(**changed: str | None) -> str:
    """The Porter's dimensions, with some written otherwise; None leaves one out."""
    return "\n".join(f"{key} = {value}" for key, value in {**DIMENSIONS, **changed}.items() if value is not None)


TABLE_MISTAKES = {
    "effects": 'gravity = true\ncentrifugal = "yes"',
    "spindle": 'speed = "2 Hz"',
    "start": 'arm_angle = "equilibrum"',
    "run": "duration = 0",
}
"""One mistake in every table that stands beside the dimensions."""

BROKEN_SCENES: list[Case] = [
    wrong("events not a table", scene_text("events = 3\n" + SCENE_HEADER), "wrong type: events"),
    wrong("event not a table", scene_text(events="passed = 3"), "wrong type: events.passed"),
    wrong("empty event", scene_text(events="passed = {}"), "missing key: events.passed.reading; missing key: events.passed.value"),
    wrong(
        "event of an unknown reading",
        scene_text(events='passed = { reading = "sleeve_lft", value = "20 mm" }'),
        "unknown name: events.passed.reading",
    ),
    wrong(
        "event in a unit of the wrong kind",
        scene_text(events='passed = { reading = "sleeve", value = "20 deg" }'),
        "wrong quantity: events.passed.value",
    ),
    wrong(
        "event with several mistakes",
        scene_text(events='passed = { reading = 3, value = "20 kg", direction = "dwn" }'),
        "wrong type: events.passed.reading; wrong quantity: events.passed.value; unknown name: events.passed.direction",
    ),
    wrong(
        "event with a misspelt key",
        scene_text(events='passed = { reading = "sleeve", value = 0.02, directon = "up" }'),
        "unknown key: events.passed.directon",
    ),
    wrong("event with a dot in its name", scene_text(events='"a.b" = { reading = "sleeve", value = 0.02 }'), "wrong type: events.a.b"),
    wrong("unit of the wrong kind", scene_text(SCENE_HEADER, format_dimensions(arm='"5 kg"')), "wrong quantity: dimensions.arm"),
    wrong("weight for a mass", scene_text(SCENE_HEADER, format_dimensions(ball_mass='"45 kgf"')), "wrong quantity: dimensions.ball_mass"),
    wrong(
        "weight in newtons for a mass",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass='"441 N"')),
        "wrong quantity: dimensions.ball_mass",
    ),
    wrong("misspelt optional key", scene_text(SCENE_HEADER, format_dimensions(sleve_mass='"20 kg"')), "unknown key: dimensions.sleve_mass"),
    wrong(
        "misspelt required key",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass=None, bal_mass='"5 kg"')),
        "unknown key: dimensions.bal_mass",
    ),
    wrong("zero mass", scene_text(SCENE_HEADER, format_dimensions(ball_mass="0")), "out of range: dimensions.ball_mass"),
    wrong("zero sleeve", scene_text(SCENE_HEADER, format_dimensions(sleeve_mass="0")), "out of range: dimensions.sleeve_mass"),
    wrong("negative mass", scene_text(SCENE_HEADER, format_dimensions(ball_mass='"-5 kg"')), "out of range: dimensions.ball_mass"),
    wrong("not a number", scene_text(SCENE_HEADER, format_dimensions(arm="nan")), "wrong quantity: dimensions.arm"),
    wrong("infinite", scene_text(SCENE_HEADER, format_dimensions(offset="-inf")), "wrong quantity: dimensions.offset"),
    wrong(
        "link too short", scene_text(SCENE_HEADER, format_dimensions(link='"20 mm"', lug_offset='"-300 mm"')), "inconsistent: [dimensions]"
    ),
    wrong("joint beyond the ball", scene_text(SCENE_HEADER, format_dimensions(arm_joint='"400 mm"')), "inconsistent: [dimensions]"),
    wrong("ball on the axis at every angle", scene_text(SCENE_HEADER, format_dimensions(offset='"-300 mm"')), "inconsistent: [dimensions]"),
    wrong(
        "numbers beyond double precision",
        scene_text(SCENE_HEADER, format_dimensions(arm="1e300", link="1e300", lug_offset="0")),
        "out of range: dimensions.arm; out of range: dimensions.link",
    ),
    wrong("bool for a length", scene_text(SCENE_HEADER, format_dimensions(arm="true")), "wrong quantity: dimensions.arm"),
    wrong("text without a unit", scene_text(SCENE_HEADER, format_dimensions(arm='"300"')), "wrong quantity: dimensions.arm"),
    wrong("unknown unit", scene_text(SCENE_HEADER, format_dimensions(arm='"300 mmm"')), "wrong quantity: dimensions.arm"),
    wrong("list for a number", scene_text(SCENE_HEADER, format_dimensions(arm="[1, 2]")), "wrong quantity: dimensions.arm"),
    wrong("date for a number", scene_text(SCENE_HEADER, format_dimensions(arm="1877-01-01")), "wrong quantity: dimensions.arm"),
    wrong("missing key", scene_text(SCENE_HEADER, format_dimensions(arm=None)), "missing key: dimensions.arm"),
    wrong("missing dimensions", 'machine = "pendulum_governor"\n[effects]\ngravity = true\n', "missing key: dimensions"),
    wrong("missing machine", scene_text('title = "T"\n'), "missing key: machine"),
    wrong("unknown machine", scene_text('machine = "pendulum_govenor"\n'), "unknown name: machine"),
    wrong(
        "misspelt machine, the rest wrong too",
        scene_text('machine = "pendulum_govenor"\n', format_dimensions(arm='"5 kg"', lnk='"1 m"'), **TABLE_MISTAKES),
        "unknown name: machine; wrong quantity: dimensions.arm; unknown key: dimensions.lnk; wrong type: effects.centrifugal",
        "wrong quantity: start.arm_angle; wrong quantity: spindle.speed; out of range: run.duration",
    ),
    wrong(
        "misspelt machine's key, the rest wrong too",
        scene_text('machin = "pendulum_governor"\n', format_dimensions(arm='"5 kg"', lnk='"1 m"'), **TABLE_MISTAKES),
        "unknown key: machin; wrong quantity: dimensions.arm; unknown key: dimensions.lnk; wrong type: effects.centrifugal",
        "wrong quantity: start.arm_angle; wrong quantity: spindle.speed; out of range: run.duration",
    ),
    wrong(
        "misspelt machine, start outside the travel",
        scene_text('machine = "pendulum_govenor"\n', start='arm_angle = "95 deg"'),
        "unknown name: machine; out of range: start",
    ),
    wrong(
        "unrecognisable machine, the rest wrong too",
        scene_text('machine = "xyzzy"\n', format_dimensions(arm='"5 kg"'), **TABLE_MISTAKES),
        "unknown name: machine; wrong type: effects.centrifugal; unknown name: start; wrong quantity: spindle.speed",
        "out of range: run.duration",
    ),
    wrong("unrecognisable machine, no dimensions", 'machine = "xyzzy"\n', "unknown name: machine; missing key: dimensions"),
    wrong(
        "bare millimetres",
        scene_text(SCENE_HEADER, format_dimensions(arm="300", offset="-60.5")),
        "wrong quantity: dimensions.arm; wrong quantity: dimensions.offset",
    ),
    wrong("bare grams", scene_text(SCENE_HEADER, format_dimensions(ball_mass="5e6")), "wrong quantity: dimensions.ball_mass"),
    wrong("bare turns per minute", scene_text(spindle="speed = 3000"), "wrong quantity: spindle.speed"),
    wrong("bare turns per minute in a program", scene_text(spindle="speed = [[0, 120], [5, -3000]]"), "wrong quantity: spindle.speed"),
    wrong("misspelt equilibrium in capitals", scene_text(start='arm_angle = "EQUILIBRUM"'), "wrong quantity: start.arm_angle"),
    wrong("a number for the machine", scene_text("machine = 3\n"), "unknown name: machine"),
    wrong("a number for the title", scene_text("title = 3\n" + SCENE_HEADER.splitlines()[1] + "\n"), "wrong type: title"),
    wrong("unknown table", scene_text(spindle=None, spindel='speed = "120 rpm"', effects="gravity = true"), "unknown key: spindel"),
    wrong("unknown key at the top", scene_text(SCENE_HEADER + "speed = 3\n"), "unknown key: speed"),
    wrong("machine under a table", 'title = "T"\n[dimensions]\nmachine = "pendulum_governor"\n', "missing key: machine"),
    wrong("title under a table", scene_text(run=DEFAULT_TABLES["run"] + '\ntitle = "T"'), "unknown key: run.title"),
    wrong("a key for a table", scene_text(SCENE_HEADER + "run = 10\n", run=None), "wrong type: run"),
    wrong("gravity as a word", scene_text(effects='gravity = "on"\ncentrifugal = true'), "wrong quantity: effects.gravity"),
    wrong("gravity upwards", scene_text(effects="gravity = -9.81\ncentrifugal = true"), "out of range: effects.gravity"),
    wrong("centrifugal as a number", scene_text(effects="gravity = true\ncentrifugal = 1"), "wrong type: effects.centrifugal"),
    wrong("centrifugal without a spindle", scene_text(spindle=None), "conflict: effects.centrifugal"),
    wrong("spindle without a speed", scene_text(spindle=""), "missing key: spindle.speed"),
    wrong("speed in hertz", scene_text(spindle='speed = "2 Hz"'), "wrong quantity: spindle.speed"),
    wrong("falling times", scene_text(spindle='speed = [[0, "120 rpm"], [5, "126 rpm"], [4, "120 rpm"]]'), "inconsistent: spindle.speed"),
    wrong("three points at one time", scene_text(spindle="speed = [[0, 12], [5, 12], [5, 13], [5, 14]]"), "inconsistent: spindle.speed"),
    wrong("empty program", scene_text(spindle="speed = []"), "wrong type: spindle.speed"),
    wrong("one point without its list", scene_text(spindle='speed = [[0, "120 rpm"], 5]'), "wrong type: spindle.speed"),
    wrong("start outside the travel", scene_text(start='arm_angle = "95 deg"'), "out of range: start"),
    wrong("misspelt equilibrium", scene_text(start='arm_angle = "equilibrum"'), "wrong quantity: start.arm_angle"),
    wrong(
        "misspelt start key, dimensions wrong too",
        scene_text(SCENE_HEADER, format_dimensions(arm='"-1 m"', link='"1 s"'), start='arm_angel = "40 deg"'),
        "out of range: dimensions.arm; wrong quantity: dimensions.link; unknown key: start.arm_angel",
    ),
    wrong("rate of the wrong kind", scene_text(start='arm_angle = "40 deg"\narm_rate = "1 m/s"'), "wrong quantity: start.arm_rate"),
    wrong("reports rarer than the run is long", scene_text(run='duration = "1 s"\noutput_interval = "2 s"'), "inconsistent: [run]"),
    wrong("zero duration", scene_text(run="duration = 0"), "out of range: run.duration"),
    wrong("accuracy zero", scene_text(run="accuracy = 0"), "out of range: run.accuracy"),
    wrong("accuracy one", scene_text(run="accuracy = 1"), "out of range: run.accuracy"),
    wrong("unknown engine", scene_text(run='engine = "impuls"'), "unknown name: run.engine"),
    wrong("empty file", "", "unreadable: "),
    wrong("only a comment", "# later\n", "unreadable: "),
    wrong("not TOML", SCENE_HEADER + "[dimensions]\narm = 300 mm\n", "unreadable: "),
    wrong("key given twice", SCENE_HEADER + SCENE_HEADER, "unreadable: "),
    wrong("a number of 5000 digits", SCENE_HEADER + "title2 = " + "1" * 5000, "unreadable: "),
    wrong("nested too deeply", "a = " + "[" * 100_000, "unreadable: "),
    wrong("too large", "#" * MAX_SCENE_FILE_SIZE + "\n", "unreadable: "),
    wrong(
        "several mistakes at once",
        scene_text(
            SCENE_HEADER,
            format_dimensions(arm='"300"', sleve_mass='"20 kg"'),
            effects='gravity = true\ncentrifugal = "yes"',
            spindle='speed = [[0, "2 Hz"], [1]]',
            start='arm_angle = "40 mm"',
            run='output_interval = "-1 s"\naccuracy = 2',
        ),
        "wrong quantity: dimensions.arm; unknown key: dimensions.sleve_mass; wrong type: effects.centrifugal",
        "wrong quantity: start.arm_angle; wrong quantity: spindle.speed; wrong type: spindle.speed",
        "out of range: run.output_interval; out of range: run.accuracy",
    ),
]

WORDING_SCENES: list[tuple[str, str]] = [
    (
        "event of an unknown reading",
        'events.passed.reading "sleeve_lft" is not a reading; readings are arm_angle, '
        "ball_radius, sleeve_lift. Did you mean 'sleeve_lift'?",
    ),
    ("event in a unit of the wrong kind", 'events.passed.value is a length; "20 deg" is an angle; write it in mm, cm or m'),
    ("unit of the wrong kind", 'dimensions.arm is a length; "5 kg" is a mass; write it in mm, cm or m'),
    ("weight for a mass", 'dimensions.ball_mass is a mass; "45 kgf" is a force: that is a weight; write 45 kg'),
    (
        "weight in newtons for a mass",
        ('dimensions.ball_mass is a mass; "441 N" is a force: that is a weight; write 45 kg (rounded: its mass at 9.81 m/s^2)'),
    ),
    (
        "misspelt optional key",
        (
            "dimensions.sleve_mass is unknown; known keys are arm, ball_mass, offset, arm_joint, link, "
            "lug_offset, sleeve_mass. Did you mean 'sleeve_mass'?"
        ),
    ),
    ("zero mass", "dimensions.ball_mass must be positive; found 0"),
    ("zero sleeve", "dimensions.sleeve_mass must be positive; found 0; leave sleeve_mass out if there is none"),
    ("negative mass", 'dimensions.ball_mass must be positive; found "-5 kg"'),
    ("not a number", 'dimensions.arm must be a finite number; found nan; write "300 mm", or the bare number in m'),
    ("infinite", 'dimensions.offset must be a finite number; found -inf; write "300 mm", or the bare number in m'),
    (
        "link too short",
        (
            "[dimensions] link (20 mm) is too short to be assembled: between arm joint and sleeve it stays open "
            "by 280 mm at best; it closes for a link longer than 300 mm"
        ),
    ),
    ("joint beyond the ball", "[dimensions] arm_joint (400 mm) lies beyond the ball; it must not exceed arm (300 mm)"),
    (
        "ball on the axis at every angle",
        (
            "[dimensions] offset (-300 mm) puts the balls on or across the spindle axis at every arm angle; with "
            "an arm of 300 mm it must lie above -300 mm"
        ),
    ),
    ("numbers beyond double precision", "dimensions.arm must lie within 1e+09 m; found 1e+300"),
    ("numbers beyond double precision", "dimensions.link must lie within 1e+09 m; found 1e+300"),
    ("bool for a length", 'dimensions.arm is a length; found true; write "300 mm", or the bare number in m'),
    ("text without a unit", 'dimensions.arm is a length; "300" has no unit; write "300 mm", or the bare number in m'),
    ("unknown unit", ('dimensions.arm is a length; "300 mmm" has an unknown unit "mmm"; write it in mm, cm or m. Did you mean \'mm\'?')),
    ("list for a number", 'dimensions.arm is a length; found [1, 2]; write "300 mm", or the bare number in m'),
    ("date for a number", 'dimensions.arm is a length; found 1877-01-01; write "300 mm", or the bare number in m'),
    ("missing key", "dimensions.arm is missing; it is the length from the suspension to the ball's centre"),
    ("missing dimensions", "[dimensions] is missing; pendulum_governor needs arm, ball_mass"),
    (
        "unknown machine",
        (
            'machine "pendulum_govenor" is unknown; known are pendulum_governor, proell, parabolic_governor, hartnell, hartung, '
            "slide_valve, slider_crank, stephenson, flywheel_engine, custom. Did you mean 'pendulum_governor'?"
        ),
    ),
    ("misspelt machine, the rest wrong too", 'effects.centrifugal must be true or false; found "yes"'),
    (
        "misspelt machine, the rest wrong too",
        (
            'start.arm_angle is an angle; "equilibrum" has no number; write "40 deg", or the bare number in rad; '
            "or write \"equilibrium\". Did you mean 'equilibrium'?"
        ),
    ),
    (
        "misspelt machine, the rest wrong too",
        'spindle.speed is an angular speed; "2 Hz" may mean turns or radians; write "120 rpm" or "2 rad/s"',
    ),
    (
        "misspelt machine's key, the rest wrong too",
        ("machin is unknown; a scene file has machine, title, effects, spindle, start, run, events, dimensions. Did you mean 'machine'?"),
    ),
    (
        "misspelt machine, start outside the travel",
        (
            "start.arm_angle (95 deg) lies outside the travel of this governor, 0 to 90 deg: the arms are at 90 "
            "degrees to the spindle (dead centre)"
        ),
    ),
    ("unrecognisable machine, the rest wrong too", "start.arm_angle \"equilibrum\" is unknown. Did you mean 'equilibrium'?"),
    ("unrecognisable machine, no dimensions", "[dimensions] is missing; every machine needs it"),
    ("bare millimetres", 'dimensions.arm = 300 is 300 m; write "300 mm" if that is meant, or "300 m"'),
    ("bare grams", 'dimensions.ball_mass = 5000000 is 5000000 kg; write "5000000 g" if that is meant, or "5000000 kg"'),
    ("bare turns per minute", 'spindle.speed = 3000 is 3000 rad/s; write "3000 rpm" if that is meant, or "3000 rad/s"'),
    (
        "bare turns per minute in a program",
        ('spindle.speed, point 2: speed = -3000 is -3000 rad/s; write "-3000 rpm" if that is meant, or "-3000 rad/s"'),
    ),
    (
        "a number for the machine",
        (
            "machine 3 is unknown; known are pendulum_governor, proell, parabolic_governor, hartnell, hartung, "
            "slide_valve, slider_crank, stephenson, flywheel_engine, custom."
        ),
    ),
    ("a number for the title", 'title must be one line of text, at most 200 characters; found 3; write title = "..."'),
    (
        "unknown table",
        (
            "[spindel] is unknown; a scene file has machine, title, effects, spindle, "
            "start, run, events, dimensions. Did you mean 'spindle'?"
        ),
    ),
    ("a key for a table", "run must be a table; found 10; write [run] on a line of its own"),
    (
        "gravity as a word",
        (
            'effects.gravity is an acceleration; "on" has no number; write "9.81 m/s^2", or the bare number in '
            "m/s^2; gravity may also be true (9.81 m/s^2) or false"
        ),
    ),
    (
        "gravity upwards",
        "effects.gravity must be positive; found -9.81; leave it out if there is none; gravity may also be true (9.81 m/s^2) or false",
    ),
    ("centrifugal as a number", "effects.centrifugal must be true or false; found 1"),
    ("centrifugal without a spindle", 'effects.centrifugal needs a turning spindle; add [spindle] with speed = "120 rpm"'),
    ("falling times", "spindle.speed: times of an input function must not fall; 4 s follows 5 s"),
    ("three points at one time", "spindle.speed: three points of an input function are at 5 s; a step takes two"),
    ("empty program", 'spindle.speed is an empty list of points; write [[0, "120 rpm"]], or one speed'),
    ("one point without its list", 'spindle.speed, point 2: must be [time, speed]; found 5; write [0, "120 rpm"]'),
    ("reports rarer than the run is long", "[run] `output_interval` (2 s) must not exceed `duration` (1 s)"),
    ("accuracy zero", "run.accuracy must be above 0 and below 1, relative to the scale of each reading, as 1e-6; found 0"),
    ("empty file", "the file is empty; a scene needs at least machine = ... and a table [dimensions]"),
    (
        "not TOML",
        (
            "not valid TOML: Expected newline or end of document after a statement (at line 4, column 11); text "
            'and quantities need quotes, as in arm = "300 mm"'
        ),
    ),
    (
        "key given twice",
        ('not valid TOML: Cannot overwrite a value (at line 3, column 28); text and quantities need quotes, as in arm = "300 mm"'),
    ),
    ("nested too deeply", "tables or lists are nested too deeply for a scene"),
    ("too large", "this file is larger than 1,000,000 bytes; a scene is a page of text"),
    (
        "several mistakes at once",
        ('spindle.speed, point 1: speed is an angular speed; "2 Hz" may mean turns or radians; write "120 rpm" or "2 rad/s"'),
    ),
    ("several mistakes at once", 'spindle.speed, point 2: must be [time, speed]; found [1]; write [0, "120 rpm"]'),
]
"""A case that has each message, and the message."""
