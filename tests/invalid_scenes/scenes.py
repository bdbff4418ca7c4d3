"""Broken scene files, each with the sentences it must produce."""

from __future__ import annotations

from governor_mechanism.scenes.parser import MAX_SCENE_FILE_SIZE

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

BROKEN_SCENES: list[tuple[str, str, list[str]]] = [
    (
        "unit of the wrong kind",
        scene_text(SCENE_HEADER, format_dimensions(arm='"5 kg"')),
        ['dimensions.arm is a length; "5 kg" is a mass; write it in mm, cm or m'],
    ),
    (
        "weight for a mass",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass='"45 kgf"')),
        ['dimensions.ball_mass is a mass; "45 kgf" is a force: that is a weight; write 45 kg'],
    ),
    (
        "weight in newtons for a mass",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass='"441 N"')),
        ['dimensions.ball_mass is a mass; "441 N" is a force: that is a weight; write 45 kg'],
    ),
    (
        "misspelt optional key",
        scene_text(SCENE_HEADER, format_dimensions(sleve_mass='"20 kg"')),
        ["dimensions.sleve_mass is unknown; known keys of [dimensions] are arm, ball_mass,", "Did you mean 'sleeve_mass'?"],
    ),
    (
        "misspelt required key",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass=None, bal_mass='"5 kg"')),
        ["dimensions.bal_mass is unknown", "Did you mean 'ball_mass'?"],
    ),
    ("zero mass", scene_text(SCENE_HEADER, format_dimensions(ball_mass="0")), ["dimensions.ball_mass must be positive; found 0"]),
    (
        "zero sleeve",
        scene_text(SCENE_HEADER, format_dimensions(sleeve_mass="0")),
        ["dimensions.sleeve_mass must be positive; found 0; leave sleeve_mass out"],
    ),
    (
        "negative mass",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass='"-5 kg"')),
        ['dimensions.ball_mass must be positive; found "-5 kg"'],
    ),
    ("not a number", scene_text(SCENE_HEADER, format_dimensions(arm="nan")), ["dimensions.arm must be a finite number; found nan"]),
    ("infinite", scene_text(SCENE_HEADER, format_dimensions(offset="-inf")), ["dimensions.offset must be a finite number; found -inf"]),
    (
        "link too short",
        scene_text(SCENE_HEADER, format_dimensions(link='"20 mm"', lug_offset='"-300 mm"')),
        ["[dimensions] link (20 mm) is too short", "open by 280 mm at best", "closes for a link longer than 300 mm"],
    ),
    (
        "joint beyond the ball",
        scene_text(SCENE_HEADER, format_dimensions(arm_joint='"400 mm"')),
        ["[dimensions] arm_joint (400 mm) lies beyond the ball; it must not exceed arm (300 mm)"],
    ),
    (
        "ball on the axis at every angle",
        scene_text(SCENE_HEADER, format_dimensions(offset='"-300 mm"')),
        ["[dimensions] offset (-300 mm) puts the balls on or across the spindle axis", "must lie above -300 mm"],
    ),
    (
        "numbers beyond double precision",
        scene_text(SCENE_HEADER, format_dimensions(arm="1e300", link="1e300", lug_offset="0")),
        ["[dimensions] arm must be a positive number between 1e-09 and 1e+09 in SI; got 1e+300"],
    ),
    ("bool for a length", scene_text(SCENE_HEADER, format_dimensions(arm="true")), ["dimensions.arm is a length; found true; write"]),
    (
        "text without a unit",
        scene_text(SCENE_HEADER, format_dimensions(arm='"300"')),
        ['dimensions.arm is a length; "300" has no unit; write "300 mm", or the bare number in m'],
    ),
    (
        "unknown unit",
        scene_text(SCENE_HEADER, format_dimensions(arm='"300 mmm"')),
        ['dimensions.arm is a length; "300 mmm" has an unknown unit "mmm"', "Did you mean 'mm'?"],
    ),
    ("list for a number", scene_text(SCENE_HEADER, format_dimensions(arm="[1, 2]")), ["dimensions.arm is a length; found [1, 2]"]),
    ("date for a number", scene_text(SCENE_HEADER, format_dimensions(arm="1877-01-01")), ["dimensions.arm is a length; found"]),
    ("missing key", scene_text(SCENE_HEADER, format_dimensions(arm=None)), ["dimensions.arm is missing; it is the length from"]),
    (
        "missing dimensions",
        'machine = "pendulum_governor"\n[effects]\ngravity = true\n',
        ["[dimensions] is missing; pendulum_governor needs arm, ball_mass"],
    ),
    ("missing machine", scene_text('title = "T"\n'), ["machine is missing; it is one of pendulum_governor"]),
    (
        "unknown machine",
        scene_text('machine = "pendulum_govenor"\n'),
        ['machine "pendulum_govenor" is unknown; known are pendulum_governor, parabolic_governor, ', "Did you mean 'pendulum_governor'?"],
    ),
    (
        "misspelt machine, the rest wrong too",
        scene_text('machine = "pendulum_govenor"\n', format_dimensions(arm='"5 kg"', lnk='"1 m"'), **TABLE_MISTAKES),
        [
            "Did you mean 'pendulum_governor'?",
            'dimensions.arm is a length; "5 kg" is a mass',
            "dimensions.lnk is unknown",
            'effects.centrifugal must be true or false; found "yes"',
            'spindle.speed is an angular speed; "2 Hz"',
            "or write \"equilibrium\". Did you mean 'equilibrium'?",
            "run.duration must be positive; found 0",
        ],
    ),
    (
        "misspelt machine's key, the rest wrong too",
        scene_text('machin = "pendulum_governor"\n', format_dimensions(arm='"5 kg"', lnk='"1 m"'), **TABLE_MISTAKES),
        ["machin is unknown", "Did you mean 'machine'?", "dimensions.arm is a length", "dimensions.lnk is unknown"],
    ),
    (
        "misspelt machine, start outside the travel",
        scene_text('machine = "pendulum_govenor"\n', start='arm_angle = "95 deg"'),
        ['machine "pendulum_govenor" is unknown', "start.arm_angle (95 deg) lies outside the travel"],
    ),
    (
        "unrecognisable machine, the rest wrong too",
        scene_text('machine = "xyzzy"\n', format_dimensions(arm='"5 kg"'), **TABLE_MISTAKES),
        [
            'machine "xyzzy" is unknown; known are pendulum_governor',
            'effects.centrifugal must be true or false; found "yes"',
            'spindle.speed is an angular speed; "2 Hz"',
            "start.arm_angle \"equilibrum\" is unknown. Did you mean 'equilibrium'?",
            "run.duration must be positive; found 0",
        ],
    ),
    (
        "unrecognisable machine, no dimensions",
        'machine = "xyzzy"\n',
        ['machine "xyzzy" is unknown', "[dimensions] is missing; every machine needs some"],
    ),
    (
        "bare millimetres",
        scene_text(SCENE_HEADER, format_dimensions(arm="300", offset="-60.5")),
        [
            'dimensions.arm = 300 is 300 m; write "300 mm" if that is meant, or "300 m"',
            'dimensions.offset = -60.5 is -60.5 m; write "-60.5 mm" if that is meant, or "-60.5 m"',
        ],
    ),
    (
        "bare grams",
        scene_text(SCENE_HEADER, format_dimensions(ball_mass="5e6")),
        ['dimensions.ball_mass = 5000000 is 5000000 kg; write "5000000 g" if that is meant, or "5000000 kg"'],
    ),
    (
        "bare turns per minute",
        scene_text(spindle="speed = 3000"),
        ['spindle.speed = 3000 is 3000 rad/s; write "3000 rpm" if that is meant, or "3000 rad/s"'],
    ),
    (
        "bare turns per minute in a program",
        scene_text(spindle="speed = [[0, 120], [5, -3000]]"),
        ['spindle.speed, point 2: speed = -3000 is -3000 rad/s; write "-3000 rpm" if that is meant'],
    ),
    ("misspelt equilibrium in capitals", scene_text(start='arm_angle = "EQUILIBRUM"'), ["Did you mean 'equilibrium'?"]),
    ("a number for the machine", scene_text("machine = 3\n"), ["machine 3 is unknown; known are pendulum_governor"]),
    ("a number for the title", scene_text("title = 3\n" + SCENE_HEADER.splitlines()[1] + "\n"), ["title must be text; found 3"]),
    (
        "unknown table",
        scene_text(spindle=None, spindel='speed = "120 rpm"', effects="gravity = true"),
        ["[spindel] is unknown; a scene file has machine, title, dimensions,", "Did you mean 'spindle'?"],
    ),
    ("unknown key at the top", scene_text(SCENE_HEADER + "speed = 3\n"), ["speed is unknown; a scene file has machine, title"]),
    ("machine under a table", 'title = "T"\n[dimensions]\nmachine = "pendulum_governor"\n', ["machine is missing"]),
    (
        "title under a table",
        scene_text(run=DEFAULT_TABLES["run"] + '\ntitle = "T"'),
        ["run.title is unknown", "'title' stands above the first [table], or is a table of its own"],
    ),
    (
        "a key for a table",
        scene_text(SCENE_HEADER + "run = 10\n", run=None),
        ["run must be a table; found 10; write [run] on a line of its own"],
    ),
    (
        "gravity as a word",
        scene_text(effects='gravity = "on"\ncentrifugal = true'),
        ['effects.gravity is an acceleration; "on" has no number', "gravity may also be true (9.81 m/s^2) or false"],
    ),
    (
        "gravity upwards",
        scene_text(effects="gravity = -9.81\ncentrifugal = true"),
        ["effects.gravity must be positive; found -9.81; write gravity = false"],
    ),
    (
        "centrifugal as a number",
        scene_text(effects="gravity = true\ncentrifugal = 1"),
        ["effects.centrifugal must be true or false; found 1"],
    ),
    ("centrifugal without a spindle", scene_text(spindle=None), ["effects.centrifugal = true needs a spindle that turns; add [spindle]"]),
    ("spindle without a speed", scene_text(spindle=""), ["spindle.speed is missing; it is the speed"]),
    (
        "speed in hertz",
        scene_text(spindle='speed = "2 Hz"'),
        ['spindle.speed is an angular speed; "2 Hz" may mean turns or radians; write "120 rpm" or "2 rad/s"'],
    ),
    (
        "falling times",
        scene_text(spindle='speed = [[0, "120 rpm"], [5, "126 rpm"], [4, "120 rpm"]]'),
        ["spindle.speed: times of an input function must not fall; 4 s follows 5 s"],
    ),
    (
        "three points at one time",
        scene_text(spindle="speed = [[0, 12], [5, 12], [5, 13], [5, 14]]"),
        ["spindle.speed: three points of an input function are at 5 s; a step takes two"],
    ),
    ("empty program", scene_text(spindle="speed = []"), ["spindle.speed is an empty program; write [[0,"]),
    (
        "one point without its list",
        scene_text(spindle='speed = [[0, "120 rpm"], 5]'),
        ["spindle.speed, point 2: must be [time, speed]; found 5"],
    ),
    (
        "start outside the travel",
        scene_text(start='arm_angle = "95 deg"'),
        ["start.arm_angle (95 deg) lies outside the travel of this governor", "dead centre"],
    ),
    ("misspelt equilibrium", scene_text(start='arm_angle = "equilibrum"'), ["or write \"equilibrium\". Did you mean 'equilibrium'?"]),
    (
        "misspelt start key, dimensions wrong too",
        scene_text(SCENE_HEADER, format_dimensions(arm='"-1 m"', link='"1 s"'), start='arm_angel = "40 deg"'),
        [
            'dimensions.arm must be positive; found "-1 m"',
            'dimensions.link is a length; "1 s" is a time',
            "start.arm_angel is unknown; known keys of [start] are arm_angle, arm_rate. Did you mean 'arm_angle'?",
        ],
    ),
    (
        "rate of the wrong kind",
        scene_text(start='arm_angle = "40 deg"\narm_rate = "1 m/s"'),
        ['start.arm_rate is an angular rate; "1 m/s" is a speed; write it in deg/s or rad/s'],
    ),
    (
        "reports rarer than the run is long",
        scene_text(run='duration = "1 s"\noutput_interval = "2 s"'),
        ["[run] `output_interval` (2 s) must not exceed `duration` (1 s)"],
    ),
    ("zero duration", scene_text(run="duration = 0"), ["run.duration must be positive; found 0"]),
    ("accuracy zero", scene_text(run="accuracy = 0"), ["run.accuracy must lie above 0 and below 1", "found 0"]),
    ("accuracy one", scene_text(run="accuracy = 1"), ["run.accuracy must lie above 0 and below 1", "found 1"]),
    (
        "unknown engine",
        scene_text(run='engine = "impuls"'),
        ["run.engine \"impuls\" is unknown; known are auto, impulse, multibody, reduced. Did you mean 'impulse'?"],
    ),
    ("empty file", "", ["the file is empty"]),
    ("only a comment", "# later\n", ["the file is empty"]),
    ("not TOML", SCENE_HEADER + "[dimensions]\narm = 300 mm\n", ["not valid TOML", "at line 4, column 11", 'arm = "300 mm"']),
    ("key given twice", SCENE_HEADER + SCENE_HEADER, ["not valid TOML", "Cannot overwrite a value (at line 3"]),
    ("a number of 5000 digits", SCENE_HEADER + "title2 = " + "1" * 5000, ["not valid TOML"]),
    ("nested too deeply", "a = " + "[" * 100_000, ["nested too deeply"]),
    ("too large", "#" * MAX_SCENE_FILE_SIZE + "\n", ["this file is larger than 1,000,000 bytes"]),
    (
        "several mistakes at once",
        scene_text(
            SCENE_HEADER,
            format_dimensions(arm='"300"', sleve_mass='"20 kg"'),
            effects='gravity = true\ncentrifugal = "yes"',
            spindle='speed = [[0, "2 Hz"], [1]]',
            start='arm_angle = "40 mm"',
            run='output_interval = "-1 s"\naccuracy = 2',
        ),
        [
            'dimensions.arm is a length; "300" has no unit',
            "dimensions.sleve_mass is unknown",
            'effects.centrifugal must be true or false; found "yes"',
            'spindle.speed, point 1: speed is an angular speed; "2 Hz" may mean',
            "spindle.speed, point 2: must be [time, speed]; found [1]",
            'start.arm_angle is an angle; "40 mm" is a length',
            'run.output_interval must be positive; found "-1 s"',
            "run.accuracy must lie above 0 and below 1",
        ],
    ),
]
