"""Coefficients of the Radau IIA methods with an odd number of stages, computed to rounding.

E. Hairer, G. Wanner, Stiff differential equations solved by Radau methods, J. Comput. Appl. Math. 111 (1999), 93-111.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from governor_mechanism.types import ComplexArray, FloatArray


class RadauTableau(NamedTuple):
    """Coefficients of the method with s stages, of order 2 s - 1.

    With the matrix A of the method, A^-1 = V diag(eigenvalues) V^-1. Of each pair of complex eigenvalues only one is listed.

    Attributes
    ----------
    nodes
        Start and stages as fractions of the step; shape (s + 1,).
    inverse_matrix
        A^-1; shape (s, s).
    real_eigenvalue
        Real eigenvalue of A^-1.
    complex_eigenvalues
        Its complex eigenvalues with a positive imaginary part; shape (pairs,).
    to_real
        Row of V^-1 of the real eigenvalue; shape (s,).
    to_complex
        Rows of V^-1 of the complex eigenvalues; shape (pairs, s).
    from_real
        Column of V of the real eigenvalue; shape (s,).
    from_complex
        Columns of V of the complex eigenvalues, twice as large: the real part of the product counts the conjugate pair; shape (s, pairs).
    error_weights
        Weights of the stage increments in the error estimate of order s; shape (s,).
    """

    nodes: FloatArray
    inverse_matrix: FloatArray
    real_eigenvalue: float
    complex_eigenvalues: ComplexArray
    to_real: FloatArray
    to_complex: ComplexArray
    from_real: FloatArray
    from_complex: ComplexArray
    error_weights: FloatArray


@cache
def make_radau_tableau(
    n_stages: int,  # number of stages, odd: of an even number no eigenvalue is real
) -> RadauTableau:
    """Compute the coefficients of a method."""
    # The nodes on (-1, 1] are the zeros of P_s - P_(s-1), Legendre's polynomials.
    difference = np.zeros(n_stages + 1)
    difference[-2:] = -1.0, 1.0
    zeros = legendre.legroots(difference)
    zeros[-1] = 1.0
    for _ in range(2):  # Newton's method: to rounding
        zeros[:-1] -= legendre.legval(zeros[:-1], difference) / legendre.legval(zeros[:-1], legendre.legder(difference))
    # Collocation: A integrates Legendre's polynomials of degree below s from -1 to the nodes.
    basis = legendre.legvander(zeros, n_stages - 1)
    integrals = np.stack([legendre.legval(zeros, legendre.legint(row, lbnd=-1.0)) for row in np.eye(n_stages)], axis=1)
    inverse_matrix = np.asarray(2.0 * np.linalg.solve(integrals.T, basis.T).T, dtype=np.float64)
    eigenvalues, vectors = np.linalg.eig(inverse_matrix)
    real, is_above = int(np.argmin(np.abs(eigenvalues.imag))), eigenvalues.imag > 1e-9
    inverse_vectors = np.linalg.inv(vectors)
    real_eigenvalue = float(eigenvalues[real].real)
    # The embedded method has the same nodes and the weight 1 / real eigenvalue at the start; its conditions of order in Legendre's basis:
    # it integrates each polynomial of degree below s as the method does, of which the value at the start is (-1)^degree.
    weight_differences = np.linalg.solve(basis.T, -((-1.0) ** np.arange(n_stages)) / real_eigenvalue)
    return RadauTableau(
        nodes=np.append(0.0, 0.5 * (1.0 + zeros)),
        inverse_matrix=inverse_matrix,
        real_eigenvalue=real_eigenvalue,
        complex_eigenvalues=np.ascontiguousarray(eigenvalues[is_above]),
        to_real=np.ascontiguousarray((inverse_vectors[real] * vectors[-1, real]).real),
        to_complex=np.ascontiguousarray(inverse_vectors[is_above]),
        from_real=np.ascontiguousarray((vectors[:, real] / vectors[-1, real]).real),
        from_complex=np.ascontiguousarray(2.0 * vectors[:, is_above]),
        error_weights=weight_differences @ inverse_matrix,
    )
