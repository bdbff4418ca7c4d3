"""Studies of the regulation by a governor, with many runs of one scene: cyclic motion, clearance, settling, jump.

Results for the shipped scenes:

- The sleeve starts to move as soon as the speed fluctuation exceeds the insensitivity band; the amplitude first grows
  with the square of the excess.
- Zehnder names clearance between links and sleeve as a remedy against cyclic motion. A small clearance is none. The
  weight of a loaded sleeve (porter_clearance) keeps the clearance closed, and the motion does not change. If friction
  carries the sleeve (watt_clearance), the balls move freely: they strike the ends of the clearance and drive the sleeve
  ten times as far and more, until the clearance is as wide as their free oscillation; only then the sleeve is at rest.
  In between the impacts are irregular, and a single amplitude means little. Such a clearance causes cyclic motion even
  if the speed fluctuation is below the insensitivity band.
- The settling time has a minimum over the damping: with less damping the governor oscillates, with more it creeps.
- The jump of the improved Watt governor is later than the equilibrium speeds predict: by rate^(2/3) at the fold, where
  it falls, and by nearly the rate itself, except for a logarithm, where it leaves its stop.

Pure functions: they run scenes and return arrays. SI units and radians.
"""
