"""Scene files whose effects or uneven spindle are wrong, each with every sentence that it must produce, in part."""

from __future__ import annotations

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


BROKEN_EFFECTS: list[tuple[str, str, list[str]]] = [
    (
        "misspelt effect",
        with_effects('dash_pot = { sleeve = "120 N s/m" }'),
        [
            "effects.dash_pot is unknown; known keys of [effects] are gravity, centrifugal, rods, spring, "
            "dry_friction, dashpot, stops, clearance, masses, bell_cranks. Did you mean 'dashpot'?"
        ],
    ),
    ("rods without masses", with_effects("rods = true"), ["effects.rods must be a table; found true; write rods = {"]),
    ("rods without any mass", with_effects("rods = { arm_mass = 0 }"), ["effects.rods: rods need arm_mass, link_mass"]),
    (
        "misspelt key of rods",
        with_effects('rods = { arm_mas = "0.6 kg" }'),
        ["effects.rods.arm_mas is unknown; known keys of [effects.rods] are arm_mass, link_mass, ball_radius."],
    ),
    (
        "rods of negative mass and of the wrong kind",
        with_effects('rods = { arm_mass = "-1 kg", ball_radius = "5 kg" }'),
        ['effects.rods.arm_mass must not be negative; found "-1 kg"', 'effects.rods.ball_radius is a length; "5 kg" is'],
    ),
    (
        "a ball as large as its arm",
        with_effects('rods = { ball_radius = "300 mm" }'),
        ["[effects] rods.ball_radius (300 mm) must be less than arm (300 mm)"],
    ),
    (
        "links where there are none",
        watt_scene('rods = { link_mass = "0.5 kg" }'),
        ["[effects] rods.link_mass needs links that carry a sleeve; a governor without sleeve_mass has none"],
    ),
    (
        "rods and play of another machine",
        parabolic_scene('rods = { arm_mass = "0.6 kg" }', 'clearance = "1 mm"'),
        [
            f"[effects] the effect rods is for a governor with arms and links; machine 'parabolic_governor' {NOT_APPLICABLE}",
            f"[effects] the effect clearance is for a sleeve on links; machine 'parabolic_governor' {NOT_APPLICABLE}",
        ],
    ),
    (
        "play of another machine whose dimensions are wrong",
        parabolic_scene('clearance = "1 mm"', size=PARABOLIC_DIMENSIONS.replace("0.6", "0")),
        ["dimensions.double_parameter must be positive", "[effects] the effect clearance is for a sleeve on links"],
    ),
    (
        "rods and play of one's own mechanism",
        custom_scene('[effects]\nrods = { arm_mass = 1 }\nclearance = "1 mm"'),
        [f"the effect rods is for a governor with arms and links; machine 'custom' {NOT_APPLICABLE}", f"machine 'custom' {NOT_APPLICABLE}"],
    ),
    (
        "a spring on nothing",
        with_effects('spring = "2 N/mm"'),
        ['effects.spring must name the readings that it acts on; found "2 N/mm"; write spring = { sleeve = { rate = "2 N/mm" } }'],
    ),
    (
        "a spring on no reading",
        with_effects('spring = { sleve = { rate = "2 N/mm" } }'),
        ["effects.spring.sleve is no reading; readings are arm_angle, ball_radius, sleeve_lift. Did you mean 'sleeve'?"],
    ),
    ("no reading at all", with_effects("spring = {}"), ["effects.spring has no reading to act on; write spring = {"]),
    (
        "a spring that is its rate",
        with_effects('spring = { sleeve = "2 N/mm" }'),
        ['effects.spring.sleeve must be a table; found "2 N/mm"; write sleeve = { rate = "2 N/mm" }'],
    ),
    (
        "one reading by two names",
        with_effects("spring = { sleeve = { rate = 1 }, sleeve_lift = { rate = 2 } }"),
        ["effects.spring.sleeve_lift is the same reading as another one there; keep one of them"],
    ),
    (
        "a spring in the wrong units",
        with_effects('spring = { sleeve = { rate = "2 N", preload = "3 m", zero = "1 N", one_sided = "yes" } }'),
        [
            'effects.spring.sleeve.rate is a stiffness; "2 N" is a force',
            'effects.spring.sleeve.preload is a force; "3 m" is a length',
            'effects.spring.sleeve.zero is a length; "1 N" is a force',
            'effects.spring.sleeve.one_sided must be true or false; found "yes"',
        ],
    ),
    (
        "a spring on an angle in the units of a length",
        with_effects('spring = { arm_angle = { rate = "2 N/mm" } }'),
        ['effects.spring.arm_angle.rate is a stiffness in torsion; "2 N/mm" is a stiffness; write it in N m/deg'],
    ),
    (
        "a spring without a rate",
        with_effects('spring = { sleeve = { preload = "3 N" }, arm_angle = { zero = 0 } }'),
        [
            'effects.spring.sleeve: rate is missing; write rate = "2 N/mm", or wire, coil, turns, modulus',
            'effects.spring.arm_angle: rate is missing; write rate = "3 N m/rad"',
        ],
    ),
    (
        "a spring of rate nought",
        with_effects("spring = { sleeve = { rate = 0 } }"),
        ["effects.spring.sleeve.rate must be positive; found 0"],
    ),
    (
        "wire and rate",
        with_effects('spring = { sleeve = { rate = 2, wire = "4 mm", coil = "40 mm" } }'),
        ["effects.spring.sleeve: rate cannot stand beside wire, coil, from which it follows; leave one of the two out"],
    ),
    (
        "half a coil",
        with_effects('spring = { sleeve = { wire = "4 mm", turns = 8 } }'),
        ["effects.spring.sleeve lacks coil, modulus; a spring of wire needs wire, coil, turns, modulus"],
    ),
    (
        "a coil thinner than its wire",
        with_effects('spring = { sleeve = { wire = "4 mm", coil = "4 mm", turns = 8, modulus = "80 GPa" } }'),
        ["effects.spring.sleeve: coil of the spring (0.004 m) must be wider than its wire (0.004 m)"],
    ),
    (
        "wire in torsion",
        with_effects('spring = { arm_angle = { wire = "4 mm" } }'),
        ['effects.spring.arm_angle is an angle, whose spring has no wire; write rate = "3 N m/rad"'],
    ),
    (
        "a modulus of paper",
        with_effects('spring = { sleeve = { wire = "4 mm", coil = "40 mm", turns = 8, modulus = "0 GPa" } }'),
        ["effects.spring.sleeve.modulus must lie between 1 Pa and 1e+13 Pa; found"],
    ),
    (
        "friction on nothing",
        with_effects('dry_friction = "40 N"'),
        ['effects.dry_friction must name the readings that it acts on; found "40 N"; write dry_friction = { sleeve = "40 N" }'],
    ),
    (
        "friction on nothing of one's own mechanism",
        custom_scene("[effects]\ndry_friction = 40"),
        ['found 40; write dry_friction = { crank_angle = "5 N m" }'],
    ),
    (
        "negative friction",
        with_effects('dry_friction = { sleeve = "-40 N", arm_angle = [[0, "1 N m"], [1, "-1 N m"]] }'),
        [
            'effects.dry_friction.sleeve must not be negative, friction opposes either way; found "-40 N"',
            "effects.dry_friction.arm_angle, point 2: must not be negative, friction opposes either way; found",
        ],
    ),
    (
        "friction as a mass, and as a force about a pin",
        with_effects('dry_friction = { sleeve = "40 kg", arm_angle = "40 N" }'),
        [
            'effects.dry_friction.sleeve is a force; "40 kg" is a mass, not a force; write "40 kgf" or in N',
            'effects.dry_friction.arm_angle is a torque; "40 N" is a force; write it in kgf m or N m',
        ],
    ),
    (
        "friction back in time",
        with_effects("dry_friction = { sleeve = [[1, 40], [0, 0]] }"),
        ["effects.dry_friction.sleeve: times of an input function must not fall; 0 s follows 1 s"],
    ),
    (
        "a dashpot without oil",
        with_effects("dashpot = { sleeve = 0, ball_radius = {} }"),
        [
            "effects.dashpot.sleeve must be positive; found 0; leave it out if there is none",
            "effects.dashpot.ball_radius: the dashpot on 'ball_radius' needs a linear or a quadratic part",
        ],
    ),
    (
        "a dashpot in the wrong units",
        with_effects('dashpot = { sleeve = "120 N", arm_angle = { linear = "1 N s/m", quadratic = "1 N" } }'),
        [
            'effects.dashpot.sleeve is a damping; "120 N" is a force',
            "effects.dashpot.arm_angle.linear is a damping in torsion",
            'effects.dashpot.arm_angle.quadratic is a quadratic damping in torsion; "1 N" is a force; write it in N m s^2/rad^2',
        ],
    ),
    (
        "quadratic and piston",
        with_effects('dashpot = { sleeve = { quadratic = 3, piston = "20 cm^2", hole = "12 mm^2" } }'),
        ["effects.dashpot.sleeve: quadratic cannot stand beside piston, hole, from which it follows; leave one"],
    ),
    (
        "a piston without a hole",
        with_effects('dashpot = { sleeve = { linear = 1, piston = "20 cm^2" } }'),
        ["effects.dashpot.sleeve lacks hole; oil through a hole needs piston, hole"],
    ),
    (
        "a screw without a piston",
        with_effects("dashpot = { sleeve = { linear = 1, screw = 0.5 } }"),
        ["effects.dashpot.sleeve lacks piston, hole; oil through"],
    ),
    (
        "a hole as wide as the piston, and a screw beyond open",
        with_effects(
            'dashpot = { sleeve = { piston = "12 mm^2", hole = "12 mm^2" }, '
            'ball_radius = { piston = "20 cm^2", hole = "12 mm^2", screw = 1.5 } }'
        ),
        [
            "effects.dashpot.sleeve: hole of the dashpot (1.2e-05 m2) must be smaller than its piston",
            "effects.dashpot.ball_radius: screw of the dashpot must lie above 0 (shut) and at most at 1 (open)",
        ],
    ),
    (
        "a piston that turns",
        with_effects('dashpot = { arm_angle = { piston = "20 cm^2", hole = "12 mm^2" } }'),
        ["effects.dashpot.arm_angle is an angle, whose dashpot has no piston, hole; write quadratic ="],
    ),
    (
        "stops on nothing",
        with_effects('stops = ["15 deg", "45 deg"]'),
        ["effects.stops must name the readings that it acts on; found ['15 deg', '45 deg']; write stops = {"],
    ),
    (
        "a restitution alone",
        with_effects("stops = { restitution = 0.5 }"),
        ["effects.stops has no reading to act on; write stops = { sleeve ="],
    ),
    (
        "stops in the wrong order, and a restitution over 1",
        with_effects('stops = { arm_angle = ["45 deg", "15 deg"], restitution = 1.5 }'),
        [
            'effects.stops.arm_angle must have its low end first and below the high one; found "45 deg" and "15 deg"',
            "effects.stops.restitution must lie between 0 and 1, it is the part of the speed that is left; found 1.5",
        ],
    ),
    (
        "one end of two",
        with_effects('stops = { arm_angle = "45 deg" }'),
        ['effects.stops.arm_angle must be [low, high], an end that is not there "none"; found "45 deg"; write ["15'],
    ),
    (
        "no end of two",
        with_effects('stops = { arm_angle = ["none", "none"] }'),
        ['effects.stops.arm_angle needs a low or a high end; found "none" for both'],
    ),
    (
        "ends of the wrong kind",
        with_effects('stops = { arm_angle = ["15 mm", "45 kg"] }'),
        ['effects.stops.arm_angle, low end is an angle; "15 mm" is', 'stops.arm_angle, high end is an angle; "45 kg"'],
    ),
    (
        "a start beyond a stop",
        with_effects('stops = { arm_angle = ["none", "35 deg"] }'),
        ["start.arm_angle (40 deg) lies beyond the stops of effects.stops.arm_angle, none to 35 deg; start"],
    ),
    (
        "a start of one's own mechanism beyond a stop",
        custom_scene('[start]\ncrank_angle = "90 deg"\n[effects]\nstops = { crank_angle = ["0 deg", "45 deg"] }'),
        ["start.crank_angle (90 deg) lies beyond the stops of effects.stops.crank_angle, 0 deg to 45 deg"],
    ),
    (
        "stops beyond the travel",
        with_effects('stops = { arm_angle = ["95 deg", "120 deg"] }'),
        ["effects.stops.arm_angle, 95 deg to 120 deg, leaves nothing of the travel, 0 deg to 90 deg"],
    ),
    ("play of nought", with_effects("clearance = 0"), ["effects.clearance must be positive; found 0; write clearance = false if"]),
    ("play without a width", with_effects("clearance = true"), ["effects.clearance is how far the sleeve may move; found true;"]),
    ("a table of play without a width", with_effects("clearance = {}"), ["effects.clearance.width is missing; it is how far"]),
    (
        "play of the wrong kind and a restitution below 0",
        with_effects('clearance = { width = "1 kg", restitution = -0.1 }'),
        ['effects.clearance.width is a length; "1 kg" is a mass', "effects.clearance.restitution must lie between 0 and 1"],
    ),
    (
        "play without a sleeve",
        watt_scene('clearance = "0.5 mm"'),
        ["[effects] clearance is between links and sleeve; a governor without sleeve_mass has no sleeve"],
    ),
    (
        "play of links with mass",
        with_effects('clearance = "0.5 mm"', 'rods = { link_mass = "0.5 kg" }'),
        ["[effects] rods.link_mass cannot be combined with clearance: links that separate from the sleeve are massless"],
    ),
    (
        "play between stops",
        with_effects('clearance = "0.5 mm"', 'stops = { sleeve_clearance = ["-1 mm", "1 mm"] }'),
        ["effects.stops.sleeve_clearance cannot stand beside effects.clearance, whose two ends are such stops; leave it out"],
    ),
    (
        "a start beyond the play",
        with_effects('clearance = "0.5 mm"', start='arm_angle = "40 deg"\nsleeve_clearance = "0.3 mm"'),
        ["start.sleeve_clearance (0.3 mm) lies beyond the stops of effects.clearance, -0.25 mm to 0.25 mm; start between them"],
    ),
    (
        "play written wrong, and its start",
        with_effects('clearance = "x"', start='arm_angle = "40 deg"\nsleeve_clearance = "0.1 mm"'),
        ['effects.clearance is a length; "x" has no number'],
    ),
    (
        "a start in play that is not there",
        with_effects("clearance = false", start="sleeve_clearance = 0"),
        ["start.sleeve_clearance is unknown; known keys of [start] are arm_angle, arm_rate."],
    ),
    (
        "speed fluctuation of 1",
        with_effects(spindle='speed = "120 rpm"\nspeed_fluctuation = 1\ncycles_per_turn = 0'),
        [
            "spindle.speed_fluctuation must be at least 0 and below 1: it is (highest - lowest) / mean speed; found 1",
            "spindle.cycles_per_turn must be positive; found 0",
        ],
    ),
    (
        "waves of nothing",
        with_effects(spindle='speed = "120 rpm"\ncycles_per_turn = 2'),
        [
            "spindle.cycles_per_turn says how often the speed fluctuation comes in a turn; write speed_fluctuation = 0.03, or leave cycles_per_turn out"
        ],
    ),
    (
        "speed fluctuation of a free spindle",
        with_effects(spindle='inertia = "1 kg m^2"\nstart_speed = "120 rpm"\nspeed_fluctuation = 0.03'),
        ["spindle.speed_fluctuation cannot stand beside inertia, start_speed: how unevenly a spindle left to itself turns"],
    ),
    (
        "speed fluctuation that nothing feels",
        scene_text(effects="gravity = true", spindle='speed = "120 rpm"\nspeed_fluctuation = 0.03'),
        ["spindle.speed_fluctuation changes nothing: without effects.centrifugal = true nothing feels the spindle turn"],
    ),
    (
        "speed fluctuation beside a fixed plane",
        custom_scene("[spindle]\nspeed = 12\nspeed_fluctuation = 0.03", top='machine = "custom"\nplane = "fixed"\n'),
        ["spindle.speed_fluctuation changes nothing: the mechanism lives in a fixed plane; write plane ="],
    ),
    (
        "wrong dimensions, effects and start",
        scene_text(
            SCENE_HEADER,
            format_dimensions(arm='"3 kg"'),
            effects='dry_friction = { sleve = "40 N" }\nstops = { arm_angle = ["45 deg", "15 deg"] }\nclearance = "1 mm"',
            start="sleeve_clearance = 0\narm_angel = 3",
        ),
        [
            'dimensions.arm is a length; "3 kg" is a mass',
            "effects.dry_friction.sleve is no reading; readings are arm_angle, ball_radius, sleeve_lift, sleeve_clearance.",
            "effects.stops.arm_angle must have its low end first",
            "start.arm_angel is unknown; known keys of [start] are arm_angle, arm_rate, sleeve_clearance, sleeve_clearance_rate.",
        ],
    ),
    (
        "an unknown machine and wrong effects",
        scene_text(
            'machine = "xyzzy"\n',
            effects='dry_friction = { whatever = "40 kg" }\nstops = { lean = ["45 deg", "15 deg"] }\nclearance = "1 kg"',
        ),
        [
            'machine "xyzzy" is unknown',
            'effects.dry_friction.whatever is a force; "40 kg" is a mass, not a force',
            "effects.stops.lean must have its low end first and below the high one",
            'effects.clearance is a length; "1 kg" is a mass',
        ],
    ),
    (
        "an unknown body and wrong effects",
        custom_scene('[readings]\nlean = { angle = "crnk" }\n[effects]\ngravity = "x"\ndry_friction = { lean = "40 kg" }'),
        [
            'readings.lean: angle names the unknown body "crnk"',
            'effects.gravity is an acceleration; "x" has no number',
            'effects.dry_friction.lean is a force; "40 kg" is a mass, not a force',
        ],
    ),
]
