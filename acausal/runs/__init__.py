"""Many runs of one compiled model: sweeps over parameters, in processes or on a cluster."""
