"""Templates to native kernels, and the native driver that calls them."""
