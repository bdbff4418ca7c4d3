"""Elementary functions for descriptions: those of the module `math`, which also take numbers of many rows (see `row_numbers`)."""

import math

from governor_mechanism.numerics.row_numbers import elementary

acos, asin, atan, atan2 = elementary(math.acos), elementary(math.asin), elementary(math.atan), elementary(math.atan2)
cos, sin, tan = elementary(math.cos), elementary(math.sin), elementary(math.tan)
copysign, hypot, radians, sqrt = elementary(math.copysign), elementary(math.hypot), elementary(math.radians), elementary(math.sqrt)
