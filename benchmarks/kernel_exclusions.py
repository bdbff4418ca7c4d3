"""What of the kernels short runs and tests need not reach, with the reasons: first lines of statements, and of loops that never run out.

They stand here rather than in the kernels, whose library would have to be built again for every word of a comment.
"""

STATEMENTS: dict[str, dict[str, str]] = {
    "engines/multibody/implicit.py: _evaluate_from": {
        "return OPEN_JOINT": "a stage that leads a linkage beyond its reach; the step is tried again, shorter"
    },
    "engines/multibody/implicit.py: _evaluate_jacobian": {"return quality": "a state beside one whose joints close"},
    "engines/multibody/implicit.py: _finish_step": {
        "return IntegrationStatus.STALLED": "the end of a step whose stages all close the joints",
        "return IntegrationStatus.LEFT_LIMITS": "a stiff governor that leaves its travel takes minutes without a compiler",
    },
    "engines/multibody/implicit.py: evaluate_linearisation": {"return OPEN_JOINT": "a start whose joints close"},
    "integrators/radau_stages.py: iterate": {
        "return 0, 1.0": "behind the loop, whose last iteration returns; test_radau.py reaches those in it"
    },
    "mechanics/dynamics/equations/constrained_solution.py: _remove_stand_in_inertia": {
        "result[:] = math.nan": "a body without mass whose motion moves no mass is refused before (engines/initial_state.py)"
    },
}
"""Statements that nothing needs to reach, by the file, kernel and their first line."""

EXITS: dict[str, dict[str, str]] = {
    "engines/multibody/implicit.py: _evaluate": {"if quality >= 0.0:": "see _evaluate_from"},
    "engines/reduced/contact.py: begin_phases": {"if side < 0:": "an integration begins on the table"},
    "integrators/event_location.py: locate_zero": {
        "for _ in range(MAX_ROOT_ITERATIONS):": "the bracket is at rounding before: every other iteration halves it"
    },
    "integrators/radau_stages.py: iterate": {"for iteration in range(1, max_iterations + 1):": "the last iteration returns"},
    "mechanics/dynamics/equations/constrained_solution.py: _remove_stand_in_inertia": {
        "for _ in range(MAX_STAND_IN_ITERATIONS):": "a body without mass whose motion moves no mass is refused before"
    },
    "numerics/banded_cholesky.py: diagonalise": {
        "for _ in range(MAX_JACOBI_SWEEPS):": "no rotation is left before: sweeps converge quadratically"
    },
}
"""Statements of which not every branch needs to be taken, in the same way."""
