"""The scene file to begin with for a mechanism of one's own: a four-bar linkage, with an example of each kind of table."""

CUSTOM_TEMPLATE = """\
title = "My four-bar linkage"
machine = "custom"
# plane = "turning"                        # the mechanism turns with a spindle; needs [spindle]. Otherwise the plane is fixed
# size = "300 mm"                          # length to which accuracy refers; by default it follows from the points

[ground]                                   # points of the fixed plane
shaft = [0, 0]
pivot = ["300 mm", 0]

[[body]]
name = "crank"
mass = "1 kg"
rod = { length = "100 mm" }                # points start, centre, end; also disc, plate, point = true, or inertia and centre
angle = "60 deg"                           # where it is at the start; with a guess it is assembled
# at = [0, 0]                              # the origin of the body at the start
# points = { pin = ["50 mm", 0] }          # points of one's own, in the axes of the body

[[body]]
name = "coupler"
mass = "2 kg"
rod = { length = "280 mm" }
at = ["50 mm", "86.6 mm"]
angle = "20 deg"

[[body]]
name = "rocker"
mass = "1.5 kg"
rod = { length = "200 mm" }
at = ["300 mm", 0]
angle = "85 deg"

[[joint]]                                  # pin, weld, prismatic, slider, arc, curve, gear, rack, driven_turn, driven_slide
type = "pin"
first = "ground.shaft"
second = "crank.start"

[[joint]]
type = "pin"
first = "crank.end"
second = "coupler.start"

[[joint]]
type = "pin"
first = "coupler.end"
second = "rocker.end"

[[joint]]
type = "pin"
first = "ground.pivot"
second = "rocker.start"

# [[joint]]                                # a motor in place of [start]
# type = "driven_turn"
# first = "ground"
# second = "crank"
# rate = "60 rpm"

# [[link]]                                 # a massless bar between two points
# first = "crank.end"
# second = "rocker.end"
# length = "280 mm"

[[force]]                                  # spring, damper, torsion_spring, torsion_damper, torque, force
type = "torsion_damper"
name = "bearing"
second = "rocker"
damping = "0.05 N m s/rad"

# [[force]]
# type = "spring"
# first = "ground.shaft"
# second = "rocker.end"
# stiffness = "2 N/mm"
# free_length = "250 mm"

[readings]                                 # what the results report; forces along readings are effects
crank_angle = { angle = "crank" }
rocker_angle = { angle = "rocker" }
end_height = { y = "coupler.end" }
# span = { distance = ["ground.shaft", "rocker.end"] }
# lean = { line = ["crank.end", "rocker.end"] }

[effects]                                  # only what is listed here is simulated
gravity = true
# dry_friction = { crank_angle = "0.1 N m" }
# dashpot = { crank_angle = "0.1 N m s/rad" }
# stops = { rocker_angle = ["60 deg", "120 deg"], restitution = 0.3 }

[start]
crank_angle = "60 deg"
# crank_rate = "10 rad/s"

[run]
duration = "3 s"
output_interval = "10 ms"                  # interval of the reported times
accuracy = 1e-6                            # largest error, relative to the scale of each reading
# engine = "auto"                          # one of auto, impulse, multibody, reduced

# [events]                                 # named moments at which a reading passes a value
# passed = { reading = "crank_angle", value = "0 deg", direction = "down" }
"""
"""Text of the scene file."""
