"""The per-user cache on disk: parse trees, kernels, compiled models."""
