"""Which rows share a body, and an order of the rows that gives a narrow band."""

import numpy as np

from governor_mechanism.types import IntArray


def find_coupled_rows(row_bodies: IntArray) -> IntArray:
    """Return the pairs of rows that share a body, from the bodies of all rows (rows, 2).

    Each pair is (row, earlier or same row, side of the body in the first, side in the second); shape (pairs, 4).
    """
    rows_of_body: dict[int, list[tuple[int, int]]] = {}
    pairs: list[tuple[int, int, int, int]] = []
    for row, bodies in enumerate(row_bodies.tolist()):
        sides = [(side, body_index) for side, body_index in enumerate(bodies) if body_index >= 0]
        for side, body_index in sides:
            rows_of_body.setdefault(body_index, []).append((row, side))
        pairs += sorted(
            (row, other_row, side, other_side) for side, body_index in sides for other_row, other_side in rows_of_body[body_index]
        )
    return np.array(pairs, dtype=np.int64).reshape(-1, 4)


def bandwidth_reducing_order(row_bodies: IntArray) -> IntArray:
    """Return an order of the rows that keeps coupled rows together (reverse Cuthill-McKee)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    pairs, n_rows = find_coupled_rows(row_bodies), len(row_bodies)
    if n_rows == 0:  # bodies on springs alone
        return np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n_rows, n_rows)).tocsr()
    return np.asarray(reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True), dtype=np.int64)
