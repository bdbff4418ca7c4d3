"""Accelerations, joint forces and projection from these arrays, as compiled kernels."""
