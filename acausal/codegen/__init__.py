"""Templates to native kernels."""
