"""What of the kernels short runs and tests need not reach, with the reasons: first lines of statements, and of loops that never run out.

They stand here rather than in the kernels, whose library would have to be built again for every word of a comment.
"""

STATEMENTS: dict[str, dict[str, str]] = {}
"""Statements that nothing needs to reach, by the file, kernel and their first line."""

EXITS: dict[str, dict[str, str]] = {
    "integrators/event_location.py: locate_zero": {"for _ in range(MAX_ROOT_ITERATIONS):": "a zero takes six false positions, a jump 80"},
    "mechanics/contact/impacts.py: _solve_sliding_impact": {
        "for _ in range(MAX_IMPACT_PHASES):": "no impact has more: two in compression and two in restitution"
    },
    "mechanics/curves/outline_kernels.py: distance_from_polar_curve": {
        "for _ in range(MAX_FOOT_ITERATIONS):": "it ends after 3 to 6 steps of Newton, or 27 of halving"
    },
    "mechanics/curves/profile_kernels.py: _find_support": {
        "for _ in range(MAX_FOOT_ITERATIONS):": "it ends after some steps of Newton, or 27 of halving"
    },
    "mechanics/curves/profile_kernels.py: _find_farthest": {
        "for _ in range(MAX_FOOT_ITERATIONS):": "it ends after some steps of Newton, or 27 of halving"
    },
    "mechanics/curves/profile_kernels.py: distance_of_profiles": {
        "for is_overlapping in (False, True):": "an outline has a piece, which the second turn does not leave out"
    },
    "mechanics/dynamics/equations_of_motion.py: _add_rubbing": {
        "if body != GROUND_INDEX:": "outlines and rollers are those of bodies; a body of the ground is welded"
    },
    "numerics/hermite_curve.py: _find_roots_of_pieces": {
        "for _ in range(MAX_NEWTON_STEPS):": "it ends after some five steps of Newton, or 50 of bisection"
    },
    "numerics/linear_equations.py: diagonalise": {
        "for _ in range(MAX_JACOBI_SWEEPS):": "no rotation is left before: random matrices need six sweeps"
    },
}
"""Statements of which not every branch needs to be taken, in the same way."""
