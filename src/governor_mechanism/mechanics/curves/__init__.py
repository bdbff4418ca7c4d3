"""Guide curves as polynomial segments, outlines as pieces, and their kernels."""
