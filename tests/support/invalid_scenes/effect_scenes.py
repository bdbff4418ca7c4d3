"""Scene files with wrong effects or spindles, each with the code and the key of every mistake."""

from invalid_scenes.cases import Case, wrong
from invalid_scenes.custom_scenes import custom_scene
from invalid_scenes.scenes import DEFAULT_TABLES, SCENE_HEADER, format_dimensions, scene_text

PARABOLIC_MACHINE = 'machine = "parabolic_governor"\n'
PARABOLIC_DIMENSIONS = 'double_parameter = 0.6\ninner_radius = 0.05\nouter_radius = 0.25\nball_mass = "1 kg"\nsleeve_mass = "4 kg"'
NOT_APPLICABLE = "does not support it; leave the effect out"


def with_effects(*lines: str, start: str | None = DEFAULT_TABLES["start"], spindle: str = DEFAULT_TABLES["spindle"]) -> str:
    """The Porter scene with more effects."""
    return scene_text(effects="\n".join([DEFAULT_TABLES["effects"], *lines]), start=start, spindle=spindle)


def watt_scene(*lines: str) -> str:
    """The same without a sleeve that has mass."""
    return scene_text(SCENE_HEADER, format_dimensions(sleeve_mass=None), effects="\n".join([DEFAULT_TABLES["effects"], *lines]))


def parabolic_scene(*lines: str, size: str = PARABOLIC_DIMENSIONS) -> str:
    """The astatic governor with more effects."""
    return scene_text(PARABOLIC_MACHINE, size, effects="\n".join([DEFAULT_TABLES["effects"], *lines]), start=None)


BROKEN_EFFECTS: list[Case] = [
    wrong("misspelt effect", with_effects('dash_pot = { sleeve = "120 N s/m" }'), "unknown key: effects.dash_pot"),
    wrong("rods without masses", with_effects("rods = true"), "wrong type: effects.rods"),
    wrong("rods without any mass", with_effects("rods = { arm_mass = 0 }"), "inconsistent: effects.rods"),
    wrong("misspelt key of rods", with_effects('rods = { arm_mas = "0.6 kg" }'), "unknown key: effects.rods.arm_mas"),
    wrong(
        "rods of negative mass and of the wrong kind",
        with_effects('rods = { arm_mass = "-1 kg", ball_radius = "5 kg" }'),
        "out of range: effects.rods.arm_mass; wrong quantity: effects.rods.ball_radius",
    ),
    wrong("a ball as large as its arm", with_effects('rods = { ball_radius = "300 mm" }'), "inconsistent: [effects]"),
    wrong("links where there are none", watt_scene('rods = { link_mass = "0.5 kg" }'), "inconsistent: [effects]"),
    wrong(
        "rods and play of another machine",
        parabolic_scene('rods = { arm_mass = "0.6 kg" }', 'clearance = "1 mm"'),
        "conflict: [effects]; conflict: [effects]",
    ),
    wrong(
        "play of another machine whose dimensions are wrong",
        parabolic_scene('clearance = "1 mm"', size=PARABOLIC_DIMENSIONS.replace("0.6", "0")),
        "out of range: dimensions.double_parameter; conflict: [effects]",
    ),
    wrong(
        "rods and play of one's own mechanism",
        custom_scene('[effects]\nrods = { arm_mass = 1 }\nclearance = "1 mm"'),
        "conflict: [effects]; conflict: [effects]",
    ),
    wrong("a spring on nothing", with_effects('spring = "2 N/mm"'), "wrong type: effects.spring"),
    wrong("a spring on no reading", with_effects('spring = { sleve = { rate = "2 N/mm" } }'), "unknown name: effects.spring.sleve"),
    wrong("no reading at all", with_effects("spring = {}"), "missing key: effects.spring"),
    wrong("a spring that is its rate", with_effects('spring = { sleeve = "2 N/mm" }'), "wrong type: effects.spring.sleeve"),
    wrong(
        "one reading by two names",
        with_effects("spring = { sleeve = { rate = 1 }, sleeve_lift = { rate = 2 } }"),
        "duplicate: effects.spring.sleeve_lift",
    ),
    wrong(
        "a spring in the wrong units",
        with_effects('spring = { sleeve = { rate = "2 N", preload = "3 m", zero = "1 N", one_sided = "yes" } }'),
        "wrong quantity: effects.spring.sleeve.rate; wrong quantity: effects.spring.sleeve.preload",
        "wrong quantity: effects.spring.sleeve.zero; wrong type: effects.spring.sleeve.one_sided",
    ),
    wrong(
        "a spring on an angle in the units of a length",
        with_effects('spring = { arm_angle = { rate = "2 N/mm" } }'),
        "wrong quantity: effects.spring.arm_angle.rate",
    ),
    wrong(
        "a spring without a rate",
        with_effects('spring = { sleeve = { preload = "3 N" }, arm_angle = { zero = 0 } }'),
        "missing key: effects.spring.sleeve; missing key: effects.spring.arm_angle",
    ),
    wrong("a spring of rate zero", with_effects("spring = { sleeve = { rate = 0 } }"), "out of range: effects.spring.sleeve.rate"),
    wrong(
        "wire and rate",
        with_effects('spring = { sleeve = { rate = 2, wire = "4 mm", coil = "40 mm" } }'),
        "conflict: effects.spring.sleeve",
    ),
    wrong("half a coil", with_effects('spring = { sleeve = { wire = "4 mm", turns = 8 } }'), "conflict: effects.spring.sleeve"),
    wrong(
        "a coil thinner than its wire",
        with_effects('spring = { sleeve = { wire = "4 mm", coil = "4 mm", turns = 8, modulus = "80 GPa" } }'),
        "inconsistent: effects.spring.sleeve",
    ),
    wrong("wire in torsion", with_effects('spring = { arm_angle = { wire = "4 mm" } }'), "conflict: effects.spring.arm_angle"),
    wrong(
        "a modulus of paper",
        with_effects('spring = { sleeve = { wire = "4 mm", coil = "40 mm", turns = 8, modulus = "0 GPa" } }'),
        "out of range: effects.spring.sleeve.modulus",
    ),
    wrong("friction on nothing", with_effects('dry_friction = "40 N"'), "wrong type: effects.dry_friction"),
    wrong("friction on nothing of one's own mechanism", custom_scene("[effects]\ndry_friction = 40"), "wrong type: effects.dry_friction"),
    wrong(
        "negative friction",
        with_effects('dry_friction = { sleeve = "-40 N", arm_angle = [[0, "1 N m"], [1, "-1 N m"]] }'),
        "out of range: effects.dry_friction.sleeve; out of range: effects.dry_friction.arm_angle",
    ),
    wrong(
        "friction as a mass, and as a force about a pin",
        with_effects('dry_friction = { sleeve = "40 kg", arm_angle = "40 N" }'),
        "wrong quantity: effects.dry_friction.sleeve; wrong quantity: effects.dry_friction.arm_angle",
    ),
    wrong(
        "friction back in time", with_effects("dry_friction = { sleeve = [[1, 40], [0, 0]] }"), "inconsistent: effects.dry_friction.sleeve"
    ),
    wrong(
        "a dashpot without oil",
        with_effects("dashpot = { sleeve = 0, ball_radius = {} }"),
        "out of range: effects.dashpot.sleeve; inconsistent: effects.dashpot.ball_radius",
    ),
    wrong(
        "a dashpot in the wrong units",
        with_effects('dashpot = { sleeve = "120 N", arm_angle = { linear = "1 N s/m", quadratic = "1 N" } }'),
        "wrong quantity: effects.dashpot.sleeve; wrong quantity: effects.dashpot.arm_angle.linear",
        "wrong quantity: effects.dashpot.arm_angle.quadratic",
    ),
    wrong(
        "quadratic and piston",
        with_effects('dashpot = { sleeve = { quadratic = 3, piston = "20 cm^2", hole = "12 mm^2" } }'),
        "conflict: effects.dashpot.sleeve",
    ),
    wrong(
        "a piston without a hole",
        with_effects('dashpot = { sleeve = { linear = 1, piston = "20 cm^2" } }'),
        "conflict: effects.dashpot.sleeve",
    ),
    wrong(
        "a screw without a piston", with_effects("dashpot = { sleeve = { linear = 1, screw = 0.5 } }"), "conflict: effects.dashpot.sleeve"
    ),
    wrong(
        "a hole as wide as the piston, and a screw beyond open",
        with_effects(
            'dashpot = { sleeve = { piston = "12 mm^2", hole = "12 mm^2" }, '
            'ball_radius = { piston = "20 cm^2", hole = "12 mm^2", screw = 1.5 } }'
        ),
        "inconsistent: effects.dashpot.sleeve; inconsistent: effects.dashpot.ball_radius",
    ),
    wrong(
        "a piston that turns",
        with_effects('dashpot = { arm_angle = { piston = "20 cm^2", hole = "12 mm^2" } }'),
        "conflict: effects.dashpot.arm_angle",
    ),
    wrong("stops on nothing", with_effects('stops = ["15 deg", "45 deg"]'), "wrong type: effects.stops"),
    wrong("a restitution alone", with_effects("stops = { restitution = 0.5 }"), "missing key: effects.stops"),
    wrong(
        "stops in the wrong order, and a restitution over 1",
        with_effects('stops = { arm_angle = ["45 deg", "15 deg"], restitution = 1.5 }'),
        "out of range: effects.stops.restitution; out of range: effects.stops.arm_angle",
    ),
    wrong("one end of two", with_effects('stops = { arm_angle = "45 deg" }'), "wrong type: effects.stops.arm_angle"),
    wrong("no end of two", with_effects('stops = { arm_angle = ["none", "none"] }'), "out of range: effects.stops.arm_angle"),
    wrong(
        "ends of the wrong kind",
        with_effects('stops = { arm_angle = ["15 mm", "45 kg"] }'),
        "wrong quantity: effects.stops.arm_angle; wrong quantity: effects.stops.arm_angle",
    ),
    wrong("a start beyond a stop", with_effects('stops = { arm_angle = ["none", "35 deg"] }'), "out of range: start.arm_angle"),
    wrong(
        "a start of one's own mechanism beyond a stop",
        custom_scene('[start]\ncrank_angle = "90 deg"\n[effects]\nstops = { crank_angle = ["0 deg", "45 deg"] }'),
        "out of range: start.crank_angle",
    ),
    wrong(
        "stops beyond the travel", with_effects('stops = { arm_angle = ["95 deg", "120 deg"] }'), "out of range: effects.stops.arm_angle"
    ),
    wrong("clearance of zero", with_effects("clearance = 0"), "out of range: effects.clearance"),
    wrong("play without a width", with_effects("clearance = true"), "wrong type: effects.clearance"),
    wrong("a table of play without a width", with_effects("clearance = {}"), "missing key: effects.clearance.width"),
    wrong(
        "play of the wrong kind and a restitution below 0",
        with_effects('clearance = { width = "1 kg", restitution = -0.1 }'),
        "wrong quantity: effects.clearance.width; out of range: effects.clearance.restitution",
    ),
    wrong("play without a sleeve", watt_scene('clearance = "0.5 mm"'), "inconsistent: [effects]"),
    wrong("play of links with mass", with_effects('clearance = "0.5 mm"', 'rods = { link_mass = "0.5 kg" }'), "inconsistent: [effects]"),
    wrong(
        "play between stops",
        with_effects('clearance = "0.5 mm"', 'stops = { sleeve_clearance = ["-1 mm", "1 mm"] }'),
        "conflict: effects.stops.sleeve_clearance",
    ),
    wrong(
        "a start beyond the play",
        with_effects('clearance = "0.5 mm"', start='arm_angle = "40 deg"\nsleeve_clearance = "0.3 mm"'),
        "out of range: start.sleeve_clearance",
    ),
    wrong(
        "play written wrong, and its start",
        with_effects('clearance = "x"', start='arm_angle = "40 deg"\nsleeve_clearance = "0.1 mm"'),
        "wrong quantity: effects.clearance",
    ),
    wrong(
        "a start in play that is not there",
        with_effects("clearance = false", start="sleeve_clearance = 0"),
        "unknown key: start.sleeve_clearance",
    ),
    wrong(
        "speed fluctuation of 1",
        with_effects(spindle='speed = "120 rpm"\nspeed_fluctuation = 1\ncycles_per_turn = 0'),
        "out of range: spindle.speed_fluctuation; out of range: spindle.cycles_per_turn",
    ),
    wrong("waves of nothing", with_effects(spindle='speed = "120 rpm"\ncycles_per_turn = 2'), "conflict: spindle.cycles_per_turn"),
    wrong(
        "speed fluctuation of a free spindle",
        with_effects(spindle='inertia = "1 kg m^2"\nstart_speed = "120 rpm"\nspeed_fluctuation = 0.03'),
        "conflict: spindle.speed_fluctuation",
    ),
    wrong(
        "speed fluctuation that nothing feels",
        scene_text(effects="gravity = true", spindle='speed = "120 rpm"\nspeed_fluctuation = 0.03'),
        "conflict: spindle.speed_fluctuation",
    ),
    wrong(
        "speed fluctuation beside a fixed plane",
        custom_scene("[spindle]\nspeed = 12\nspeed_fluctuation = 0.03", top='machine = "custom"\nplane = "fixed"\n'),
        "conflict: spindle.speed_fluctuation",
    ),
    wrong(
        "wrong dimensions, effects and start",
        scene_text(
            SCENE_HEADER,
            format_dimensions(arm='"3 kg"'),
            effects='dry_friction = { sleve = "40 N" }\nstops = { arm_angle = ["45 deg", "15 deg"] }\nclearance = "1 mm"',
            start="sleeve_clearance = 0\narm_angel = 3",
        ),
        "wrong quantity: dimensions.arm; unknown name: effects.dry_friction.sleve; out of range: effects.stops.arm_angle",
        "unknown key: start.arm_angel",
    ),
    wrong(
        "an unknown machine and wrong effects",
        scene_text(
            'machine = "xyzzy"\n',
            effects='dry_friction = { whatever = "40 kg" }\nstops = { lean = ["45 deg", "15 deg"] }\nclearance = "1 kg"',
        ),
        "unknown name: machine; wrong quantity: effects.dry_friction.whatever; out of range: effects.stops.lean",
        "wrong quantity: effects.clearance",
    ),
    wrong(
        "an unknown body and wrong effects",
        custom_scene('[readings]\nlean = { angle = "crnk" }\n[effects]\ngravity = "x"\ndry_friction = { lean = "40 kg" }'),
        "unknown name: readings.lean.angle; wrong quantity: effects.gravity; wrong quantity: effects.dry_friction.lean",
    ),
]

WORDING_EFFECTS: list[tuple[str, str]] = [
    ("rods without masses", 'effects.rods must be a table; found true; write { arm_mass = "0.6 kg", link_mass = "0.5 kg" }'),
    ("rods without any mass", "effects.rods: rods need arm_mass, link_mass or ball_radius; leave the effect out if there are none"),
    ("rods of negative mass and of the wrong kind", 'effects.rods.arm_mass must not be negative; found "-1 kg"'),
    (
        "a ball as large as its arm",
        ("[effects] rods.ball_radius (300 mm) must be less than arm (300 mm), or the ball would contain its suspension"),
    ),
    (
        "links where there are none",
        (
            "[effects] rods.link_mass needs links that carry a sleeve; a governor without sleeve_mass has none; "
            "leave link_mass out, or add sleeve_mass to [dimensions]"
        ),
    ),
    (
        "rods and play of another machine",
        (
            "[effects] the effect rods is for a governor with arms and links; machine 'parabolic_governor' does "
            "not support it; leave the effect out"
        ),
    ),
    (
        "rods and play of another machine",
        ("[effects] the effect clearance is for a sleeve on links; machine 'parabolic_governor' does not support it; leave the effect out"),
    ),
    (
        "a spring on nothing",
        (
            'effects.spring must be a table with the readings on which it acts; found "2 N/mm"; write spring = { '
            'sleeve = { rate = "2 N/mm" } }'
        ),
    ),
    (
        "a spring on no reading",
        ("effects.spring.sleve is not a reading; readings are arm_angle, ball_radius, sleeve_lift. Did you mean 'sleeve'?"),
    ),
    ("no reading at all", 'effects.spring has no reading to act on; write spring = { sleeve = { rate = "2 N/mm" } }'),
    ("a spring that is its rate", 'effects.spring.sleeve must be a table; found "2 N/mm"; write { rate = "2 N/mm" }'),
    ("one reading by two names", "effects.spring.sleeve_lift is the same reading as another key; keep one of them"),
    ("a spring without a rate", 'effects.spring.sleeve: rate is missing; write rate = "2 N/mm", or wire, coil, turns, modulus'),
    ("a spring without a rate", 'effects.spring.arm_angle: rate is missing; write rate = "3 N m/rad"'),
    ("wire and rate", ("effects.spring.sleeve: rate cannot be combined with wire, coil, from which it follows; leave one of the two out")),
    ("half a coil", "effects.spring.sleeve lacks coil, modulus; wire, coil, turns, modulus are all needed"),
    ("a coil thinner than its wire", "effects.spring.sleeve: coil of the spring (0.004 m) must be wider than its wire (0.004 m)"),
    ("wire in torsion", 'effects.spring.arm_angle is an angle and cannot have wire; write rate = "3 N m/rad"'),
    ("a modulus of paper", 'effects.spring.sleeve.modulus must be positive; found "0 GPa"'),
    (
        "friction on nothing",
        ('effects.dry_friction must be a table with the readings on which it acts; found "40 N"; write dry_friction = { sleeve = "40 N" }'),
    ),
    (
        "friction on nothing of one's own mechanism",
        (
            "effects.dry_friction must be a table with the readings on which it acts; found 40; write "
            'dry_friction = { crank_angle = "5 N m" }'
        ),
    ),
    ("negative friction", 'effects.dry_friction.sleeve must not be negative, because friction opposes the motion; found "-40 N"'),
    (
        "negative friction",
        ('effects.dry_friction.arm_angle, point 2: must not be negative, because friction opposes the motion; found "-1 N m"'),
    ),
    (
        "friction as a mass, and as a force about a pin",
        'effects.dry_friction.sleeve is a force; "40 kg" is a mass, not a force; write "40 kgf" or in N',
    ),
    ("a dashpot without oil", "effects.dashpot.sleeve must be positive; found 0; leave it out if there is none"),
    ("a dashpot without oil", "effects.dashpot.ball_radius: the dashpot on 'ball_radius' needs a linear or a quadratic part"),
    (
        "quadratic and piston",
        ("effects.dashpot.sleeve: quadratic cannot be combined with piston, hole, from which it follows; leave one of the two out"),
    ),
    ("a piston without a hole", "effects.dashpot.sleeve lacks hole; piston, hole are all needed"),
    ("a screw without a piston", "effects.dashpot.sleeve lacks piston, hole; piston, hole are all needed"),
    (
        "a hole as wide as the piston, and a screw beyond open",
        ("effects.dashpot.sleeve: hole of the dashpot (1.2e-05 m2) must be smaller than its piston (1.2e-05 m2)"),
    ),
    (
        "a hole as wide as the piston, and a screw beyond open",
        ("effects.dashpot.ball_radius: screw of the dashpot must lie above 0 (shut) and at most at 1 (open); got 1.5"),
    ),
    ("a piston that turns", ('effects.dashpot.arm_angle is an angle and cannot have piston, hole; write quadratic = "0.3 N m s^2/rad^2"')),
    (
        "stops on nothing",
        (
            "effects.stops must be a table with the readings on which it acts; found ['15 deg', '45 deg']; write "
            'stops = { sleeve = ["10 mm", "60 mm"] }'
        ),
    ),
    ("a restitution alone", 'effects.stops has no reading to act on; write stops = { sleeve = ["10 mm", "60 mm"] }'),
    (
        "stops in the wrong order, and a restitution over 1",
        ("effects.stops.restitution must be at least 0 and at most 1 (speed after over speed before an impact); found 1.5"),
    ),
    (
        "stops in the wrong order, and a restitution over 1",
        (
            "effects.stops.arm_angle: stops of 'arm_angle': the low end (0.785398) must be below the high end (0.261799); "
            "found ['45 deg', '15 deg']"
        ),
    ),
    (
        "one end of two",
        ('effects.stops.arm_angle must be [low, high], with "none" for a missing end; found "45 deg"; write ["15 deg", "45 deg"]'),
    ),
    ("no end of two", ("effects.stops.arm_angle: stops of 'arm_angle' need a low or a high end; found ['none', 'none']")),
    ("ends of the wrong kind", 'effects.stops.arm_angle, low end is an angle; "15 mm" is a length; write it in deg or rad'),
    ("ends of the wrong kind", 'effects.stops.arm_angle, high end is an angle; "45 kg" is a mass; write it in deg or rad'),
    (
        "a start beyond a stop",
        ("start.arm_angle (40 deg) is beyond the stops of effects.stops.arm_angle, none to 35 deg; start between them"),
    ),
    (
        "a start of one's own mechanism beyond a stop",
        ("start.crank_angle (90 deg) is beyond the stops of effects.stops.crank_angle, 0 deg to 45 deg; start between them"),
    ),
    ("stops beyond the travel", "effects.stops.arm_angle, 95 deg to 120 deg, leaves nothing of the travel, 0 deg to 90 deg"),
    ("clearance of zero", "effects.clearance must be positive; found 0; write clearance = false if there is none"),
    (
        "play without a width",
        'effects.clearance is the distance that the sleeve may move between the links; found true; write clearance = "0.5 mm"',
    ),
    (
        "play without a sleeve",
        (
            "[effects] clearance is between links and sleeve; a governor without sleeve_mass has no sleeve; leave "
            "clearance out, or add sleeve_mass to [dimensions]"
        ),
    ),
    (
        "play of links with mass",
        (
            "[effects] rods.link_mass cannot be combined with clearance: links that separate from the sleeve are "
            "massless; leave one of them out"
        ),
    ),
    (
        "play between stops",
        ("effects.stops.sleeve_clearance cannot be combined with effects.clearance, whose two ends are such stops; leave it out"),
    ),
    (
        "a start beyond the play",
        ("start.sleeve_clearance (0.3 mm) is beyond the stops of effects.clearance, -0.25 mm to 0.25 mm; start between them"),
    ),
    ("play written wrong, and its start", 'effects.clearance is a length; "x" has no number; write "300 mm", or the bare number in m'),
    (
        "speed fluctuation of 1",
        ("spindle.speed_fluctuation must be at least 0 and below 1: it is (highest - lowest) / mean speed; found 1"),
    ),
    (
        "waves of nothing",
        ("spindle.cycles_per_turn has no effect without a fluctuation; write speed_fluctuation = 0.03, or leave cycles_per_turn out"),
    ),
    (
        "speed fluctuation of a free spindle",
        (
            "spindle.speed_fluctuation cannot be combined with inertia, start_speed; the speed of a free spindle "
            "follows from its torque; leave it out, or give spindle.speed"
        ),
    ),
    (
        "speed fluctuation that nothing feels",
        ("spindle.speed_fluctuation has no effect without effects.centrifugal = true; add it, or leave speed_fluctuation out"),
    ),
    (
        "speed fluctuation beside a fixed plane",
        'spindle.speed_fluctuation has no effect in a fixed plane; write plane = "turning", or leave it out',
    ),
]
"""A case that has each message, and the message."""
